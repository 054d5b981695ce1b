"""A machine's parameters from its log, for a script."""

from collections.abc import Callable, Sequence
from pathlib import Path

from hfc_design.core.arguments import check_positive, check_whole, path_of
from hfc_design.core.overrides import Changes
from hfc_design.files.design import AnyDesign
from hfc_design.files.named_scenario import AnyScenario
from hfc_design.identify import identified
from hfc_design.identify.page import write
from hfc_design.identify.recording import recordings, sources
from hfc_design.identify.request import task_of
from hfc_design.identify.result import Identified


def identify(
    log: str | Path,
    plant: str | None = None,
    *,
    scenario: AnyScenario | None = None,
    changes: Changes = (),
    axis: str | None = None,
    controller: AnyDesign | None = None,
    free: Sequence[str] | None = None,
    bandwidth: float | None = None,
    columns: Sequence[str] = (),
    sample_time: float | None = None,
    check_log: str | Path | None = None,
    check_columns: Sequence[str] = (),
    seed: int = 0,
    folder: str | Path | None = None,
    on_step: Callable[[str], None] = lambda line: None,
) -> Identified:
    """Find the parameters of a machine that make it do what a log has recorded.

    What ``hfc identify`` does. The plant is simulated under the recorded command from a hundred
    starts. The result shows itself as a table; ``numbers()`` is what ``identified.json`` holds,
    ``for_design()`` the scenario for a search, ``plot`` draws the replay beside the log.

    Args:
        log: CSV with a header, a log of LinuxCNC, .mat up to version 7, .npy or .npz.
        plant: its machine by name; not needed with a scenario or a controller.
        scenario: plant, values to start from, sensors, limits; that of the controller if left out.
        changes: of the scenario, by dotted keys; what they set of the machine, its constant load,
            delay and lag is known, and not looked for.
        axis: which one, of a machine of several.
        free: parameters to look for, "mass=50" from there; if left out all but exact ones, those
            that are 0 and those in ``changes``, and the load where no parameter is one.
        controller: the one in the loop that recorded the log: its loop is replayed too.
        bandwidth: of the observer [Hz]; 0 replays in open loop; the best of 50, 20 and 5 Hz if
            left out.
        columns: which column a signal is, and its unit, as in "position=qm [m]".
        sample_time: of the log [s], where it does not say it.
        check_log: another log, which the result is checked on.
        check_columns: the columns of that where they differ.
        seed: of the starts.
        folder: where page, numbers and scenario are written; nothing is if left out.
        on_step: is called with a line at every step.

    Raises:
        UserError: there is no such machine, axis or parameter; the log cannot be read or has not
            what is needed, or no replay of it stays finite.
        RunError: the folder cannot be written.
    """
    check_whole("--seed", seed, 0)
    if bandwidth:  # 0: open loop
        check_positive("--bandwidth", bandwidth)
    if sample_time is not None:
        check_positive("--sample-time", sample_time)
    place = None if folder is None else path_of(folder)
    other = None if check_log is None else path_of(check_log)
    task = task_of(plant, scenario, changes, axis, controller, free, bandwidth, seed)
    logs = sources(task, path_of(log), columns, other, check_columns)
    result = identified.identify(*recordings(task, logs, sample_time), on_step)
    if place is not None:
        write(result, place, "hfc_design.api.identify")
    return result
