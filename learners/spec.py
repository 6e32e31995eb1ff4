"""What a run is made of, as a preset states it (validated, frozen).

A run is a function of a :class:`RunSpec`, a seed, and the commands given while it runs.
"""

from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator

from learners.learner_spec import LearnerSpec
from learners.misfits import misfits
from learners.names import MAX_TRIALS
from learners.schedule_spec import ScheduleSpec
from sim.spec import Problem, ProblemsError, Spec, WorldSpec


class RunSpec(Spec):
    """A preset: a world, a learner, the schedule of its skills, and a number of trials."""

    description: Annotated[str, Field(max_length=400)] = ""
    world: WorldSpec = Field(default_factory=WorldSpec)
    learner: LearnerSpec
    schedule: ScheduleSpec = Field(default_factory=ScheduleSpec)
    trials: Annotated[int, Field(ge=1, le=MAX_TRIALS)]

    @field_validator("learner")
    @classmethod
    def _fits_the_world(cls, learner: LearnerSpec, info: ValidationInfo) -> LearnerSpec:
        world = info.data.get("world")
        if world is None or world.shares_sensors:
            return learner
        if learner.applicable is not None:
            message = (
                "asks in each state of the selection what skills promise there, and their sensors"
                " tell other states apart; allowed: none, or a world without skill_n_directions"
                " and skill_n_distances"
            )
            raise ProblemsError([Problem(("applicable",), learner.applicable, message)])
        if learner.selection != "learned":
            message = (
                "knows what the skills know, and the skills' sensors tell other states apart than"
                " the selection's; allowed: learned, or a world without skill_n_directions and"
                " skill_n_distances"
            )
            raise ProblemsError([Problem(("selection",), learner.selection, message)])
        return learner

    @field_validator("schedule")
    @classmethod
    def _fits_the_learner(cls, schedule: ScheduleSpec, info: ValidationInfo) -> ScheduleSpec:
        # Compared as soon as these two are sound, whatever is wrong with the rest.
        learner = info.data.get("learner")
        if learner is None:
            return schedule
        schedule = schedule.with_a_first(learner.skills)
        problems = list(misfits(schedule, learner))
        if problems:
            raise ProblemsError(problems)
        return schedule
