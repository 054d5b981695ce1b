"""A number in a dotted key names an entry of a list, in a design and in a scenario."""

import json

from hfc_design import api as hfc
from hfc_design.files.design import BUILTIN, parse_design


def test_labels_follow_from_a_changed_number():
    """With 20 the rule of the zeros is between the PM (16) and the PL (32) of JK04 Table 3."""
    found = hfc.load_design("jee-koren-2004-flc", ["controller.rules.centroids.3.3=20"]).controller
    assert found.rules.centroids[3][3] == 20.0
    assert found.rules.labels[3][3] == "PM"
    before = hfc.load_design("jee-koren-2004-flc").controller
    assert found.rules.labels[0] == before.rules.labels[0]


def test_numbers_follow_from_a_changed_label_where_it_names_one():
    terms = {"low": -2.0, "none": 0.0, "high": 3.0}
    design = json.loads((BUILTIN / "jee-koren-2004-flc.json").read_text())
    labels = [["none"] * 7 for _ in range(7)]
    design["controller"]["rules"] = {"labels": labels, "output_terms": terms}
    own = parse_design(json.dumps(design), "own")
    found = hfc.load_design(own, ["controller.rules.labels.1.2=high"]).controller.rules
    assert found.centroids[1][2] == 3.0
    assert sum(map(sum, found.centroids)) == 3.0


def test_an_axis_of_its_own():
    axes = {"x": "jee-koren-2004-flc", "y": "jee-koren-2004-flc"}
    own = {k: hfc.load_design(name).controller.model_dump(mode="json") for k, name in axes.items()}
    design = json.loads((BUILTIN / "jee-koren-2004-flc.json").read_text())
    design["controller"] = {"kind": "per-axis", "sample_time_s": 0.01, "axes": own}
    whole = parse_design(json.dumps(design), "both")
    found = hfc.load_design(whole, ["controller.axes.y.rules.centroids.3.3=20"]).controller
    assert found.axes["y"].rules.labels[3][3] == "PM"
    assert found.axes["x"] == whole.controller.axes["x"]
