"""What a code page lacks stops no command; what goes into a file is UTF-8."""

import io
import json

import pytest
from click.testing import CliRunner
from rich.console import Console
from rich.progress import Progress

from hfc_design.cli import main
from hfc_design.core.console import Fitting

#: Of each code page a letter that it has; none has the second word.
PAGES = {"cp437": "Ω", "cp1252": "€", "latin-1": "ü"}
LACKING = "漢字"


@pytest.mark.parametrize("page", PAGES)
def test_a_name_that_the_code_page_lacks(page, tmp_path):
    runner = CliRunner(charset=page, env={"PYTHONIOENCODING": page})
    path = tmp_path / f"{PAGES[page]}{LACKING}.json"
    done = runner.invoke(main, ["export", "pd-only", "--to", "json", "--out", str(path)])
    assert done.exit_code == 0, done.exception
    assert done.stdout_bytes.decode(page).splitlines()[-1] == str(path).replace(LACKING, "??")
    assert json.loads(path.read_text("utf-8"))["name"] == "pd-only"
    again = runner.invoke(main, ["score", f"{path}x"])
    assert again.exit_code == 2
    assert f"{PAGES[page]}??.jsonx".encode(page) in again.stderr_bytes


@pytest.mark.parametrize("page", PAGES)
def test_a_table_is_drawn_with_what_there_is(page):
    runner = CliRunner(charset=page, env={"PYTHONIOENCODING": page})
    done = runner.invoke(main, ["list", "plants"])
    assert done.exit_code == 0
    assert done.stdout.isascii()
    assert "?" not in done.stdout


def test_a_pipe_gets_utf_8_whatever_the_code_page(tmp_path):
    runner = CliRunner(charset="cp1252", env={"PYTHONIOENCODING": None})
    path = tmp_path / f"ü{LACKING}.json"
    done = runner.invoke(main, ["export", "pd-only", "--to", "json", "--out", str(path)])
    assert done.exit_code == 0
    assert done.stdout_bytes.decode("utf-8").splitlines()[-1] == str(path)


@pytest.mark.parametrize(("page", "dash"), [("cp437", "-"), ("utf-8", "━")])
def test_a_progress_bar_is_drawn_with_what_there_is(page, dash):
    shown = io.TextIOWrapper(io.BytesIO(), encoding=page)
    console = Console(file=shown, width=80, force_terminal=True, color_system=None)
    with Progress(Fitting(console), console=console) as bar:
        bar.update(bar.add_task("machines", total=2, line=""), completed=1)
    shown.flush()
    assert dash * 10 in shown.buffer.getvalue().decode(page)
