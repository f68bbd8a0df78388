#!/usr/bin/env bash
# Builds the test programs whose names match the patterns with a sanitising preset, and runs them.
# A pattern that matches none is an error: the tests were renamed.
#   tests/gates/sanitized_tests.sh PRESET PATTERN...
set -euo pipefail
cd "$(dirname "$0")/../.."
preset=$1
shift

bash tests/gates/install.sh
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
cmake --preset "$preset" >/dev/null
programs=$(ninja -C "build/$preset" -t targets all | sed -nE 's/^([a-z0-9_]+_test): phony$/\1/p' |
  grep -v '^cmake_object_order_' | sort -u)
selected=()
for pattern in "$@"; do
  mapfile -t matching < <(grep -Ex "$pattern" <<<"$programs")
  if [ ${#matching[@]} -eq 0 ]; then
    echo "no test program matches $pattern" >&2
    exit 1
  fi
  selected+=("${matching[@]}")
done

# Addresses in shadow memory are fixed: the sanitisers of clang 14 do not start where a kernel
# spreads programs wider than they know.
fixed_addresses=()
if setarch "$(uname -m)" -R true 2>/dev/null; then
  fixed_addresses=(setarch "$(uname -m)" -R)
fi
suppressions=$PWD/tests/gates/suppressions
export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1
export UBSAN_OPTIONS=print_stacktrace=1
export LSAN_OPTIONS=suppressions=$suppressions/leak.txt:print_suppressions=0
export TSAN_OPTIONS=suppressions=$suppressions/thread.txt:second_deadlock_stack=1
"${fixed_addresses[@]}" cmake --build --preset "$preset" --target "${selected[@]}"
# Each is a test of its own here, whatever else was built before.
tests=$(printf '%s\n' "${selected[@]}" | sort -u)
rm -rf "build/$preset/gate"
mkdir -p "build/$preset/gate"
while read -r program; do
  path=$(find "build/$preset/tests" -type f -name "$program" -perm -u+x)
  # Relative to the CTestTestfile.cmake beside it.
  echo "add_test($program \"$PWD/$path\" --gtest_brief=1)"
done <<<"$tests" >"build/$preset/gate/CTestTestfile.cmake"
"${fixed_addresses[@]}" ctest --test-dir "build/$preset/gate" --output-on-failure \
  --no-tests=error --timeout 900 -j "$(nproc)"
