"""A small reader of LaTeX tables, which knows nothing of how they were written."""

import re

#: What a command prints, as far as tables use any; another one is a mistake.
PRINTS = {
    "textbackslash": "\\",
    "textasciicircum": "^",
    "textasciitilde": "~",
    "textasciigrave": "`",
    "textless": "<",
    "textgreater": ">",
    "textbar": "|",
    "textmu": "µ",
    "textdegree": "°",
    "textbf": "",
    "ldots": "…",
    "pm": "±",
    "times": "×",
    "infty": "∞",
    "leq": "≤",
    "lambda": "λ",
    "varphi": "φ",
    "gamma": "γ",
    "Omega": "Ω",
}
#: What two of a letter side by side print.
PAIRS = {"-": "–", "'": '"', ",": "„", "`": "“"}
TOKEN = re.compile(r"\\[A-Za-z]+|\\.|.", re.DOTALL)


def tokens(text):
    """Commands and letters, without comments."""
    return TOKEN.findall(re.sub(r"(?<!\\)%.*", "", text))


def depth(text):
    """(lowest, last) depth of braces; (0, 0) where they are balanced."""
    now = lowest = 0
    for token in tokens(text):
        now += {"{": 1, "}": -1}.get(token, 0)
        lowest = min(lowest, now)
    return lowest, now


def rows(table):
    """The cells of every row of a file with one table, the head first, as a reader sees them."""
    assert depth(table) == (0, 0)
    body = re.search(r"\\begin\{tabular\}(\{.*?\})\n(.*)\\end\{tabular\}", table, re.DOTALL)[2]
    found, row, cell = [], [], ""
    for token in tokens(body):
        if token in ("&", r"\\"):
            row.append(printed(cell))
            cell = ""
            if token == r"\\":
                found.append(row)
                row = []
        elif token not in (r"\toprule", r"\midrule", r"\bottomrule"):
            cell += token
    assert not row
    assert not cell.strip()
    return found


def printed(text):
    """What a text in LaTeX looks like."""
    shown, formula, last = "", False, ""
    for token in tokens(text):
        formula ^= token == "$"
        if token[0] == "\\" and len(token) > 1:
            name = token[1:]
            shown += PRINTS[name] if name[0].isalpha() else name
        elif not formula and token == last and token in PAIRS:
            shown = shown[:-1] + PAIRS[token]
        elif token not in "{}$":
            shown += "\N{MINUS SIGN}" if formula and token == "-" else token
        last = token
    return shown.strip()
