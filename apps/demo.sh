#!/usr/bin/env bash
# The demo: installs what is missing, builds, renders a stereo flight of 20 seconds, runs odometry on
# it by every method with the weights that the repo carries, and prints the table of their errors and
# the path of a report. Results in build/demo; what is done already is not done again.
set -euo pipefail
cd "$(dirname "$0")/.."

mapfile -t packages < cmake/packages.txt
bash cmake/install_packages.sh "${packages[@]}"
cmake --preset release -DGLUEVO_BUILD_TESTS=OFF -DGLUEVO_BUILD_BENCH=OFF >/dev/null
cmake --build --preset release --target gluevo

gluevo=build/release/apps/gluevo
if [ ! -d build/demo/hall ]; then
  "$gluevo" simulate -o build/demo/hall --path hall_loop --duration 20
fi
"$gluevo" experiment apps/experiments/demo.yaml -o build/demo/results
