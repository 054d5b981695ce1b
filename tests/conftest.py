"""What several test modules build their individuals from."""

import gc
import os
import signal
import sys
import sysconfig
import time
from pathlib import Path

if os.environ.get("HFC_BARE"):
    import bare  # noqa: F401

    helpers = str(Path(__file__).parent / "helpers")  # whose sitecustomize.py does so in processes
    os.environ["PYTHONPATH"] = os.pathsep.join([helpers, os.environ.get("PYTHONPATH", "")])

import numpy as np
import oracle
import pytest
import wording
from known_parts import forget, made_known
from lifted import controller_of
from sledge import CONTROLLER, MODULE, SCENARIO

from hfc_design.controllers.hierarchical import tree as hierarchy
from hfc_design.controllers.hierarchical.law import HierarchicalGains
from hfc_design.files.loop_setup import load_design
from hfc_design.report import parts

#: Fixtures of single rooms, for whatever tier.
pytest_plugins = ["report_fixtures", "comparison_fixtures", "batch_fixtures"]
pytest_plugins += ["toy_run", "carried_files", "own_strategies"]

#: Where the modules lie that no test brings.
INSTALLED = tuple(sysconfig.get_paths()[key] for key in ("stdlib", "purelib", "platlib"))

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # A shell began the tests in its background; the commands that they interrupt would not hear.
    signal.signal(signal.SIGINT, signal.default_int_handler)


gc.disable()  # what is imported stays


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Rubbish is looked for among what the tests make, which takes a tenth of the time."""
    result = yield
    gc.freeze()
    gc.enable()
    gc.set_threshold(10_000)
    return result


@pytest.hookimpl(tryfirst=True)  # before what it needs is made
def pytest_runtest_setup():
    if time.time() > float(os.environ.get("HFC_TESTS_UNTIL", "inf")):
        pytest.skip("no time is left, see .ci/run")


@pytest.hookimpl(optionalhook=True)  # of xdist, whose workers have seen what was said
def pytest_testnodedown(node):
    wording.SAID.update(getattr(node, "workeroutput", {}).get("said", {}))


def pytest_sessionfinish(session):
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["said"] = dict(wording.SAID)
    elif wording.ASKED == "write":
        wording.write(wording.SAID)


@pytest.fixture
def random_population():
    """Individuals with different trees, tables and gains, the same for the same seed."""

    def build(count, seed, inputs=5):
        random = np.random.default_rng(seed)
        trees = hierarchy.all_sources(inputs)
        sources = trees[random.integers(len(trees), size=count)]
        scales = np.array([*oracle.SCALES, 40.0])[:inputs]
        level = random.uniform(-2.0, 2.0, count)  # the spread in the paper's tables is +/-0.1
        spread = random.uniform(-0.1, 0.1, (inputs - 1, 7, 7, count))
        return HierarchicalGains(
            kp=random.uniform(600.0, 1500.0, count),
            kd=random.uniform(200.0, 900.0, count),
            scales=np.tile(scales[:, None], count),
            sources=np.stack(sources, axis=-1),
            consequents=level + spread,
        )

    return build


@pytest.fixture
def published():
    """(controller, gains of a population of one) of a built-in design."""
    return lambda name: controller_of(load_design(name))


@pytest.fixture
def no_baselines(monkeypatch):
    """Commands compare a run with no published design: each would have to be compiled too."""
    for plant in list(parts.BASELINES):  # the same table for whoever has imported it
        monkeypatch.delitem(parts.BASELINES, plant)


@pytest.fixture
def own_plugins(monkeypatch):
    """Forgets afterwards which plug-ins and modules came in."""
    groups = made_known()
    modules = set(sys.modules)
    monkeypatch.setattr(sys, "path", [*sys.path])
    yield
    forget(groups)
    for name in set(sys.modules) - modules:
        file = getattr(sys.modules[name], "__file__", None) or ""
        if not name.startswith(("hfc_design", "plants")) and not file.startswith(INSTALLED):
            del sys.modules[name]


@pytest.fixture
def own(tmp_path, monkeypatch, own_plugins):
    """The current folder, with a module of plug-ins that nobody has imported, and a scenario."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(MODULE)
    (tmp_path / "sledge.toml").write_text(SCENARIO + CONTROLLER)
    (tmp_path / "broken.py").write_text("1 / 0\n")
    return tmp_path
