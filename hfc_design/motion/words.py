"""The words of a block of G-code, ``X-1.5``, and what stands between them.

As RS274/NGC has it, blanks mean nothing, inside of numbers neither: ``X- .992`` is X-.992.
"""

import re

#: A comment, blanks, or a letter with the number that belongs to it.
PIECE = re.compile(
    r"(?P<comment>\([^()\n]*\)|;[^\n]*|%)"
    r"|(?P<letter>[A-Za-z])\s*(?P<number>[+-]?\s*(?:[0-9][0-9\s]*(?:\.[0-9\s]*)?|\.\s*[0-9][0-9\s]*))?"
    r"|(?P<blank>\s+)"
)
#: Characters that are shown of what is not understood.
SHOWN = 20


def words_of(block: str) -> list[tuple[str, float]]:
    """Letters, in capitals, and numbers of a block.

    Raises:
        ValueError: a letter has no number, or something is neither word nor comment.
    """
    found: list[tuple[str, str | None]] = []
    place = 0
    while place < len(block):
        piece = PIECE.match(block, place)
        if piece is None:
            there = block[max(place - SHOWN, 0) : place + SHOWN].strip()
            raise ValueError(f"cannot be understood at column {place + 1}: {there!r}")
        if piece["letter"]:
            found.append((piece["letter"].upper(), piece["number"]))
        place = piece.end()
    return [(letter, _number(letter, number)) for letter, number in found]


def _number(letter: str, number: str | None) -> float:
    if number is None:
        raise ValueError(f"{letter} has no number")
    return float("".join(number.split()))
