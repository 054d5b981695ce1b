"""A log against what was promised: how often machines are called unlike, and what is named."""

import numpy as np
import pytest

from hfc_design import api
from hfc_design.files.loop_setup import machine, own_scenario
from hfc_design.files.robust import friction_of
from hfc_design.identify import checking
from hfc_design.identify.recording import Recording
from hfc_design.simulation.following import followed
from hfc_design.simulation.frequency import Setup
from hfc_design.simulation.machines import drawn
from hfc_design.simulation.population import Machines, standing

SPREAD, MACHINES, EACH = 0.05, 1000, 60


def test_before_leaves_what_the_model_lacks_out_of_account(tmp_path):
    """A stage with 10 % more mass than the model, then with half more friction too."""

    def log_of(name, friction):
        changes = {"plant.parameters.mass": 1.1 * 95.11}
        changes["plant.parameters.coulomb_friction"] = friction * 20.39
        changes["plant.parameters.viscous_friction"] = friction * 203.5
        scenario = api.load_scenario("positioning-stage-move", changes)
        (tmp_path / name).write_text(api.trajectory_csv(api.evaluate("emps-cascade", scenario)))
        return tmp_path / name

    tight = {"design": "emps-cascade", "changes": {"robust.spread": 0.02}, "machines": 400}
    first, again, worn = (log_of(f"{x}.csv", x) for x in (1.0, 1.002, 1.5))
    assert api.check(first, **tight).unlike
    assert not api.check(again, before=first, **tight).unlike
    found = api.check(worn, before=first, **tight)
    assert found.unlike
    assert found.explained
    assert found.explanations[0].name == "friction"
    lines = first.read_text().splitlines()
    (tmp_path / "short.csv").write_text("\n".join(lines[: len(lines) // 2]))
    with pytest.raises(api.UserError, match="the same reference, not shorter"):
        api.check(first, before=tmp_path / "short.csv", **tight)


class Bench:
    """Logs of machines that the check has not drawn."""

    def __init__(self, name):
        design = api.load_design(name)
        own = own_scenario(design, name).model_dump(exclude_unset=True)
        self.scenario = api.load_scenario(own | {"robust": {"spread": SPREAD}})
        self.setup = Setup.of(design, self.scenario, None, 0.0, MACHINES, checking.LATER)
        self.drive = self.scenario.machine.drives[0]
        reference = np.asarray(self.scenario.each_motion()[0].samples().axes[0].reference)
        self.reference = np.append(reference, reference[::-1])[:6000]
        self.others, self.promise = machine(design, self.scenario), None

    def checked(self, count, factors=None, late=0.0):
        """Return checks of so many machines, with parameters times factors, or a longer delay."""
        some, _ = drawn(self.others, SPREAD, count, 4242)
        own = some.actual[0]
        own = own._replace(**{x: f * getattr(own, x) for x, f in (factors or {}).items()})
        some = Machines(some.nominal, (own, *some.actual[1:]), some.around)
        some = standing(some, self.scenario, self.setup.loop, {"delay_samples": late})
        still, setup = np.zeros(len(self.reference)), self.setup
        command, place = followed(setup, some, self.reference - self.reference[0], still)
        for k in range(1, count + 1):
            seen = {self.drive.seen[0]: place[:, k] + self.reference[0]}
            signals = (seen, command[:, k], self.reference, still, still, still + 1.0)
            log = Recording(*signals, setup.every, 0.0)
            self.promise = self.promise or checking.Promise(setup, log, "log")
            yield self.promise.check(log, "log")


@pytest.mark.parametrize("name", ["emps-cascade", "huang-pid"])
def test_false_alarms_are_as_rare_as_promised_and_changes_are_found_and_named(name):
    bench = Bench(name)
    alarms = np.mean([one.unlike for one in bench.checked(MACHINES)])
    assert alarms == pytest.approx(0.05, abs=0.015)
    rubs = dict.fromkeys(friction_of(bench.drive), 1.2)
    changes = {"friction": {"factors": rubs}, "delay_samples": {"late": 1.0}}
    if "backlash" in bench.drive.parameters._fields:
        changes["backlash"] = {"factors": {"backlash": 2.0}}
    for what, change in changes.items():
        found = [*bench.checked(EACH, **change)]
        assert np.mean([one.unlike for one in found]) >= 0.9
        best = [one.explanations[0] for one in found if one.unlike]
        assert sum(one.name == what for one in best) >= 0.8 * EACH
    found = bench.checked(EACH, **changes["friction"])
    sizes = [one.explanations[0].size for one in found if one.unlike]
    assert np.median(sizes) == pytest.approx(1.2, abs=0.06)
