"""A table of a page for a paper in LaTeX: booktabs, few digits, everything escaped."""

import re
from collections.abc import Sequence
from decimal import Decimal

from hfc_design.pictures.latex import escaped
from hfc_design.pictures.section import Listing
from hfc_design.report import plain_name

#: How a cell of a column of numbers begins; "–" stands where there is none.
NUMERIC = re.compile(r"[<≤]? ?[-+±\u2212]?(\d|\.\d|[–∞]|unstable$|diverged$)|$")
#: A number, and its power of ten.
NUMBER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)(?:e([+-]?\d+))?(?![\w.])")
MINUS = re.compile(r"(?<![\w.)])-(?=[\d.])")
#: A column of words with more letters than that gets this share of the width.
LONG, SHARE = 40, 0.4
#: Digits of a number, unless more stand before the point; a number from there on has a power.
DIGITS, LARGE = 4, 6
#: Powers of ten up to which digits are written out.
PLAIN = range(-3, 4)
#: Letters of 10 points in a column of 88 mm and on a page of 181 mm, and between two columns.
COLUMN, PAGE, GAP = 50, 103, 2.4
#: What of a text in TeX is no letter on paper.
COMMAND = re.compile(r"\\[a-z]+(?:\{\})?|[{}$^]")


#: The unit that a head ends with, and a power in it.
UNIT = re.compile(r"\[(1/)?[A-Za-zµΩ][A-Za-zµΩ 23/().]*\]$")
POWER = re.compile(r"(?<=[A-Za-zµΩ])[23](?![\w.])")


def table(name: str, listing: Listing, of: str = "", label: str = "") -> str:
    r"""A ``listing`` of a page about ``of`` as a table with ``\label{tab:label-name}``.

    Cells that are the best are bold, and a comment says where a table is wider than a column. The
    same gives the same text.
    """
    numeric = [all(map(NUMERIC.match, column)) for column in zip(*listing.rows, strict=True)]
    numeric = [False, *numeric[1:]] if numeric else [False] * len(listing.head)
    told_in = [
        (lambda x: escaped(_powers(x))) if cell == "unit" else _words for cell in listing.head
    ]
    written = [_number if digits else words for digits, words in zip(numeric, told_in, strict=True)]
    rows = [[write(x) for write, x in zip(written, row, strict=True)] for row in listing.rows]
    for row, best in zip(rows, listing.best, strict=False):
        for k in best:
            row[k] = rf"\textbf{{{row[k]}}}"
    head = [_words(cell) for cell in listing.head]
    # Numbers on the right, words on the left, long ones in lines of their own.
    wide = (x > LONG for x in _longest([listing.head, *listing.rows]))
    in_lines = rf"p{{{SHARE}\linewidth}}"
    columns = ["r" if x else in_lines if y else "l" for x, y in zip(numeric, wide, strict=True)]
    lines = [
        r"% A table of hfc-design. In the preamble: \usepackage{booktabs}",
        *_room([head, *rows], columns),
        r"\begin{table}",
        r"\centering",
        rf"\caption{{{escaped(': '.join(filter(None, [of, listing.caption])))}}}",
        rf"\label{{tab:{'-'.join([*([plain_name(label)] if label else []), name])}}}",
        rf"\begin{{tabular}}{{{''.join(columns)}}}",
        r"\toprule",
        _row(head),
        r"\midrule",
        *map(_row, rows),
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{table}",
    ]
    return "\n".join(lines) + "\n"


def _longest(rows: Sequence[Sequence[str]]) -> list[int]:
    """Letters of the longest cell of each column."""
    return [max(map(len, column)) for column in zip(*rows, strict=True)]


def _room(rows: Sequence[Sequence[str]], columns: Sequence[str]) -> list[str]:
    """What a comment says of a table that is wider than a column."""
    printed = _longest([[COMMAND.sub("", cell) for cell in row] for row in rows])
    own = [min(x, SHARE * COLUMN) if "p" in c else x for x, c in zip(printed, columns, strict=True)]
    letters = round(sum(own) + GAP * (len(own) - 1))
    if letters <= COLUMN:
        return []
    told = f"% About {letters} letters wide, a column of 88 mm has {COLUMN}: write table* for table"
    return [told + ("," if letters > PAGE else ".")] + [
        f"% and leave columns out or turn it: a page of 181 mm has {PAGE}."
    ] * (letters > PAGE)


def _row(cells: Sequence[str]) -> str:
    line = " & ".join(cells)
    # Behind a line TeX takes these for an option of its end.
    return ("{}" if line.startswith(("[", "*")) else "") + line + r" \\"


def _words(cell: str) -> str:
    """Words, behind which a unit in brackets has its powers above the line."""
    return escaped(UNIT.sub(lambda unit: _powers(unit[0]), cell))


def _powers(unit: str) -> str:
    return POWER.sub(lambda x: {"2": "²", "3": "³"}[x[0]], unit)


def _number(cell: str) -> str:
    """A cell whose numbers have few digits, very large and small ones a power of ten."""
    parts = NUMBER.split(MINUS.sub("\N{MINUS SIGN}", cell))
    told = [escaped(parts[0])]
    for mantissa, exponent, rest in zip(parts[1::3], parts[2::3], parts[3::3], strict=True):
        told += [_digits(mantissa, exponent), escaped(rest)]
    return "".join(told)


def _digits(mantissa: str, exponent: str | None) -> str:
    """A number without a sign; what has neither a point nor a power is a count and stays."""
    value = Decimal(f"{mantissa}e{exponent or 0}")
    if exponent is None and "." not in mantissa:
        return mantissa
    if not value:
        return "0"
    power = value.adjusted()
    if power >= LARGE if exponent is None else power not in PLAIN:
        return rf"{value.scaleb(-power):.{DIGITS}g}$\times10^{{{power}}}$"
    if len(value.as_tuple().digits) <= DIGITS:
        return f"{value:f}"
    return f"{round(value, max(DIGITS - 1 - power, 0)):f}"
