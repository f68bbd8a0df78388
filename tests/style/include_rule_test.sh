#!/usr/bin/env bash
# The include rule holds, and finds each kind of breach where there is one.
set -euo pipefail
cd "$(dirname "$0")"
bash include_rule.sh

breach() {
  local file=$1 line=$2 folder
  folder=$(mktemp -d)
  mkdir -p "$folder"/{nn,command_line,vo,weights_tools,apps} "$folder/$(dirname "$file")"
  printf '#pragma once\n%s\n' "$line" >"$folder/$file"
  if bash include_rule.sh "$folder" >"$folder/said" || ! grep -q "^$file:2: " "$folder/said"; then
    echo "not found: $line in $file"
    exit 1
  fi
  rm -r "$folder"
}
breach vo/geometry/camera.cc '#include "gluevo/vo/io/dataset.h"'
breach vo/core/x.cc '#include "gluevo/nn/superpoint.h"'
breach vo/include/gluevo/vo/mapping/map.h '#include "gluevo/vo/pipeline/odometry.h"'
breach vo/include/gluevo/vo/pipeline/odometry.h '#include <ceres/ceres.h>'
breach vo/include/gluevo/vo/io/x.h '#include "text_file.h"'
breach vo/pipeline/x.cc '#include "gluevo/vo/simulation/simulation.h"'
breach vo/pipeline/x.cc '#include "../io/text_file.h"'
breach nn/src/x.cc '#include "gluevo/vo/core/rigid3.h"'
breach weights_tools/src/x.cc '#include "gluevo/vo/core/rigid3.h"'
breach command_line/x.cc '#include "gluevo/vo/core/rigid3.h"'
breach nn/src/x.cc '#include "command_line/message.h"'
breach apps/x.cc '#include "gluevo/weights_tools/convert.h"'
breach vo/attic/x.cc '#include "gluevo/vo/core/rigid3.h"'
