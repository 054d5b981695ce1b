"""Random engines and systems as pyfuzzylite and Octave compute them, every method that is read.

Of 500 engines none differs, at most by 4e-15 of the largest output; of 300 systems, which took
Octave half a minute, none either, at most by 3e-15. The suite draws fewer systems.
"""

from random import Random

import numpy as np
from fuzzylite_tool import in_python
from random_fuzzy import fis, fll

from hfc_design.formats.reading import fis as any_fis
from hfc_design.formats.reading import fll as any_fll

#: Octave takes 24 ms a point.
ENGINES, SYSTEMS = 500, 20


def drawn(write, read, count, points):
    """Texts, points within the ranges of the inputs, and what the reader computes there."""
    found = []
    for seed in range(count):
        text = write(Random(seed))
        base = read(text)
        rows = np.random.default_rng(seed).uniform(size=(points, 2))
        low, high = ([getattr(v, end) for v in base.inputs] for end in ("low", "high"))
        places = low + rows * np.subtract(high, low)
        places[0] = low
        found.append((text, places, base.outputs(*places.T)))
    return found


def differing(found, wanted):
    """Numbers of those that differ by more than 1e-9 of the largest output."""
    return [
        number
        for number, ((_, _, own), other) in enumerate(zip(found, wanted, strict=True))
        if not np.allclose(
            own,
            other,
            rtol=0.0,
            atol=1e-9 * max(1.0, np.nanmax(np.abs([*other, 0.0]))),
            equal_nan=True,
        )
    ]


def test_engines_are_those_of_pyfuzzylite():
    found = drawn(fll, any_fll.rule_base, ENGINES, 25)
    texts, points, _ = zip(*found, strict=True)
    rows = in_python("evaluate_engines.py", texts=texts, points=[x.T.tolist() for x in points])
    assert not differing(found, [np.array(row, dtype=float) for row in rows])


def test_systems_are_those_of_octave(octave, tmp_path):
    found = drawn(fis, any_fis.rule_base, SYSTEMS, 10)
    for number, (text, points, _) in enumerate(found):
        copy = text.replace("'mom'", "'level_mom'")
        if "'sugeno'" in text:  # MATLAB adds whatever AggMethod says
            for method in ("max", "probor"):
                copy = copy.replace(f"AggMethod='{method}'", "AggMethod='sum'")
        (tmp_path / f"{number}.fis").write_text(copy.replace("probor", "algebraic_sum"))
        np.savetxt(tmp_path / f"{number}.points", points, fmt="%.17g")
    wanted = octave("evaluate_systems.m", SYSTEMS, tmp_path, tmp_path / "out")
    assert not differing(found, wanted)
