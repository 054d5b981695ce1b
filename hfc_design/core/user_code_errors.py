"""Description of an error in a user's own code in a line: its place, and how to correct it.

Never imports JAX: it recognises JAX's errors by the names of their classes.
"""

import re
import sys
from pathlib import Path
from traceback import walk_tb

from pydantic import ValidationError

#: Packages whose code is not the user's, although a user's mistake may raise an error there.
OURS = {"hfc_design", "plants", "jax", "jaxlib", "numpy", "scipy", "equinox", "optimistix"}
_WRITE = (
    "write jnp.sin for math.sin or np.sin (likewise all functions), jnp.asarray for "
    "float; annotate a float of an AxisLaw that Python needs as hfc.Constant"
)
#: JAX's error where code needs the number of a value that JAX traces -> what to write instead.
INSTEAD = {
    "TracerBoolConversionError": "write jnp.where(condition, a, b) for if (xp.where in a law), "
    "jnp.minimum and jnp.maximum for min and max, & and | for and, or",
    "ConcretizationTypeError": _WRITE,
    "TracerArrayConversionError": _WRITE,
    "TracerIntegerConversionError": "write jnp.take(values, k) for values[k]",
}
_WHY = "values are not known yet"

#: JAX's message that a carried value changes its type: the type before, the type after.
_CARRIED = re.compile(
    r"input carry .+? (?:is a|has type) (.+?) but the corresponding .+? "
    r"(?:is a|has type) (.+?), so "
)


def describe(error: Exception) -> str:
    """Return class, first line and place in the user's file of an error, as one text.

    If a correction is known, it replaces the first line. An error of a record keeps all lines.
    """
    kind, place = type(error).__name__, _place(error)
    for one in type(error).__mro__:
        if one.__name__ in INSTEAD:
            return f"{place and f'in {place}: '}{INSTEAD[one.__name__]}; {_WHY} ({kind})"
    if isinstance(error, ValidationError):
        return f"{kind}: {error}"
    message = _carried(str(error)) or str(error).partition("\n")[0]
    return f"{kind}: {message}{place and f' ({place})'}"


def _carried(message: str) -> str:
    """Return one line for JAX's long message on a carried value; "" for other messages."""
    match = _CARRIED.search(message)
    if not match:
        return ""
    before, after = map(_in_a_word, match.groups())
    head = "the values carried from sample to sample must keep their type, each number a float"
    return f"{head}: {before} became {after}"


def _in_a_word(kind: str) -> str:
    """ "State" for <class 'mine.State'>, "int64" for int64[64], "number" for a traced value."""
    name = kind.partition("[")[0].removeprefix("<class '").removesuffix("'>").rpartition(".")[2]
    return "number" if name == "ShapedArray" else name


def _place(error: Exception) -> str:
    """Return file, line and function of the innermost frame in the user's own code; "": none."""
    last = ""
    for frame, line in walk_tb(error.__traceback__):
        module = str(frame.f_globals.get("__name__", "")).partition(".")[0]
        if module not in OURS and module not in sys.stdlib_module_names:
            code = frame.f_code
            last = f"{Path(code.co_filename).name}, line {line}, {code.co_name.strip('<>')}"
    return last
