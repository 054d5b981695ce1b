"""Plug-ins: plants, fitnesses, strategies and laws that users add without changing the package.

A file names one by a plain name. It is looked up among the built-in ones, those that the program
has added, and the entry points of installed packages. Modules are named only on the command line
and in scripts, so that a file never causes an import. Never imports JAX.
"""

import importlib
import pkgutil
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha256
from importlib import metadata
from os.path import isfile
from pathlib import Path
from types import ModuleType
from typing import Any, Generic, TypeVar, get_type_hints

from pydantic import (
    AfterValidator,
    ConfigDict,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    create_model,
)

from hfc_design.core.arguments import a_kind
from hfc_design.core.numbers import Json
from hfc_design.core.overrides import flat
from hfc_design.core.records import NAME, UserError, checked, either, option
from hfc_design.core.user_code_errors import describe
from hfc_design.core.validation_errors import short
from hfc_design.core.wording import alternatives, near, one_of

Thing = TypeVar("Thing")
#: Of several groups: ``Group.what`` and the name or ``module:OBJECT`` of each plug-in.
References = list[tuple[str, str]]
#: ``module:OBJECT``, as ``--use`` takes it.
REFERENCE = re.compile(r"\w[\w.-]*:\w[\w.]*")
ANY_CLASS = ConfigDict(arbitrary_types_allowed=True)
#: What makes a part of one's own known.
LOAD = either("--use module:OBJECT", "hfc.register(module.OBJECT) or runtime.use")
#: Every group, by the option that names one of it, without its dashes.
GROUPS: "dict[str, Group[Any]]" = {}


@dataclass(frozen=True)
class Group(Generic[Thing]):
    """Plug-ins of one kind, by their names."""

    what: str  # as in --plant
    kind: tuple[type[Any], ...]  # any of which has a ``name``; in ``classes`` it is one itself
    entry_points: str  # the group of them
    known: dict[str, Thing]  # built in, or added since
    fault: Callable[[Thing], str | None] = lambda thing: None  # what is wrong with one, in a line
    adopt: Callable[[Any], Any] = lambda thing: thing  # what makes one of something simpler
    classes: tuple[type[Any], ...] = ()
    built_in: frozenset[str] = field(init=False)  # known at first: names that nobody may take
    given: dict[str, str] = field(default_factory=dict)  # name -> module:OBJECT that was resolved
    modules: dict[str, str] = field(default_factory=dict)  # name -> module of an added one's code

    def __post_init__(self) -> None:
        object.__setattr__(self, "built_in", frozenset(self.known))
        GROUPS[self.what] = self

    def add(self, thing: Any) -> Thing:
        """Register ``thing``; one of the same name that was added earlier is replaced.

        Raises:
            UserError: it is not of this kind, cannot work, or has a name that is taken.
        """
        if not self.takes(thing):
            wanted = alternatives(kind.__name__ for kind in (*self.kind, *self.classes))
            raise UserError(f"must be a {wanted} (got {a_kind(thing)})")
        name = str(thing.name)
        if not re.fullmatch(NAME, name):
            raise UserError(
                f"{self.what} {name!r}: name must have only letters, digits, '.', '_' and '-'"
            )
        if name in self.built_in and self.known.get(name) is not thing:
            raise UserError(f"{self.what} {name!r} is built in; choose another name")
        with own_code("", (self.what, name)):
            _check_fields(thing, f"{self.what} {name!r}")
            self.modules[name] = _module(thing)
            thing = self.adopt(thing)
            fault = self.fault(thing)
        if fault:
            raise UserError(f"{self.what} {name!r}: {fault}")
        self.known[name] = thing
        return thing

    def takes(self, thing: Any) -> bool:
        """Whether ``thing`` is of this kind."""
        is_subclass = isinstance(thing, type) and issubclass(thing, self.classes)
        return is_subclass or isinstance(thing, self.kind)

    def get(self, name: str) -> Thing:
        """Return the plug-in with a name, from an installed package if necessary.

        Raises:
            UserError: no plug-in has that name, or that of a package cannot be used.
        """
        if name in self.known:
            return self.known[name]
        entries = tuple(metadata.entry_points(group=self.entry_points, name=name))
        if not entries:
            raise UserError(
                f"{short(name)}: unknown {self.what}; {one_of(name, self.names())}; load "
                f"your own with {LOAD}"
            )
        if len(entries) > 1:
            packages = ", ".join(
                entry.dist.name if entry.dist else entry.value for entry in entries
            )
            rule = f"must be of one package (got {packages}); uninstall the others"
            raise UserError(f"{self.what} {name!r}: {rule}")
        thing = self._imported(entries[0].value, f"entry point {name} = {entries[0].value}")
        if (declared := getattr(thing, "name", None)) != name:
            raise UserError(
                f"entry point {name} = {entries[0].value}: name must be that of the entry "
                f"point (got {declared!r})"
            )
        return thing

    def named(self, key: str, name: str) -> Thing:
        """Plug-in with the name that a file has under ``key``; ValueError: ``get`` refuses it.

        ``key`` is "" if the message names it elsewhere.
        """
        try:
            return self.get(name)
        except UserError as error:
            why = error.message.removeprefix(f"{short(name)}: ")
            raise ValueError(f"{key} = {short(name)}: {why}" if key else why) from None

    def source(self, name: str) -> str | None:
        """Origin of a user's own plug-in, as ``module:OBJECT``; None if it is not known."""
        entries = metadata.entry_points(group=self.entry_points, name=name)
        return self.given.get(name) or next((entry.value for entry in entries), None)

    def resolve(self, text: str) -> Thing:
        """Plug-in from a text of the command line: a name, or ``module:OBJECT``.

        A module may lie in the current folder; installed ones come first.

        Raises:
            UserError: there is no such thing, or it cannot be used.
        """
        if ":" not in text:
            if text not in self.names() and (meant := _module_meant(text)):
                raise UserError(f"{option(self.what, text)}: unknown {self.what}; {meant}")
            return self.get(text)
        thing = self._imported(text, option(self.what, text))
        self.given[str(getattr(thing, "name", ""))] = text
        return thing

    def names(self) -> list[str]:
        """Every name that ``get`` accepts, built-in ones first."""
        installed = metadata.entry_points(group=self.entry_points).names
        reserved = sorted(self.built_in - self.known.keys())
        return list(dict.fromkeys([*self.known, *reserved, *sorted(installed)]))

    def _imported(self, reference: str, source: str) -> Thing:
        try:
            return self.add(_found_at(reference))
        except UserError as error:
            raise error.within(source) from error


