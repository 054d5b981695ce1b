"""What ``hfc design`` and ``hfc score`` say first: can it be used?"""

import sys
from textwrap import fill

import numpy as np

from hfc_design.core.console import plain_table, terminal
from hfc_design.core.numbers import Floats
from hfc_design.core.statistics import share_interval
from hfc_design.simulation.monte_carlo import Robustness
from hfc_design.simulation.usable import Usable

QUESTION = "Can I use it?"
WARNING = "hfc: warning: the design is not usable as it is"


def show_usable(found: Usable) -> None:
    """The answer first, then its figures; a design that fails is warned of on stderr too."""
    print(fill(f"{QUESTION} {found.answer}", 80))
    if not found.yes:
        print(WARNING, file=sys.stderr)
    tracking = next(iter(found.units))
    scale, unit = (1e6, "urad") if found.units[tracking] == "rad" else (1.0, found.units[tracking])
    command = found.units["chatter"]
    table = plain_table(caption=_caption(found), caption_justify="left")
    table.add_column("motion", no_wrap=True)
    heads = [
        *("keep all\n[%]", f"error\nmedian\n[{unit}]", f"\n95 %\n[{unit}]"),
        *(f"chatter\nmedian\n[{command}]", f"\nlargest\n[{command}]"),
        *(f"peak\nmedian\n[{command}]", f"\nlargest\n[{command}]", "at limit\nlargest\n[%]"),
    ]
    for head in heads:
        table.add_column(head, justify="right")
    for one in found.motions:
        error, chatter, peak = (
            one.told[tracking] * scale,
            one.told["chatter"],
            one.told["peak_command"],
        )
        cells = [
            100 * float(one.good.mean()),
            *_quantiles(error, 0.5, 0.95),
            *_quantiles(chatter, 0.5, 1.0),
            *_quantiles(peak, 0.5, 1.0),
            100 * _quantiles(one.told["limit_share"], 1.0)[0],
        ]
        table.add_row(one.name, *map(_short, cells))
    terminal().print(table)


def answer(found: Robustness) -> str:
    """The same line for one motion on the machines of ``--spread``."""
    share, count = float(found.stable.mean()), len(found.stable)
    low, high = share_interval(int(found.stable.sum()), count)
    machines = (
        f"{100 * share:.4g} % of {count} machines within +-{100 * found.spread:g} % are stable"
    )
    told = f"{machines} ({100 * low:.3g} to {100 * high:.3g} %)"
    if found.usable:
        return f"yes: {told}"
    if not share:
        return f"no: not one of {count} machines within +-{100 * found.spread:g} % is stable"
    return f"no: {told if found.nominal_stable else f'the nominal machine is not stable; {told}'}"


def _caption(found: Usable) -> str:
    low, high = found.interval
    lines = [
        f"{100 * found.good.mean():.4g} % keep everything ({100 * low:.4g} to {100 * high:.4g} % "
        "with 95 % confidence)"
    ]
    if found.gain is None:
        lines.append("gain: the nominal machine does not keep everything as it is")
    else:
        lines.append(
            f"gain: nominal machine keeps everything from {found.gain[0]:.3g} to "
            f"{found.gain[1]:.3g} times the command"
        )
    changes = f"merit changes by {100 * found.precision:.2g} % from float32 to float64"
    if found.substeps is not None:
        changes += f", {100 * found.substeps:.2g} % in finer steps"
    return "\n".join([*lines, changes])


def _quantiles(values: Floats, *shares: float) -> list[float]:
    finite = values[np.isfinite(values)]
    return np.quantile(finite, shares).tolist() if len(finite) else [np.nan] * len(shares)


def _short(value: float) -> str:
    if not np.isfinite(value):
        return "-"
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.3g}"
