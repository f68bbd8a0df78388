#!/usr/bin/env bash
# Makes places.safetensors again: the built-in SuperPoint's typical descriptors in twelve rendered
# rooms, 40 images each.
#   nn/open_weights/make_places.sh [GLUEVO]
set -euo pipefail
cd "$(dirname "$0")/../.."
gluevo=${1:-build/release/apps/gluevo}
images=$(mktemp -d)
trap 'rm -rf "$images"' EXIT
for seed in {101..112}; do
  paths=(hall_loop figure_eight)
  "$gluevo" simulate -o "$images/r$((seed - 100))" --path "${paths[seed % 2]}" --duration 20 --rate 1 \
    --seed "$seed" >/dev/null
done
"$gluevo" codebook "$images" -o nn/open_weights/places.safetensors
