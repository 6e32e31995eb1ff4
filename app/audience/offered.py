"""What own learners begin with, and what can be done with them: as the lesson has it that is on, or
as the presenter's run began."""

from pathlib import Path
from typing import Final, NamedTuple

from app.audience.own import Beginning
from app.audience.own_view import CONTROLS, controls_of
from app.documents.lessons import Lesson
from app.lessons import story as story_module
from app.lessons.story import card_of, is_locked, question_of
from app.lessons.taken import lesson_of
from app.live.status import Status
from app.live.story import Story

_PREDICTED: Final = ("ask", "transfer")
"""Cards of which the answer is not to be looked up."""


class Offer(NamedTuple):
    """The same for all seats."""

    beginning: Beginning
    controls: tuple[str, ...] = CONTROLS
    holds: bool = False
    """Whether the presenter asks what will come: then all stand still, so that it is predicted."""


def offer_of(live: Status) -> Offer | None:
    """What there is now; None where it stays as it was.

    What comes of an experiment, or of somebody else, is shown for a moment, and is nothing to begin
    with.
    """
    snapshot, story = live.snapshot, live.story
    if story is not None:
        lesson = lesson_of(story.took)
        return None if lesson is None else _of_lesson(lesson, story)
    if not live.is_own or live.opened is not None:
        return None
    return Offer(Beginning(snapshot.preset, snapshot.preset_spec, snapshot.seed))


def _of_lesson(lesson: Lesson, story: Story) -> Offer:
    spec, setup = lesson.spec, lesson.spec.setup
    beginning = Beginning(
        preset=Path(setup.preset).stem or setup.preset,
        spec=lesson.run_spec,
        seed=setup.seed,
        start=setup.start,
        schedule=setup.schedule == "on",
        speed=Beginning.speed if setup.speed is None else float(setup.speed),
        explorations=_explorations(lesson),
    )
    card = card_of(story, spec)
    holds = card.kind in _PREDICTED and not is_locked(story, question_of(card))
    return Offer(beginning, controls_of(story_module.shown(story, spec)), holds)


def _explorations(lesson: Lesson) -> tuple[tuple[str, int, float], ...]:
    """How skills are explored that a card has explored; of each skill the first."""
    found: dict[str, tuple[str, int, float]] = {}
    for card in lesson.spec.steps:
        do = card.do
        if do is not None and do.skill is not None and do.explore is not None:
            explored = (do.skill, do.explore.trials, float(do.explore.chance))
            found.setdefault(do.skill, explored)
    return tuple(found.values())
