"""A page in a headless browser."""

import re
import shutil
import subprocess

import pytest

CHROMIUM = "--headless --no-sandbox --disable-gpu --no-first-run --virtual-time-budget=5000"


def printed(path, folder):
    """What a page puts on paper: the streams of its PDF."""
    pdf = folder / f"{path.stem}.pdf"
    _run(folder, "--no-pdf-header-footer", f"--print-to-pdf={pdf}", path.as_uri())
    found = re.findall(rb"(?s)stream\r?\n(.*?)endstream", pdf.read_bytes())
    assert found
    return found


def shown(path, folder, *options):
    """The DOM of a page in a browser, and what its console said."""
    done = _run(folder, *options, "--enable-logging=stderr", "--v=0", "--dump-dom", path.as_uri())
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def _run(folder, *options):
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("no chromium on the PATH")
    command = [chromium, *CHROMIUM.split(), f"--user-data-dir={folder}/profile", *options]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
