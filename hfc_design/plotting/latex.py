"""Texts and tables for LaTeX, with all commands escaped."""

import re
from collections.abc import Sequence
from decimal import Decimal

from hfc_design.core.records import harmless
from hfc_design.core.tables import Table

_NAMES = (
    "alpha beta gamma delta varepsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau "
    "upsilon varphi chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi Omega"
)
GREEK = dict(zip("αβγδεζηθικλμνξπρστυφχψωΓΔΘΛΞΠΣΦΨΩ", _NAMES.split(), strict=True))
#: Replacements of letters that have a meaning in TeX, or that its fonts may lack.
LETTERS = {
    "\\": r"\textbackslash{}",
    **{letter: "\\" + letter for letter in "{}$&#%_"},
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "`": r"\textasciigrave{}",
    "'": r"{'}",  # two of them would be one quotation mark
    '"': "''",
    "\N{MINUS SIGN}": "$-$",
    "\N{EN DASH}": "--",
    "\N{EM DASH}": "---",
    "\N{HYPHEN}": "-",
    "\N{NO-BREAK SPACE}": "~",
    "\N{RIGHT SINGLE QUOTATION MARK}": "'",
    "\N{HORIZONTAL ELLIPSIS}": r"\ldots{}",
    "\N{MICRO SIGN}": r"\textmu{}",
    "\N{DEGREE SIGN}": r"\textdegree{}",
    "\N{SUPERSCRIPT TWO}": "$^2$",
    "\N{SUPERSCRIPT THREE}": "$^3$",
    "\N{PLUS-MINUS SIGN}": r"$\pm$",
    "\N{MULTIPLICATION SIGN}": r"$\times$",
    "\N{MIDDLE DOT}": r"$\cdot$",
    "\N{SQUARE ROOT}": r"$\surd$",
    "\N{INFINITY}": r"$\infty$",
    "\N{LESS-THAN OR EQUAL TO}": r"$\leq$",
    "\N{GREATER-THAN OR EQUAL TO}": r"$\geq$",
    "\N{RIGHTWARDS ARROW}": r"$\rightarrow$",
    **{letter: rf"$\{name}$" for letter, name in GREEK.items()},
}
#: Subscript digits, which follow a letter.
BELOW = {0x2080 + digit: str(digit) for digit in range(10)}
#: TeX would merge two consecutive dashes or commas into another sign.
_SPECIAL = re.compile("|".join([*map(re.escape, LETTERS), "[₀-₉]+", "-(?=-)", ",(?=,)"]))
#: A number, and its power of ten.
NUMBER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)(?:e([+-]?\d+))?(?![\w.])")
MINUS = re.compile(r"(?<![\w.)])-(?=[\d.])")
#: Letters above which a column of words is wide, and its share of the width.
LONG, SHARE = 40, 0.4
#: Digits of a number, unless it has more before the point; digits from which it has a power of ten.
DIGITS, LARGE = 4, 6
#: Powers of ten up to which digits are written out.
PLAIN = range(-3, 4)
#: Letters (of 10 points) that fit a column of 88 mm and a page of 181 mm; gap between columns.
COLUMN, PAGE, GAP = 50, 103, 2.4
#: Parts of a text in TeX that are not letters on paper.
COMMAND = re.compile(r"\\[a-z]+(?:\{\})?|[{}$^]")
#: The unit at the end of a head, and a power in it.
UNIT = re.compile(r"\[(1/)?[A-Za-zµΩ][A-Za-zµΩ 23/().]*\]$")
POWER = re.compile(r"(?<=[A-Za-zµΩ])[23](?![\w.])")


def escaped(text: str) -> str:
    """Return a text that LaTeX prints literally.

    Letters beyond Latin are kept: LuaLaTeX and XeLaTeX print those that the font has.
    """
    plain = harmless(re.sub(r"\s+", " ", text))
    return _SPECIAL.sub(lambda match: LETTERS.get(match[0]) or _other(match[0]), plain)


