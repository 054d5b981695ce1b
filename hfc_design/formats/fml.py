"""Fuzzy Markup Language of IEEE 1855-2016, with the structure that JFML reads."""

import xml.etree.ElementTree as ET
from collections import Counter

from hfc_design.controllers.rules import Triangle
from hfc_design.core.records import UserError
from hfc_design.files.design import Design
from hfc_design.formats.fuzzy_files import Input, texts
from hfc_design.formats.writing import Format


def systems(design: Design) -> dict[str, str]:
    """A folder with one system a unit; UserError: two names of a system are alike."""
    files = texts(design, "fml", domain=domain)
    for text in (text for name, text in files.items() if name.endswith(".fml")):
        # Names are XML IDs: all variables, terms and rules of a file share one space of them.
        names = Counter(element.get("name") for element in ET.fromstring(text.encode()).iter())
        for name, count in names.items():
            if name is not None and count > 1:
                raise UserError(f"--to fml: two things are called {name} there; rename one of them")
    return files


def domain(place: Input) -> tuple[float, float]:
    """Domain of a variable, wide where a value is not clamped: JFML does not take one beyond."""
    if place.clamped:
        return place.lowest, place.highest
    room = 1e6 if isinstance(place.terms[0], Triangle) else 1.0
    return place.lowest - room, place.highest + room


TEXT = "a folder with Fuzzy Markup Language (IEEE 1855), one system a unit"
FORMATS = (Format("fml", TEXT, systems),)
