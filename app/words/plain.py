"""How skills, parameters and moves are said where people read of them."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from sim import geometry

HEADING_NAMES = (
    "east",
    "north-east",
    "north",
    "north-west",
    "west",
    "south-west",
    "south",
    "south-east",
)
_TOWARDS = dict(zip(map(tuple, geometry.HEADINGS.tolist()), HEADING_NAMES, strict=True))
PARAMETER_NAMES: Final[Mapping[str, str]] = {
    "learner.epsilon": "Exploration ε",
    "learner.alpha": "α of selection",
    "learner.skill_alpha": "α of skills",
    "learner.gamma": "Discount γ",
    "world.capture_reward": "Capture reward",
    "world.flight_reward": "Flight reward",
    "world.vision_radius": "Vision radius",
}
"""What the parameters that can be steered are called, by their keys in a preset."""


def parameter_name(key: str) -> str:
    """What a parameter is called: one of ``PARAMETER_NAMES``, or the weight of a skill."""
    if key in PARAMETER_NAMES:
        return PARAMETER_NAMES[key]
    return f"Weight of {plain(key.rpartition('.')[2])}"


RULES_IN_WORDS: Final[Mapping[str, str]] = {
    "best_happiness": "that of the skill that expects most",
    "worst_unhappiness": "the one that leaves the others least unhappy",
    "negotiated_unhappiness": "that of the skill that has most to lose, as they negotiate it",
    "collective": "the one that is worth most to all skills together",
    "w_learning": "that of the skill that has learned that it loses most (its W)",
}
"""Which move the rules of static selection make."""
MOVE_NAMES = tuple(_TOWARDS.get(tuple(way), "staying") for way in geometry.MOVES.tolist())


def plain(skill: str) -> str:
    """A skill's name as people say it."""
    return skill.replace("_", " ")


def named(skill: str) -> str:
    """A skill's plain name at the start of a sentence."""
    name = plain(skill)
    return name[:1].upper() + name[1:]


def by_plain_name(skills: Iterable[str]) -> dict[str, str]:
    """Skills by their plain names, which a list offers to choose from."""
    return {plain(skill): skill for skill in skills}


def joined_by_and(names: Sequence[str]) -> str:
    """One name or more as a sentence lists them."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def shortened(text: str, characters: int) -> str:
    """A text that fits, if need be without its end; of at least 1 character."""
    return text if len(text) <= characters else f"{text[: characters - 1]}…"
