#!/usr/bin/env bash
# No source file over 300 lines and no function over 80, as universal-ctags sees functions. Prints
# what is too long and fails.
#   tests/style/lengths.sh [FOLDER]    # a folder laid out as this repository, which it is by default
set -euo pipefail
cd "${1:-$(dirname "$0")/../..}"

largest_file=300
largest_function=80

mapfile -t sources < <(find nn command_line vo weights_tools apps -type f \
  \( -name '*.cc' -o -name '*.h' -o -name '*.py' -o -name '*.sh' \) | sort)
if [ "${#sources[@]}" -eq 0 ]; then
  echo "no sources in $PWD"
  exit 1
fi

too_long=$(
  wc -l -- "${sources[@]}" | awk -v largest=$largest_file '
    $2 != "total" && $1 > largest { print $2 ": " $1 " lines, " largest " are allowed" }'
  printf '%s\n' "${sources[@]}" |
    ctags -x --languages=C++,Python --langmap=C++:.cc.h --kinds-C++=f --kinds-Python=fm \
      --_xformat='%F:%n %{end} %N' -L - | awk -v largest=$largest_function '
    { begin = $1; sub(/.*:/, "", begin); lines = $2 - begin + 1; place = $1
      $1 = $2 = ""; sub(/^ +/, "") }
    lines > largest { print place ": " $0 " has " lines " lines, " largest " are allowed" }'
)
echo "${#sources[@]} files${too_long:+, too long:
$too_long}"
[ -z "$too_long" ]
