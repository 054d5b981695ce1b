"""Texts for LaTeX; nothing in them is a command."""

import re

from hfc_design.core.records import harmless

_NAMES = (
    "alpha beta gamma delta varepsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau "
    "upsilon varphi chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi Omega"
)
GREEK = dict(zip("αβγδεζηθικλμνξπρστυφχψωΓΔΘΛΞΠΣΦΨΩ", _NAMES.split(), strict=True))
#: What stands for a letter that means something to TeX, or that its fonts may not have.
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
#: Digits below the line, in what follows a letter as one.
BELOW = {0x2080 + digit: str(digit) for digit in range(10)}
#: Of two dashes or commas in a row TeX would make another sign.
_SPECIAL = re.compile("|".join([*map(re.escape, LETTERS), "[₀-₉]+", "-(?=-)", ",(?=,)"]))


def escaped(text: str) -> str:
    """A text that LaTeX prints as it is.

    Letters beyond Latin are left as they are: LuaLaTeX and XeLaTeX print those that the font has.
    """
    plain = harmless(re.sub(r"\s+", " ", text))
    return _SPECIAL.sub(lambda found: LETTERS.get(found[0]) or _other(found[0]), plain)


def _other(letters: str) -> str:
    """Digits below the line, or a letter that is not to join with the next."""
    below = letters.translate(BELOW)
    return f"{letters}{{}}" if below == letters else f"$_{{{below}}}$"
