"""Mistakes in a user's file: a line for each, with its key. Never imports JAX."""

import re
from collections.abc import Callable, Iterable
from itertools import islice
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError
from pydantic_core.core_schema import ErrorType

from hfc_design.core.numbers import Plain
from hfc_design.core.quantities import without_unit
from hfc_design.core.wording import Keys, alternatives, near, one_of, rule

#: Most lines on one file; further mistakes are only counted.
MOST = 100
#: Most parts of a dotted key that are examined; only a key in quotes can have more.
DEEP, _DOT = 64, re.compile(r"\.")
#: Types of errors that pydantic defines; validators may raise errors of other types.
KINDS = frozenset(get_args(ErrorType))
NO_SUCH, MEANT = "unknown key", "did you mean"
NO_KEYS = Keys()
Place = tuple[int | str, ...]


class NoSuchKey(ValueError):
    """Error for a key that a table does not have."""


def no_such_key(model: type[BaseModel], key: str) -> NoSuchKey:
    """Return the error for a key that the table of ``model`` does not have."""
    known = [*model.model_fields]
    inside = [f"{name}.{key}" for name in known if key in _fields(model, name)]
    meant = inside if inside and not near(key, known) else []
    hint = f"{MEANT} {' or '.join(meant)}? " if meant else ""
    return NoSuchKey(f"{NO_SUCH}; {hint}{one_of('' if meant else key, known)}")


def _fields(model: type[BaseModel], name: str) -> Iterable[str]:
    """Return the keys of a field that is a table with fixed keys; else ()."""
    field: Any = model.model_fields[name].annotation
    if get_origin(field) is Annotated:
        field = get_args(field)[0]
    return field.model_fields if isinstance(field, type) and issubclass(field, BaseModel) else ()


def with_keys(error: ValidationError, model: type[BaseModel]) -> ValidationError:
    """Return the same error; for unknown keys of the ``model`` itself it lists the known keys."""

    mine = 0  # unknown keys so far; to find what each of very many may mean takes minutes

    def with_key(kind: str, place: Place) -> Exception | None:
        nonlocal mine
        if kind != "extra_forbidden" or len(place) != 1:
            return None
        mine += 1
        return no_such_key(model, str(place[0])) if mine <= MOST else NoSuchKey(NO_SUCH)

    return _again(error, (), with_key)


def inside(error: ValidationError, *place: int | str) -> ValidationError:
    """Return the same error with ``place``, the keys of its record in the file, in front."""
    return _again(error, place, lambda kind, place: None)


def with_lines(error: ValidationError | None, lines: Iterable[str]) -> ValidationError:
    """Return the error of a table with further mistakes: ``lines`` that begin with its keys."""
    details = [] if error is None else _details(error, (), lambda kind, place: None)
    details += [
        InitErrorDetails(type="value_error", loc=(), input={}, ctx={"error": ValueError(line)})
        for line in lines
    ]
    return ValidationError.from_exception_data("" if error is None else error.title, details)


def _again(
    error: ValidationError, front: Place, reword: Callable[[str, Place], Exception | None]
) -> ValidationError:
    return ValidationError.from_exception_data(error.title, _details(error, front, reword))


def _details(
    error: ValidationError, front: Place, reword: Callable[[str, Place], Exception | None]
) -> list[InitErrorDetails]:
    details = []
    for one in error.errors(include_url=False):
        kind: Any = one["type"]
        context = one.get("ctx", {})
        if (new := reword(kind, one["loc"])) is not None:
            kind, context = "value_error", {"error": new}
        elif kind not in KINDS:
            kind, context = PydanticCustomError(kind, "{told}", {"told": one["msg"]}), {}
        place = (*front, *one["loc"])
        details.append(InitErrorDetails(type=kind, loc=place, input=one["input"], ctx=context))
    return details


def format_errors(
    error: ValidationError, data: Plain, again: Callable[[Plain], Any], keys: Keys = NO_KEYS
) -> list[str]:
    """Return lines on the mistakes in ``data``; all missing keys come first, in one line.

    ``again`` validates changed data, whose error tells the available kinds. ``keys`` are the keys
    that such a file may have.
    """
    missing, faults = [], dict[str, list[str]]()
    for one in error.errors(include_url=False):
        if one["type"] == "missing":
            missing.append(_place(one["loc"], data, True)[0])
            continue
        if len(faults) <= MOST:
            key, line = _text(one, data, again, keys)
        else:
            key = line = _place(one["loc"], data, False)[0]
        faults.setdefault(key, []).append(line)
    lines = []
    if missing:
        lines = [f"{', '.join(missing)}: {'are' if len(missing) > 1 else 'is'} missing"]
    # Where several types are allowed, a fault inside a value says more than "not the other type".
    around = {key[: dot.start()] for key in faults for dot in islice(_DOT.finditer(key), DEEP)}
    shown = {key: messages for key, messages in faults.items() if key not in around}
    lines += [_either(messages) for messages in [*shown.values()][:MOST]]
    if rest := [*shown][MOST:]:
        lines.append(f"and {len(rest)} more keys with errors, starting with {rest[0]}")
    return lines


