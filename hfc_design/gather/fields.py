"""The fields of a checked record as entries: type, default and what is allowed, in words."""

from collections.abc import Iterator
from typing import Annotated, Any, get_args

from pydantic import BaseModel, TypeAdapter

from hfc_design.core.carried import Carried
from hfc_design.core.numbers import Json, Plain
from hfc_design.gather.comments import Comment, comments_of, source_in
from hfc_design.reference.entries import Entry

NAMES = {
    "number": "number",
    "integer": "whole number",
    "string": "text",
    "boolean": "true or false",
    "object": "table",
    "array": "list",
    "null": "",
}
#: Bounds of a JSON schema, and how they are said.
BOUNDS = {
    "exclusiveMinimum": "more than",
    "minimum": "at least",
    "exclusiveMaximum": "less than",
    "maximum": "at most",
}


def fields_of(
    record: type[BaseModel], prefix: str, head: Entry, passed: tuple[type[Any], ...] = ()
) -> Iterator[Entry]:
    """An entry for each field of a record and of those inside it, by dotted keys.

    ``head`` has what all share. A field that says which kind something is has no entry, nor has a
    record inside of itself.
    """
    said = comments_of(record)
    for name, field in record.model_fields.items():
        inside = records_in(field.annotation)
        schema = _schema(field)
        named = "const" in schema or (head.part and prefix.count(".") == 1)
        if named and name in ("kind", "preset"):
            continue
        # what stands in a table of its own has its defaults there
        kind = type_of(schema).replace("file or table", "file")
        begins = isinstance(field.default, str)  # with a design of that name
        own = field.is_required() or (inside and kind.startswith("table") and not begins)
        default = None if own else plain(field.get_default(call_default_factory=True))
        told, key = said.get(name, Comment(field.description or "")), prefix + name
        yield head._replace(
            key=key,
            type=kind,
            unit=told.unit,
            default=default,
            required=field.is_required(),
            allowed=allowed(schema),
            meaning=told.meaning,
            source=source_in(told.meaning),
        )
        for one in inside:
            if not issubclass(one, (*passed, record, Carried)):
                place = key + placeholder(name, schema)
                yield from fields_of(one, f"{place}.", head, (*passed, record))


def placeholder(name: str, schema: Json) -> str:
    """What stands in the key of a record inside a list or a table with names of its own."""
    branches = _branches(schema)
    found = branches[0] if len(branches) == 1 else schema
    if found.get("type") == "array":
        return ".N"
    if _named(found) is not None:
        return ".AXIS" if name in ("axes", "limits") else ".NAME"
    return ""


def _named(schema: Json) -> Json | None:
    """What a table holds under whatever names; None where it has keys of its own."""
    found = schema.get("additionalProperties")
    for own in schema.get("patternProperties", {}).values():
        found = own
    return found if isinstance(found, dict) else None


def records_in(annotation: Any) -> list[type[BaseModel]]:
    """The records that a type is made of."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [one for part in get_args(annotation) for one in records_in(part)]


def plain(value: Any) -> Plain:
    """A default as a file has it."""
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json", exclude_none=True)
    if isinstance(value, tuple | list):
        return [plain(one) for one in value]
    return value


def _schema(field: Any) -> Json:
    """What a field asks for, as a JSON schema."""
    told = field.annotation
    if field.metadata:
        told = Annotated[(told, *field.metadata)]
    found: Json = TypeAdapter(told).json_schema()
    return _resolved(found, found.get("$defs", {}))


def _resolved(schema: Json, known: Json) -> Json:
    """A schema with what it refers to in its place, one level deep."""
    if "$ref" in schema:
        return known[schema["$ref"].rpartition("/")[2]]
    found = dict(schema)
    for key in ("anyOf", "oneOf"):
        if key in found:
            found[key] = [_resolved(one, known) for one in found[key]]
    for key in ("items", "additionalProperties"):
        if isinstance(found.get(key), dict):
            found[key] = _resolved(found[key], known)
    if own := found.get("patternProperties"):
        found["patternProperties"] = {key: _resolved(one, known) for key, one in own.items()}
    return found


def _branches(schema: Json) -> list[Json]:
    found = [*schema.get("anyOf", ()), *schema.get("oneOf", ())]
    return [one for one in found if one.get("type") != "null"]


def type_of(schema: Json) -> str:
    """The type that a schema asks for, in words."""
    if len(branches := _branches(schema)) > 0:
        return " or ".join(dict.fromkeys(type_of(one) for one in branches))
    if schema.get("format") == "path":
        return "file"
    if "enum" in schema or "const" in schema:
        values = schema.get("enum", [schema.get("const")])
        return "whole number" if isinstance(values[0], int) else "text"
    name = NAMES.get(schema.get("type", ""), "anything")
    inside = _named(schema) if name == "table" else None
    if name == "list":
        inside = schema.get("items") or (schema.get("prefixItems") or [{}])[0]
    told = type_of(inside) if inside is not None else "anything"
    return name if told == "anything" else f"{name} of {plural(told)}"


def plural(name: str) -> str:
    """Several of a type."""
    if name == "true or false":
        return name
    parts = (part.partition(" of ") for part in name.split(" or "))
    return " or ".join(f"{first}s{of}{rest}" for first, of, rest in parts)


def allowed(schema: Json) -> str:
    """What a schema allows beside its type, in words."""
    if branches := _branches(schema):
        return "; ".join(filter(None, dict.fromkeys(map(allowed, branches))))
    if "enum" in schema or "const" in schema:
        return ", ".join(map(str, schema.get("enum", [schema.get("const")])))
    words = [f"{words} {schema[key]:.12g}" for key, words in BOUNDS.items() if key in schema]
    if "prefixItems" in schema:
        inner = allowed(schema["prefixItems"][0])
        return f"{len(schema['prefixItems'])} of them" + (f", each {inner}" if inner else "")
    low, high = schema.get("minItems"), schema.get("maxItems")
    if low is not None and low == high:
        words.append(f"{low} of them")
    else:
        words += [f"at least {low} of them"] if low else []
        words += [f"at most {high} of them"] if high else []
    for part in (schema.get("items"), _named(schema)):
        if isinstance(part, dict) and (inner := allowed(part)):
            words.append(f"each {inner}")
    return ", ".join(words)
