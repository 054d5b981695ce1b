"""Which finalist becomes the design, where some of them are chaotic."""

from types import SimpleNamespace

import numpy as np
import pytest
from short_runs import SMALL

from hfc_design.controllers.genome import taken
from hfc_design.files.named_scenario import load_scenario
from hfc_design.runs import champion
from hfc_design.runs.individuals import design_of, genome_of
from hfc_design.search.loop import Archive
from hfc_design.simulation.evaluating import evaluate
from hfc_design.simulation.repeats import Repeats

#: Merits of the repeats, the loop as it is first; what the search found is in this order.
LUCKY, STEADY = [430.8, 511.0, 362.0], [380.0, 380.1, 379.9]


@pytest.mark.parametrize(
    ("each", "chosen"),
    [
        ([LUCKY, STEADY], 1),
        ([STEADY, LUCKY], 0),
        ([LUCKY, [350.0, 350.0, 350.0]], 0),  # the worst of it is better still
        ([[430.8, -np.inf, 440.0], STEADY], 1),
        ([[380.0, 379.0, 380.0], [380.1, 376.4, 380.2]], 1),  # by the merit: none is chaotic
    ],
)
def test_finalists_rank_by_their_lower_end(each, chosen, monkeypatch):
    scenario = load_scenario("c-axis-ramp", SMALL)
    found = genome_of(scenario).fresh(np.zeros(2, int), np.random.default_rng(0))
    designs = [design_of(taken(found, np.array([k])), scenario) for k in range(2)]

    def judged(design, where):
        (own,) = (x for x, one in zip(each, designs, strict=True) if one == design)
        repeats = {"merit": Repeats(np.array(own))}
        return evaluate(design, where)._replace(merit=own[0], repeats=repeats)

    monkeypatch.setattr(champion, "evaluate", judged)
    searched = SimpleNamespace(archive=Archive(found, np.array([2.0, 1.0])), state=None)
    _, design, evaluation = next(champion.best_of(searched, scenario))
    assert design.controller == designs[chosen].controller
    assert evaluation.merit == each[chosen][0]
    assert design.score.get("chaotic", False) == evaluation.chaotic
