#!/usr/bin/env bash
# Writes docs/OPTIONS.md, all options of all commands, from their --help; with --check it compares
# instead, and says what to do where they differ.
#   bash docs/make_options.sh [--check] [GLUEVO [GLUEVO_WEIGHTS]]
set -euo pipefail

cd "$(dirname "$0")/.."
check=false
if [ "${1:-}" = --check ]; then
  check=true
  shift
fi
gluevo=${1:-build/dev/apps/gluevo}
weights=${2:-build/dev/weights_tools/gluevo-weights}

# The commands that the last argument's --help lists, and those below them.
commands_of() {
  local command
  "$@" --help | awk '/^Subcommands:/ { on = 1; next } on && /^  [a-z]/ { print $1 } on && /^$/ { exit }' |
    while read -r command; do
      echo "${*:2} $command"
      commands_of "$@" "$command" < /dev/null
    done
}

# CLI11 gives each option two spaces, its text, and from column 31 what it does: there or in the
# next line.
table_of() {
  "$@" --help | awk '
    function cell(text) {
      gsub(/\|/, "\\|", text)
      gsub(/^ +| +$/, "", text)
      return text
    }
    function row(option, what,    name, takes, excludes, value, required) {
      option = cell(option)
      excludes = ""
      if (match(option, / (Excludes|Needs): .*/)) {
        excludes = substr(option, RSTART + 1)
        option = substr(option, 1, RSTART - 1)
      }
      name = option
      sub(/ .*/, "", name)
      takes = substr(option, length(name) + 2)
      value = ""
      # The default stands behind the last equals sign that is not of ">= 1".
      if (match(takes, /=[^ =][^=]*$/) && substr(takes, RSTART - 1, 1) !~ /[<>]/) {
        value = substr(takes, RSTART + 1)
        takes = substr(takes, 1, RSTART - 1)
      }
      gsub(/,/, ", ", name)
      required = sub(/ *REQUIRED$/, "", takes) ? "needed" : ""
      if (takes !~ /^TEXT \.\.\.|^TEXT$/) sub(/^TEXT:?/, "", takes)
      sub(/^BOOLEAN$/, "true,false", takes)
      gsub(/^BOOLEAN:?|^INT:?\{|[{}]/, "", takes)
      sub(/^TEXT/, "text", takes)
      sub(/^U?INT:?/, "whole number ", takes)
      sub(/^FLOAT:?/, "number ", takes)
      gsub(/,/, ", ", takes)
      if (required != "") value = required
      what = cell(what) (excludes == "" ? "" : " (" tolower(substr(excludes, 1, 1)) \
                                              substr(excludes, 2) ")")
      if (!headed) {
        print "\n| " heading " | takes | default | |\n| --- | --- | --- | --- |"
        headed = 1
      }
      print "| `" name "` | " cell(takes) " | " value " | " what " |"
    }
    { lines[NR] = $0 }
    END {
      print lines[1] "."
      for (i = 2; i <= NR; ++i) {
        line = lines[i]
        if (line ~ /^(Example|Examples|Subcommands):/) {
          exit
        } else if (line ~ /^[A-Z][A-Za-z]*:$/) {
          heading = tolower(substr(line, 1, length(line) - 1))
          headed = 0
        } else if (line ~ /^  [-A-Z]/ && line !~ /-h,--help|--version/) {
          if (length(lines[i + 1]) > 30 && substr(lines[i + 1], 1, 30) ~ /^ *$/) {
            row(line, lines[++i])
          } else {
            row(substr(line, 1, 30), substr(line, 31))
          }
        }
      }
    }'
}

document() {
  echo "# Options"
  echo "Of every command, as its \`--help\` says them: \`bash docs/make_options.sh\` writes this file, a test compares it."
  echo "\`--config FILE\` of \`run\` and \`live\` takes any of theirs from a YAML file."
  for program in "$gluevo" "$weights"; do
    local name command
    name=$(basename "$program")
    while read -r command; do
      printf '\n## `%s %s`\n' "$name" "$command"
      # shellcheck disable=SC2086
      table_of "$program" $command < /dev/null
    done < <(commands_of "$program")
  done
}

if $check; then
  if ! diff docs/OPTIONS.md <(document); then
    echo "docs/OPTIONS.md is not what --help says: run bash docs/make_options.sh" >&2
    exit 1
  fi
else
  document > docs/OPTIONS.md.new
  mv docs/OPTIONS.md.new docs/OPTIONS.md
fi
