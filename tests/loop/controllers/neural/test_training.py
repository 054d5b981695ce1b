"""A network off line and on line: taught, simulated, searched, refused, and one that diverges."""

from math import isnan

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from click.testing import CliRunner
from made_up import network
from wording import refused_command

import hfc_design.api as hfc
from hfc_design.cli import main
from hfc_design.controllers.kind import ReportContext
from hfc_design.controllers.neural.law import Weights, changes, passed
from hfc_design.core.numbers import SCALARS
from hfc_design.runtime import Controller

SHORT = {"simulation.duration_s": 4.0}


def run(*arguments):
    done = CliRunner().invoke(main, [str(argument) for argument in arguments])
    assert done.exit_code == 0, done.output
    return done.output


def test_the_command_writes_a_design_that_goes_on_learning(tmp_path):
    path = tmp_path / "network.json"
    short = ("--set", "simulation.duration_s=4")
    options = (*short, "--network", "rate=1e-3", "--hidden", 4, "--seed", 3)
    told = run("train", "jee-koren-2004-pid", *options, "--out", path)
    assert told.startswith("800 samples of ")  # two axes at 100 Hz
    design = hfc.load_design(path)
    assert design.name == "neural-jee-koren-2004-pid"
    assert design.plant.axes["x"]["gain"] == 40.0  # of the machine that was moved, not the default
    taught = design.provenance["taught"]
    assert taught["by"] == "jee-koren-2004-pid"
    assert taught | {"rate": 0.5, "passes": 1, "hidden": 4, "seed": 3} == taught
    scenario = hfc.load_scenario("feed-drive-circle", SHORT)
    again = hfc.taught("jee-koren-2004-pid", scenario, {"rate": 1e-3}, lesson=hfc.Lesson(4, 3))
    assert again.design.controller == design.controller
    evaluation = hfc.evaluate(design, scenario)
    assert not evaluation.diverged
    x, y = hfc.learned_in(design, scenario, evaluation).controller.axes.values()
    assert x.weights != y.weights != design.controller.weights
    controller = Controller(design)
    for error in evaluation.axes[0].sensed()["error"].tolist():
        controller.step({"error": error})
    found = controller.adapted()
    assert np.array(found.weights.hidden) == pytest.approx(np.array(x.weights.hidden), abs=1e-9)
    # What is learnt is where a next lesson begins.
    more = hfc.taught("jee-koren-2004-pid", scenario, start=design)
    assert more.training.before == pytest.approx(again.training.after, rel=1e-12)
    shown = ReportContext(
        scenario.plant.machine, scenario.plant.values(), {"x": {"error": np.ones(3)}}
    )
    (section,) = design.kind.sections(design.controller, shown)
    assert len(section.drawings) == 2  # as designed, and after the motion


def test_one_that_diverges_stops_safely():
    """On line beyond all numbers: faulty samples, and weights as before them."""
    design = network(0, 4, rate=1e6, error_unit=1e-160, slope=1.0)
    controller = Controller(design)
    commands = [controller.step({"error": 30.0 * (-1) ** k}) for k in range(400)]
    assert isnan(commands[-1])
    assert np.isfinite(controller.adapted().weights.output).all()  # as before the faulty sample


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--training-rate", "500"),
        ("--hidden", "101"),
        ("--network", "slope=-1"),
        ("--network", "speed=1"),
        ("--start", "pd-only"),
        ("--set", "sensors.noise=0.1"),
    ],
)
def test_a_lesson_that_cannot_be_is_refused(option, value, tmp_path):
    path, short = tmp_path / "network.json", ("--set", "simulation.duration_s=4")
    own = ("train", "jee-koren-2004-pid", *short, option, value, "--out", path)
    found = refused_command(*own)
    assert option in found or "sensors" in found
    assert len(found.splitlines()) == 1
    assert not path.exists()


RATE, SLOPE = 0.3, 0.7


def cost(weights, inputs, targets):
    """Half the sum of the squares of the output errors, written once more with matrices."""
    hidden, output = weights
    active = jnp.tanh(SLOPE * (hidden[:, :-1] @ inputs + hidden[:, -1]))
    return 0.5 * jnp.sum((targets - output[:, :-1] @ active - output[:, -1]) ** 2)


def test_weights_move_down_the_derivative_of_the_squares():
    random = np.random.default_rng(0)  # two inputs, five hidden units, two outputs
    weights = Weights(random.normal(size=(5, 3)).tolist(), random.normal(size=(2, 6)).tolist())
    still, inputs, targets = Weights([[0.0] * 3] * 5, [[0.0] * 6] * 2), [0.4, -1.1], [0.3, -2.0]
    answer = passed(SCALARS, weights, SLOPE, inputs)
    off = [t - o for t, o in zip(targets, answer.outputs, strict=True)]
    moved = changes(SCALARS, weights, still, answer, off, RATE, 0.9, SLOPE)
    with jax.enable_x64(True):
        own = Weights(*map(jnp.array, weights))
        found = jax.jit(jax.grad(cost))(own, *map(jnp.array, (inputs, targets)))
    for steps, slopes in zip(moved, found, strict=True):
        np.testing.assert_allclose(np.array(steps), -RATE * np.array(slopes), rtol=1e-12)
