import base64
import json
import re
import shutil
from html.parser import HTMLParser

import numpy as np
import phone
import pytest

from hfc_design.controllers.hierarchical import drawn_tree as diagrams
from hfc_design.controllers.hierarchical import pictures
from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.controllers.hierarchical.genome import Hierarchies
from hfc_design.core.records import RunError, UserError
from hfc_design.files.design import Design
from hfc_design.files.named_scenario import load_scenario
from hfc_design.files.pairing import load_design
from hfc_design.pictures.curves import SLICES
from hfc_design.pictures.files import image, save
from hfc_design.report import plots, searches
from hfc_design.report.errors import errors
from hfc_design.report.page import write_page
from hfc_design.report.parts import sections
from hfc_design.report.verdict import baselines
from hfc_design.runs.run import Result, new_run
from hfc_design.search.loop import Archive, History, Search
from hfc_design.simulation.evaluating import evaluate
from plants import C_AXIS

INPUTS = [
    "error",
    "error_rate",
    "deflection",
    "deflection_rate",
    "spindle_velocity",
    "previous_spindle_velocity",
]
HOSTILE = '<script>alert("1")</script> & <img src=x>'


def design(inputs, tree=0):
    """A design with random rule tables and one of the trees of that many inputs."""
    random = np.random.default_rng(inputs)
    units = hierarchy.trees(inputs)[tree]
    sources = INPUTS[:inputs] + [f"unit-{unit.heap_id}" for unit in units]
    labels = [f"f{k}" for k in range(1, 8)]
    return Design.model_validate(
        {
            "name": "random",
            "plant": {"name": "c-axis", "parameters": {}},
            "controller": {
                "kind": "pd+hierarchical-fuzzy",
                "sample_time_s": 0.001,
                "pd": {"kp": 758.0, "kd": 743.0},
                "inputs": [{"name": name, "scale": 10.0} for name in INPUTS[:inputs]],
                "output_scale": 10.0,
                "terms": [
                    {"label": label, "centre": centre, "half_width": 0.0, "rate": 32.0}
                    for label, centre in zip(labels, np.linspace(-1, 1, 7).tolist(), strict=True)
                ],
                "units": [
                    {
                        "id": unit.heap_id,
                        "column_input": sources[unit.column],
                        "row_input": sources[unit.row],
                        "consequents": random.normal(size=(7, 7)).tolist(),
                    }
                    for unit in units
                ],
            },
            "provenance": {"program": "hfc-design 0", "note": HOSTILE},
        }
    )


