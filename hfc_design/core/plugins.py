"""Plug-ins: plants, fitnesses, strategies and laws that users add without changing the package.

A file refers to a plug-in by a plain name. The name is looked up among the built-in parts, those
that this process has added, and the entry points of installed packages. Only the command line and
scripts name modules, so that no file can cause the import of any module. Never imports JAX.
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
#: Pairs for several plug-ins: ``Group.what`` of its group, and its name or ``module:OBJECT``.
References = list[tuple[str, str]]
#: ``module:OBJECT``, as ``--use`` takes it.
REFERENCE = re.compile(r"\w[\w.-]*:\w[\w.]*")
ANY_CLASS = ConfigDict(arbitrary_types_allowed=True)
#: How a user makes an own part known, for messages.
LOAD = either("--use module:OBJECT", "hfc.register(module.OBJECT) or runtime.use")
#: ``Group.what`` -> group, for every group.
GROUPS: "dict[str, Group[Any]]" = {}


@dataclass(frozen=True)
class Group(Generic[Thing]):
    """Plug-ins of one kind, by their names."""

    what: str  # the kind as messages and options name it: "plant", as in --plant
    kind: tuple[type[Any], ...]  # classes: an instance of one, with a ``name``, is a plug-in
    entry_points: str  # name of the group of entry points of installed packages
    known: dict[str, Thing]  # name -> plug-in that is built in, or was added since
    fault: Callable[[Thing], str | None] = lambda thing: None  # line on what is wrong with one
    adopt: Callable[[Any], Any] = lambda thing: thing  # makes a plug-in of a simpler object
    classes: tuple[type[Any], ...] = ()  # a subclass of one of these is a plug-in too
    built_in: frozenset[str] = field(init=False)  # names of built-in parts, which nobody may take
    given: dict[str, str] = field(default_factory=dict)  # name -> module:OBJECT it was loaded from
    modules: dict[str, str] = field(default_factory=dict)  # name -> module of an added part's code

    def __post_init__(self) -> None:
        object.__setattr__(self, "built_in", frozenset(self.known))
        GROUPS[self.what] = self

    def add(self, thing: Any) -> Thing:
        """Register and return a plug-in; it replaces one with the same name that was added earlier.

        Raises:
            UserError: it is not of this kind, has a fault, or has the name of a built-in part.
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
        """Return whether ``thing`` is an instance of ``kind`` or a subclass of ``classes``."""
        is_subclass = isinstance(thing, type) and issubclass(thing, self.classes)
        return is_subclass or isinstance(thing, self.kind)

    def get(self, name: str) -> Thing:
        """Return the plug-in with a name, from an installed package if necessary.

        Raises:
            UserError: no plug-in has that name, several packages have one, or it cannot be used.
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
        """Return the plug-in that a file names under ``key``; ValueError: ``get`` refuses the name.

        ``key`` is "" if the caller adds the key to the message.
        """
        try:
            return self.get(name)
        except UserError as error:
            why = error.message.removeprefix(f"{short(name)}: ")
            raise ValueError(f"{key} = {short(name)}: {why}" if key else why) from None

    def source(self, name: str) -> str | None:
        """Return the origin of a user's plug-in, as ``module:OBJECT``; None if it is not known."""
        entries = metadata.entry_points(group=self.entry_points, name=name)
        return self.given.get(name) or next((entry.value for entry in entries), None)

    def resolve(self, text: str) -> Thing:
        """Return the plug-in for a text of the command line: a name, or ``module:OBJECT``.

        A module is searched among the installed modules first, then in the current folder.

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
        """Return every name that ``get`` accepts; names of installed packages come last."""
        installed = metadata.entry_points(group=self.entry_points).names
        reserved = sorted(self.built_in - self.known.keys())
        return list(dict.fromkeys([*self.known, *reserved, *sorted(installed)]))

    def _imported(self, reference: str, source: str) -> Thing:
        try:
            return self.add(_found_at(reference))
        except UserError as error:
            raise error.within(source) from error


def use(text: str) -> None:
    """Register the object ``module:OBJECT``; UserError: it does not exist, or no group takes it."""
    try:
        group = group_of(_found_at(text))
    except UserError as error:
        raise error.within(f"--use {text}") from error
    group.resolve(text)


def group_of(thing: Any) -> Group[Any]:
    """Return the group that takes ``thing``; UserError: there is none."""
    for group in GROUPS.values():
        if group.takes(thing):
            return group
    raise UserError(f"argument must be a {alternatives(GROUPS)} (got {short(thing)})")


def given() -> References:
    """Return the plug-ins that this process has loaded from ``module:OBJECT``."""
    return [(what, text) for what, group in GROUPS.items() for text in group.given.values()]


def know(references: References) -> None:
    """Register plug-ins, after forgetting all that were loaded from ``module:OBJECT`` before.

    Raises:
        UserError: a plug-in cannot be imported or used in this process.
    """
    for group in GROUPS.values():
        for name in group.given:
            group.known.pop(name, None)
        group.given.clear()
    for what, text in references:
        GROUPS[what].resolve(text)


def own_ones(used: Iterable[tuple[str, str]]) -> References:
    """Return group and name of each part in ``used`` that is not built in, without repetitions."""
    return [(what, name) for what, name in dict.fromkeys(used) if name not in GROUPS[what].built_in]


def sources(used: Iterable[tuple[str, str]]) -> dict[str, dict[str, str]]:
    """Return group -> name -> ``module:OBJECT`` of the parts in ``used`` that are not built in."""
    by_group: dict[str, dict[str, str]] = {}
    for what, name in own_ones(used):
        if source := GROUPS[what].source(name):
            by_group.setdefault(what, {})[name] = source
    return by_group


def origins(used: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return "group 'name'" -> version of each part in ``used`` that is not built in.

    It is the version of the part's distribution, the digest of its module's file, or "unknown".
    """
    return {f"{what} {name!r}": _origin(GROUPS[what], name) for what, name in own_ones(used)}


