"""Own plants, fitnesses and control laws that are refused."""

import json
import sys

import pytest
from sledge import BUDGET, MODULE, api_text, imported, refused, scenario_of

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
            assert "evil" in refused("design", "bad.toml", "--out", "run")
        design = json.loads(api_text("pd-only"))
        for part, key in (("plant", "name"), ("controller", "kind")):
            changed = design | {part: design[part] | {key: kind}}
            (own / "bad.json").write_text(json.dumps(changed))
            assert "bad.json" in refused("score", "bad.json")
    assert not (own / "ran").exists()
    assert "evil" not in sys.modules
    assert "looks" not in refused("design", "bad.toml", "--plant", "evil:PLANT")
    assert (own / "ran").exists()  # the command line may


def test_what_is_missing_is_said(own):
    line = refused("design", "sledge.toml")
    for part in ("sledge.toml: plant.name = 'sledge'", "c-axis,", "--use module:OBJECT"):
        assert part in line
    (own / "own.toml").write_text("fitness = { kind = 'smooth' }\n")
    line = refused("design", "own.toml")
    for part in ("fitness.kind = 'smooth'", "lin-lee,", "contour,", "--use module:OBJECT"):
        assert part in line
    (own / "own.toml").write_text("controller = { kind = 'mpc' }\n")
    line = refused("design", "own.toml")
    for part in ("controller.kind = 'mpc'", "pid,", "aflc,", "--use module:OBJECT"):
        assert part in line


@pytest.mark.parametrize(
    ("option", "reference", "words"),
    [
        ("plant", "nowhere:PLANT", ["--plant nowhere:PLANT", "ModuleNotFoundError", "nowhere"]),
        ("plant", "broken:PLANT", ["broken cannot be imported", "ZeroDivisionError"]),
        ("plant", "mine:ROCKET", ["mine has no ROCKET"]),
        ("plant", "mine:", ["module:OBJECT"]),
        ("plant", ":SLEDGE", ["module:OBJECT"]),
        ("plant", "mine:step", ["is a function and no Drive or Machine"]),
        ("plant", "mine:Parameters", ["is a type and no Drive or Machine"]),
        ("plant", "mine:P", ["is a Law and no Drive or Machine"]),
        ("plant", "mine:TAKEN", ["'c-axis' is built in", "another name"]),
        ("plant", "mine:BAD_NAME", ["'my sledge'", "letters"]),
        ("plant", "mine:NO_UNIT", ["'sledge'", "units has no 'speed'"]),
        ("plant", "mine:NO_FIELD", ["no field 'angle'"]),
        ("plant", "mine:OWN_ERROR", ["'error' is a signal of the loop"]),
        ("plant", "mine:NO_DEFAULTS", ["default"]),
        ("plant", "mine.py:SLEDGE", ["--plant mine.py:SLEDGE: ", "did you mean mine:SLEDGE?"]),
        ("plant", "mine.SLEDGE", ["--plant mine.SLEDGE: ", "did you mean mine:SLEDGE?"]),
        ("plant", "mine.py", ["--plant mine.py: ", "did you mean mine:OBJECT?"]),
        ("plant", "mine:SLEDG", ["mine has no SLEDG; did you mean mine:SLEDGE?"]),
        ("plant", "rocket", ["'rocket' is no plant", "feed-drive,"]),
        ("controller", "mine:SLEDGE", ["is a Drive and no Law or Kind"]),
        ("controller", "mine:NO_RANGE", ["ranges.p", "[low, high]"]),
        ("controller", "mine:NO_RECORD", ["NamedTuple"]),
        ("fitness", "mine:FITNESS_TAKEN", ["'contour' is built in"]),
        ("fitness", "mine:step", ["is a function and no Objective"]),
    ],
)
def test_references_that_cannot_be_used(own, option, reference, words):
    line = refused("design", "sledge.toml", f"--{option}", reference)
    for word in words:
        assert word in line


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
        (["--plant", "mine:SHRINKING"], ["step has to return the record State"]),
        (
            ["--controller", "mine:BLIND"],
            ["controller 'only-p': its law reads 'mood'", "no signal"],
        ),
        (["--fitness", "mine:GROWING"], ["fitness 'last-error' cannot", "number became tuple"]),
    ],
)
def test_own_code_that_cannot_be_simulated_is_named(own, options, words):
    sledge = ["sledge.toml"] if "--plant" in options else ["c-axis-ramp"]
    if "--fitness" in options:
        sledge += ["--controller", "pd"]
    line = refused("design", *sledge, *options, "--out", "run", *BUDGET)
    for word in words:
        assert word in line


def test_settings_of_an_own_law_are_checked(own):
    api.register(imported("mine").P)
    for ranges, words in (
        ({"q": (1.0, 2.0)}, ["ranges.q", "unknown", "there is p"]),
        ({"p": (2.0, 1.0)}, ["ranges.p", "[low, high]"]),
        ({"p": 3.0}, ["controller.ranges.p = 3.0"]),
    ):
        with pytest.raises(api.UserError) as error:
            api.load_scenario({"controller": {"kind": "only-p", "ranges": ranges}})
        for word in words:
            assert word in str(error.value)
    scenario = api.load_scenario("c-axis-ramp")
    for kind, gains, word in (
        ("only-p", {"k": 1.0}, "controller.gains.p: is missing"),
        ("only-p", {}, "controller.gains.p: is missing"),
        ("pd", {"kp": 1.0}, "controller.pd.kd: is missing"),
        ("nothing", {}, "no controller known here"),
    ):
        with pytest.raises(api.UserError, match=word):
            api.with_gains(scenario, kind, gains)
    with pytest.raises(api.UserError, match="lin-lee-1999"):
        api.load_scenario(scenario_of("only-p") | {"search": {"preset": "lin-lee-1999"}})


def test_a_machine_of_own_axes_follows_no_path(own):
    api.register(imported("mine").SLEDGE)
    with pytest.raises(api.UserError, match="is for feed drives, not for the sledge"):
        api.load_scenario(
            "feed-drive-circle", {"plant": {"name": "sledge", "axes": {"x": {}, "y": {}}}}
        )


@pytest.mark.parametrize("name", [".x", "a..b", "x" * 5000 + ".y", "a\0.b"])
def test_names_that_no_module_can_have(name):
    with pytest.raises(UserError):
        GROUPS["plant"].resolve(name)
