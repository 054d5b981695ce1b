"""Stepped sines in the simulated loop: against the exact linear loop, and a limit cycle."""

import numpy as np
import pytest
from click.testing import CliRunner

from hfc_design import api
from hfc_design.cli import main
from hfc_design.simulation.limit_cycles import limit_cycles
from hfc_design.simulation.loop_margins import loop_margins

GAINS = {"k_p": 758.0, "k_i": 300.0, "k_d": 743.0}


@pytest.mark.parametrize("design", ["pd-only", "pid"])
def test_a_linear_loop_answers_as_its_poles_say(design):
    """Within 1 % and 1 degree up to half the sampling rate."""
    design = api.with_gains("c-axis-ramp", "pid", GAINS) if design == "pid" else design
    (found,) = api.frequency(design, amplitudes=[0.05], machines=0).responses
    row = loop_margins(design, "c-axis-ramp").rows[-1]
    exact = row.loop.transfer(2.0 * np.pi * found.hertz * found.sample_time)
    assert found.hertz[-1] > 0.48 / found.sample_time
    ratio = (1.0 + found.loop[0]) / (1.0 + exact), (found.loop[0] / exact)[found.known]
    for part in ratio:
        assert np.abs(np.abs(part) - 1.0).max() < 0.01
        assert np.abs(np.angle(part, deg=True)).max() < 1.0
    margins = found.margins
    assert margins["sensitivity"][0] == pytest.approx(row.numbers["sensitivity"], rel=0.05)
    for key in ("crossover_hz", "bandwidth_hz", "phase_deg", "gain_up"):
        assert margins[key][0] == pytest.approx(row.numbers[key], rel=0.05)


def test_encoder_steps_hide_a_small_sine_and_the_table_says_so():
    result = api.frequency("huang-pid", amplitudes=[0.1, 1.0], machines=0)
    small, large = result.responses
    assert not small.known.any()
    assert large.known[10:31].all()
    assert "no frequency has a coherence" in result.tables()[0].lines[0]


@pytest.mark.parametrize("gain", [196.0, 280.0, 560.0])
def test_a_limit_cycle_of_the_milling_table_is_predicted_within_five_percent(gain):
    """7 to 20 times the gain of its PID: a trembling at the limit of the command."""
    design = api.load_design("huang-pid", {"controller.pid.k_p": gain})
    (cycle,) = [one for one in limit_cycles(design) if one.stable]
    assert cycle.hz == pytest.approx(cycle.simulated_hz, rel=0.05)
    assert cycle.command == pytest.approx(cycle.simulated_command, rel=0.05)
    assert cycle.position == pytest.approx(cycle.simulated_position, rel=0.05)
    # A square wave of the command, which its limits make: 4 / pi times its largest value.
    assert cycle.command == pytest.approx(4.0 / np.pi * 10.0, rel=0.02)


def test_no_limit_cycle_of_the_milling_table_as_published():
    assert not [one for one in limit_cycles("huang-pid") if one.stable]


def test_a_command_line_draws_what_it_tells(tmp_path):
    call = ["frequency", "pd-only", "--machines", "3", "--frequencies", "20", "--amplitude", "1"]
    done = CliRunner().invoke(main, [*call, "--cycles", "--plot", str(tmp_path / "own.svg")])
    assert done.exit_code == 0
    assert "no limit cycle is predicted" in " ".join(done.output.split())
    assert "compliance" in (tmp_path / "own.svg").read_text("utf-8")
