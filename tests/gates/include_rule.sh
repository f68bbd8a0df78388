#!/usr/bin/env bash
# Each room includes only what the rooms below it offer.
set -euo pipefail
cd "$(dirname "$0")/../.."
bash tests/gates/install.sh
bash tests/style/include_rule.sh