def finished(inputs):
    """A search that has tried only some of the trees."""
    trees = len(hierarchy.trees(inputs))
    score = np.where(np.arange(trees) < 12, np.arange(trees) * 10.0, -np.inf)
    population = Hierarchies(
        np.arange(trees),
        np.ones((trees, 2)),
        np.ones((trees, inputs)),
        np.zeros((trees, inputs - 1, 7, 7)),
    )
    history = History(
        np.array([5.0, 50.0]), np.array([0.0, 7.0]), np.array([70, 3]), np.array([3, 2])
    )
    return Search(2, None, Archive(population, score), history)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The arguments of ``write_page``, and the report that it wrote."""
    folder = tmp_path_factory.mktemp("report") / "run"
    changes = ("simulation.duration_s=0.5", f"description={json.dumps(HOSTILE)}")
    scenario = new_run(load_scenario("c-axis-ramp-cutting", changes), folder)
    found = design(5, tree=40)
    names = ("lin-lee-1999-table-1", "lin-lee-1999-table-2", "pd-only")
    rivals = {name: evaluate(load_design(name), scenario) for name in names}
    result = Result(found, evaluate(found, scenario), finished(5))
    write_page(scenario, result, folder, rivals)
    return (scenario, result, folder, rivals), folder / "report.html"


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.addresses, self.images = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.tags.append(tag)
        self.addresses += [found[key] for key in ("src", "href", "xlink:href") if key in found]
        if tag == "img":
            self.images.append(found)


def test_report_stands_alone_and_is_small(report):
    text = report[1].read_text()
    page = Page(text)
    assert len(text) < 1_000_000
    assert page.addresses
    assert all(address.startswith("data:") for address in page.addresses)
    assert "url(" not in text
    assert "@import" not in text
    assert "link" not in page.tags
    for picture in page.images:
        drawing = base64.b64decode(picture["src"].partition(",")[2]).decode()
        assert all(address.startswith(("#", "data:")) for address in Page(drawing).addresses)
        assert picture["alt"]


def test_report_escapes_what_a_user_wrote(report):
    text = report[1].read_text()
    tags = Page(text).tags
    assert tags.count("script") == 5  # the page's own, and numbers of four units
    assert tags.count("img") == tags.count("figure") == 12
    assert text.count("&lt;script&gt;") == 3  # description, configuration, provenance


def test_report_tells_fitness_rivals_and_structures(report):
    (scenario, result, folder, rivals), path = report
    text = path.read_text()
    assert f"{result.evaluation.fitness:.1f} on {scenario.name}" in text
    for evaluation in (result.evaluation, *rivals.values()):
        assert f"{evaluation.fitness:.4f}" in text
    assert "73 individuals diverged" in text
    assert text.count('</th><td class="value">110.0</td>') == 1
    assert len(re.findall(r'<tr><th scope="row">\(', text)) == 10
    assert sorted(file.name for file in (folder / "tables").iterdir()) == sorted(
        ["manifest.csv", *(f"unit-{unit.id}.csv" for unit in result.design.controller.units)]
    )


def test_same_run_gives_the_same_bytes(report):
    arguments, path = report
    first = path.read_bytes()
    write_page(*arguments)
    assert path.read_bytes() == first


def test_report_of_diverged_designs(report, tmp_path):
    (scenario, result, folder, rivals), _ = report
    shutil.copy(folder / "config.toml", tmp_path)
    lost = diverged(scenario)
    write_page(scenario, result._replace(evaluation=lost), tmp_path, {"pd-only": lost})
    text = (tmp_path / "report.html").read_text()
    assert "diverges on c-axis-ramp-cutting" in text
    assert text.count(">diverged<") == 4  # fitness and merit of two designs
    write_page(scenario, result, tmp_path, rivals | {"lin-lee-1999-table-1": lost})
    assert "Table I of Lin &amp; Lee (1999) diverges" in (tmp_path / "report.html").read_text()


def diverged(scenario):
    record = load_design("pd-only").model_dump()
    record["controller"]["pd"] = {"kp": -1e9, "kd": 1e7}
    found = evaluate(Design.model_validate(record), scenario)
    assert found.diverged
    assert not np.isfinite(found.axes[0].motion.error).all()
    return found


def changed(evaluation, **axis):
    """The evaluation with parts of its only axis replaced."""
    return evaluation._replace(axes=(evaluation.axes[0]._replace(**axis),))


def moving(evaluation, values):
    """The motion of its only axis with these values (steps,) for everything."""
    motion = evaluation.axes[0].motion
    state = type(motion.state)(*[values] * len(motion.state))
    return motion._replace(error=values, command=values, state=state)


def nothing_but_nan(evaluation):
    nan = np.full(len(evaluation.time), np.nan)
    lost = changed(evaluation, motion=moving(evaluation, nan))
    return lost._replace(diverged=True)


def test_plots_of_a_diverged_evaluation(report):
    scenario = report[0][0]
    for evaluation in (diverged(scenario), nothing_but_nan(diverged(scenario))):
        drawing = image(plots.response(evaluation, "lost"), "svg").decode()
        assert "lost (diverged at" in drawing
        assert image(errors({"lost": evaluation}), "png")


def test_response_shows_a_load_only_where_there_is_one(report):
    with_load = report[0][1].evaluation
    happens = with_load.axes[0].happens
    without = changed(with_load, happens=happens._replace(loads=np.zeros_like(happens.loads)))
    assert len(plots.response(with_load, "x").axes) == 5
    assert len(plots.response(without, "x").axes) == 4


def test_long_curves_keep_their_peaks(report):
    evaluation = report[0][1].evaluation
    time = 1e-5 * np.arange(100_001)
    error = np.sin(time)
    error[[777, 54_321, -1]] = 5.0, -7.0, 3.0
    long = changed(
        evaluation._replace(time=time),
        happens=evaluation.axes[0].happens._replace(reference=time, loads=[0 * time]),
        motion=moving(evaluation, error),
    )
    line = plots.response(long, "long").axes[1].lines[0]
    assert len(line.get_xdata()) <= 2 * SLICES + 2
    assert np.all(np.diff(line.get_xdata()) > 0)
    assert {5e3, -7e3, 3e3} <= set(line.get_ydata())


def test_history_of_one_generation_where_everything_diverged():
    history = History(np.array([np.nan]), np.array([np.nan]), np.array([30]), np.array([3]))
    assert image(searches.history(history, "merit"), "svg")


@pytest.mark.parametrize(("inputs", "tree"), [(2, 0), (6, 0), (6, 944)])
def test_diagrams_show_every_unit_and_input(inputs, tree):
    found = design(inputs, tree)
    drawing = image(diagrams.drawn_tree(found.controller, C_AXIS), "svg").decode()
    words = {word for name in INPUTS[:inputs] for word in name.split("_")}
    texts = set(re.findall(r">([^<>]+)</t", drawing))
    assert words <= {word for text in texts for word in text.split()}
    assert {f"unit {unit.id}" for unit in found.controller.units} <= texts
    for k, unit in enumerate(found.controller.units):
        drawing = image(pictures.table(found.controller, k), "svg").decode()
        assert f"unit {unit.id}<" in drawing
        assert f"row: {diagrams.readable(unit.row_input)}<" in drawing


def test_diagrams_need_a_hierarchy(report):
    own = report[0][1]
    names = {name: load_design(name) for name in ("pd-only", "lin-lee-1999-table-1")}
    drawn = [
        sum(len(section.drawings) for section in sections(design, own.evaluation, report[0][0]))
        for design in names.values()
    ]
    assert drawn == [0, 9]  # a tree, four tables and four surfaces


@pytest.mark.parametrize(
    ("suffix", "magic"), [("png", b"\x89PNG"), ("PDF", b"%PDF"), ("svg", b"<?xml")]
)
def test_save_response(report, tmp_path, suffix, magic):
    path = tmp_path / f"plot.{suffix}"
    for _ in range(2):
        save(plots.response(report[0][1].evaluation, "title"), path)
        first = path.read_bytes()
        assert first.startswith(magic)
    save(plots.response(report[0][1].evaluation, "title"), path)
    assert path.read_bytes() == first


def test_save_response_refuses_a_suffix(report, tmp_path):
    for name in ("plot.gif", "plot"):
        with pytest.raises(UserError, match=r"has to end in \.png, \.svg or \.pdf$"):
            save(plots.response(report[0][1].evaluation, "title"), tmp_path / name)
    with pytest.raises(RunError, match="cannot be written"):
        save(plots.response(report[0][1].evaluation, "title"), tmp_path / "none" / "plot.png")


@pytest.mark.browser
def test_report_in_a_browser_as_wide_as_a_phone(report, tmp_path):
    assert phone.figures_that_fit(report[1], tmp_path) == 12


def test_tables_are_not_written_through_a_link(tmp_path):
    """It may lead to tables of others, which have the same names."""
    folder = tmp_path / "run"
    scenario = new_run(load_scenario("c-axis-ramp", {"simulation.duration_s": 0.1}), folder)
    design, others = load_design("lin-lee-1999-table-1"), tmp_path / "others"
    others.mkdir()
    (others / "manifest.csv").write_text("precious")
    (folder / "tables").symlink_to(others)
    result = Result(design, evaluate(design, scenario), None)
    with pytest.raises(RunError, match="is a link"):
        write_page(scenario, result, folder, {})
    assert [file.read_text() for file in others.iterdir()] == ["precious"]


def told(share, reasons, scale=1.0):
    values = {"settled_rms_error": 3.57e-6, "chatter": 3.79, "peak_command": 120.0}
    measures = {
        key: {"nominal": x, "median": scale * x, "q95": x, "largest": 1000 * scale * x}
        for key, x in values.items()
    }
    own = {"share": share, "reasons": reasons, "nominal": [], "asked_of": "all"}
    return own | {"measures": measures | {"limit_share": {"median": 0.0, "largest": 0.381}}}


USED = {
    "usable": False,
    "answer": "no: only 99.6 % of 1000 unseen machines within +-15 % keep everything",
    "spread": 0.15,
    "machines": 1000,
    "share": 0.996,
    "interval": [0.9898, 0.9989],
    "gain": [0.455, 16.0],
    "precision": 0.0027,
    "substeps": None,
    "units": {"settled_rms_error": "rad", "chatter": "V", "peak_command": "V"},
    "motions": {
        "ramp": told(1.0, {}) | {"asked_of": "nominal"},
        "position": told(
            0.998, {"is far off": 1, "swings": 2, "breaks unsettled": 2, "stays at a limit": 1}, 2.0
        ),
    },
}


@pytest.fixture
def with_answer(report, tmp_path, monkeypatch):
    """The page of a run with that answer."""
    (scenario, result, folder, rivals), _ = report
    monkeypatch.setattr("hfc_design.report.page.used", lambda *_: json.loads(json.dumps(USED)))
    shutil.copy(folder / "config.toml", tmp_path)
    write_page(scenario, result, tmp_path, rivals)
    return tmp_path / "report.html"


def test_whether_it_can_be_used(with_answer):
    text = with_answer.read_text()
    places = [text.index(part) for part in ("Can I use it?", "only 99.6 %", "<img", "<table")]
    assert places == sorted(places)  # the answer, the picture that shows it, and then tables
    part = text[text.index("On other machines") : text.index("The controller</h2>")]
    heads = re.findall(r'<th scope="col"[^>]*>(.*?)</th>', part)
    assert heads[1:3] == ["keep all [%]", "error once settled [µrad]"]
    rows = re.findall(r'<tr><th scope="row">(.*?)</tr>', part)
    cells = [re.split("<[^>]+>", row)[0::2] for row in rows]
    assert [cell[0] for cell in cells] == ["ramp *", "position"]
    assert part.count("* is asked of the nominal machine alone.") == 1
    assert "keeps everything from 0.455 to at least 16 times the command." in part
    assert cells[0][1:4] == ["100", "3.57 / 3570", "3.79 / 3790"]
    assert cells[1][1:3] == ["99.8", "7.14 / 7140"]
    (why,) = re.findall("<li>(.*?)</li>", part)  # of those motions that some do not keep
    assert why == "position: 2 swing, 2 break unsettled, 1 is far off, 1 stays at a limit"


def test_an_edited_answer_is_left_out(report, with_answer, monkeypatch):
    edited = USED | {"units": {"chatter": "V"}}
    monkeypatch.setattr("hfc_design.report.page.used", lambda *_: edited)
    (scenario, result, _, rivals), _ = report
    write_page(scenario, result, with_answer.parent, rivals)
    assert "Can I use it?" not in with_answer.read_text()


@pytest.mark.browser
@pytest.mark.parametrize("width", [400, 800, 1100, 1300])
def test_what_others_do_is_seen_without_scrolling(with_answer, tmp_path, width):
    (window, (table, scrolled), *others) = phone.widths(with_answer, tmp_path, width)
    assert window == width
    assert table >= scrolled or width == 400
    for left, right in others:
        assert 0 <= left < right <= width


def test_the_loop_of_one_machine_is_a_rival_on_that_machine_only():
    stage = {"name": "x", "plant": {"name": "positioning-stage"}}
    stage |= {"reference": {"kind": "step", "height": 0.01}, "controller": {"kind": "pid"}}
    assert [*baselines(load_scenario(stage))] == ["emps-cascade"]
    assert not baselines(load_scenario(stage, {"plant.parameters.mass": 40.0}))
    other = load_scenario("c-axis-ramp", {"plant.parameters.stiffness": 150.0})
    assert len(baselines(other)) == 3
