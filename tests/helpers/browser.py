"""A page in a headless browser."""

import shutil
import subprocess

import pytest

CHROMIUM = "--headless --no-sandbox --disable-gpu --no-first-run --virtual-time-budget=5000"


def shown(path, folder, *options):
    """The DOM of a page in a browser, and what its console said."""
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("no chromium on the PATH")
    command = [chromium, *CHROMIUM.split(), f"--user-data-dir={folder}/profile", *options]
    done = subprocess.run(
        [*command, "--enable-logging=stderr", "--v=0", "--dump-dom", path.as_uri()],
        capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]
