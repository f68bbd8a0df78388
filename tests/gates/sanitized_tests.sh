#!/usr/bin/env bash
# Builds the test programs whose names match the patterns with a sanitising preset, and runs them.
# A pattern that matches none is an error: the tests were renamed. After a colon stands which of
# a program's tests run, as --gtest_filter takes it.
#   tests/gates/sanitized_tests.sh PRESET PATTERN[:FILTER]...
set -euo pipefail
cd "$(dirname "$0")/../.."
preset=$1
shift

bash tests/gates/install.sh
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
cmake --preset "$preset" -DGLUEVO_PRECOMPILE=ON >/dev/null
programs=$(ninja -C "build/$preset" -t targets all | sed -nE 's/^([a-z0-9_]+_test): phony$/\1/p' |
  grep -v '^cmake_object_order_' | sort -u)
declare -A filters
for argument in "$@"; do
  pattern=${argument%%:*}
  mapfile -t matching < <(grep -Px "$pattern" <<<"$programs")
  if [ ${#matching[@]} -eq 0 ]; then
    echo "no test program matches $pattern" >&2
    exit 1
  fi
  for program in "${matching[@]}"; do
    filters[$program]=${argument:${#pattern}+1}
  done
done

# Addresses in shadow memory are fixed: the sanitisers of clang 14 do not start where a kernel
# spreads programs wider than they know.
fixed_addresses=()
if setarch "$(uname -m)" -R true 2>/dev/null; then
  fixed_addresses=(setarch "$(uname -m)" -R)
fi
suppressions=$PWD/tests/gates/suppressions
# Suppressions go by the names of functions, which only the symbolizer tells.
symbolizer=external_symbolizer_path=$(command -v llvm-symbolizer-14)
export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1:$symbolizer
export UBSAN_OPTIONS=print_stacktrace=1:$symbolizer
export TSAN_OPTIONS=suppressions=$suppressions/thread.txt:second_deadlock_stack=1:$symbolizer
"${fixed_addresses[@]}" cmake --build --preset "$preset" --target "${!filters[@]}"

# A list of tests with these programs alone, whatever else was built before.
gate=build/$preset/gate
mkdir -p "$gate"
for program in "${!filters[@]}"; do
  path=$(find "$PWD/build/$preset/tests" -type f -name "$program" -perm -u+x)
  echo "add_test($program \"$path\" --gtest_brief=1 \"--gtest_filter=${filters[$program]:-*}\")"
done | sort >"$gate/CTestTestfile.cmake"
"${fixed_addresses[@]}" ctest --test-dir "$gate" --output-on-failure --no-tests=error \
  --timeout 900 -j "$(nproc)"
