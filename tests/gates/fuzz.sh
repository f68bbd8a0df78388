#!/usr/bin/env bash
# Each fuzzer over its corpus and on from there, for some seconds. What fails is kept in
# build/fuzz/findings.
#   tests/gates/fuzz.sh [SECONDS]
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-15}

bash tests/gates/install.sh
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
cmake --preset fuzz >/dev/null
mapfile -t readers < <(ninja -C build/fuzz -t targets all |
  sed -nE 's/^([a-z0-9_]+)_fuzzer: phony$/\1/p' | grep -v '^cmake_object_order_' | sort -u)
if [ ${#readers[@]} -eq 0 ]; then
  echo "no fuzzer is built by tests/fuzz/CMakeLists.txt" >&2
  exit 1
fi
cmake --build --preset fuzz --target "${readers[@]/%/_fuzzer}"

fuzz() {
  local reader=$1 seeds=tests/fuzz/corpus/$1 folder=build/fuzz/findings/$1
  local count
  count=$(find "$seeds" -type f | wc -l)
  rm -rf "$folder"
  mkdir -p "$folder/corpus"
  if ! "build/fuzz/tests/fuzz/${reader}_fuzzer" -max_len=20000 -timeout=20 -rss_limit_mb=2048 \
    -max_total_time="$seconds" -artifact_prefix="$folder/" "$folder/corpus" "$seeds" \
    >"$folder/log" 2>&1; then
    echo "$reader: a finding, see $PWD/$folder"
    tail -n 60 "$folder/log"
    return 1
  fi
  local runs
  runs=$(sed -nE 's/^Done ([0-9]+) runs.*/\1/p' "$folder/log")
  echo "$reader: $count seeds, ${runs:-no} runs"
  [ "$count" -gt 0 ] && [ "${runs:-0}" -ge "$count" ]
}
export -f fuzz
export seconds
printf '%s\n' "${readers[@]}" | xargs -P "$(nproc)" -I{} bash -c 'fuzz {}'
