"""What a log tells of a machine, in tables and sentences."""

from hfc_design.core.wording import percent
from hfc_design.identify.identifiability import CONFIDENCE, GIVEN, HELD, Combination
from hfc_design.identify.outcome import Outcome
from hfc_design.identify.response import LAGS, Response
from hfc_design.pictures.numbers import readable
from hfc_design.pictures.section import Rows

HEADS = ["parameter", "unit", "began", "found", "from", "to", "told?"]
CHECKED = ["log", "replayed in", "rms before", "rms after"]


def parameter_rows(found: Outcome) -> Rows:
    """Of each parameter its value and the ends of its interval."""
    known, free = found.known, found.free
    rows = []
    for k, name in enumerate(free.names):
        start = free.starts[name]
        numbers = [f"{x:.5g}" for x in (start, known.value[k])]
        told = known.error[k] < 2.0 and found.states[k] != HELD
        ends = [f"{x:.5g}" if told else "–" for x in (known.low[k], known.high[k])]
        rows.append([name, free.unit(name), *numbers, *ends, found.states[k]])
    return rows


def interval_line(found: Outcome) -> str:
    """What the ends of the intervals mean."""
    line = f"from and to are the ends of the {100 * CONFIDENCE:g} % interval, if the model is right"
    each = zip(found.free.names, found.states, strict=True)
    held = ", ".join(name for name, state in each if state == HELD)
    return f"{line}; where 'given', if what is held ({held}) is right" if held else line


def check_rows(found: Outcome) -> Rows:
    """Of each replay what it is off, before and after."""
    rows = []
    for check in found.checks:
        cells = [_read(found, x) for x in (check.before, check.after)]
        rows.append([check.log, check.how, *cells])
    return rows


#: So many combinations are told that the log does not tell, and parameters of each.
COMBINATIONS, TOGETHER = 4, 3
ALIKE = (
    "changed together like this the machine does the same under a command, if not under an outer "
    "force: what is given is known beside what is held, and a design needs no wider tolerance"
)


def untold_lines(found: Outcome) -> list[str]:
    """What the log does not tell, in words."""
    lines = [_untold(one) for one in found.known.untold[:COMBINATIONS]]
    if len(found.known.untold) > COMBINATIONS:
        more = len(found.known.untold) - COMBINATIONS
        lines.append(f"and {more} more such combinations: look for fewer parameters")
    if lines and GIVEN in found.states:
        lines.append(ALIKE)
    return lines


def _untold(one: Combination) -> str:
    change = percent(one.change) if one.change < 10.0 else f"a factor of {one.change:.2g}"
    (first, _), *others = sorted(one.shares.items(), key=lambda item: -abs(round(item[1], 9)))
    if not others:
        return f"{first} is only known to {change}"
    rest = f" and {len(others) - TOGETHER} more" if len(others) > TOGETHER else ""
    shown = others[:TOGETHER]
    told = ", ".join(f"{name} ({100 * one.change * x:+.3g} %)" for name, x in shown)
    return f"{first} may change by {change} if others do too: {told}{rest}"


def response_lines(found: Response | None) -> list[str]:
    """What the frequencies of the log say against the model."""
    if found is None:
        return []
    if found.top is None:
        return [UNEXCITED]
    lines = [
        f"nothing above {found.unknown_above:g} Hz was excited; a mode there cannot be excluded: "
        "design for one, or record faster motions"
    ]
    if found.top > ALL * found.frequency[-1]:
        lines = []
    if found.mode:
        lines.append(f"there is a mode near {found.mode.hz:g} Hz that this model has not")
    white = "is white" if found.coloured <= WHITE * LAGS else "is not white, the model lacks it"
    told = f"{found.coloured} of {LAGS} autocorrelations are none of white noise"
    return [*lines, f"what is left {white}: {told}"]


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


def advice_line(found: Outcome) -> str:
    """What to record next; "" if there is nothing to say."""
    one = found.advice
    if one is None:
        untold = not all(found.known.told)
        return NOTHING if untold else ""
    units = found.free.drive.units
    gains = ", ".join(
        f"{name} to {percent(b)} (now to {percent(a)})" for name, (a, b) in one.errors.items()
    )
    factor, small = readable(found.position_unit, one.travel)
    return (
        f"{one.duration:g} s of a sine of the command of {one.amplitude:.3g} {units['command']} at "
        f"{one.frequency:g} Hz (the axis goes {factor * one.travel:.3g} {small} to and fro, at up "
        f"to {one.speed:.3g} {units['error_rate']}) would tell {gains} (standard errors)"
    )


def verdict(found: Outcome) -> str:
    """What came out, in a sentence."""
    told, one = found.known.told, found.checks[0]
    count = f"{sum(told) or 'none'} of {len(told)} parameters that were looked for"
    before, after = (_read(found, x) for x in (one.before, one.after))
    return (
        f"the log tells {count}, and the replay is {after} off (rms); it was {before} with the "
        "values that it began with"
    )


def _read(found: Outcome, position: float) -> str:
    """A position with a unit that it is easy to read in."""
    factor, unit = readable(found.position_unit, position)
    return f"{factor * position:.3g} {unit}"


def agreeing_line(found: Outcome) -> str:
    """How far the starts agree."""
    return (
        f"{found.found.fit.agreeing} of the ten best of a hundred starts end at the same residual; "
        f"replayed under: {found.found.how}"
    )
