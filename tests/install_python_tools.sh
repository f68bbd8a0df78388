#!/usr/bin/env bash
# The Python tools that two tests compare with: evo, and torch with transformers. Prints the Python
# that has them. They are kept in ~/.cache/gluevo; where PyPI is not reachable, it says so and exits
# with 1. torch is Debian's, as PyPI's brings gigabytes for GPUs along.
set -euo pipefail
cd "$(dirname "$0")/.."

# Versions that go with Debian 12's numpy and torch.
requirements=(evo==1.38.1 "numpy<1.25" "onnx<1.17" safetensors==0.8.0 transformers==4.49.0)
imports="import evo, numpy, onnx, safetensors.torch, torch, transformers"
key=$(echo "${requirements[@]}" | sha256sum | cut -c1-12)
folder=${XDG_CACHE_HOME:-$HOME/.cache}/gluevo/python-$key
python=$folder/bin/python3

works() {
  [ -x "$python" ] && "$python" -c "$imports" >/dev/null 2>&1
}

bash cmake/install_packages.sh python3-torch python3-venv >&2
if ! works; then
  rm -rf "$folder"
  /usr/bin/python3 -m venv --system-site-packages "$folder"
  echo "installing ${requirements[*]} into $folder" >&2
  if ! timeout 300 "$folder/bin/pip" install --quiet --disable-pip-version-check --no-cache-dir \
    --retries 1 --timeout 20 "${requirements[@]}" >&2 || ! works; then
    rm -rf "$folder"
    echo "no evo, torch and transformers from PyPI: tests that compare with them are skipped" >&2
    exit 1
  fi
fi
echo "$python"
