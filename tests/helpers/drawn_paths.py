"""Paths of lines and arcs as Hypothesis draws them."""

from math import pi

import numpy as np
from hypothesis import strategies as st

from hfc_design.motion.paths import Path, arc, line

segments = st.lists(
    st.tuples(
        st.floats(0.5, 20.0),  # length or radius
        st.sampled_from([-5.0, -pi / 2, -0.5, 0.0, 0.5, pi / 2, 5.0]),  # sweep, 0: a line
        st.sampled_from([0.0, 0.0, 0.3, -1.5]),  # jump of the direction before it
        st.floats(60.0, 3000.0),  # feed
    ),
    min_size=1,
    max_size=6,
)


def chained(parts):
    """The path of lines and arcs one after the other, turned step by step in complex numbers."""
    place, heading, made = 0j, 1 + 0j, []
    for size, sweep, jump, feed in parts:
        heading *= np.exp(1j * jump)
        start = (place.real, place.imag)
        if sweep == 0.0:
            place += size * heading
            made.append(line(start, (place.real, place.imag), feed))
        else:
            centre = place + 1j * np.sign(sweep) * size * heading
            made.append(arc(start, (centre.real, centre.imag), sweep, feed))
            place = centre + (place - centre) * np.exp(1j * sweep)
            heading *= np.exp(1j * sweep)
    return Path.of(made), place
