"""A project of PLCopen's XML as Structured Text again, for tests; written from the schema."""

import xml.etree.ElementTree as ET

PPX = "{http://www.plcopen.org/xml/tc6_0201}"
PARAGRAPH = "{http://www.w3.org/1999/xhtml}p"
SECTIONS = {"inputVars": "VAR_INPUT", "outputVars": "VAR_OUTPUT", "localVars": "VAR"}


def pous(text):
    """POU -> its kind, sections of (name, type, first value, documentation), body."""
    found = {}
    for pou in ET.fromstring(text).iter(f"{PPX}pou"):
        sections = {
            section.tag.removeprefix(PPX): [_variable(one) for one in section]
            for section in pou.find(f"{PPX}interface")
        }
        body = pou.find(f"{PPX}body/{PPX}ST/{PARAGRAPH}").text
        found[pou.get("name")] = (pou.get("pouType"), sections, body)
    return found


def block_in(text):
    """Name, sections and body of the function block in a project."""
    found = pous(text).items()
    name, (_, sections, body) = next(item for item in found if item[1][0] != "program")
    return name, sections, body


def _variable(element):
    kind = element.find(f"{PPX}type")[0]
    name = kind.get("name") or kind.tag.removeprefix(PPX)
    if name == "array":
        low, high = (kind.find(f"{PPX}dimension").get(key) for key in ("lower", "upper"))
        of = kind.find(f"{PPX}baseType")[0].tag.removeprefix(PPX)
        name = f"ARRAY[{low}..{high}] OF {of}"
    told = element.find(f"{PPX}documentation/{PARAGRAPH}")
    first = element.find(f"{PPX}initialValue")
    return element.get("name"), name, _first(first), "" if told is None else told.text


def _first(place):
    if place is None:
        return None
    if place[0].tag == f"{PPX}simpleValue":
        return place[0].get("value")
    return [_first(value) for value in place[0]]


def function_block(name, sections, body):
    """The text of a function block that these are the parts of."""
    lines = [f"FUNCTION_BLOCK {name}"]
    for section, variables in sections.items():
        lines.append(SECTIONS[section])
        for variable, kind, first, _ in variables:
            values = f"[{', '.join(first)}]" if isinstance(first, list) else first
            lines.append(f"{variable} : {kind}{(values and f' := {values}') or ''};")
        lines.append("END_VAR")
    return "\n".join([*lines, body, "END_FUNCTION_BLOCK"])
