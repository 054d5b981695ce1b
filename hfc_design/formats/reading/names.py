"""Names of another program's variables and terms as a design can hold them."""

import re
import unicodedata
from collections.abc import Iterable

#: Longest name of a term or variable, see ``records.Label``.
LONGEST = 32
PLAIN = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")


def identifiers(names: Iterable[str], prefix: str) -> list[str]:
    """The names as identifiers of every format, all different, also in lower case.

    A letter, then letters, digits and single underscores: accents go, whatever else is none
    becomes an underscore, ``prefix`` stands before what would begin with a digit or be empty.
    """
    found: list[str] = []
    taken: set[str] = set()
    for name in names:
        plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
        text = re.sub(r"[^A-Za-z0-9]+", "_", plain).strip("_")
        if not PLAIN.fullmatch(text):
            text = f"{prefix}_{text}".rstrip("_")
        text = short = text[:LONGEST].rstrip("_")
        number = 1
        while text.casefold() in taken:
            number += 1
            text = f"{short[: LONGEST - 4].rstrip('_')}_{number}"
        taken.add(text.casefold())
        found.append(text)
    return found