def use(text: str) -> None:
    """Register the object ``module:OBJECT``; UserError: there is none, or no group takes it."""
    try:
        group = group_of(_found_at(text))
    except UserError as error:
        raise error.within(f"--use {text}") from error
    group.resolve(text)


def group_of(thing: Any) -> Group[Any]:
    """Group that takes ``thing``; UserError: there is none."""
    for group in GROUPS.values():
        if group.takes(thing):
            return group
    raise UserError(f"argument must be a {alternatives(GROUPS)} (got {short(thing)})")


def given() -> References:
    """Plug-ins named on the command line of this process, never by a file or a package."""
    return [(what, text) for what, group in GROUPS.items() for text in group.given.values()]


def know(references: References) -> None:
    """Register these, and forget those that an earlier call registered.

    Raises:
        UserError: one cannot be imported or used here.
    """
    for group in GROUPS.values():
        for name in group.given:
            group.known.pop(name, None)
        group.given.clear()
    for what, text in references:
        GROUPS[what].resolve(text)


def own_ones(used: Iterable[tuple[str, str]]) -> References:
    """Group and name of each used part that is not built in, once."""
    return [(what, name) for what, name in dict.fromkeys(used) if name not in GROUPS[what].built_in]


def sources(used: Iterable[tuple[str, str]]) -> dict[str, dict[str, str]]:
    """Group -> name -> origin, of used parts that are not built in."""
    by_group: dict[str, dict[str, str]] = {}
    for what, name in own_ones(used):
        if source := GROUPS[what].source(name):
            by_group.setdefault(what, {})[name] = source
    return by_group