def _origin(group: Group[Any], name: str) -> str:
    module = (group.source(name) or group.modules.get(name, "")).partition(":")[0]
    if package := _distributions().get(module.partition(".")[0]):
        return f"{package[0]} {metadata.version(package[0])}"
    file = getattr(sys.modules.get(module), "__file__", None)
    if file and Path(file).is_file():
        return sha256(Path(file).read_bytes()).hexdigest()
    return "unknown"  # such as a part typed into an interactive Python


_distributions = cache(metadata.packages_distributions)


def _module(thing: Any) -> str:
    """Return the module with a user's code in a part; "" if all its code is this package's."""
    parts = [thing, *(thing if isinstance(thing, tuple) else vars(thing).values())]
    names = (str(getattr(part, "__module__", None) or "") for part in parts)
    ours = {"", "builtins", "functools", *(__name__.partition(".")[:1]), "plants"}
    return next((name for name in names if name.partition(".")[0] not in ours), "")


@contextmanager
def own_code(
    doing: str, *parts: tuple[str, str], passing: tuple[type[Exception], ...] = ()
) -> Iterator[None]:
    """Turn an error of a user's own code into a UserError: a line with the part, then ``doing``.

    ``parts`` are group and name of all parts involved. If all of them are built in, the error is
    not changed; neither are UserErrors and errors of the classes ``passing``.
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
    """Return ``--use`` for each part in ``named`` (of ``sources``), or only if it is not known."""
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
    """Return `` --use module:OBJECT`` for each text ``module:OBJECT``, quoted for a shell."""
    return "".join(f" --use {shlex.quote(text)}" for text in texts)


@AfterValidator
def naming_modules(provenance: Json) -> Json:
    """Validate a provenance: each of its plug-ins must be a text ``module:OBJECT``."""
    for key, text in flat({"plugins": provenance.get("plugins", {})}).items():
        if not isinstance(text, str) or not REFERENCE.fullmatch(text):
            raise ValueError(f"{key} = {short(text)}: must be module:OBJECT")
    return provenance


def resuming(folder: Path) -> str:
    """Return the advice to continue a stopped run, with a command that loads the user's parts."""
    use_options = options(text for _, text in given())
    return f"continue with: hfc design --resume --out {shlex.quote(folder.as_posix())}{use_options}"


def _check_fields(thing: Any, source: str) -> None:
    """Check a NamedTuple or dataclass; UserError: a field does not fit its annotation."""
    if isinstance(thing, type):
        return
    hints: Any = {name: (hint, ...) for name, hint in get_type_hints(type(thing)).items()}
    fields = create_model("Fields", __config__=ANY_CLASS, **hints)
    checked(fields, {name: getattr(thing, name) for name in hints}, source, Path())


def chosen(
    group: Group[Any] | Callable[[], Group[Any]], part: str, key: str = "kind", default: str = ""
) -> WrapValidator:
    """Return a validator for a table of a file in which ``key`` names a plug-in of ``group``.

    The record in the attribute ``part`` of the plug-in checks the table. ``default`` is the name if
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
    """Return name -> object, of the objects called ``attribute`` in the modules of a package.

    A module with several has a tuple of them, called ``attribute`` with an S. ``folders``: search
    subpackages only, so that nothing else is imported, such as modules that draw.
    """
    inside = pkgutil.iter_modules(package.__path__)
    modules = sorted(module.name for module in inside if module.ispkg or not folders)
    parts = [importlib.import_module(f"{package.__name__}.{name}") for name in modules]
    things = [getattr(part, attribute) for part in parts if hasattr(part, attribute)]
    things += [thing for part in parts for thing in getattr(part, f"{attribute}S", ())]
    return {thing.name: thing for thing in things}


def _module_meant(text: str) -> str:
    """Return the hint "did you mean mine:AXIS?" for mine.py:AXIS, mine.AXIS or mine.py; else ""."""
    start, colon, name = text.partition(":")
    path = Path(start)
    if path.suffix == ".py":
        return f"did you mean {path.stem}:{name or 'OBJECT'}?"
    module, dot, last = start.rpartition(".")
    if not colon and dot and isfile(f"{module.replace('.', '/')}.py"):
        return f"did you mean {module}:{last}?"
    return ""


def _found_at(reference: str) -> Any:
    """Import and return the object ``module:OBJECT``; UserError: it cannot be imported."""
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
