#!/usr/bin/env bash
# Peak memory of `gluevo run` over a sequence and over the same frames there and back ten times: it
# must not grow with the length. (Places, that loops keep, do.)
#   bench/memory.sh KITTI_SEQUENCE [FRAMES] [GLUEVO]
set -euo pipefail

sequence=$(realpath "$1")
frames=${2:-500}
gluevo=${3:-$(dirname "$0")/../build/release/apps/gluevo}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

count=$(wc -l < "$sequence/times.txt")
for length in "$count" "$frames"; do
  looped=$work/$length
  mkdir -p "$looped/image_0" "$looped/image_1"
  cp "$sequence/calib.txt" "$looped/"
  for ((i = 0; i < length; ++i)); do
    # 0 1 2 ... n-1 n-2 ... 1 0 1 ...: the motion stays smooth.
    period=$((2 * count - 2))
    phase=$((i % period))
    source=$((phase < count ? phase : period - phase))
    for camera in 0 1; do
      ln -s "$(printf '%s/image_%d/%06d.png' "$sequence" "$camera" "$source")" \
        "$(printf '%s/image_%d/%06d.png' "$looped" "$camera" "$i")"
    done
    awk -v i="$i" 'BEGIN { printf "%.6f\n", i / 10 }' >> "$looped/times.txt"
  done
  "$gluevo" run "$looped" -o "$work/out$length" --loops off >/dev/null 2>&1
  printf '%s frames: ' "$length"
  grep -o '"peak_memory_mb": [0-9.]*' "$work/out$length/metrics.json"
done
