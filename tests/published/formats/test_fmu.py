"""FMUs without a program of others: what is in them, what they refuse, what their binary does."""

import re
import zipfile
from xml.etree import ElementTree

from hfc_design.files.pairing import load_design
from hfc_design.formats import FORMATS

AFLC = load_design("jee-koren-2004-aflc")


def written(design, to, folder):
    FORMATS[to].write(design, folder)
    return {path.name: path for path in folder.iterdir()}


def described(fmu):
    with zipfile.ZipFile(fmu) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


def test_the_same_design_gives_the_same_bytes(tmp_path):
    first = written(AFLC, "fmu", tmp_path / "a")
    again = written(AFLC, "fmu", tmp_path / "b")
    assert set(first) == {"jee_koren_2004_aflc_fmi2.fmu", "jee_koren_2004_aflc_fmi3.fmu"}
    assert {k: x.read_bytes() for k, x in first.items()} == {
        k: x.read_bytes() for k, x in again.items()
    }
    other = written(load_design("jee-koren-2004-flc"), "fmu", tmp_path / "c")
    guids = [described(x).get("guid") for x in (*first.values(), *other.values())]
    assert len(set(guids)) == 3  # FMI 3.0 has none
    assert re.fullmatch(r"\{[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}\}", guids[0])
