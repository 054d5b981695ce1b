#!/usr/bin/env bash
# What the read-back tests of the export formats need; as root on Debian, else only what pip gives.
set -euo pipefail
cd "$(dirname "$0")/../.."
packages=(gcc)
packages+=(fuzzylite) # FLL, FCL
if command -v apt-get >/dev/null && [ "$(id -u)" = 0 ]; then
    apt-get -o DPkg::Lock::Timeout=600 update -qq
    DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600 install -y -qq \
        --no-install-recommends "${packages[@]}" >/dev/null
fi
# pyfuzzylite needs an older NumPy than this project: an environment of its own.
if ! .venv-fuzzylite/bin/python -c "import fuzzylite" 2>/dev/null; then
    .venv/bin/python -m venv .venv-fuzzylite
    .venv-fuzzylite/bin/pip install -q "pyfuzzylite==8.*" "numpy<2"
fi
