"""Folders of code: what a page names, what vectors are, and that a PLC runs them."""

import re

import numpy as np
import pytest
from deployment_folders import ALL, FEW, runs_in_a_plc, vectors
from exported import texts

from hfc_design.formats import code


@pytest.mark.parametrize("name", FEW)
def test_the_page_names_every_signal_its_unit_and_how_large_it_was(name):
    found = texts(ALL[name], "c")
    names, numbers, _ = vectors(found)
    largest = dict(zip(names, np.abs(numbers).max(axis=0), strict=True))
    rows = re.findall(r"\| `(\w+)` \| (in|out) \| (\S+) \| (\S+) \| \w", found["README.md"])
    wanted = {(name, "in", unit) for name, unit in code.signals(ALL[name]).items()}
    assert wanted < {row[:3] for row in rows}
    assert all(unit for _, _, unit in wanted)
    assert {row[:2] for row in rows} - {row[:2] for row in wanted} == {("command", "out")}
    for signal, _, _, told in rows:
        ends = [x for key, x in largest.items() if key.rpartition(".")[2] == signal]
        assert float(told) == pytest.approx(max(ends), rel=6e-3)


@pytest.mark.parametrize("name", ["jee-koren-2004-flc", "jee-koren-1995-fit-flc"])
def test_every_rule_of_a_table_fires(name):
    """Judged by centres: error and its change come nearer to those of every rule than the next."""
    names, numbers, _ = vectors(texts(ALL[name], "c"))
    record = ALL[name].controller
    error = numbers[:, names.index("error")]
    change = np.diff(error, prepend=0.0)
    places = []
    for terms, values in ((record.error_terms, error), (record.error_change_terms, change)):
        centres = np.array([term.centre for term in terms])
        places.append(np.abs(values[:, None] - centres).argmin(axis=1))
    count = len(record.error_terms) * len(record.error_change_terms)
    assert len(set(zip(*places, strict=True))) == count


def test_a_plc_runs_the_vectors_and_a_project_has_the_same():
    design = ALL["jee-koren-2004-flc"]
    runs_in_a_plc(design)
    block, project = texts(design, "st"), texts(design, "plcopen")
    checks = {"check/check.st", "check/vectors.csv"}
    assert {file: project[file] for file in checks} == {file: block[file] for file in checks}
    assert project.keys() == checks | {"README.md", "jee_koren_2004_flc.xml"}
