#!/usr/bin/env bash
# Programs that tests need from outside PyPI, and parsers with packages of their own.
# As root on Debian, else only what pip gives.
set -euo pipefail
cd "$(dirname "$0")/../.."
packages=(gcc g++ clang) # C
packages+=(make)         # FMUs, which FMPy builds
# C on microcontrollers
packages+=(gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm gcc-avr avr-libc simavr)
packages+=(fuzzylite)    # FLL, FCL
linuxcnc=(linuxcnc-uspace linuxcnc-uspace-dev make) # in Debian from 12 on
packages+=(octave octave-fuzzy-logic-toolkit) # FIS, MAT
command -v chromium >/dev/null || packages+=(chromium) # reports as wide as a phone
command -v node >/dev/null || packages+=(nodejs) # JavaScript
if command -v apt-get >/dev/null && [ "$(id -u)" = 0 ]; then
    apt-get -o DPkg::Lock::Timeout=600 update -qq
    apt-cache show "${linuxcnc[@]}" >/dev/null 2>&1 && packages+=("${linuxcnc[@]}")
    DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600 install -y -qq \
        --no-install-recommends "${packages[@]}" >/dev/null
fi
# pyfuzzylite needs an older NumPy than this project: an environment of its own.
if ! .venv-fuzzylite/bin/python -c "import fuzzylite" 2>/dev/null; then
    .venv/bin/python -m venv .venv-fuzzylite
    .venv-fuzzylite/bin/pip install -q --require-hashes -r requirements/fuzzylite.txt
fi
# Parsers of Structured Text and of PLCopen's XML; blark wants packages of its own. Beside them the
# sources of two releases, which are unpacked and not built.
if [ ! -d .venv-st/sources ]; then
    .venv/bin/python -m venv .venv-st
    .venv-st/bin/pip install -q --require-hashes -r requirements/st.txt
    .venv-st/bin/pip download -q --require-hashes --no-deps --no-binary :all: --no-build-isolation \
        -r requirements/sources.txt -d .venv-st/packed
    mkdir .venv-st/unpacked
    for file in .venv-st/packed/*.tar.gz; do tar xzf "$file" -C .venv-st/unpacked; done
    mv .venv-st/unpacked .venv-st/sources
fi
# Reads FMUs.
if [ ! -x .venv-fmpy/bin/python ]; then
    .venv/bin/python -m venv .venv-fmpy
    .venv-fmpy/bin/pip install -q --require-hashes -r requirements/fmpy.txt
fi
# Oracles of fronts; their packages stand behind this project's, see test_pymoo.py.
if [ ! -x .venv-pymoo/bin/python ]; then
    .venv/bin/python -m venv .venv-pymoo
    .venv-pymoo/bin/pip install -q --require-hashes -r requirements/pymoo.txt
fi
