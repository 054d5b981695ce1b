"""What a log tells of a machine, in tables and sentences."""

from collections.abc import Callable
from typing import Any

from hfc_design.core.wording import percent
from hfc_design.identify.identifiability import CONFIDENCE, GIVEN, HELD, Combination
from hfc_design.identify.outcome import Outcome
from hfc_design.identify.response import LAGS, Response
from hfc_design.pictures.numbers import readable
from hfc_design.pictures.section import Rows

HEADS = ["parameter", "unit", "began", "found", "from", "to", "told?"]
CHECKED = ["log", "replayed in", "rms before", "rms after"]
#: The end of an interval is shown if the standard error is a smaller share than this.
WIDEST = 2.0
#: So many combinations are told that the log does not tell, and parameters of each.
COMBINATIONS, TOGETHER = 4, 3
ALIKE = (
    "changed together like this the machine does the same under a command, if not under an outer "
    "force: what is given is known beside what is held, and a design needs no wider tolerance"
)
UNEXCITED = (
    "DOUBTFUL: the log has no excitation: at no frequency the position answers the command above "
    "its noise; record reversals and faster motions"
)
#: Above this share of the highest frequency of a log there is nothing; of white noise so many
#: autocorrelations may be off.
ALL, WHITE = 0.8, 0.15
NOTHING = (
    "no sine of the command would tell much more; measure other signals too, as the current, or "
    "look for fewer parameters"
)


def parameter_rows(found: Outcome) -> Rows:
    """Of each parameter its value and the ends of its interval."""
    known, free = found.known, found.free
    columns = known.value, known.low, known.high, known.error, known.state
    return [
        [name, free.unit(name), f"{free.starts[name]:.5g}", f"{value:.5g}"]
        + [f"{x:.5g}" if error < WIDEST and state != HELD else "–" for x in (low, high)]
        + [state]
        for name, value, low, high, error, state in zip(free.names, *columns, strict=True)
    ]


def interval_line(found: Outcome) -> str:
    """What the ends of the intervals mean."""
    line = f"from and to are the ends of the {100 * CONFIDENCE:g} % interval, if the model is right"
    states = zip(found.free.names, found.known.state, strict=True)
    held = ", ".join(name for name, state in states if state == HELD)
    return f"{line}; where 'given', if what is held ({held}) is right" if held else line


def check_rows(found: Outcome) -> Rows:
    """Of each replay what it is off, before and after."""
    return [
        [x.log, x.how, _readable(found, x.before), _readable(found, x.after)] for x in found.checks
    ]


def _readable(found: Outcome, position: float) -> str:
    """A position with a unit that it is easy to read in."""
    factor, unit = readable(found.position_unit, position)
    return f"{factor * position:.3g} {unit}"


def untold_lines(found: Outcome) -> list[str]:
    """What the log does not tell, in words."""
    lines = [combination_line(one) for one in found.known.untold[:COMBINATIONS]]
    if (more := len(found.known.untold) - COMBINATIONS) > 0:
        lines.append(f"and {more} more such combinations: look for fewer parameters")
    if lines and GIVEN in found.known.state:
        lines.append(ALIKE)
    return lines


def combination_line(one: Combination) -> str:
    """How parameters may change together without the log telling it."""
    change = percent(one.change) if one.change < 10.0 else f"a factor of {one.change:.2g}"
    (first, _), *others = sorted(one.shares.items(), key=lambda item: -abs(round(item[1], 9)))
    if not others:
        return f"{first} is only known to {change}"
    rest = f" and {len(others) - TOGETHER} more" if len(others) > TOGETHER else ""
    shown = (f"{name} ({100 * one.change * x:+.3g} %)" for name, x in others[:TOGETHER])
    return f"{first} may change by {change} if others do too: {', '.join(shown)}{rest}"


def response_lines(found: Response | None) -> list[str]:
    """What the frequencies of the log say against the model."""
    if found is None:
        return []
    if found.top is None:
        return [UNEXCITED]
    lines = []
    if found.top <= ALL * found.frequency[-1]:
        lines.append(
            f"nothing above {found.unknown_above:g} Hz was excited; a mode there cannot be "
            "excluded: design for one, or record faster motions"
        )
    if found.mode:
        lines.append(f"there is a mode near {found.mode.hz:g} Hz that this model has not")
    white = "is white" if found.coloured <= WHITE * LAGS else "is not white, the model lacks it"
    count = f"{found.coloured} of {LAGS} autocorrelations are none of white noise"
    return [*lines, f"what is left {white}: {count}"]


def advice_line(found: Outcome) -> str:
    """What to record next; "" if there is nothing to say."""
    one, units = found.advice, found.free.drive.units
    if one is None:
        return "" if found.known.told.all() else NOTHING
    gains = ", ".join(
        f"{name} to {percent(b)} (now to {percent(a)})" for name, (a, b) in one.errors.items()
    )
    return (
        f"{one.duration:g} s of a sine of the command of {one.amplitude:.3g} {units['command']} at "
        f"{one.frequency:g} Hz (the axis goes {_readable(found, one.travel)} to and fro, at up "
        f"to {one.speed:.3g} {units['error_rate']}) would tell {gains} (standard errors)"
    )


def verdict(found: Outcome) -> str:
    """What came out, in a sentence."""
    told, check = found.known.told, found.checks[0]
    return (
        f"the log tells {sum(told) or 'none'} of {len(told)} parameters that were looked for, and "
        f"the replay is {_readable(found, check.after)} off (rms); it was "
        f"{_readable(found, check.before)} with the values that it began with"
    )


def agreeing_line(found: Outcome) -> str:
    """How far the starts agree."""
    return (
        f"{found.fit.agreeing} of the ten best of a hundred starts end at the same residual; "
        f"replayed under: {found.fit.how}"
    )


#: What a page shows of an outcome.
OF_A_PAGE: tuple[Callable[[Outcome], Any], ...] = (
    parameter_rows, interval_line, check_rows, untold_lines, advice_line, verdict, agreeing_line,
)  # fmt: skip
