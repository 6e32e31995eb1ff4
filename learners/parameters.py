"""Numbers of a preset that may change while a run goes on, by their dotted keys."""

from learners.spec import RunSpec

PARAMETERS = (
    "learner.epsilon",
    "learner.alpha",
    "learner.skill_alpha",
    "learner.gamma",
    "world.capture_reward",
    "world.flight_reward",
    "world.vision_radius",
)
"""What may change while a run goes on. All else would make it another run."""


def value_of(spec: RunSpec, key: str) -> float:
    """Value of a parameter."""
    section, name = key.split(".")
    return float(getattr(getattr(spec, section), name))


def with_value(spec: RunSpec, key: str, value: float) -> RunSpec:
    """The same preset with another value of a parameter, which is not looked at."""
    section, name = key.split(".")
    part = getattr(spec, section).model_copy(update={name: float(value)})
    return spec.model_copy(update={section: part})
