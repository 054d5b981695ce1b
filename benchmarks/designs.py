"""The designs that the benchmarks run: those that are built in, and two that are made here."""

from hfc_design.files.design import Design
from hfc_design.files.loop_setup import load_design
from hfc_design.simulation.imitation import taught

NEURAL, CROSS_COUPLED = "neural-huang-soc", "cross-coupled-huang-pid"
#: Of hfc train on the page of learning.
NETWORK = {"error_unit": 0.005, "change_unit": 0.01, "command_unit": 0.5, "xi": 0.8}


def design_of(name: str) -> Design:
    """The network that the SOC has taught, the PID with cross-coupling, or a built-in design."""
    if name == NEURAL:
        return taught("huang-soc", "milling-table-circle", NETWORK).design
    if name != CROSS_COUPLED:
        return load_design(name)
    inner = load_design("huang-pid")
    data = inner.model_dump(mode="json")
    data["plant"]["axes"] = {"x": {}, "y": {}}
    data["controller"] = {
        "kind": "cross-coupled",
        "sample_time_s": inner.controller.sample_time_s,
        "inner": data["controller"],
        "contour": {"k_p": 20.0, "k_i": 60.0, "k_d": 0.1},
        "feed_forward": {"x": 0.3, "y": 0.3},
    }
    return Design.model_validate(data | {"name": name})
