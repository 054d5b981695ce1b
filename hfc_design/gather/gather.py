"""Everything that a user can name, gathered from the code.

Imports all of the package, and with it JAX; whoever only reads has ``reference.entries``.
"""

from collections.abc import Callable, Iterator
from typing import Any

from pydantic import BaseModel

from hfc_design.controllers.kinds import KINDS
from hfc_design.core.plugins import Group
from hfc_design.core.texts import read_toml
from hfc_design.files.design import Design, builtin_designs, named_design
from hfc_design.files.machine import ALL_PLANTS
from hfc_design.files.motions import AnyReference
from hfc_design.files.named_scenario import BUILTIN, builtin_names
from hfc_design.files.scenario import DEFAULT_KIND, Scenario
from hfc_design.formats import FORMATS
from hfc_design.gather.fields import fields_of, plain, records_in
from hfc_design.gather.machines import plant_entries
from hfc_design.gather.named import (
    kind_entries,
    metric_entry,
    objective_entries,
    reference_entries,
    strategy_entries,
)
from hfc_design.motion.references import Load
from hfc_design.objectives.judge import OBJECTIVES
from hfc_design.objectives.measures import MEASURES, band_time
from hfc_design.reference.entries import (
    CONTROLLER,
    DESIGN,
    DESIGN_KEY,
    FORMAT,
    KEY,
    OBJECTIVE,
    PLANT,
    SCENARIO,
    STRATEGY,
    Entry,
)
from hfc_design.search.loop import STRATEGIES

#: Plug-ins by the kind of their entries, and what makes these of one.
PLUGINS: dict[str, tuple[Group[Any], Callable[[Any], Iterator[Entry]]]] = {
    PLANT: (ALL_PLANTS, plant_entries),
    CONTROLLER: (KINDS, kind_entries),
    STRATEGY: (STRATEGIES, strategy_entries),
    OBJECTIVE: (OBJECTIVES, objective_entries),
}
#: Tables with the keys of [load].
AS_LOAD = "motions.N.load.", "load.axes.AXIS."
#: Tables of a scenario whose keys are those of what they name: the key that names it, its default.
CHOSEN = {
    "reference": ("kind", "ramp"),
    "fitness": ("kind", "lin-lee"),
    "controller": ("kind", DEFAULT_KIND),
    "search": ("preset", "race"),
}


def gather() -> list[Entry]:
    """Every entry of what is built in."""
    references = records_in(AnyReference)
    found = [*_keys(references), *fields_of(Design, "", Entry(DESIGN_KEY, ""))]
    for group, entries_of in PLUGINS.values():
        for name in group.names():
            if name in group.built_in:
                found += entries_of(group.get(name))
    for record in references:
        found += reference_entries(record, (*references, Load))
    found += map(metric_entry, (*MEASURES.values(), band_time(0.0)))
    found += [Entry(FORMAT, one.name, meaning=one.text) for one in FORMATS.values()]
    for name in builtin_names():
        found.append(
            Entry(
                SCENARIO, name, meaning=read_toml(BUILTIN / f"{name}.toml").get("description", "")
            )
        )
    for name in builtin_designs():
        told = str(named_design(name).provenance["source"])
        found.append(Entry(DESIGN, name, meaning=told))
    return [one._replace(name=one.name or one.key) for one in found]


def live(kind: str, name: str) -> list[Entry]:
    """The entries of one plug-in, an own one too: a name that is known, or ``module:OBJECT``.

    Raises:
        UserError: there is none.
    """
    group, entries_of = PLUGINS[kind]
    return [*entries_of(group.resolve(name))]


def _keys(references: list[type[BaseModel]]) -> Iterator[Entry]:
    """The keys of every scenario."""
    for one in fields_of(Scenario, "", Entry(KEY, ""), tuple(references)):
        table, _, rest = one.key.partition(".")
        if one.key.startswith(AS_LOAD):
            continue
        if table not in CHOSEN:
            yield one._replace(required=one.required and one.key != "name")  # a file has a name
        elif not rest:
            yield one
            yield _choice(table, references)


def _choice(table: str, references: list[type[BaseModel]]) -> Entry:
    """The key of a table that names what its other keys belong to."""
    key, default = CHOSEN[table]
    groups: dict[str, Group[Any]] = {
        "fitness": OBJECTIVES,
        "controller": KINDS,
        "search": STRATEGIES,
    }
    names = [plain(one.model_fields["kind"].default) for one in references]
    if table in groups:
        group = groups[table]
        names = [name for name in group.names() if name in group.built_in]
    return Entry(
        KEY, "", "", f"{table}.{key}", "text", "", default, False, ", ".join(names), "which one"
    )
