"""What a rule table is called in the program that it comes from. Never imports JAX."""

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from hfc_design.core.records import Finite, Label, Record

Variable = Literal["error", "error_change", "output"]


class NamesRecord(Record):
    """Names of the variables, and of the system of them."""

    error: Label = "error"  # name of the error in exported files
    error_change: Label = "error_change"  # name of its change in exported files
    output: Label = "rules"  # name of what the rules say in exported files
    #: name of the whole system in exported files; left out: that of the output
    engine: Label | None = Field(None, exclude_if=lambda name: name is None)

    @model_validator(mode="after")
    def _differ(self) -> Self:
        names = [name.casefold() for name in (self.error, self.error_change, self.output)]
        if twice := next((name for name in names if names.count(name) > 1), None):
            raise ValueError(f"two of error, error_change, output are called {twice}")
        return self


#: Names of variables that no other program has given.
USUAL = NamesRecord()


def called(name: str, usual: str, meaning: str) -> str:
    """A variable for people: its own name with what it means, if it is not the usual one."""
    return meaning if name in (usual, meaning) else f"{name} ({meaning})"


def signals_of(names: NamesRecord) -> dict[str, str]:
    """Names of the inputs -> the signals that they are; none where they have the usual ones."""
    pairs = (names.error, USUAL.error), (names.error_change, USUAL.error_change)
    return {name: signal for name, signal in pairs if name != signal}


def _rising(ends: tuple[float, float]) -> tuple[float, float]:
    if not ends[0] < ends[1]:
        raise ValueError(f"a range has to rise; from {ends[0]} to {ends[1]} it does not")
    return ends


#: Ranges that variables have there, in BLU and units of the command. They change no command.
Ranges = dict[Variable, Annotated[tuple[Finite, Finite], AfterValidator(_rising)]]
