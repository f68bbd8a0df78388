#!/usr/bin/env bash
# Makes docs/picture.png: the path and a frame with tracks, as the demo's report shows them.
#   docs/make_picture.sh [REPORT.html]
# Without a report apps/demo.sh is run, which does nothing where its results are there.
set -euo pipefail
report=$(realpath -m "${1:-$(dirname "$0")/../build/demo/results/runs/hall_loop/superglue/report.html}")
cd "$(dirname "$0")/.."

bash cmake/install_packages.sh chromium
if [ $# -eq 0 ]; then
  bash apps/demo.sh
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# The report allows itself no scripts.
{ sed '/http-equiv="Content-Security-Policy"/d' "$report"; echo "<script>"; cat docs/picture.js; echo "</script>"; } >"$folder/page.html"
browse() {
  chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --force-device-scale-factor=1 \
    --blink-settings=preferredColorScheme=1 --user-data-dir="$folder/profile" \
    --window-size=1200,480 "$@" "file://$folder/page.html" 2>/dev/null
}
if ! browse --dump-dom | grep -q "<title>ready</title>"; then
  echo "$report: no report that has a path and frames" >&2
  exit 1
fi
browse --screenshot="$PWD/docs/picture.png"
echo "docs/picture.png: $(($(stat -c %s docs/picture.png) / 1000)) kB"
