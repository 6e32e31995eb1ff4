"""Perceptual templates, as a preset states them (section 2.3.2): what a table begins with."""

from typing import Annotated, Literal, Self, get_args

from pydantic import Field, model_validator

from learners.names import SkillName
from sim.spec import FiniteFloat, Problem, ProblemsError, Spec

SELECTION = "selection"
Way = Literal["inwards", "outwards", "clockwise", "counterclockwise"]
WAYS: tuple[str, ...] = get_args(Way)


class TemplateSpec(Spec):
    """Where something is worth trying, before anything has been learned."""

    table: SkillName
    """``selection``, or the skill whose table begins with it."""
    prefer: SkillName
    """A way to move, or, in the selection, a skill."""
    bearing: Annotated[
        tuple[FiniteFloat, FiniteFloat], Field(strict=False, description="[from, to]")
    ] = (0.0, 180.0)
    """Degrees from where the prey looks, to either side."""
    distance: Annotated[
        tuple[FiniteFloat, FiniteFloat], Field(strict=False, description="[from, to]")
    ] = (0.0, 120.0)
    """From the prey, as on a grid of 120."""
    value: Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]
    """What it is worth there to begin with."""

    @model_validator(mode="after")
    def _from_less_to_more(self) -> Self:
        problems = [
            Problem((name,), span, f"must go from less to more; allowed: [from, to], 0 to {most}")
            for name, span, most in (
                ("bearing", self.bearing, 180),
                ("distance", self.distance, 120),
            )
            if not 0 <= span[0] <= span[1] <= most
        ]
        if problems:
            raise ProblemsError(problems)
        return self
