#!/usr/bin/env bash
# What bf16 costs: each data set's run with SuperGlue's products in float and in bf16, and the
# matches of two images in both. Prints Markdown.
#   bench/precision.sh IMAGE0 IMAGE1 DATASET...        [environment: GLUEVO, the program; OPTIONS]
set -euo pipefail

gluevo=${GLUEVO:-$(dirname "$0")/../build/release/apps/gluevo}
read -ra options <<< "${OPTIONS:-}"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
image0=$1
image1=$2
shift 2

for precision in float bf16; do
  "$gluevo" match "$image0" "$image1" --json --precision "$precision" "${options[@]}" \
    > "$work/$precision.json"
done
python3 - "$work" <<'END'
import json, sys
runs = [json.load(open(f"{sys.argv[1]}/{precision}.json")) for precision in ("float", "bf16")]
scores = [{(m["x0"], m["y0"], m["x1"], m["y1"]): m["score"] for m in run["matches"]}
          for run in runs]
pairs = [set(s) for s in scores]
both = pairs[0] & pairs[1]
print(f"Matches: {len(pairs[0])} in float, {len(pairs[1])} in bf16, {len(both)} of them the same; "
      f"confidences differ by at most {max(abs(scores[0][p] - scores[1][p]) for p in both):.3f}.\n")
END
echo '| data | precision | ATE SE(3), m | RPE, % | correct motions |'
echo '| --- | --- | --- | --- | --- |'
for dataset in "$@"; do
  for precision in float bf16; do
    "$gluevo" run "$dataset" -o "$work/$precision" --precision "$precision" "${options[@]}" \
      2>&1 | grep '^ATE' |
      sed -E "s#^ATE ([0-9.]+) m.*RPE ([0-9.]+|nan|-)[^;]*; correct motions ([^;]*);.*#| $(basename "$dataset") | $precision | \1 | \2 | \3 |#"
    rm -rf "${work:?}/$precision"
  done
done
