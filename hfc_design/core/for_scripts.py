"""Error lines for Python scripts, with arguments in place of command-line options.

Messages are written once, in the words of the command line. Never imports JAX.
"""

import re

#: Options of an argument of the same name, except for their dashes.
SAME = (
    *("axis", "bandwidth", "check-log", "controller", "free", "gain", "hidden", "kind", "like"),
    *("machines", "name", "nearest", "output", "passes", "plant", "point"),
    *("sample-time", "samples"),
    *("scenario", "seed", "spread", "start", "terms", "time-constant", "to", "unit", "workers"),
)
#: Option -> argument, of the others that a function of ``hfc_design.api`` has.
ARGUMENTS = {
    **{option: option.replace("-", "_") for option in SAME},
    **{"set": "changes", "change": "changes", "at": "sample", "tolerance": "tolerances"},
    **{"column": "columns", "check-column": "check_columns", "signal": "signals"},
    **{"out": "folder", "training-rate": "rate", "network": "network", "motion": "name"},
}
#: What a script gives in the place of an option that takes no value.
FLAGS = {"anyway": "anyway=True", "bare": "bare=True", "each": "each=True"}
FLAGS |= {"open-loop": "bandwidth=0"}
#: Options of which a script gives all at once, as a list or a mapping.
SEVERAL = {"at", "change", "check-column", "column", "free"}
SEVERAL |= {"nearest", "network", "set", "signal", "tolerance"}
#: Whole phrases, before any option: the variable is all that a script has for --memory.
PHRASES = {
    r"--memory or (?=HFC_MEMORY)": "",
    r"--memory\b": "HFC_MEMORY",
    r"--use module:OBJECT\b": "hfc.register(module.OBJECT)",
}
#: A whole command, which is typed into a shell as it is; an option at the head of a message with
#: its value; one anywhere else.
_OPTIONS = re.compile(
    r"(?P<command>\bhfc [a-z]+ [^;,)]*)"
    r"|(?P<head>^|: )--(?P<first>[a-z][a-z-]*)(?: (?P<value>(?!and |needs )(?:(?!: ).)+))?(?=: )"
    r"|(?<![\w-])--(?P<option>[a-z][a-z-]*)"
    r"(?: (?P<its>(?<=--to )\w+|[\w.]+=[^\s;,)]+|[\d.]\S*|[A-Z]\w*|'[^']*'))?"
)


def for_scripts(line: str) -> str:
    """Translate ``--samples 0: must`` to ``samples=0: must``; a whole ``hfc`` command stays.

    An option that no function has as an argument stays too.
    """
    for phrase, instead in PHRASES.items():
        line = re.sub(phrase, instead, line)
    return _OPTIONS.sub(_argument, line)


def _argument(match: re.Match[str]) -> str:
    option = match["first"] or match["option"]
    head, value = match["head"] or "", match["value"] or match["its"]
    if match["command"] or option not in {*ARGUMENTS, *FLAGS}:
        return match[0]
    if option in FLAGS:
        return f"{head}{FLAGS[option]}" + (f" {value}" if value else "")
    name = ARGUMENTS[option]
    if value is None:
        return f"{head}{name}" if match["first"] else f"{name}="
    if option not in SEVERAL:
        return f"{head}{name}={_text(value)}"
    key, equals, inside = value.partition("=")
    if not equals or "=" in inside:
        return f"{head}{name}: {value}"
    return f"{head}{name}={{{key!r}: {_text(inside)}}}"


def _text(value: str) -> str:
    """A value as Python has it; what stands for one, as NAME, stays."""
    plain = re.fullmatch(
        r"[-+]?[\d.]+(e[-+]?\d+)?|[-+]?inf|nan|True|False|None|[A-Z]+|['\"\[{(].*", value
    )
    return value if plain else repr(value)
