"""Names of another program's variables and terms as a design can hold them."""

import re
import unicodedata
from collections.abc import Iterable, Sequence

#: Longest name of a term or variable, see ``records.Label``.
LONGEST = 32
PLAIN = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")
#: Letters that are written as two, and those of which Unicode knows no plain one.
WRITTEN = {"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "æ": "ae", "œ": "oe", "ø": "o", "ł": "l"}
LETTERS = str.maketrans(WRITTEN | {k.upper(): v.title() for k, v in WRITTEN.items() if k != "ß"})
GREEK = re.compile(r"GREEK (CAPITAL|SMALL) LETTER (\w+)")


def _plain(name: str) -> str:
    """The name in ASCII: umlauts as two letters, Greek ones by name, no accents, nothing else."""

    def written(letter: re.Match[str]) -> str:
        greek = GREEK.fullmatch(unicodedata.name(letter[0], ""))
        return "" if not greek else greek[2].title() if greek[1] == "CAPITAL" else greek[2].lower()

    text = unicodedata.normalize("NFC", name).translate(LETTERS)
    return re.sub(r"[^\x00-\x7f]", written, unicodedata.normalize("NFKD", text))


def identifiers(names: Iterable[str], prefix: str, stand_ins: Sequence[str] = ()) -> list[str]:
    """The names as identifiers of every format, all different, also in lower case.

    A letter, then letters, digits and single underscores: whatever else is none becomes an
    underscore, ``prefix`` stands before what would begin with a digit. Of a name of which nothing
    is left the place decides: one of ``stand_ins``, or ``prefix`` with a number from 1 on.
    """
    found: list[str] = []
    taken: set[str] = set()
    for place, name in enumerate(names):
        text = re.sub(r"[^A-Za-z0-9]+", "_", _plain(name)).strip("_")
        text = text or (stand_ins[place] if stand_ins else f"{prefix}_{place + 1}")
        if not PLAIN.fullmatch(text):
            text = f"{prefix}_{text}"
        text = short = text[:LONGEST].rstrip("_")
        number = 1
        while text.casefold() in taken:
            number += 1
            text = f"{short[: LONGEST - 4].rstrip('_')}_{number}"
        taken.add(text.casefold())
        found.append(text)
    return found
