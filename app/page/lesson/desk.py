"""What goes on in the lesson that is on, for all browsers: its run is brought to where a card is to
begin, and whatever comes true is told.

The render loop asks it with each frame; what takes longer than a moment is done elsewhere.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from app.documents.lessons import Lesson
from app.lessons.story import index_of
from app.live.requests import Pause, Request, RunTo, Tell
from app.live.status import Status
from app.live.story import Act, Story, WentToCard
from app.page.lesson.learn import Library, request_to_begin
from learners.commands import FollowSchedule

Submit = Callable[[Request], object]
"""Hands a request to the session, which means the run that is live."""
_NO_RUN: Final = "Another run is on the board. *Back to the lesson* brings the lesson's run."


@dataclass(frozen=True)
class Sitting:
    """The lesson that is on, as far as this pounce can read it."""

    lesson: Lesson
    story: Story
    has_run: bool
    """Whether its run is on the board."""


class Desk:
    """Of one lab. The render loop alone has to do with it."""

    def __init__(self, submit: Submit, first: Lesson | None = None) -> None:
        """``first`` is a lesson of one's own that is to be on at once."""
        self.library = Library(first)
        """The lessons that there are."""
        self._submit = submit
        self._first = first
        self._leads_to: tuple[str, int, int] | None = None
        """A lesson, the card that comes next, and the trial that is learned up to before that."""

    def sitting(self, live: Status) -> Sitting | None:
        """The lesson that is on; None if none is."""
        story = live.story
        lesson = None if story is None else self.library.of(story)
        if story is None or lesson is None:
            return None
        has_run = any(line.number == story.took.run for line in live.lines)
        return Sitting(lesson, story, has_run)

    def tell(self, story: Story, act: Act) -> None:
        """Have something done in a lesson, if it is still the one that is on."""
        self._submit(Tell(act, story.name))

    def goes_on_to(self, story: Story) -> int | None:
        """The trial that is learned up to before the next card; None if that is not so."""
        leads = self._leads_to
        return leads[2] if leads is not None and leads[:2] == (story.name, story.card + 1) else None

    def go_on(self, sitting: Sitting, live: Status) -> None:
        """Go on to the next card, after what is to be learned before that."""
        story, spec = sitting.story, sitting.lesson.spec
        index = index_of(story, spec)
        run, began = spec.steps[index].run, story.began.get(story.card)
        until = 0 if run is None or began is None else run.after(began.trial)
        if until <= live.snapshot.trial or index + 1 <= story.furthest:
            self.tell(story, WentToCard(index + 1))
            return
        self._leads_to = (story.name, index + 1, until)
        self._submit(RunTo(until))

    def update(self, live: Status, is_answered: bool) -> None:
        """Do what is due.

        Args:
            live: how the live run stands.
            is_answered: whether it has answered all that was asked; before, nothing is asked again.
        """
        first, self._first = self._first, None
        if first is not None:
            self._submit(request_to_begin(first, "", is_anew=False))
            return
        sitting = self.sitting(live)
        if sitting is None or not is_answered:
            return
        story = sitting.story
        if not sitting.has_run or live.runs_to is not None:
            return
        if story.card not in story.began:
            self._enter(sitting, live)
        elif self._leads_to is not None:
            self._arrive(sitting, live)

    def _enter(self, sitting: Sitting, live: Status) -> None:
        """Have the first card begin, once its run is where it is to find it."""
        setup, trial = sitting.lesson.spec.setup, live.snapshot.trial
        if trial < setup.start:
            self._submit(RunTo(setup.start))
            return
        if live.playing:
            self._submit(Pause())
        if setup.schedule == "off" and live.snapshot.control.schedule_on:
            self._submit(FollowSchedule(False))
        self.tell(sitting.story, WentToCard(0))

    def _arrive(self, sitting: Sitting, live: Status) -> None:
        """Show the next card, once all is learned that is to be before; or give that up."""
        story, leads = sitting.story, self._leads_to
        assert leads is not None
        self._leads_to = None
        if leads[:2] == (story.name, story.card + 1) and live.snapshot.trial >= leads[2]:
            self.tell(story, WentToCard(leads[1]))
