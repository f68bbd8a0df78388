#!/usr/bin/env bash
# Who may include whom. Layers: apps -> vo -> nn, weights_tools -> nn; both commands -> command_line.
# Rooms of vo: the table below.
# Names each line that goes against an arrow; exit code 1 if there is one. The folder that is
# checked is the repository, or the argument (for the test of this test).
set -euo pipefail
cd "${1:-$(dirname "$0")/../..}"

find nn command_line vo weights_tools apps -name '*.cc' -o -name '*.h' | sort | xargs awk '
BEGIN {
  # A room: the rooms and layers whose public headers it sees. nn_base: errors and whole files.
  sees["vo/core"] = "nn_base"
  sees["vo/geometry"] = "nn_base core"
  sees["vo/io"] = "nn_base core geometry"
  sees["vo/evaluation"] = "nn_base core"
  sees["vo/frontend"] = "nn_base nn core geometry io"
  sees["vo/inertial"] = "nn_base core geometry"
  sees["vo/estimator"] = "nn_base core geometry inertial"
  sees["vo/mapping"] = "nn_base nn core geometry io frontend"
  sees["vo/pipeline"] = "nn_base nn core geometry io evaluation frontend inertial estimator mapping"
  sees["vo/doctor"] = "nn_base core geometry io"
  sees["vo/simulation"] = "nn_base core geometry io"
  sees["nn"] = "nn_base nn"
  sees["nn/base"] = "nn_base"
  sees["command_line"] = "nn_base"
  sees["weights_tools"] = "nn_base nn weights_tools"
  sees["apps"] = "nn_base nn core geometry io evaluation frontend inertial estimator mapping pipeline doctor simulation"
}

function home_of(path, parts) {
  split(path, parts, "/")
  if (parts[1] == "vo") return "vo/" (parts[2] == "include" ? parts[5] : parts[2])
  return path ~ /^nn\/base\// ? "nn/base" : parts[1]
}

function room_of(header, parts) {
  split(header, parts, "/")
  if (parts[2] == "vo") return parts[3]
  if (parts[2] == "weights_tools") return "weights_tools"
  return header ~ /^gluevo\/nn\/(error|option_error|output_file|replaced_file|stand_in)\.h$/ ? "nn_base" : "nn"
}

function complain(why) {
  printf "%s:%d: %s\n", FILENAME, FNR, why
  wrong = 1
}

/^#include "gluevo\// {
  split($0, quoted, "\"")
  home = home_of(FILENAME)
  room = room_of(quoted[2])
  if (!(home in sees)) {
    complain("a folder that the table of tests/style/include_rule.sh does not know: " home)
  } else if (home != "vo/" room && index(" " sees[home] " ", " " room " ") == 0) {
    complain(home " must not see " quoted[2])
  }
}

# Of the commands alone.
/^#include "command_line/ && !/"command_line\.h"/ {
  if (home_of(FILENAME) !~ /^(apps|weights_tools|command_line)$/) {
    complain(home_of(FILENAME) " must not see the command line")
  }
}

# A private header is seen by its room alone. Kernels and nn/src are one room.
/^#include "/ && !/"gluevo\// {
  split($0, quoted, "\"")
  folder = FILENAME
  sub(/\/[^\/]*$/, "", folder)
  if (folder ~ /^vo\/include/) {
    complain("a public header must not see the private header " quoted[2])
  } else if (folder ~ /^vo\// && quoted[2] ~ /\//) {
    complain("the private header of another folder: " quoted[2])
  }
}

/^#include <ceres\// && FILENAME ~ /\/include\// {
  complain("public headers are free of the solver")
}

END { exit wrong }'