def _other(letters: str) -> str:
    """Return subscript digits, or a letter that must not join with the next one."""
    below = letters.translate(BELOW)
    return f"{letters}{{}}" if below == letters else f"$_{{{below}}}$"


def latex(name: str, table: Table, of: str = "", label: str = "") -> str:
    r"""Return a ``table`` of a page about ``of`` in LaTeX, with ``\label{tab:label-name}``.

    Numbers are aligned right, words left; long texts are wrapped and the best cells bold. A comment
    says if the table is wider than a column.
    """
    kinds, columns = [], []
    for numeric, head, *cells in zip(table.numeric, table.head, *table.rows, strict=True):
        if numeric:
            write, kind = _number, "r"
        else:
            write = _unit if head == "unit" else _words
            kind = rf"p{{{SHARE}\linewidth}}" if max(map(len, [head, *cells])) > LONG else "l"
        kinds.append(kind)
        columns.append([_words(head), *map(write, cells)])
    head, *rows = ([*row] for row in zip(*columns, strict=True))
    comment = _width(columns, kinds)
    for row, best in zip(rows, table.best, strict=False):
        for k in best:
            row[k] = rf"\textbf{{{row[k]}}}"
    lines = [
        r"% A table of hfc-design. In the preamble: \usepackage{booktabs}",
        *comment,
        r"\begin{table}",
        r"\centering",
        rf"\caption{{{escaped(': '.join(filter(None, [of, table.caption + table.key])))}}}",
        rf"\label{{tab:{'-'.join(filter(None, [label, name]))}}}",
        rf"\begin{{tabular}}{{{''.join(kinds)}}}",
        r"\toprule",
        _row(head),
        r"\midrule",
        *map(_row, rows),
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{table}",
    ]
    return "\n".join(lines) + "\n"


def _width(columns: Sequence[Sequence[str]], kinds: Sequence[str]) -> list[str]:
    """Return a comment on a table that is wider than a column; no lines on others."""
    sizes: list[float] = []
    for cells, kind in zip(columns, kinds, strict=True):
        longest = max(len(COMMAND.sub("", cell)) for cell in cells)
        sizes.append(min(longest, SHARE * COLUMN) if "p" in kind else longest)
    letters = round(sum(sizes) + GAP * (len(sizes) - 1))
    if letters <= COLUMN:
        return []
    wide = f"% About {letters} letters wide, a column of 88 mm has {COLUMN}: write table* for table"
    if letters <= PAGE:
        return [f"{wide}."]
    return [f"{wide},", f"% and leave columns out or turn it: a page of 181 mm has {PAGE}."]


def _row(cells: Sequence[str]) -> str:
    line = " & ".join(cells)
    # After the end of the previous line, TeX would take these for an option of that end.
    return ("{}" if line.startswith(("[", "*")) else "") + line + r" \\"


def _words(cell: str) -> str:
    """Return escaped words; a unit in brackets at their end gets superscript powers."""
    return escaped(UNIT.sub(lambda unit: _powers(unit[0]), cell))


def _unit(cell: str) -> str:
    return escaped(_powers(cell))


def _powers(unit: str) -> str:
    return POWER.sub(lambda x: {"2": "²", "3": "³"}[x[0]], unit)


def _number(cell: str) -> str:
    """Return a cell with shortened numbers, very large and small ones with a power of ten."""
    parts = NUMBER.split(MINUS.sub("\N{MINUS SIGN}", cell))
    texts = [escaped(parts[0])]
    for mantissa, exponent, rest in zip(parts[1::3], parts[2::3], parts[3::3], strict=True):
        texts += [_digits(mantissa, exponent), escaped(rest)]
    return "".join(texts)


def _digits(mantissa: str, exponent: str | None) -> str:
    """Return a shortened number without a sign; a number without point and power is kept."""
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
