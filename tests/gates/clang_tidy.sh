#!/usr/bin/env bash
# clang-tidy 14 over what changed against a commit, or over everything.
#   tests/gates/clang_tidy.sh [COMMIT]    # the commit before this one, where none is named
#   tests/gates/clang_tidy.sh --all
set -euo pipefail
cd "$(dirname "$0")/../.."

bash tests/gates/install.sh
if [ "${1:-}" = --all ]; then
  files=$(git ls-files 'nn/*.cc' 'vo/*.cc' 'weights_tools/*.cc' 'apps/*.cc' 'tests/*.cc' 'bench/*.cc' |
    grep -v '^tests/fuzz/\|^tests/install/')
elif commit=$(git rev-parse --verify --quiet "${1:-HEAD~1}^{commit}"); then
  files=$(git diff --name-only "$commit" -- | python3 tests/gates/affected_sources.py)
elif [ $# -gt 0 ]; then
  echo "there is no commit $1" >&2
  exit 1
else
  echo "no commit before this one is here: nothing to compare with"
  exit 0
fi
if [ -z "$files" ]; then
  echo "no C++ source changed"
  exit 0
fi

cmake --preset dev >/dev/null
echo "$(wc -l <<<"$files") files"
xargs -P "$(nproc)" -n 1 -d '\n' clang-tidy-14 -p build/dev --quiet <<<"$files"
