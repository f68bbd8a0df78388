#!/usr/bin/env bash
# clang-tidy 14 over what changed against a commit, or over everything. Over a large change it leaves
# out the analyser, which takes most of the time, to --all.
#   tests/gates/clang_tidy.sh [COMMIT]    # the commit before this one, where none is named
#   tests/gates/clang_tidy.sh --all
set -euo pipefail
cd "$(dirname "$0")/../.."

many_files=24

bash tests/gates/install.sh
checks=
if [ "${1:-}" = --all ]; then
  files=$(git ls-files 'nn/*.cc' 'vo/*.cc' 'command_line/*.cc' 'weights_tools/*.cc' 'apps/*.cc' 'tests/*.cc' 'bench/*.cc' |
    grep -v '^tests/fuzz/\|^tests/install/')
elif commit=$(git rev-parse --verify --quiet "${1:-HEAD~1}^{commit}"); then
  files=$(git diff --name-only "$commit" -- | bash tests/gates/affected_sources.sh)
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

count=$(wc -l <<<"$files")
if [ "${1:-}" != --all ] && [ "$count" -gt "$many_files" ]; then
  checks=-clang-analyzer-*
fi
# Every source with a command of its own.
cmake --preset dev -B build/tidy -DGLUEVO_UNITY_BUILD=OFF >/dev/null
echo "$count files${checks:+, without the analyser}"
xargs -P "$(nproc)" -n 1 -d '\n' clang-tidy-14 -p build/tidy --quiet --checks="$checks" <<<"$files"
