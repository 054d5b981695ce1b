"""Gains of a rule table, which the stable range bounds."""

from hfc_design.controllers.flc.record import FuzzyRecord
from hfc_design.stability.sectors import Triangle, sectors_at_centres, true_sectors


def points(record: FuzzyRecord) -> dict[str, tuple[float, float]]:
    """(K_1, K_2) of the rule table [unit/BLU], by how they were found."""
    error, change = (
        [Triangle(term.left, term.centre, term.right) for term in terms]
        for terms in (record.error_terms, record.error_change_terms)
    )
    table = record.rules.centroids
    at_centres = sectors_at_centres(
        [term.centre for term in error], [term.centre for term in change], table
    )
    with_edges = true_sectors(error, change, table)
    found = {
        "table, eq. 13 and 14": (at_centres.k1, at_centres.k2),
        "table, with its edges": (with_edges.k1, with_edges.k2),
    }
    return found | record.adaptation_limit()
