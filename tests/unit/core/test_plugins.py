"""Own plants, fitnesses and control laws: how they come in, and what they compute."""

import re

from sledge import SCENARIO, hfc, imported, installed
from wording import refused, refused_command

from hfc_design import api
from hfc_design.controllers.kinds import KINDS
from hfc_design.files.machine import ALL_PLANTS


def test_entry_points(own, tmp_path):
    installed(
        tmp_path,
        "[hfc_design.plants]",
        "sledge = mine:SLEDGE",
        "rocket = mine:ROCKET",
        "other = mine:SLEDGE",
        "[hfc_design.fitness]",
        "last-error = mine:LAST",
        "[hfc_design.controllers]",
        "only-p = mine:P",
    )
    text = SCENARIO + "[fitness]\nkind = 'last-error'\n[controller]\nkind = 'only-p'\n"
    (tmp_path / "sledge.toml").write_text(text)
    scenario = api.load_scenario("sledge.toml")
    assert scenario.plant.machine.name == "sledge"
    assert scenario.judge().objectives[0].name == "last-error"
    assert scenario.controller.kind == KINDS.get("only-p").name == "only-p"
    for name in ("rocket", "other"):
        refused_command("design", "sledge.toml", "--plant", name)


def test_lists_show_what_packages_bring(own, tmp_path):
    installed(tmp_path, "[hfc_design.plants]", "sledge = mine:SLEDGE")
    done = hfc("list", "plants")
    assert done.exit_code == 0, done.output
    assert "sledge" in done.stdout
    assert re.search(r"\nmass +[\d.]+.*\nfriction +[\d.]+", done.stdout)


def test_a_built_in_plant_cannot_be_replaced(own, tmp_path):
    installed(tmp_path, "[hfc_design.plants]", "c-axis = mine:SLEDGE")
    built_in = ALL_PLANTS.get("c-axis")
    (drive,) = api.load_scenario("c-axis-ramp").plant.machine.drives
    assert drive is built_in
    with refused():
        api.register(imported("mine").TAKEN)


def test_an_own_one_can_be_registered_again(own):
    """A cell of a notebook runs twice, with another object under the same name."""
    mine = imported("mine")
    api.register(mine.SLEDGE)
    heavier = api.register(mine.sledge())
    assert ALL_PLANTS.get("sledge") is heavier


def test_two_packages_with_one_name_are_refused(own, tmp_path):
    for name in ("a", "b"):
        folder = tmp_path / name
        folder.mkdir()
        installed(folder, "[hfc_design.plants]", "sledge = mine:SLEDGE")
        place = folder / "sledges-1.0.dist-info"
        place.rename(folder / f"{name}-1.0.dist-info")
        metadata = folder / f"{name}-1.0.dist-info" / "METADATA"
        metadata.write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    with refused():
        ALL_PLANTS.get("sledge")
