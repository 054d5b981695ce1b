"""The tolerances of the fitness, its targets, that a design exceeds: stable, and still far off.

Plain numbers, as ``usable.json`` and design files have them. Never imports JAX.
"""

from hfc_design.core.numbers import SAME_SINGLE, Json


def missed(motions: Json) -> Json:
    """Measure -> ``times`` its tolerance, more than once, and the ``motion`` where it is most.

    ``motions`` are those of ``Usable.numbers``. It is of the median machine, in a motion that is
    asked of the nominal one alone of that.
    """
    found: Json = {}
    for motion, one in motions.items():
        which = "nominal" if one["asked_of"] == "nominal" else "median"
        for name, told in one["tolerances"].items():
            times = (told[which] or 0.0) / told["allowed"]  # None: nothing finite, which is no yes
            if times > found.get(name, {"times": 1.0 + SAME_SINGLE})["times"]:
                found[name] = {"times": times, "motion": motion}
    return found


def missed_told(found: Json, motions: int = 2) -> str:
    """The same as a line, "" where nothing is missed; of a single motion without its name."""
    told = [
        f"{name} {three_digits(one['times'])}" + (f" ({one['motion']})" if motions > 1 else "")
        for name, one in found.items()
    ]
    worst = " in the worst motion" if motions > 1 else ""
    return f"targets missed, value divided by target{worst}: {', '.join(told)}" if told else ""


def three_digits(value: float) -> str:
    """Of a number as tables have it, up to a million without an exponent."""
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.3g}"
