"""A report in a browser as wide as a phone."""

import html
import json
import re
import shutil
import subprocess

import pytest

# The smallest window of a desktop browser is wider than a phone; a frame is not.
PHONE = """<!DOCTYPE html>
<iframe width="400" height="800" srcdoc="{}"></iframe>
<pre id="sizes"></pre>
<script>addEventListener("load", () => {{
  const frame = document.querySelector("iframe").contentWindow;
  const all = [...frame.document.querySelectorAll("figure, img, svg")];
  const figures = all.filter((one) => one.getClientRects().length).map((element) => {{
    const box = element.getBoundingClientRect();
    return [element.localName, box.left, box.right, box.height];
  }});
  document.querySelector("pre").textContent = JSON.stringify(
    [frame.innerWidth, frame.document.documentElement.scrollWidth, figures]);
}});</script>
"""


def figures_that_fit(report, folder):
    """Number of figures that a page shows; none of it may be wider than the phone."""
    window, width, figures = measured(PHONE, report, folder)
    assert window == 400
    assert width <= 400
    for name, left, right, height in figures:
        assert 0 <= left < right - 50, name
        assert right <= 400, name
        assert height > 50, name
    return sum(name == "figure" for name, *_ in figures)


#: What a report of some width says of the answer whether it can be used.
ANSWER = """<!DOCTYPE html>
<iframe width="{}" height="800" srcdoc="{}"></iframe>
<pre id="sizes"></pre>
<script>addEventListener("load", () => {{
  const frame = document.querySelector("iframe").contentWindow;
  const table = frame.document.querySelector(".used .scroll");
  const others = [...frame.document.querySelectorAll(".used + p, .used ~ ul li")].map((one) => {{
    const text = frame.document.createRange();
    text.selectNodeContents(one);
    const box = text.getBoundingClientRect();
    return [box.left, box.right];
  }});
  document.querySelector("pre").textContent = JSON.stringify(
    [frame.innerWidth, [table.clientWidth, table.scrollWidth], ...others]);
}});</script>
"""


def widths(report, folder, width):
    """Width of the window; of the first table and of what is in it; left and right of reasons."""
    return measured(ANSWER, report, folder, width)


def measured(frame, report, folder, *values):
    """What a page that frames the report says of it."""
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("no chromium on the PATH")
    page = folder / "phone.html"
    page.write_text(frame.format(*values, html.escape(report.read_text())))
    options = (
        "--headless --no-sandbox --disable-gpu --disable-background-networking --no-first-run "
        f"--user-data-dir={folder}/profile --enable-logging=stderr --v=0 "
        "--dump-dom"
    )
    done = subprocess.run(
        [chromium, *options.split(), page.as_uri()],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    assert [line for line in done.stderr.splitlines() if "CONSOLE" in line] == []
    found = re.search(r'<pre id="sizes">(.*?)</pre>', done.stdout)
    assert found is not None
    return json.loads(found[1])
