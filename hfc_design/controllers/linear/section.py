"""Report section of a linear controller: its gains with units."""

from hfc_design.controllers.controller import units_of
from hfc_design.controllers.kind import ReportContext
from hfc_design.controllers.linear.record import LinearDesign, WeightedDesign, resonator_name
from hfc_design.core.tables import Table
from hfc_design.plotting.section import Section

CAPTION = "Gains of the kind {}: command = sum of gain \u00d7 signal."


def sections(record: LinearDesign, shown: ReportContext) -> list[Section]:
    """Return the section that lists the gains."""
    cells = [[name, f"{x:.6g}", unit] for name, x, unit in rows(record, shown.units)]
    gains = Table(CAPTION.format(record.kind), ["gain", "value", "unit"], cells)
    return [Section("The controller", "", gains, [])]


def rows(record: LinearDesign, units: dict[str, str]) -> list[tuple[str, float, str]]:
    """Return name, value and unit of every gain."""
    units = units_of(units)
    command, rate, ahead = units["command"], units["error_rate"], record.feed_forward

    def per(name: str) -> str:
        """Return the unit of a gain on the signal ``name``."""
        unit = units.get(name, "1")
        return f"{command}/({unit})" if "/" in unit or " " in unit else f"{command}/{unit}"

    summed = f"{command}/({units['error']} s)"
    entries: list[tuple[str, float | None, str]] = [
        ("kp, on the error", record.kp, per("error")),
        ("ki, on its integral", record.ki, summed),
        ("kd, on its rate", record.kd, per("error_rate")),
        ("cut-off of the filter before kd", record.derivative_hz or None, "Hz"),
        ("notch in the command", record.notch_hz, "Hz"),
        ("its width", record.notch_width if record.notch_hz else None, "1"),
        ("its gain there", record.notch_depth if record.notch_hz else None, "1"),
        ("low-pass of the command", record.lowpass_hz, "Hz"),
    ]
    for name, gain in record.signals.items():
        entries.append((f"on {name.replace('_', ' ')}", gain, per(name)))
    entries += [
        ("feed-forward of the velocity", ahead.velocity, per("reference_rate")),
        ("feed-forward of the acceleration", ahead.acceleration, per("reference_acceleration")),
        ("feed-forward of Coulomb friction", ahead.coulomb, command),
        ("speed at which that is full", ahead.coulomb_width, rate),
        ("feed-forward of the expected load", ahead.load * ahead.expected_load, command),
    ]
    for one in record.resonators:
        name = f"resonator of {one.frequency_rad_s:g} rad/s"
        entries.append((f"{name}, in phase", one.in_phase, summed))
        entries.append((f"{name}, quadrature", one.quadrature, summed))
    if isinstance(record, WeightedDesign):
        integral_names = ("integral", *(resonator_name(k) for k in range(len(record.resonators))))
        for name, weight in record.weights.items():
            unit = summed if name in integral_names else per(name)
            entries.append((f"weight of {name.replace('_', ' ')}", weight, unit))
    return [(name, x, unit) for name, x, unit in entries if x is not None]
