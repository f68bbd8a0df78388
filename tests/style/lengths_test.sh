#!/usr/bin/env bash
# The lengths hold, and what is a line too long is found: files, and functions of every kind.
set -euo pipefail
cd "$(dirname "$0")"
bash lengths.sh

lines() { printf "$2%.0s" $(seq "$1"); }

# expect SAID FILE TEXT: whether a file of this text is found, in a line that begins so ("" for not).
expect() {
  local folder said
  folder=$(mktemp -d)
  mkdir -p "$folder"/{nn,command_line,vo,weights_tools,apps}
  printf '%s' "$3" >"$folder/$2"
  said=$(bash lengths.sh "$folder" || true)
  rm -r "$folder"
  if [ -n "$1" ] && ! grep -q "^$1" <<<"$said" || [ -z "$1" ] && grep -q "allowed" <<<"$said"; then
    printf 'expected "%s", found\n%s\n' "$1" "$said"
    exit 1
  fi
}

body=$'{\n'$(lines 79 '  F();\n')$'\n}\n'  # 81 lines with the line that opens it.
short=$'{\n'$(lines 78 '  F();\n')$'\n}\n'
expect "" vo/a.cc "void A() $short"
expect "vo/a.cc:1: A has 81" vo/a.cc "void A() $body"
expect "vo/a.h:2: A has 81" vo/a.h "namespace n {"$'\n'"inline void A() $body}"
expect "apps/a.cc:2: A has 81" apps/a.cc "struct S {"$'\n'"int A() const $body};"
expect "nn/a.cc:1: A has 8[12]" nn/a.cc "A::A(int x)"$'\n'": a_{x}, b_(x) $body"
expect "nn/a.cc:1: operator == has 81" nn/a.cc "bool operator==(A a, A b) $body"
expect "nn/a.cc:2: A has 81" nn/a.cc "template <typename T>"$'\n'"T A(T a) $body"
expect "" vo/a.cc 'const char* k = R"css('$'\n'"void A() $body"')css";'
expect "vo/a.py:1: a has 81" vo/a.py "def a():"$'\n'"$(lines 80 '    b()\n')"$'\n'
expect "" vo/a.cc "$(lines 300 '\n')x"
expect "vo/a.cc: 301 lines" vo/a.cc "$(lines 300 'int a;\n')"$'\n'"int b;"$'\n'
