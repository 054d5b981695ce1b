"""Fields of a checked record as entries: type, default and allowed values, in words."""

from collections.abc import Iterator
from typing import Annotated, Any, get_args

from pydantic import BaseModel, TypeAdapter

from hfc_design.core.embedded_files import EmbeddedFile
from hfc_design.core.numbers import Json, Plain
from hfc_design.reference.entries import Entry
from hfc_design.schema.comments import Comment, comments_of, source_in

#: Words for the types of a JSON schema.
TYPES = {
    "number": "number",
    "integer": "whole number",
    "string": "text",
    "boolean": "true or false",
    "object": "table",
    "array": "list",
    "null": "",
}
#: Words for the bounds of a JSON schema.
BOUNDS = {
    "exclusiveMinimum": "greater than",
    "minimum": "at least",
    "exclusiveMaximum": "less than",
    "maximum": "at most",
}


def fields_of(
    record: type[BaseModel], prefix: str, head: Entry, passed: tuple[type[Any], ...] = ()
) -> Iterator[Entry]:
    """Yield an entry for each field of a record and of its nested records, with dotted keys.

    ``prefix`` begins each key; ``head`` has the values that all entries share. Fields that select a
    kind have no entry, nor have the fields of ``passed`` records and of a record within itself.
    """
    comments = comments_of(record)
    for name, field in record.model_fields.items():
        inside, schema = records_in(field.annotation), _schema(field)
        named = "const" in schema or (head.part and prefix.count(".") == 1)
        if named and name in ("kind", "preset"):
            continue
        # the defaults of a table are those of its own keys
        kind = type_of(schema).replace("file or table", "file")
        begins = isinstance(field.default, str)  # the name of a design
        without = field.is_required() or (inside and kind.startswith("table") and not begins)
        comment, key = comments.get(name, Comment(field.description or "")), prefix + name
        yield head._replace(
            key=key,
            type=kind,
            unit=comment.unit,
            default=None if without else plain(field.get_default(call_default_factory=True)),
            required=field.is_required(),
            absent=kind == "table" and field.default is None,
            allowed=allowed(schema),
            meaning=comment.meaning,
            source=source_in(comment.meaning),
        )
        for one in inside:
            if not issubclass(one, (*passed, record, EmbeddedFile)):
                place = key + _placeholder(name, schema)
                yield from fields_of(one, f"{place}.", head, (*passed, record))


def _placeholder(name: str, schema: Json) -> str:
    """Return the placeholder in keys of records in a list or a table of arbitrary names."""
    branches = _branches(schema)
    only = branches[0] if len(branches) == 1 else schema
    if only.get("type") == "array":
        return ".N"
    if _of_any_name(only) is not None:
        return ".AXIS" if name in ("axes", "limits") else ".NAME"
    return ""


def records_in(annotation: Any) -> list[type[BaseModel]]:
    """Return the record classes that a type annotation contains."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [one for part in get_args(annotation) for one in records_in(part)]


def plain(value: Any) -> Plain:
    """Return a default value as a file represents it."""
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json", exclude_none=True)
    return [plain(one) for one in value] if isinstance(value, tuple | list) else value


def _schema(field: Any) -> Json:
    """Return the JSON schema of a field, with references replaced."""
    annotation: Any = field.annotation
    if field.metadata:
        annotation = Annotated[(annotation, *field.metadata)]
    schema: Json = TypeAdapter(annotation).json_schema()
    return _resolved(schema, schema.get("$defs", {}))


def _resolved(schema: Json, known: Json) -> Json:
    """Return a schema with references replaced, but not those inside what replaces them."""
    if "$ref" in schema:
        return known[schema["$ref"].rpartition("/")[2]]
    resolved = dict(schema)
    for key in {"anyOf", "oneOf"} & resolved.keys():
        resolved[key] = [_resolved(one, known) for one in resolved[key]]
    for key in ("items", "additionalProperties"):
        if isinstance(resolved.get(key), dict):
            resolved[key] = _resolved(resolved[key], known)
    if patterns := resolved.get("patternProperties"):
        resolved["patternProperties"] = {key: _resolved(x, known) for key, x in patterns.items()}
    return resolved


def _branches(schema: Json) -> list[Json]:
    branches = [*schema.get("anyOf", ()), *schema.get("oneOf", ())]
    return [one for one in branches if one.get("type") != "null"]


def _of_any_name(schema: Json) -> Json | None:
    """Return the schema of values in a table of arbitrary keys; None if its keys are fixed."""
    values = [schema.get("additionalProperties"), *schema.get("patternProperties", {}).values()]
    return values[-1] if isinstance(values[-1], dict) else None


def type_of(schema: Json) -> str:
    """Return the type of a schema in words."""
    if branches := _branches(schema):
        return " or ".join(dict.fromkeys(type_of(one) for one in branches))
    if schema.get("format") == "path":
        return "file"
    if "enum" in schema or "const" in schema:
        return "whole number" if isinstance(_choices(schema)[0], int) else "text"
    name = TYPES.get(schema.get("type", ""), "anything")
    inside = _of_any_name(schema) if name == "table" else None
    if name == "list":
        inside = schema.get("items") or (schema.get("prefixItems") or [{}])[0]
    of = type_of(inside) if inside is not None else "anything"
    return name if of == "anything" else f"{name} of {_plural(of)}"


def _choices(schema: Json) -> list[Any]:
    return schema.get("enum", [schema.get("const")])


def _plural(name: str) -> str:
    """Return the plural of a type's name."""
    if name == TYPES["boolean"]:
        return name
    parts = (part.partition(" of ") for part in name.split(" or "))
    return " or ".join(f"{first}s{of}{rest}" for first, of, rest in parts)


def allowed(schema: Json) -> str:
    """Return in words which values of its type a schema allows; "": all."""
    if branches := _branches(schema):
        return "; ".join(filter(None, dict.fromkeys(map(allowed, branches))))
    if "enum" in schema or "const" in schema:
        return ", ".join(map(str, _choices(schema)))
    words = [f"{words} {schema[key]:.12g}" for key, words in BOUNDS.items() if key in schema]
    if several := schema.get("prefixItems"):
        inner = allowed(several[0])
        return f"{len(several)} of them" + (f", each {inner}" if inner else "")
    low, high = schema.get("minItems"), schema.get("maxItems")
    if low is not None and low == high:
        words.append(f"{low} of them")
    else:
        words += [f"at least {low} of them"] if low else []
        words += [f"at most {high} of them"] if high else []
    for part in (schema.get("items"), _of_any_name(schema)):
        if isinstance(part, dict) and (inner := allowed(part)):
            words.append(f"each {inner}")
    return ", ".join(words)