def origins(used: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Version of each used part that is not built in, or digest of its module.

    The version is that of the installed distribution that contains it.
    """
    return {f"{what} {name!r}": _origin(GROUPS[what], name) for what, name in own_ones(used)}


def _origin(group: Group[Any], name: str) -> str:
    module = (group.source(name) or group.modules.get(name, "")).partition(":")[0]
    if package := _distributions().get(module.partition(".")[0]):
        return f"{package[0]} {metadata.version(package[0])}"
    file = getattr(sys.modules.get(module), "__file__", None)
    if file and Path(file).is_file():
        return sha256(Path(file).read_bytes()).hexdigest()
    return "unknown"  # typed in, for one


_distributions = cache(metadata.packages_distributions)


def _module(thing: Any) -> str:
    """Module of a user's own part, "" if it has no code but the package's."""
    parts = [thing, *(thing if isinstance(thing, tuple) else vars(thing).values())]
    names = (str(getattr(part, "__module__", None) or "") for part in parts)
    ours = {"", "builtins", "functools", *(__name__.partition(".")[:1]), "plants"}
    return next((name for name in names if name.partition(".")[0] not in ours), "")


@contextmanager
def own_code(
    doing: str, *parts: tuple[str, str], passing: tuple[type[Exception], ...] = ()
) -> Iterator[None]:
    """Turn an error of a user's own code into a UserError, a line: which part, ``doing`` what.

    ``parts`` are group and name of all parts involved; if all are built in, the error stays, as do
    ``passing`` errors.
    """
    try:
        yield
    except Exception as error:
        user_parts = [f"{what} {name!r}" for what, name in own_ones(parts)]
        if not user_parts or isinstance(error, (UserError, *passing)):
            raise
        noted = "".join(f"{x}: " for x in getattr(error, "__notes__", ()) if x.isidentifier())
        raise UserError(f"{alternatives(user_parts)}{doing}: {noted}{describe(error)}") from error


def uses(named: Any, known: bool = True) -> str:
    """`` --use module:OBJECT`` for each of ``sources``, or of those not registered here."""
    groups = named.items() if isinstance(named, dict) else ()
    valid_groups = [
        (what, parts) for what, parts in groups if what in GROUPS and isinstance(parts, dict)
    ]
    return options(
        str(source)
        for what, parts in valid_groups
        for name, source in parts.items()
        if REFERENCE.fullmatch(str(source)) and (known or name not in GROUPS[what].names())
    )


def options(texts: Iterable[str]) -> str:
    """`` --use module:OBJECT`` for each, as a shell reads it."""
    return "".join(f" --use {shlex.quote(text)}" for text in texts)


@AfterValidator
def naming_modules(provenance: Json) -> Json:
    """Validate a provenance: its plug-ins contain only modules and names of objects in them."""
    for key, text in flat({"plugins": provenance.get("plugins", {})}).items():
        if not isinstance(text, str) or not REFERENCE.fullmatch(text):
            raise ValueError(f"{key} = {short(text)}: must be module:OBJECT")
    return provenance


def resuming(folder: Path) -> str:
    """Command that continues a stopped run, with the user's own parts of this process."""
    use_options = options(text for _, text in given())
    return f"continue with: hfc design --resume --out {shlex.quote(str(folder))}{use_options}"


def _check_fields(thing: Any, source: str) -> None:
    """UserError: a field of a NamedTuple or dataclass is not what its annotation says."""
    if isinstance(thing, type):
        return
    hints: Any = {name: (hint, ...) for name, hint in get_type_hints(type(thing)).items()}
    fields = create_model("Fields", __config__=ANY_CLASS, **hints)
    checked(fields, {name: getattr(thing, name) for name in hints}, source, Path())


def chosen(
    group: Group[Any] | Callable[[], Group[Any]], part: str, key: str = "kind", default: str = ""
) -> WrapValidator:
    """Validator of a table of a file, whose ``key`` names an object of ``group``.

    The record in the attribute ``part`` of that object checks the table. ``default`` is the name if
    the key is left out.
    """

    def validated(data: Any, base: ValidatorFunctionWrapHandler, info: ValidationInfo) -> Any:
        if isinstance(data, dict) and default:
            data = {key: default} | data
        if not isinstance(data, dict) or not isinstance(data.get(key), str):
            return base(data)  # a record already, or refused
        known = group if isinstance(group, Group) else group()
        record = getattr(known.named(key, data[key]), part)
        if record is None:
            raise ValueError(f"{key} = {data[key]!r}: has no settings to search")
        return record.model_validate(data, context=info.context)

    return WrapValidator(validated)


def found_in(package: ModuleType, attribute: str, folders: bool = False) -> Json:
    """Objects with one name in the modules and folders of a package, by the names of these.

    A module with several has a tuple of them under the plural. With ``folders`` only those are
    searched, so that nothing else is imported, such as modules that draw.
    """
    inside = pkgutil.iter_modules(package.__path__)
    modules = sorted(module.name for module in inside if module.ispkg or not folders)
    parts = [importlib.import_module(f"{package.__name__}.{name}") for name in modules]
    things = [getattr(part, attribute) for part in parts if hasattr(part, attribute)]
    things += [thing for part in parts for thing in getattr(part, f"{attribute}S", ())]
    return {thing.name: thing for thing in things}


def _module_meant(text: str) -> str:
    """Suggested ``module:OBJECT`` for mine.py:AXIS, mine.AXIS or mine.py; "": none."""
    start, colon, name = text.partition(":")
    path = Path(start)
    if path.suffix == ".py":
        return f"did you mean {path.stem}:{name or 'OBJECT'}?"
    module, dot, last = start.rpartition(".")
    if not colon and dot and isfile(f"{module.replace('.', '/')}.py"):
        return f"did you mean {module}:{last}?"
    return ""


def _found_at(reference: str) -> Any:
    """Object that ``module:OBJECT`` names."""
    module, _, name = reference.partition(":")
    meant = _module_meant(reference)
    if not module or not name or not (meant or REFERENCE.fullmatch(reference)):
        raise UserError("must be module:OBJECT")
    if meant:
        raise UserError(f"must be a module's import name, without folder and .py; {meant}")
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.append(here)
    try:
        target = importlib.import_module(module)
    except Exception as error:  # whatever the user's code raises
        raise UserError(f"module {module} cannot be imported: {describe(error)}") from error
    for part in name.split("."):
        if not hasattr(target, part):
            known = [x for x in vars(target) if not x.startswith("_")]
            meant = "".join(f"; did you mean {module}:{x}?" for x in near(name, known))
            raise UserError(f"{module} has no {name}{meant}")
        target = getattr(target, part)
    return target
