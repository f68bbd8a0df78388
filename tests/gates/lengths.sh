#!/usr/bin/env bash
# No source over 300 lines, no function over 80, and the script that counts them counts right.
set -euo pipefail
cd "$(dirname "$0")/../.."
bash tests/gates/install.sh
bash tests/style/lengths_test.sh
