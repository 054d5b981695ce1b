"""Report picture of the factor by which a hierarchy multiplies its scheduled law."""

from functools import partial

import numpy as np

from hfc_design.controllers.hierarchical.law import memberships, outputs
from hfc_design.controllers.hierarchical.record import HierarchicalDesign, layout_of
from hfc_design.core.numbers import ARRAYS, Floats
from hfc_design.plotting.figure import OTHER, OWN, finish, framed
from hfc_design.plotting.section import Drawing

#: Line styles of the inputs of a hierarchy, six at most.
STYLES = ((OWN, "-"), (OTHER, "-"), ("0.35", "-"), (OWN, ":"), (OTHER, ":"), ("0.35", ":"))


def factor(record: HierarchicalDesign, points: Floats) -> Floats:
    """Return the factor (n,) on the scheduled law at ``points`` (n, inputs) of scaled inputs."""
    layout = layout_of(record)
    degrees = partial(memberships, ARRAYS, layout.terms)
    units, _ = outputs(ARRAYS, degrees, layout.input_range, record.law_gains(), list(points.T))
    return np.asarray(record.output_scale * units[-1].output)


def schedule(record: HierarchicalDesign, labels: dict[str, str], units: dict[str, str]) -> Drawing:
    """Draw ``factor`` over each input, the others being 0; ``labels``, ``units``: by input name."""
    figure = framed(3.3 + 0.2 * len(record.inputs), top=0.15 + 0.2 * len(record.inputs))
    axes = figure.subplots()
    places = np.linspace(-1.0, 1.0, 201)
    for k, ((color, style), item) in enumerate(zip(STYLES, record.inputs, strict=False)):
        points = places[:, None] * np.eye(len(record.inputs))[k]
        label = f"{labels[item.name]}, 1 is {1.0 / item.scale:.3g} {units[item.name]}"
        axes.plot(places, factor(record, points), color=color, ls=style, lw=1.6, label=label)
    finish(axes, "factor on the scheduled law [1]", "scaled input [1]")
    axes.legend(fontsize=8, frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    return Drawing(
        figure,
        "The factor on the scheduled law against each scaled input",
        "Factor by which the scheduled law is added to the linear part: the scaled "
        "output of the root over each input while all others are 0.",
    )
