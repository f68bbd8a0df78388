#!/usr/bin/env bash
# The demo: installs what is missing, builds, renders a stereo sequence and runs odometry on it with
# the weights that the repo carries. Results in build/demo.
set -euo pipefail
cd "$(dirname "$0")/.."

mapfile -t packages < cmake/packages.txt
bash cmake/install_packages.sh "${packages[@]}"
cmake --preset release -DGLUEVO_BUILD_TESTS=OFF -DGLUEVO_BUILD_BENCH=OFF >/dev/null
cmake --build --preset release

gluevo=build/release/apps/gluevo
if [ ! -d build/demo/hall ]; then
  "$gluevo" simulate -o build/demo/hall --path hall_loop --duration 20
fi
for method in klt superglue; do
  echo "--- method $method"
  "$gluevo" run build/demo/hall -o "build/demo/$method" --method "$method"
done
"$gluevo" evaluate build/demo/superglue/trajectory.tum \
  build/demo/hall/mav0/state_groundtruth_estimate0/data.csv --plot build/demo/superglue/plot.svg
echo "trajectory over ground truth: build/demo/superglue/plot.svg"
