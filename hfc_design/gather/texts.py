"""What a docstring says of itself: its first line, and where an equation is printed."""

import re

#: Papers by what they are cited as.
PAPERS = {
    "LL": "Lin & Lee 1999",
    "JK95": "Jee & Koren 1995",
    "JK04": "Jee & Koren 2004",
    "LG09": "Lin & Gai 2009",
    "EMPS": "Janot, Gautier & Brunot 2019",
}
_PLACE = r"(?:eq\.|[Tt]able|sections?|[Aa]ppendix|fig\.) ?[A-Z\d][\d.]*"
_CITED = rf"(?:{'|'.join(PAPERS)})\b"
_NAMED = r"(?:Lin & Lee|Lin & Gai|Jee & Koren|Koren) \(?\d{4}\)?|Huang & Shy|Huang et al\."
#: A paper as it is cited, "LL eq. 1-2" or "Lin & Lee 1999, section 3.2".
_SOURCE = re.compile(rf"\b(?:{_CITED}|{_NAMED})(?:,? {_PLACE}(?:(?:-| to | and )\d[\d.]*)?)?")


def first_line(text: str) -> str:
    """The first sentence of a docstring."""
    return " ".join(text.partition("\n\n")[0].split()).replace("`", "").rstrip(".")


def described(text: str) -> str:
    """The same without the paper that it cites in brackets."""
    return re.sub(r" \([^()]*(cited as|\d{4})[^()]*\)", "", first_line(text))


def source_in(text: str) -> str:
    """The paper that a text names, in full, with the equation if it does; "" for none."""
    text = re.sub(r"cited as (\w+), eq", r"\1 eq", " ".join(text.split()))
    found = [re.sub(r"(?<=[\d)])[., ]+$", "", one[0]) for one in _SOURCE.finditer(text)]
    placed = [one for one in found if re.search(_PLACE, one)]
    first = next(iter(placed or found), "").replace("(", "").replace(")", "")
    for short, paper in PAPERS.items():
        if first == short or first.startswith((f"{short} ", f"{short},")):
            first = ", ".join(filter(None, (paper, first.removeprefix(short).strip(", "))))
    return first
