#!/usr/bin/env bash
# From the names of changed files on the standard input to the .cc files that clang-tidy has to read
# for them: those that changed, and for each header that changed up to three that include it,
# through other headers where no .cc does so itself.
set -euo pipefail
cd "$(dirname "$0")/../.."

most_includers=3

# The .cc files nearest to a header, its own first.
includers_of() {
  local headers=("$1") seen=" $1 " stem patterns sources header
  stem=$(basename "$1" .h)
  while [ "${#headers[@]}" -gt 0 ]; do
    patterns=()
    for header in "${headers[@]}"; do
      patterns+=(-e "^ *# *include *[<\"](.*/)?${header##*/}[>\"]")
    done
    sources=$(git grep -lE "${patterns[@]}" -- '*.cc' || true)
    if [ -n "$sources" ]; then
      { grep "/$stem\.cc$" <<<"$sources" || true; grep -v "/$stem\.cc$" <<<"$sources" || true; } |
        head -n "$most_includers"
      return
    fi
    mapfile -t headers < <(git grep -lE "${patterns[@]}" -- '*.h' | while read -r header; do
      [[ $seen == *" $header "* ]] || echo "$header"
    done)
    seen+="${headers[*]} "
  done
}

while read -r file; do
  if [ -f "$file" ]; then
    case $file in
      *.cc) echo "$file" ;;
      *.h) includers_of "$file" ;;
    esac
  fi
# Those of tests/fuzz and tests/install are built by presets of their own.
done | sort -u | { grep -v '^tests/fuzz/\|^tests/install/' || true; }
