"""A table of a page for a paper in LaTeX: booktabs, plain digits, everything escaped."""

import re
from collections.abc import Sequence
from decimal import Decimal

from hfc_design.pictures.latex import escaped
from hfc_design.pictures.section import Listing

#: How a cell of a column of numbers begins; "–" stands where there is none.
NUMERIC = re.compile(r"[<≤]? ?[-+±\u2212]?(\d|\.\d|[–∞]|unstable$|diverged$)|$")
#: A number with a power of ten.
POWER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e([+-]?\d+)(?![\w.])")
MINUS = re.compile(r"(?<![\w.)])-(?=[\d.])")
#: A column of words with more letters than that gets this share of the width.
LONG, SHARE = 40, 0.4
#: Powers of ten up to which digits are written out.
DIGITS = range(-7, 10)


def table(name: str, listing: Listing) -> str:
    r"""A ``listing`` as a table with ``\label{tab:name}``; the same gives the same text."""
    numeric = [all(map(NUMERIC.match, column)) for column in zip(*listing.rows, strict=True)]
    numeric = [False, *numeric[1:]] if numeric else [False] * len(listing.head)
    written = [_number if digits else escaped for digits in numeric]
    rows = [[write(x) for write, x in zip(written, row, strict=True)] for row in listing.rows]
    lines = [
        r"% A table of hfc-design. In the preamble: \usepackage{booktabs}",
        r"\begin{table}",
        r"\centering",
        rf"\caption{{{escaped(listing.caption)}}}",
        rf"\label{{tab:{name}}}",
        rf"\begin{{tabular}}{{{''.join(map(_column, numeric, _longest(listing)))}}}",
        r"\toprule",
        _row([escaped(cell) for cell in listing.head]),
        r"\midrule",
        *map(_row, rows),
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{table}",
    ]
    return "\n".join(lines) + "\n"


def _longest(listing: Listing) -> list[int]:
    """Letters of the longest cell of each column."""
    return [max(map(len, column)) for column in zip(listing.head, *listing.rows, strict=True)]


def _column(digits: bool, longest: int) -> str:
    """Numbers on the right, words on the left, long ones in lines of their own."""
    return "r" if digits else "l" if longest <= LONG else rf"p{{{SHARE}\linewidth}}"


def _row(cells: Sequence[str]) -> str:
    line = " & ".join(cells)
    # Behind a line TeX takes these for an option of its end.
    return ("{}" if line.startswith(("[", "*")) else "") + line + r" \\"


def _number(cell: str) -> str:
    """A cell with its powers of ten written out, or as powers where that would be too long."""
    parts = POWER.split(MINUS.sub("\N{MINUS SIGN}", cell))
    told = [escaped(parts[0])]
    for mantissa, exponent, rest in zip(parts[1::3], parts[2::3], parts[3::3], strict=True):
        if int(exponent) in DIGITS:
            told.append(f"{Decimal(f'{mantissa}e{exponent}'):f}")
        else:
            told.append(rf"{mantissa}$\times 10^{{{int(exponent)}}}$")
        told.append(escaped(rest))
    return "".join(told)
