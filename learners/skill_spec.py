"""A skill of one's own, as a preset states it."""

from learners.names import Weight
from learners.skills import LocalReward, rewards
from sim.spec import Spec


class SkillWeights(Spec):
    """A skill of one's own: its local reward is a weighted sum of those of the four skills."""

    approach: Weight = 0.0
    avoid: Weight = 0.0
    circle_clockwise: Weight = 0.0
    circle_counterclockwise: Weight = 0.0

    def reward(self, spiral_penalty: float) -> LocalReward:
        """The sum as weights of the three metrics, for circles that are charged so much."""
        of_skill = rewards(spiral_penalty)
        parts = [
            [weight * part for part in of_skill[skill]]
            for skill, weight in self.model_dump().items()
        ]
        return LocalReward(*(sum(column) for column in zip(*parts, strict=True)))
