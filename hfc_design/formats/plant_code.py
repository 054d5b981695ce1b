"""Plants in C99, step for step what the simulator does; LinuxCNC and FMUs have the same files."""

from typing import NamedTuple

from hfc_design.core.numbers import Json, Parameters
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats.writing import rendered
from plants import PLANTS, Drive
from plants.blocks import STIFF
from plants.five_axis import FIVE_AXIS, FIVE_AXIS_B, per_unit_of
from plants.milling_table import INNER


class PlantCode(NamedTuple):
    """How a drive is written in C."""

    body: str  # template in templates/plants; what every name in its C ends with
    what: str  # in a line
    #: Unit of what the state has beside the signals, the position and the velocity.
    units: dict[str, str] = {}
    values: Json = {}  # what its template reads beside the names
    counts: bool = False  # whether its own encoder reads the position in steps

    @property
    def name(self) -> str:
        """What every name in its C begins with."""
        return f"plant_{self.body}"


_SERVO = "servo axis of a five-axis machine, a velocity loop against sliding friction"


def _servo(drive: Drive) -> PlantCode:
    rotary = drive.degrees is not None
    body, values = f"servo_{'rotary' if rotary else 'linear'}", {"per_unit": per_unit_of(rotary)}
    return PlantCode(body, _SERVO, values=values, counts=True)


#: Drives that there is C of.
CODES = {
    "c-axis": PlantCode(
        "c_axis",
        "C-axis of a turning centre: induction motor, flexible transmission, LuGre friction",
        {"rotor_angle": "rad", "bristle_deflection": "rad"},
        {"stiff": STIFF},
    ),
    "feed-drive": PlantCode(
        "feed_drive",
        "feed drive of a milling machine with stiction, converter and encoder",
        counts=True,
    ),
    "milling-table": PlantCode(
        "milling_table",
        "axis of a milling table with backlash and stick-slip",
        values={"inner": INNER},
        counts=True,
    ),
    "positioning-stage": PlantCode(
        "positioning_stage", "positioning stage, a mass with friction of two sides", counts=True
    ),
    **{x.name: _servo(x) for m in (FIVE_AXIS, FIVE_AXIS_B) for x in m.drives},
}


#: Plants of scenarios that there is C of.
LISTED = ", ".join(name for name in (*CODES, FIVE_AXIS.name, FIVE_AXIS_B.name) if name in PLANTS)


def check(drive: Drive, design: Design) -> None:
    """Whether there is C of a drive of the design's plant.

    Raises:
        UserError: there is none.
    """
    if drive.name not in CODES:
        told = f"there is no C of the plant {design.plant.name}; there is of {LISTED}"
        raise UserError(f"design {design.name}: {told}")


def state_units(drive: Drive) -> dict[str, str]:
    """Unit of every field of a drive's state."""
    own = {drive.position: drive.units["error"], drive.velocity: drive.units["error_rate"]}
    own |= drive.units | CODES[drive.name].units
    return {field: own[field] for field in drive.initial_state(0.0)._fields}


def signals(drive: Drive) -> list[str]:
    """What a drive's sensors tell beside the error."""
    fixed = drive.coefficients(drive.parameters())
    return list(drive.signals(fixed, drive.measured(fixed, drive.initial_state(0.0))))


def sources(drive: Drive, design: Design) -> dict[str, str]:
    """Header and source of a drive by their names."""
    own = CODES[drive.name]
    parameters = drive.parameters()
    values = {
        "name": own.name,
        "what": own.what,
        "body": f"{own.body.partition('_linear')[0].partition('_rotary')[0]}.c.j2",
        "parameters": {key: drive.parameter_units.get(key, "") for key in parameters._fields},
        "coefficients": coefficients(drive.coefficients(parameters)),
        "states": state_units(drive),
        "signals": {name: drive.units[name] for name in signals(drive)},
        **own.values,
    }
    files = {f"{own.name}{end}": f"plants/plant{end}.j2" for end in (".h", ".c")}
    return {name: rendered(template, design, **values) for name, template in files.items()}


def coefficients(record: Parameters, prefix: str = "") -> dict[str, float]:
    """The coefficients of a drive by name; those of a part have the part's name before theirs."""
    found: dict[str, float] = {}
    for name, value in record._asdict().items():
        part = hasattr(value, "_asdict")
        found |= coefficients(value, f"{prefix}{name}_") if part else {prefix + name: float(value)}
    return found
