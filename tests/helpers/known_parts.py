"""Own parts that tests make known, and forget."""

from hfc_design.core.plugins import GROUPS


def made_known():
    """What is known now, for ``forget``."""
    tables = (found for group in GROUPS.values() for found in (group.known, group.given))
    return [(found, dict(found)) for found in tables]


def forget(groups):
    """Know what was known then."""
    for known, before in groups:
        known.clear()
        known.update(before)
