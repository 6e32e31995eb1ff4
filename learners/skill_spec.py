"""What a skill sees and earns, as a preset states it, and the skills that are built in."""

from collections.abc import Mapping
from typing import Annotated, Final, Literal

from pydantic import Field

from learners.names import Rate, Truth, Weight
from learners.skills import SKILLS, LocalReward, rewards
from sim.spec import FiniteFloat, Spec

FLIGHT_IS_FEARED: Final = -50.0
"""What ``fear`` earns when the prey flees: as much as the trial does in the thesis."""

_SLOWLY: Final = 0.05
"""Learning rate of skills that see the prey's heading: what a move earns them differs from cell to
cell of a state."""


class SkillWeights(Spec):
    """A skill: its local reward is a weighted sum of those of the thesis's four skills, and more.

    Unless stated it is like these: it does not see where the prey looks, goes on when a trial ends,
    and learns at the rate of all skills.
    """

    approach: Weight = 0.0
    avoid: Weight = 0.0
    circle_clockwise: Weight = 0.0
    circle_counterclockwise: Weight = 0.0
    behind: Weight = 0.0
    """For each cell gained by a move that begins more than 105 degrees from the prey's heading."""
    flight: Annotated[FiniteFloat, Field(ge=-1_000, le=1_000)] = 0.0
    """For a move that puts the prey to flight."""
    sees: Literal["prey_heading"] | None = None
    """What it sees besides direction and distance."""
    ends_with_trial: Truth = False
    """Whether nothing follows capture and flight for it."""
    alpha: Rate | None = None
    """Its own learning rate; that of all skills unless given."""

    def reward(self, spiral_penalty: float) -> LocalReward:
        """Weights of the thesis's metrics, for circles that are charged so much."""
        of_skill = rewards(spiral_penalty)
        parts = [[getattr(self, name) * part for part in of_skill[name]] for name in SKILLS]
        return LocalReward(*(sum(column) for column in zip(*parts, strict=True)))


BUILT_IN: Final[Mapping[str, SkillWeights]] = {
    "approach": SkillWeights(approach=1.0),
    "avoid": SkillWeights(avoid=1.0),
    "circle_clockwise": SkillWeights(circle_clockwise=1.0),
    "circle_counterclockwise": SkillWeights(circle_counterclockwise=1.0),
    "appetite": SkillWeights(behind=1.0, sees="prey_heading", ends_with_trial=True, alpha=_SLOWLY),
    "fear": SkillWeights(
        flight=FLIGHT_IS_FEARED, sees="prey_heading", ends_with_trial=True, alpha=_SLOWLY
    ),
}
"""The skills that a preset can name without stating them."""
