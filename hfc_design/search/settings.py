"""Settings of the search strategies; all of them can stand in the ``[search]`` of a scenario."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from hfc_design.core.records import NotNegative, Positive, Record

Probability = Annotated[float, Field(ge=0, le=1)]
Range = tuple[Positive, Positive]


class _Settings(Record):
    @model_validator(mode="after")
    def _ordered(self) -> "_Settings":
        for name in ("kp_range", "kd_range"):
            low, high = getattr(self, name, (0.0, 1.0))
            if low > high:
                raise ValueError(f"{name} has to be [low, high], not [{low}, {high}]")
        return self


class RaceSettings(_Settings):
    """A race of structures: every tree is an island, and after each heat half of them remain.

    Inside an island individuals breed; when few islands are left, Gauss-Newton steps from the
    best of an island compete with its children.
    """

    preset: Literal["race"] = "race"
    population: int = Field(840, ge=1, le=10_000_000)
    generations: int = Field(200, ge=1, le=10_000_000)
    kp_range: Range = (100.0, 10_000.0)  # of the first individuals [V/rad]
    kd_range: Range = (30.0, 3_000.0)  # [V s/rad]
    scale_range: Annotated[float, Field(ge=1)] = 10.0  # factor around the layout's scales
    inner_limit: Annotated[float, Field(gt=0, le=4)] = 4.0  # |consequent| of an inner unit
    root_limit: Positive = 20.0  # |consequent| of the root
    tournament: int = Field(3, ge=1)
    blend: Probability = 0.5  # share of children that mix two parents
    step: Positive = 0.2  # first mutation step, relative
    stick_penalty: NotNegative = 300.0  # the search divides by 1 + this * stick share
    newton_islands: int = Field(2, ge=0)  # Gauss-Newton steps begin with this many islands left
    newton_steps: int = Field(2, ge=0)  # of them in one generation


class LinLeeSettings(_Settings):
    """The two-phase genetic algorithm of Lin & Lee 1999, section 3.2, with their numbers."""

    preset: Literal["lin-lee-1999"] = "lin-lee-1999"
    population: int = Field(30, ge=3, le=10_000_000)  # n; the three thirds are rounded
    generations: int = Field(200, ge=1, le=10_000_000)
    structure_crossover: Probability = 0.3  # p_c1
    structure_mutation: Probability = 0.5  # alpha, per bit
    parameter_crossover: Probability = 0.7  # p_c2
    parameter_mutation: Probability = 0.8  # beta, per number
    gain_step: Positive = 10.0  # A_max of the PD gains
    centre_step: Positive = 0.1  # A_max of the consequent centres
    kp_range: Range = (10.0, 1_500.0)  # of fresh individuals [V/rad]
    kd_range: Range = (10.0, 1_500.0)  # [V s/rad]
    stick_penalty: NotNegative = 0.0  # as in RaceSettings; the paper has none
    level_limit: Positive = 2.0  # |common level| of the consequents of a fresh individual


SearchSettings = Annotated[RaceSettings | LinLeeSettings, Field(discriminator="preset")]
