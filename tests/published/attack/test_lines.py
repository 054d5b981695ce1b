"""Long names, keys and values in files: a line of 300 characters, the file and the key in front."""

import json
from pathlib import Path

import pytest
from attack import Attack, rounds
from run_folders import hfc

from hfc_design.files.design import BUILTIN

WORDS = ("x" * 400, "ab, " * 200, "1" * 400, "Ω/" * 300, "k.e.y." * 60, "'[{(" * 99, "\\\\n" * 150)
DESIGN = json.loads((BUILTIN / "lin-lee-1999-table-1.json").read_text())
FLL = Path(__file__).parents[2] / "data/imported/pyfuzzylite-8.0.6-gaussian.fll"
FIS = FLL.with_name("mamdani.fis")
#: Kind of a file -> its suffix, its texts where WORD is long, what is done with it.
FILES = {
    "scenario": (
        ".toml",
        [
            '"WORD" = 1',
            'name = "WORD"',
            '[plant]\nname = "WORD"',
            '[plant.parameters]\n"WORD" = 1',
            '[controller]\nkind = "WORD"',
            "[search]\nWORD = 1",
            '[reference]\nkind = ["WORD", "WORD"]',
            '[[motions]]\nname = "WORD"',
            '[controller]\nkind = "pd"\nranges = {"WORD" = [1, 0]}',
            '[constraints]\n"WORD" = 1',
            '[load]\nfile = "WORD"',
            "WORD",
        ],
        ("score", "pd-only", "--scenario"),
    ),
    "design": (
        ".json",
        [
            json.dumps(DESIGN | {"WORD": 1}),
            json.dumps(DESIGN | {"name": "WORD"}),
            json.dumps(DESIGN | {"plant": {"name": "WORD", "parameters": {}}}),
            json.dumps(DESIGN | {"controller": {"kind": "WORD"}}),
            json.dumps(DESIGN | {"controller": DESIGN["controller"] | {"inputs": ["WORD"] * 9}}),
            json.dumps(DESIGN | {"provenance": {"plugins": {"WORD": {"WORD": "WORD"}}}}),
            json.dumps(DESIGN | {"provenance": {"scenario": {"WORD": "WORD"}}}),
            json.dumps(DESIGN | {"limits": {"axes": {"WORD": {"WORD": "WORD"}}}}),
            '{"WORD": WORD}',
        ],
        ("score",),
    ),
    "batch": (
        ".toml",
        ['[grid]\n"WORD" = [1]', '[grid]\nscenario = ["WORD"]', '[set]\nsearch = "WORD"', "WORD"],
        ("batch",),
    ),
    "plant": (
        ".py",
        [
            'raise ValueError("WORD" * 9)',
            "from plants import PLANTS\nfrom dataclasses import replace\n"
            'OWN = replace(PLANTS["c-axis"], name="own", units={"WORD": "WORD"})',
            "OWN = type('WORD', (), {})()",
        ],
        ("score", "pd-only", "--use"),
    ),
    "G-code": (".ngc", ["G1 X1 WORD", "(WORD", "G1 X1 F100\nG1 XWORD", "#<WORD> = 1"], None),
    "log": (
        ".csv",
        ["time_s,WORD\n0,1\n1,2\n", "time_s,error\n0,WORD\n", "WORD"],
        ("identify", "--plant", "positioning-stage"),
    ),
    "fll": (
        ".fll",
        ["WORD", "Engine: WORD\n  WORD: WORD\n", FLL.read_text() + "WORD"],
        ("import",),
    ),
    "term": (".fll", [FLL.read_text().replace("deflection", "dWORD")], ("import",)),
    "fis": (".fis", ["WORD", FIS.read_text().replace("trimf", "WORD")], ("import",)),
    "tables": (".csv", ["WORD", "a,WORD\nWORD,1\n"], ("import",)),
}


def told(name, place, word, text):
    """Every line of what is said of a file, whose name is long as well."""
    suffix, _, command = FILES[name]
    folder = place / ("long-" * 30) / ("f" * 200)
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{'n' * 100}{len(list(folder.iterdir()))}{suffix}"
    file.write_text(text.replace("WORD", word), encoding="utf-8")
    if command is None:
        found = hfc(
            "score",
            "pd-only",
            "--scenario",
            "feed-drive-contour",
            "--set",
            f"reference.file={file}",
        )
    elif suffix == ".py":
        found = hfc(*command, f"{file.stem}:OWN")
    else:
        found = hfc(*command, file)
    assert found.exit_code in (1, 2), (found.output, found.exception)
    lines = found.stderr.splitlines()
    for line in lines:
        assert line.startswith("hfc: "), line
        assert len(line) <= 300, (len(line), line)
        assert line.isprintable()
    assert "n" * 15 in lines[0] or "reference.file" in lines[0]
    return lines


@pytest.mark.parametrize("name", FILES)
def test_a_line_is_of_three_hundred_characters(name, tmp_path, monkeypatch):
    attack = Attack(f"long lines, {name}")
    monkeypatch.syspath_prepend(str(tmp_path / ("long-" * 30) / ("f" * 200)))
    monkeypatch.chdir(tmp_path)
    words = WORDS[: rounds(3, len(WORDS))]
    for text in FILES[name][1]:
        for word in words:
            attack.input(told, name, tmp_path, word, text)
    attack.end()
