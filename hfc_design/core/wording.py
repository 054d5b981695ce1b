"""Rules that a value breaks, in the words of this project. Never imports JAX.

pydantic names the kind of a mistake; none of its own sentences reaches a user.
"""

from collections.abc import Callable, Iterable, Mapping
from difflib import get_close_matches
from typing import Any, NamedTuple

#: What the last parts of a key say of its unit.
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
NUMBER, WHOLE, TEXT = "has to be a number", "has to be a whole number", "has to be a text"
LIST, TABLE = "has to be a list", "has to be a table of keys and values"
#: Kind of a mistake -> the rule, with what pydantic knows of it; UNIT stands for the key's.
RULES = {
    "missing": "is missing",
    "extra_forbidden": "there is no such key",
    "greater_than": "has to be greater than {gt}UNIT",
    "greater_than_equal": "has to be {ge} or moreUNIT",
    "less_than": "has to be less than {lt}UNIT",
    "less_than_equal": "has to be {le} or lessUNIT",
    "multiple_of": "has to be a multiple of {multiple_of}UNIT",
    "finite_number": "has to be a finite numberUNIT",
    **dict.fromkeys(("float_type", "float_parsing"), f"{NUMBER}UNIT"),
    **dict.fromkeys(("int_type", "int_parsing", "int_from_float", "int_parsing_size"), WHOLE),
    **dict.fromkeys(("bool_type", "bool_parsing"), "has to be true or false"),
    **dict.fromkeys(("string_type", "string_sub_type", "string_unicode"), TEXT),
    "string_too_short": "has to have {min_length} letters or more",
    "string_too_long": "has to have {max_length} letters or fewer",
    **dict.fromkeys(("tuple_type", "list_type", "set_type", "frozen_set_type"), LIST),
    **dict.fromkeys(("dict_type", "mapping_type", "model_type", "model_attributes_type"), TABLE),
    "too_short": "has to have at least {min_length} entries, not {actual_length}",
    "too_long": "has to have at most {max_length} entries, not {actual_length}",
    "path_type": "has to be the path of a file",
    "callable_type": "has to be a function",
    "is_instance_of": "has to be of class {class}",
    "is_subclass_of": "has to be a class made from {class}",
    "none_required": "has to be left out",
    "literal_error": "has to be {expected}",
    "enum": "has to be {expected}",
    "recursion_loop": "holds itself",
    "invalid_key": "has to have texts as its keys",
    "invalid-json-value": "is nothing that a file can hold",
}
#: Letters of names in a row.
MOST = 150
#: Of a kind that nobody thought of.
NOT_ALLOWED = "is not allowed here"
_FIRST = "with a letter or digit in front"
#: Pattern of a text -> what it means.
PATTERNS = {
    r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$": f"1 to 64 letters, digits, '.', '_' and '-', {_FIRST}",
    r"^[A-Za-z_][A-Za-z0-9_]{0,31}$": "1 to 32 letters, digits and '_', with no digit in front",
    r"^[a-z][a-z0-9_]{0,31}$": "1 to 32 small letters, digits and '_', with a letter in front",
    r"^[a-z0-9][a-z0-9-]{0,31}$": f"1 to 32 small letters, digits and '-', {_FIRST}",
    r"^unit-\d{1,4}$": "unit-N with a number N, as in unit-3",
    r"^[^/\\\x00-\x1f]{1,255}$": "the name of a file without its folder",
}


def rule(kind: str, context: Mapping[str, Any], unit: str) -> str:
    """What has to be there in a ``unit``, of a mistake's kind and what pydantic knows of it."""
    if kind == "string_pattern_mismatch":
        pattern = str(context["pattern"])
        return f"has to be {PATTERNS.get(pattern, f'a text of the form {pattern}')}"
    numbers = {name: f"{x:.15g}" for name, x in context.items() if isinstance(x, float)}
    text = RULES.get(kind, NOT_ALLOWED).format_map({**context, **numbers})
    return text.replace("UNIT", f" [{unit}]" if unit else "")


def of_its_name(key: str) -> str:
    """The unit that a key ends with, s of ``duration_s``; "": none."""
    return next((unit for end, unit in UNITS.items() if key.endswith(end)), "")


class Keys(NamedTuple):
    """The keys that a file may have."""

    unit: Callable[[str], str] = of_its_name  # of what stands at a dotted key; "": none
    every: Callable[[], Iterable[str]] = tuple
    whose: Callable[[str], str] = lambda key: ""  # of what else a dotted key is; "": of nothing


def near(given: object, known: Iterable[str], most: int = 1) -> list[str]:
    """The names that may be meant: ends or beginnings of dotted keys, else those that are alike."""
    name, each = str(given).lower(), {one.lower(): one for one in known}
    alike = [name] if name in each else []
    if len(name) > 1:
        alike = alike or [one for one in each if one.endswith(f".{name}")]
        alike = alike or [one for one in each if "." in name and one.startswith(name)]
    return [each[one] for one in (alike or get_close_matches(name, each, most))[:most]]


def percent(share: float) -> str:
    """A share to two digits; what is below a thousandth of a per cent is told as that."""
    if 0.0 < share < 1e-5:
        return "less than 0.001 %"
    return f"{100 * share:{'.2g' if share < 0.995 else '.0f'}} %"


def three_digits(value: float) -> str:
    """Of a number as tables have it, up to a million without an exponent."""
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.3g}"


def one_of(given: object, known: Iterable[str], head: str = "there is") -> str:
    """``there is a, b, c`` with what may have been meant in front."""
    names = [*known]
    meant = "".join(f"did you mean {one}? " for one in near(given, names))
    listing = ", ".join(names) or "none"
    if len(listing) > MOST:
        first = listing[:MOST].rpartition(", ")[0]
        listing = f"{first} and {len(names) - first.count(', ') - 1} more"
    return f"{meant}{head} {listing}"
