"""Rules that a value breaks, in the words of this project. Never imports JAX.

pydantic gives the kind of a mistake; none of its own sentences reaches a user.
"""

from collections.abc import Callable, Iterable, Mapping
from difflib import get_close_matches
from typing import Any, NamedTuple

#: End of a key -> unit of its value.
UNITS = {
    "_mm_min": "mm/min",
    "_mm_s2": "mm/s²",
    "_mm_s": "mm/s",
    "_rad_s": "rad/s",
    "_per_s2": "1/s²",
    "_per_min": "1/min",
    "_hz": "Hz",
    "_deg": "°",
    "_rad": "rad",
    "_mm": "mm",
    "_s": "s",
}
NUMBER, WHOLE, TEXT = "must be a number", "must be a whole number", "must be a string"
LIST, TABLE = "must be a list", "must be a table of keys and values"
#: Kind of a mistake -> rule, with numbers from pydantic in braces; UNIT: place of the unit.
RULES = {
    "missing": "is missing",
    "extra_forbidden": "unknown key",
    "greater_than": "must be greater than {gt}UNIT",
    "greater_than_equal": "must be at least {ge}UNIT",
    "less_than": "must be less than {lt}UNIT",
    "less_than_equal": "must be at most {le}UNIT",
    "multiple_of": "must be a multiple of {multiple_of}UNIT",
    "finite_number": "must be a finite numberUNIT",
    "dataclass_type": "must be a {class_name}",
    **dict.fromkeys(("float_type", "float_parsing"), f"{NUMBER}UNIT"),
    **dict.fromkeys(("int_type", "int_parsing", "int_from_float", "int_parsing_size"), WHOLE),
    **dict.fromkeys(("bool_type", "bool_parsing"), "must be true or false"),
    **dict.fromkeys(("string_type", "string_sub_type", "string_unicode"), TEXT),
    "string_too_short": "must have at least {min_length} characters",
    "string_too_long": "must have at most {max_length} characters",
    **dict.fromkeys(("tuple_type", "list_type", "set_type", "frozen_set_type"), LIST),
    **dict.fromkeys(("dict_type", "mapping_type", "model_type", "model_attributes_type"), TABLE),
    "too_short": "must have at least {min_length} entries (got {actual_length})",
    "too_long": "must have at most {max_length} entries (got {actual_length})",
    "path_type": "must be the path of a file",
    "callable_type": "must be a function",
    "is_instance_of": "must be of class {class}",
    "is_subclass_of": "must be a subclass of {class}",
    "none_required": "must be left out",
    "literal_error": "must be {expected}",
    "enum": "must be {expected}",
    "recursion_loop": "must not contain itself",
    "invalid_key": "must have strings as keys",
    "invalid-json-value": "must be a value that a file can hold",
}
#: Most characters of a list of names; if only ``FEW`` names do not fit, they are listed too.
MOST, FEW = 150, 3
#: Text for a kind of mistake that is not in ``RULES``.
NOT_ALLOWED = "is not allowed here"
_FIRST = "starting with a letter or digit"
#: Pattern of a text -> what it means.
PATTERNS = {
    r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$": f"1 to 64 letters, digits, '.', '_' and '-', {_FIRST}",
    r"^[A-Za-z_][A-Za-z0-9_]{0,31}$": "1 to 32 letters, digits and '_', not starting with a digit",
    r"^[a-z][a-z0-9_]{0,31}$": "1 to 32 lower-case letters, digits and '_', starting with a letter",
    r"^[a-z0-9][a-z0-9-]{0,31}$": f"1 to 32 lower-case letters, digits and '-', {_FIRST}",
    r"^unit-\d{1,4}$": "unit-N with a whole number N, as in unit-3",
    r"^[^/\\\x00-\x1f]{1,255}$": "a file name without a folder",
}


def rule(kind: str, context: Mapping[str, Any], unit: str) -> str:
    """Return the rule that a value breaks, from the mistake's kind and pydantic's context."""
    if kind == "string_pattern_mismatch":
        pattern = str(context["pattern"])
        return f"must be {PATTERNS.get(pattern, f'a string of the form {pattern}')}"
    numbers = {name: f"{x:.15g}" for name, x in context.items() if isinstance(x, float)}
    text = RULES.get(kind, NOT_ALLOWED).format_map({**context, **numbers})
    return text.replace("UNIT", f" [{unit}]" if unit else "")


def of_its_name(key: str) -> str:
    """Return the unit at the end of a key, as s of ``duration_s``; "" if it has none."""
    return next((unit for end, unit in UNITS.items() if key.endswith(end)), "")


class Keys(NamedTuple):
    """The keys that a file may have."""

    unit: Callable[[str], str] = of_its_name  # dotted key -> unit of the value; "": none
    every: Callable[[], Iterable[str]] = tuple  # all dotted keys
    whose: Callable[[str], str] = lambda key: ""  # dotted key -> names of its owners; "": none


def near(given: object, known: Iterable[str], most: int = 1) -> list[str]:
    """Return known names that ``given`` may mean: dotted keys with its end or start, or similar."""
    name, each = str(given).lower(), {one.lower(): one for one in known}
    alike = [name] if name in each else []
    if len(name) > 1:
        alike = alike or [one for one in each if one.endswith(f".{name}")]
        alike = alike or [one for one in each if "." in name and one.startswith(name)]
    return [each[one] for one in (alike or get_close_matches(name, each, most))[:most]]


def percent(share: float) -> str:
    """Return a share in per cent with two digits; above 0 and below 1e-5: "less than 0.001 %"."""
    if 0.0 < share < 1e-5:
        return "less than 0.001 %"
    return f"{100 * share:{'.2g' if share < 0.995 else '.0f'}} %"


def three_digits(value: float) -> str:
    """Return a number with three digits, as in tables; below a million without an exponent."""
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.3g}"


def alternatives(names: Iterable[str]) -> str:
    """Return the text ``a, b or c``; "" if there are no names."""
    *others, last = [*names] or [""]
    return f"{', '.join(others)} or {last}" if others else last


def one_of(given: object, known: Iterable[str], head: str = "available:") -> str:
    """Return ``available: a, b, c``, preceded by the known name that ``given`` may mean."""
    names = [*known]
    meant = "".join(f"did you mean {one}? " for one in near(given, names))
    listing = ", ".join(names) or "none"
    if len(listing) > MOST:
        first = listing[:MOST].rpartition(", ")[0]
        left = len(names) - first.count(", ") - 1
        listing = f"{first} and {left} more" if left > FEW else listing
    return f"{meant}{head} {listing}"