def _either(messages: list[str]) -> str:
    """Return one line for several rules of which a value has to meet any one."""
    first, *others = dict.fromkeys(messages)
    head, rule, _ = first.partition(": must be ")
    alike = bool(rule) and all(line.startswith(head + rule) for line in others)
    return (
        alternatives([first, *(x.removeprefix(head + rule).strip() for x in others)])
        if alike
        else ("; ".join([first, *others]))
    )


def _text(error: Any, data: Plain, again: Callable[[Plain], Any], keys: Keys) -> tuple[str, str]:
    """Return the dotted key of an error, and the line for the user."""
    kind, place, context = error["type"], error["loc"], error.get("ctx", {})
    key, value = _place(place, data, False)
    if place and place[-1] == "[key]":
        if kind == "value_error":
            return key, f"{key}: its name {context['error']}"
        return key, f"{key}: its name {rule(kind, context, '')}"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _no_kind(error, data, key, again)
    if kind == "value_error":
        fault = context["error"]
        message = str(fault)
        if isinstance(fault, NoSuchKey) and MEANT not in message:
            message = message.replace(f"{NO_SUCH};", _there(key, keys), 1)
        if isinstance(value, dict) and not isinstance(fault, NoSuchKey):
            line = f"{key}.{message}" if key else message  # the record names its own key
            return line.partition(" = ")[0].partition(": ")[0], line
    else:
        message = rule(kind, context, keys.unit(key))
        if kind == "float_parsing":
            message += without_unit(value, keys.unit(key))
        if kind == "literal_error" and isinstance(value, str):
            names = [
                name.strip("'") for name in context["expected"].replace(" or ", ", ").split(", ")
            ]
            if meant := near(value, names):
                message += f"; did you mean {meant[0]!r}?"
    return key, f"{key} = {short(value)}: {message}" if key else message


def _there(key: str, keys: Keys) -> str:
    """Return a text on an unknown key: whose key it is, or which known keys end alike."""
    if other := keys.whose(key):
        return f"{NO_SUCH} here, it belongs to {other};"
    end = key.rpartition(".")[2]
    ends = [one for one in keys.every() if one.endswith(f".{end}")]
    return f"{NO_SUCH}; {MEANT} {' or '.join(ends[:2])}?" if ends else f"{NO_SUCH};"


def _no_kind(error: Any, data: Plain, key: str, again: Callable[[Plain], Any]) -> tuple[str, str]:
    """Return the dotted key and the line for a table whose kind is missing or unknown."""
    context = error.get("ctx", {})
    which = context["discriminator"].strip("'")
    kind_key = f"{key}.{which}" if key else which
    if error["type"] == "union_tag_invalid":
        known = [name.strip("' ") for name in context["expected_tags"].split(",")]
        return (
            kind_key,
            f"{kind_key} = {short(context['tag'])}: unknown {which}; "
            f"{one_of(context['tag'], known)}",
        )
    known = _kinds(error["loc"], data, which, again)
    return kind_key, f"{kind_key}: is missing; {one_of('', known)}"


def _kinds(place: Place, data: Plain, which: str, again: Callable[[Plain], Any]) -> list[str]:
    """Return the kinds that the table at ``place`` can have, from the error for an unknown kind."""
    try:
        again(_with_kind(data, place, which))
    except ValidationError as error:
        for one in error.errors(include_url=False):
            if one["type"] == "union_tag_invalid" and one["loc"] == place:
                return [name.strip("' ") for name in one["ctx"]["expected_tags"].split(",")]
    return []


def _with_kind(data: Plain, place: Place, which: str) -> Plain:
    """Return ``data`` with an impossible kind in the table at ``place``."""
    if isinstance(data, dict) and place and place[0] in data:
        return data | {place[0]: _with_kind(data[place[0]], place[1:], which)}
    if isinstance(data, list | tuple) and place and isinstance(place[0], int):
        entry = _with_kind(data[place[0]], place[1:], which)
        return [*data[: place[0]], entry, *data[place[0] + 1 :]]
    if place:  # the branch of a union, which is no key of the file
        return _with_kind(data, place[1:], which)
    return data | {which: ""} if isinstance(data, dict) else data


def _place(location: Place, data: Plain, missing: bool) -> tuple[str, Plain]:
    """Return the dotted key of a location, and the value there; ``missing``: it is not in the file.

    pydantic puts the branch of a union into the location too; no such key is in the file.
    """
    keys = []
    for k, part in enumerate(location):
        last = k + 1 == len(location)
        branch = part not in data if isinstance(data, dict) else not isinstance(data, list | tuple)
        if branch and not (last and missing):
            continue
        keys.append(str(part))
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            data = None
    return ".".join(keys), data


def short(value: Plain, limit: int = 60) -> str:
    """Return the ``repr`` of a value, shortened for a message."""
    text = repr(value)
    return text if len(text) <= limit else text[:limit] + "..."
