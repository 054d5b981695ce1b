"""Own plants, fitnesses and control laws that are refused."""

import json
import sys

import pytest
from run_folders import hfc
from sledge import BUDGET, MODULE, SCENARIO, api_text, imported, scenario_of
from wording import refused, refused_command

from hfc_design import api
from hfc_design.core.plugins import GROUPS
from hfc_design.core.records import UserError


def test_a_file_alone_imports_nothing(own):
    (own / "evil.py").write_text("from pathlib import Path\nPath('ran').touch()\nPLANT = 1\n")
    for kind in ("evil:PLANT", "evil", "evil.PLANT"):
        for text in (
            f"[plant]\nname = '{kind}'\n",
            f"[fitness]\nkind = '{kind}'\n",
            f"[controller]\nkind = '{kind}'\n",
        ):
            (own / "bad.toml").write_text(text)
            assert "evil" in hfc("design", "bad.toml", "--out", "run").stderr
        design = json.loads(api_text("pd-only"))
        for part, key in (("plant", "name"), ("controller", "kind")):
            changed = design | {part: design[part] | {key: kind}}
            (own / "bad.json").write_text(json.dumps(changed))
            assert "bad.json" in hfc("score", "bad.json").stderr
    assert not (own / "ran").exists()
    assert "evil" not in sys.modules
    refused_command("design", "bad.toml", "--plant", "evil:PLANT")
    assert (own / "ran").exists()  # the command line may


@pytest.mark.parametrize(
    "text", [SCENARIO, "fitness = { kind = 'smooth' }\n", "controller = { kind = 'mpc' }\n"]
)
def test_what_is_missing_is_said(text, own):
    (own / "own.toml").write_text(text)
    assert refused_command("design", "own.toml").where == "own.toml"


REFERENCES = {
    "plant": (
        "nowhere:PLANT broken:PLANT mine:ROCKET mine: :SLEDGE mine:step "
        "mine:Parameters mine:P mine:TAKEN mine:BAD_NAME mine:NO_UNIT "
        "mine:NO_FIELD mine:OWN_ERROR mine:NO_DEFAULTS mine.py:SLEDGE "
        "mine.SLEDGE mine.py mine:SLEDG rocket"
    ),
    "controller": "mine:SLEDGE mine:NO_RANGE mine:NO_RECORD",
    "fitness": "mine:FITNESS_TAKEN mine:step",
}


@pytest.mark.parametrize(
    ("option", "reference"),
    [(option, one) for option, every in REFERENCES.items() for one in every.split()],
)
def test_references_that_cannot_be_used(own, option, reference):
    line = refused_command("design", "sledge.toml", f"--{option}", reference)
    assert line.count("\n") == 1


def line_of(text):
    """The line of mine.py in which a text stands."""
    (found,) = [k for k, line in enumerate(MODULE.split("\n"), 1) if text in line]
    return found


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--plant", "mine:BRANCHING"], ["plant 'sledge' cannot", "TracerBoolConversionError"]),
        (
            ["--plant", "mine:BRANCHING"],
            [f"in mine.py, line {line_of('if force > 0.0')}, branching", "jnp.where(condition,"],
        ),
        (
            ["--plant", "mine:WAVING"],
            [f"in mine.py, line {line_of('math.sin')}, waving", "jnp.sin for math.sin"],
        ),
        (["--plant", "mine:SHRINKING"], ["step must return the record State"]),
        (
            ["--controller", "mine:BLIND"],
            ["controller 'only-p': reads 'mood'", "not a signal"],
        ),
        (["--fitness", "mine:GROWING"], ["fitness 'last-error' cannot", "number became tuple"]),
    ],
)
def test_own_code_that_cannot_be_simulated_is_named(own, options, words):
    sledge = ["sledge.toml"] if "--plant" in options else ["c-axis-ramp"]
    if "--fitness" in options:
        sledge += ["--controller", "pd"]
    line = hfc("design", *sledge, *options, "--out", "run", *BUDGET).stderr
    assert line.count("\n") == 1
    for word in words:
        assert word in line


def test_settings_of_an_own_law_are_checked(own):
    api.register(imported("mine").P)
    for ranges in ({"q": (1.0, 2.0)}, {"p": (2.0, 1.0)}, {"p": 3.0}):
        with refused() as found:
            api.load_scenario({"controller": {"kind": "only-p", "ranges": ranges}})
        assert f"ranges.{next(iter(ranges))}" in found.refusal
    scenario = api.load_scenario("c-axis-ramp")
    for kind, gains in (
        ("only-p", {"k": 1.0}),
        ("only-p", {}),
        ("pd", {"kp": 1.0}),
        ("nothing", {}),
    ):
        with refused():
            api.with_gains(scenario, kind, gains)
    with refused():
        api.load_scenario(scenario_of("only-p") | {"search": {"preset": "lin-lee-1999"}})


@pytest.mark.parametrize("name", [".x", "a..b", "x" * 5000 + ".y", "a\0.b"])
def test_names_that_no_module_can_have(name):
    with pytest.raises(UserError):
        GROUPS["plant"].resolve(name)


def test_a_machine_of_own_axes_follows_no_path(own):
    api.register(imported("mine").SLEDGE)
    plant = {"name": "sledge", "axes": {"x": {}, "y": {}}}
    with refused():
        api.load_scenario("feed-drive-circle", {"plant": plant})
