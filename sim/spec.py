"""What a world is made of, as a user states it (validated, frozen).

Lengths are those of a grid of 120 x 120 cells and scale with ``size / 120`` (section 4.3.2).
"""

from collections.abc import Sequence
from typing import Annotated, NamedTuple, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

STANDARD_SIZE = 120
N_HEADINGS = 8

FiniteFloat = Annotated[float, Field(allow_inf_nan=False)]


class Problem(NamedTuple):
    """One thing that is wrong with a setting."""

    key: tuple[str | int, ...]
    """Path of the setting, from the model that found the problem."""
    value: object
    """``...`` where there is none, such as for a key that is missing."""
    message: str
    """What is wrong and what is allowed."""


class ProblemsError(ValueError):
    """Settings that are each well-formed and do not go together; carries all problems found."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__("; ".join(f"{'.'.join(map(str, p.key))}: {p.message}" for p in problems))


class Spec(BaseModel):
    """Base of everything a preset states: frozen, strict, and closed to unknown keys."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid")


class WorldSpec(Spec):
    """Settings of the predator's world (sections 4.1, 4.1.1 and 4.1.2)."""

    size: Annotated[int, Field(ge=20, le=400)] = STANDARD_SIZE
    """Cells along each side of the grid."""
    n_directions: Annotated[int, Field(ge=8, le=48, multiple_of=8)] = 24
    """Equal sectors of the direction sensor."""
    n_distances: Annotated[int, Field(ge=2, le=64)] = 18
    """Rings of the distance sensor."""
    skill_n_directions: Annotated[int | None, Field(ge=8, le=48, multiple_of=8)] = None
    """Sectors that skills tell apart; those of the selection unless given (section 4.3.3)."""
    skill_n_distances: Annotated[int | None, Field(ge=2, le=64)] = None
    """Rings that skills tell apart; those of the selection unless given."""
    ring_exponent: Annotated[FiniteFloat, Field(ge=1, le=3)] = 1.5
    """Of the rings' outer edges, ``d_max (k / n) ** ring_exponent``: above 1, thinner near the
    prey."""
    vision_radius: Annotated[FiniteFloat, Field(ge=0, le=1000)] = 27.0
    """How far the prey sees, as on a grid of 120."""
    start_radius: Annotated[
        tuple[FiniteFloat, FiniteFloat], Field(strict=False, description="[nearest, farthest]")
    ] = (10.0, 60.0)
    """Nearest and farthest distance at which a trial starts, as on a grid of 120."""
    step_limit: Annotated[int, Field(ge=1, le=1_000_000)] = 500
    """Steps after which a trial is cut off; not scaled."""
    capture_reward: Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)] = 100.0
    flight_reward: Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)] = -50.0

    @model_validator(mode="after")
    def _starts_lie_in_the_grid(self) -> Self:
        nearest, farthest = self.start_radius
        one_cell = STANDARD_SIZE / self.size
        problems = []
        if nearest < one_cell:
            problems.append(
                f"the nearest start, {nearest:g}, must be at least one cell from the prey;"
                f" allowed: {one_cell:g} or more on a grid of size {self.size}"
            )
        if farthest < nearest:
            problems.append(
                f"the farthest start, {farthest:g}, must not be smaller than the nearest,"
                f" {nearest:g}"
            )
        if farthest > STANDARD_SIZE / 2:
            problems.append(
                f"the farthest start, {farthest:g}, lies outside the grid; allowed: up to"
                f" {STANDARD_SIZE // 2} (half the grid, whatever its size)"
            )
        if problems:
            key = ("start_radius",)
            raise ProblemsError([Problem(key, self.start_radius, text) for text in problems])
        return self

    @property
    def scale(self) -> float:
        """Cells per unit of a stated length."""
        return self.size / STANDARD_SIZE

    @property
    def of_skills(self) -> "WorldSpec":
        """The same world as skills see it: their sensors in the place of the selection's."""
        sensors = {
            "n_directions": self.skill_n_directions or self.n_directions,
            "n_distances": self.skill_n_distances or self.n_distances,
        }
        return self.model_copy(
            update=sensors | {"skill_n_directions": None, "skill_n_distances": None}
        )

    @property
    def shares_sensors(self) -> bool:
        """Whether skills tell apart what the selection does."""
        of_skills = self.of_skills
        return (of_skills.n_directions, of_skills.n_distances) == (
            self.n_directions,
            self.n_distances,
        )

    @property
    def n_readings(self) -> int:
        """Distinct readings of direction and distance."""
        return self.n_directions * self.n_distances

    @property
    def n_states(self) -> int:
        """Distinct readings of direction, distance and heading: what the selection tells apart."""
        return self.n_readings * N_HEADINGS

    @property
    def n_skill_states(self) -> int:
        """Distinct readings of the skills' own sensors: what a skill tells apart."""
        return self.of_skills.n_readings
