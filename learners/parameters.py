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
WEIGHTS = "learner.weights."
"""How the keys of skills' weights begin, which may change besides where a rule selects."""


def parameters_of(spec: RunSpec) -> tuple[str, ...]:
    """All that may change of a run: where a rule selects, the weight of each skill as well."""
    if spec.learner.selection == "learned":
        return PARAMETERS
    return (*PARAMETERS, *(f"{WEIGHTS}{skill}" for skill in spec.learner.skills))


def value_of(spec: RunSpec, key: str) -> float:
    """Value of a parameter."""
    if key.startswith(WEIGHTS):
        return spec.learner.weights.get(key.removeprefix(WEIGHTS), 1.0)
    section, name = key.split(".")
    return float(getattr(getattr(spec, section), name))


def with_value(spec: RunSpec, key: str, value: float) -> RunSpec:
    """The same preset with another value of a parameter, which is not looked at."""
    if key.startswith(WEIGHTS):
        weights = spec.learner.weights | {key.removeprefix(WEIGHTS): float(value)}
        learner = spec.learner.model_copy(update={"weights": weights})
        return spec.model_copy(update={"learner": learner})
    section, name = key.split(".")
    part = getattr(spec, section).model_copy(update={name: float(value)})
    return spec.model_copy(update={section: part})
