"""The terminal: text is shown as it is, since brackets hold units and are no markup."""

from rich.console import Console
from rich.progress import TextColumn


def terminal(stderr: bool = False) -> Console:
    """Standard output, or standard error."""
    return Console(stderr=stderr, markup=False, emoji=False)


def column(text: str) -> TextColumn:
    """A column of a bar of progress, a format of its task."""
    return TextColumn(text, markup=False)
