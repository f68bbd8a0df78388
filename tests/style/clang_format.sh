#!/usr/bin/env bash
# All C++ files of the repository are as clang-format 14 leaves them: other versions differ. Exit
# code 77 is a skipped test.
set -euo pipefail
cd "$(dirname "$0")/../.."

skip() {
  echo "skipped: $1"
  exit 77
}

program=$(command -v clang-format-14 || command -v clang-format) || skip "no clang-format"
version=$("$program" --version | sed -E 's/.*version ([0-9]+).*/\1/')
[ "$version" = 14 ] || skip "$program is version $version, expected 14"
files=$(git ls-files '*.cc' '*.h' 2>/dev/null) || skip "not a git repository"
[ -n "$files" ] || skip "git knows no files here"

xargs -d '\n' "$program" --dry-run --Werror --style=file <<<"$files"
echo "$(wc -l <<<"$files") files"
