"""A strict reader of zero-order TSK systems of IEEE 1855-2016, independent of the package.

It takes the elements and attributes of the standard that such a system needs and nothing else, and
reckons in the precision it is told, because the standard's numbers are xs:float.
"""

import xml.etree.ElementTree as ET

import numpy as np

NS = "{http://www.ieee1855.org}"
#: Element -> its attributes, its children in order.
STRUCTURE = {
    "fuzzySystem": ({"name"}, ["knowledgeBase", "tskRuleBase"]),
    "knowledgeBase": (set(), ["fuzzyVariable", "tskVariable"]),
    "fuzzyVariable": ({"name", "scale", "domainleft", "domainright", "type"}, ["fuzzyTerm"]),
    "tskVariable": ({"name", "scale", "type", "combination", "defaultValue"}, ["tskTerm"]),
    "fuzzyTerm": ({"name", "complement"}, None),
    "circularDefinition": (set(), ["and"]),
    "and": ({"t-norm"}, ["termName"]),
    "termName": (set(), []),
    "gaussianShape": ({"param1", "param2"}, []),
    "rightGaussianShape": ({"param1", "param2"}, []),
    "leftGaussianShape": ({"param1", "param2"}, []),
    "rightLinearShape": ({"param1", "param2"}, []),
    "leftLinearShape": ({"param1", "param2"}, []),
    "triangularShape": ({"param1", "param2", "param3"}, []),
    "tskTerm": ({"name", "order"}, ["tskValue"]),
    "tskValue": (set(), []),
    "tskRuleBase": ({"name", "activationMethod", "andMethod", "orMethod"}, ["tskRule"]),
    "tskRule": ({"name", "andMethod", "connector", "weight"}, ["antecedent", "tskConsequent"]),
    "antecedent": (set(), ["clause"]),
    "clause": (set(), ["variable", "term"]),
    "tskConsequent": (set(), ["tskThen"]),
    "tskThen": (set(), ["tskClause"]),
    "tskClause": (set(), ["variable", "term"]),
    "variable": (set(), []),
    "term": (set(), []),
}


class System:
    """A system in a file; ``kind`` is np.float64, or np.float32 as JFML reckons."""

    def __init__(self, file, kind=np.float64):
        self.root = ET.parse(file).getroot()
        self.kind = kind
        _check(self.root)
        elements = list(self.root.iter())
        names = [element.get("name") for element in elements if element.get("name")]
        assert len(set(names)) == len(names), "an ID stands there twice"
        referring = [e for e in elements if e.tag in (NS + "variable", NS + "term")]
        assert {element.text for element in referring} <= set(names)
        self.inputs = {v.get("name"): v for v in self.root.iter(NS + "fuzzyVariable")}
        self.terms = {t.get("name"): t for t in self.root.iter(NS + "fuzzyTerm")}
        (self.output,) = self.root.iter(NS + "tskVariable")
        self.values = {
            t.get("name"): kind(t.findtext(NS + "tskValue"))
            for t in self.output.iter(NS + "tskTerm")
        }

    def domain(self, name):
        return tuple(self.kind(self.inputs[name].get(key)) for key in ("domainleft", "domainright"))

    def evaluate(self, **inputs):
        """Output for arrays of the inputs; none may be outside its domain."""
        for name, values in inputs.items():
            low, high = self.domain(name)
            assert low <= values.min(), f"{name} below its domain"
            assert values.max() <= high, f"{name} above its domain"
        inputs = {name: values.astype(self.kind) for name, values in inputs.items()}
        weights = total = self.kind(0.0)
        for rule in self.root.iter(NS + "tskRule"):
            assert (rule.get("andMethod"), rule.get("connector")) == ("PROD", "and")
            firing = self.kind(rule.get("weight"))
            for clause in rule.iter(NS + "clause"):
                variable, term = clause.findtext(NS + "variable"), clause.findtext(NS + "term")
                assert self.terms[term] in list(self.inputs[variable])
                firing = firing * self.degree(term, inputs[variable])
            value = self.values[rule.find(f".//{NS}tskClause").findtext(NS + "term")]
            weights, total = weights + firing, total + firing * value
        default = self.kind(self.output.get("defaultValue"))
        return np.where(weights > 0.0, total / np.where(weights > 0.0, weights, 1), default)

    def degree(self, name, x):
        (shape,) = self.terms[name]
        p = [self.kind(shape.get(key)) for key in sorted(shape.keys())]
        kind = shape.tag.removeprefix(NS)
        if kind == "circularDefinition":
            first, second = (self.degree(part.text, x) for part in shape.iter(NS + "termName"))
            assert shape[0].get("t-norm") == "PROD"
            return first * second
        if kind == "triangularShape":
            rising, falling = (x - p[0]) / (p[1] - p[0]), (p[2] - x) / (p[2] - p[1])
            return np.clip(np.minimum(rising, falling), 0, 1)
        if kind == "rightLinearShape":
            return np.clip((x - p[0]) / (p[1] - p[0]), 0, 1)
        if kind == "leftLinearShape":
            return np.clip((p[1] - x) / (p[1] - p[0]), 0, 1)
        centre, sigma = p
        bell = np.exp(-((x - centre) ** 2) / (2 * sigma**2)).astype(self.kind)
        flat = {
            "gaussianShape": np.zeros_like(x, dtype=bool),
            "rightGaussianShape": x >= centre,
            "leftGaussianShape": x <= centre,
        }[kind]
        return np.where(flat, self.kind(1), bell)


def _check(element):
    attributes, children = STRUCTURE[element.tag.removeprefix(NS)]
    assert element.tag.startswith(NS)
    assert set(element.keys()) == attributes, element.tag
    found = [child.tag.removeprefix(NS) for child in element]
    if children is None:
        assert len(found) == 1
        assert found[0].endswith("Shape") or found[0] == "circularDefinition"
    else:
        assert list(dict.fromkeys(found)) == children, element.tag
    for child in element:
        _check(child)


def read(reader, file, row, column, points):
    """The output of a file, of points within the domains of its inputs."""
    system = reader(file)
    low, high = np.transpose([system.domain(name) for name in (row, column)])
    points = np.clip(points, low, high)
    return system.evaluate(**{row: points[:, 0], column: points[:, 1]})
