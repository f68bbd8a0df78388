#!/usr/bin/env bash
# The build, whose warnings are errors, and all tests: the README's command.
set -euo pipefail
cd "$(dirname "$0")/../.."
exec bash tests/run.sh
