"""What goes on in the lesson that is on, for all browsers: its run is brought to where a card is to
begin, and whatever comes true is told.

The render loop asks it with each frame; what takes longer than a moment is done elsewhere: checks
and answers are looked for by the referee's thread, and twenty runs are made in one of their own.
"""

import json
import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from app.documents.lesson_cards import Card
from app.documents.lesson_grammar import Moment
from app.documents.lesson_questions import Asked
from app.documents.lesson_spec import LessonSpec
from app.documents.lessons import Lesson
from app.lessons.checks import Verdict
from app.lessons.measures import Began
from app.lessons.predictions import answer_of, scored
from app.lessons.referee import Line, Referee
from app.lessons.spread import Spread
from app.lessons.story import Guess, card_of, index_of, open_guesses, sound, value_of
from app.lessons.twenty import Twenty
from app.lessons.words import Words, words_of
from app.live.requests import Pause, Request, RunTo, Tell, TrialOnce
from app.live.session import Session
from app.live.status import Status
from app.live.story import Act, LongText, Passed, Revealed, Story, WentToCard
from app.page.lesson.done import Doings
from app.page.lesson.learn import Library, request_to_begin
from app.results.service import Service
from learners.commands import FollowSchedule
from sim.world import CAPTURE

Submit = Callable[[Request], object]
"""Hands a request to the session, which means the run that is live."""
_PATIENCE_S: Final = 30.0
"""After so long a run is told of even if not all the others are there."""
_LOOK_S: Final = 0.2
"""How often the referee is told how far the run is."""


@dataclass(frozen=True)
class Sitting:
    """The lesson that is on, as far as this pounce can read it."""

    lesson: Lesson
    story: Story
    has_run: bool
    """Whether its run is on the board."""

    @property
    def words(self) -> Words:
        """What is said around the lesson's own texts, in the language that is read."""
        return words_of(self.story.language)

    @property
    def card(self) -> Card:
        """The card that is shown, in the lesson's own language."""
        return card_of(self.story, self.lesson.spec)

    @property
    def index(self) -> int:
        """Which one that is, from 0."""
        return index_of(self.story, self.lesson.spec)

    @property
    def began(self) -> Began | None:
        """Where it was entered; None before the first is."""
        return began_of(self.story, self.story.card)


def began_of(story: Story, card: int) -> Began | None:
    """Where a card was entered; None if it was not."""
    found = story.began.get(card)
    return None if found is None else Began(found.trial, found.place.step, found.events)


class Desk:
    """Of one lab. The render loop alone has to do with it."""

    def __init__(
        self,
        session: Session,
        service: Service,
        submit: Submit,
        wake: Callable[[], object],
        first: Lesson | None = None,
        folder: Path | None = None,
    ) -> None:
        """Prepare.

        Args:
            session: whose lessons it knows.
            service: runs experiments that are run from the page.
            submit: hands a request to the session.
            wake: lets the render loop draw; called in any thread.
            first: a lesson that is to be on at once.
            folder: in which what twenty runs answer is kept; None for nowhere.
        """
        self.library = Library()
        """The lessons that there are."""
        self.doings = Doings(session, service)
        """What was done on the card that is shown."""
        self._session, self._submit = session, submit
        self._referee = Referee(wake)
        self._twenty = Twenty(wake, folder)
        self._first = None if first is None else self.library.offer(first)
        self._sound: tuple[Story | None, Any] = (None, None)
        """A story as it was kept, and without what makes no sense in its lesson."""
        self._goes_to: tuple[str, int, Moment] | None = None
        """A lesson, the card that comes next, and up to when is learned before that."""
        self._entered: tuple[str, int, Began | None] | None = None
        """The lesson, the card, and where it was entered, of which things are looked for."""
        self._looked_s = -1.0
        self._found_s: dict[tuple[int, str], float] = {}
        """When it was known what the run answers, by run and question, while others are not there
        yet."""
        self.is_answered = True
        """Whether the session has answered all that it was asked before this frame."""
        self.verdict: Verdict | None = None
        """What the check of the card that is shown has come to; None if it has none, or not yet."""

    def stop(self) -> None:
        """End its threads."""
        self._referee.stop()
        self._twenty.stop()

    def sitting(self, live: Status) -> Sitting | None:
        """The lesson that is on; None if none is."""
        story = live.story
        lesson = None if story is None else self.library.of(story)
        if story is None or lesson is None:
            return None
        if self._sound[0] is not story:
            self._sound = (story, sound(story, lesson.spec))
        has_run = any(line.number == story.took.run for line in live.lines)
        return Sitting(lesson, self._sound[1], has_run)

    def tell(self, story: Story, act: Act) -> None:
        """Have something done in a lesson, if it is still the one that is on."""
        self._submit(Tell(act, story.name))

    # Going on

    def goes_on_to(self, story: Story) -> Moment | None:
        """Up to when is learned before the next card; None if that is not so."""
        goes = self._goes_to
        return goes[2] if goes is not None and goes[:2] == (story.name, story.card + 1) else None

    def go_on(self, sitting: Sitting, live: Status) -> None:
        """Go on to the next card, after what is to be learned before that."""
        story, index = sitting.story, sitting.index
        until = None if index < story.furthest else self._until(sitting)
        if until is None or self._has_come(until, live):
            self.tell(story, WentToCard(index + 1))
            return
        self._goes_to = (story.name, index + 1, until)
        self._learn(until)

    def _until(self, sitting: Sitting) -> Moment | None:
        """Up to when is learned before the next card: as far as the card says, and as far as what
        the next one asks can be seen."""
        spec, index = sitting.lesson.spec, sitting.index
        card, following = spec.steps[index], spec.steps[index + 1]
        wanted: list[Moment] = []
        began = sitting.began
        if card.run is not None and began is not None:
            wanted.append(_from(card.run, began.trial))
        if following.see is not None:
            at = spec.index_of(following.see.same_as)
            guessed, of_guess = spec.steps[at], began_of(sitting.story, at)
            asked = guessed.question
            reveal = None if asked is None else asked.reveal
            moment = None if reveal is None else reveal.at
            if moment is not None and of_guess is not None:
                wanted.append(_from(moment, of_guess.trial))
        # Of catches it is not known before in which trial they come.
        return max(wanted, key=lambda moment: moment.trials, default=None)

    def _has_come(self, until: Moment, live: Status) -> bool:
        if until.captures is None:
            return live.snapshot.trial >= until.trials
        past = self._session.past_of(live.snapshot.generation)
        caught = 0 if past is None else int((past.outcomes[until.trials :] == CAPTURE).sum())
        return caught >= until.captures

    def _learn(self, until: Moment) -> None:
        self._submit(RunTo(until.trials) if until.captures is None else TrialOnce())

    # With each frame

    def update(self, live: Status, is_answered: bool) -> None:
        """Do what is due.

        Args:
            live: how the live run stands.
            is_answered: whether it has answered all that was asked; before, nothing is asked again.
        """
        self.is_answered = is_answered
        first, self._first = self._first, None
        if first is not None:
            self._submit(request_to_begin(first, "", is_anew=False))
            return
        sitting = self.sitting(live)
        if sitting is None:
            self.verdict = self._goes_to = None
            self._referee.keep(())
            self._twenty.leave()
        elif is_answered:
            self._twenty.want(sitting.lesson)
            self._go(sitting, live)

    def _go(self, sitting: Sitting, live: Status) -> None:
        story = sitting.story
        entered = (story.name, story.card, sitting.began)
        if entered != self._entered:
            self._entered, self.verdict = entered, None
            self.doings.begin()
        if not sitting.has_run:
            return
        if sitting.began is not None:
            self._look(sitting, live)
        if live.runs_to is not None:
            return
        if sitting.began is None:
            self._enter(sitting, live)
        elif self._goes_to is not None:
            self._arrive(sitting, live, self._goes_to)

    def _enter(self, sitting: Sitting, live: Status) -> None:
        """Have a card begin in a run that has just begun, once that is where it is to find it."""
        took = sitting.story.took
        if live.snapshot.trial < took.start:
            self._submit(RunTo(took.start))
            return
        if live.playing:
            self._submit(Pause())
        if not took.follows and live.snapshot.control.schedule_on:
            self._submit(FollowSchedule(False))
        self.tell(sitting.story, WentToCard(sitting.story.card))

    def _arrive(self, sitting: Sitting, live: Status, goes: tuple[str, int, Moment]) -> None:
        """Show the next card, once all is learned that is to be before; or give that up."""
        story, (name, card, until) = sitting.story, goes
        if (name, card) != (story.name, story.card + 1):
            self._goes_to = None
        elif self._has_come(until, live):
            self._goes_to = None
            self.tell(story, WentToCard(card))
        elif until.captures is None or live.playing or live.finished:
            self._goes_to = None
        else:
            self._learn(until)

    # What comes true

    def _look(self, sitting: Sitting, live: Status) -> None:
        """Have the check and the guesses be looked for, and tell what has been found."""
        story, spec = sitting.story, sitting.lesson.spec
        now_s = time.perf_counter()
        is_due = now_s - self._looked_s >= _LOOK_S or not live.playing
        past = self._session.past_of(live.snapshot.generation)
        began = sitting.began
        if past is None or began is None or began.step > past.end_step:
            # Anybody may have written the session that it was kept in.
            return
        line = Line(live.snapshot.generation, past, self.doings.deeds())
        if is_due:
            self._looked_s = now_s
        card, wanted = sitting.card, list[Hashable]()
        if card.check is not None and sitting.index not in story.passed:
            key = ("check", line.number, story.name, sitting.index, began)
            wanted.append(key)
            if is_due:
                self._referee.want(key, card.check, began, line)
            self.verdict = self._referee.verdict(key)
            if self.verdict is not None and self.verdict.state == "yes":
                self.tell(story, Passed(sitting.index))
                if live.playing:
                    # What comes next is about this moment.
                    self._submit(Pause())
        for guess in open_guesses(story, spec):
            if _is_undone(guess, story, spec):
                continue
            key = ("answer", line.number, story.name, guess.place)
            wanted.append(key)
            self._look_for_answer(guess, sitting, line, is_due, key)
        self._referee.keep(wanted)

    def _look_for_answer(
        self, guess: Guess, sitting: Sitting, line: Line, is_due: bool, key: Hashable
    ) -> None:
        story = sitting.story
        asked, began = guess.card.question, began_of(story, guess.place)
        if asked is None or began is None or began.step > line.past.end_step:
            return
        known, question = self._twenty.found(sitting.lesson), (story.took.run, guess.card.id)
        if asked.reveal is None:
            # What is right hangs on no run.
            right = list(asked.key) if isinstance(asked.key, tuple) else asked.key
            given = answer_of(asked, value_of(story.answers[guess.card.id]))
            within = scored(asked, given, None, Spread(())).within
            self.tell(story, Revealed(guess.card.id, LongText(json.dumps(right)), within))
            return
        if guess.card.transfer is not None or _is_beside(asked):
            # No live run answers this; the lesson's own does, where all is done as its cards say.
            is_over = known is not None and guess.card.id in known.own
            answer = None if known is None else known.own.get(guess.card.id)
        else:
            run = guess.card.run
            until = None if run is None or run.captures is not None else run.after(began.trial)
            if is_due:
                self._referee.want(key, asked, began, line, until)
            is_over, answer = self._referee.answer(key)
        if not is_over:
            self._found_s.pop(question, None)
            return
        found_s = self._found_s.setdefault(question, time.perf_counter())
        is_late = time.perf_counter() - found_s > _PATIENCE_S
        if (known is not None and known.is_whole) or is_late:
            del self._found_s[question]
            spread = Spread(()) if known is None else known.of(guess.card.id)
            given = answer_of(asked, value_of(story.answers[guess.card.id]))
            within = scored(asked, given, answer, spread).within
            self.tell(story, Revealed(guess.card.id, LongText(json.dumps(answer)), within))

    def spread_of(self, sitting: Sitting, guess: Guess) -> Spread:
        """What twenty runs answer to a question, as far as they are there."""
        known = self._twenty.found(sitting.lesson)
        return Spread(()) if known is None else known.of(guess.card.id)

    def has_come(self, story: Story, guess: Guess) -> bool:
        """Whether the run has come to where it answers a guess of which is not told yet."""
        return (story.took.run, guess.card.id) in self._found_s


def _is_undone(guess: Guess, story: Story, spec: LessonSpec) -> bool:
    """Whether something is still to be done that was asked for after a guess: what a run comes to
    without that is no answer, and somebody may yet go back to before."""
    asked_for = range(guess.place, min(story.furthest + 1, len(spec.steps)))
    return any(
        spec.steps[place].check is not None and place not in story.passed for place in asked_for
    )


def _is_beside(asked: Asked) -> bool:
    """Whether a question is about what stands beside the run: a race, or an experiment."""
    reveal = asked.reveal
    return reveal is not None and reveal.reading.name in ("leader", "experiment")


def _from(moment: Moment, began: int) -> Moment:
    """A moment that counts from where a card was entered, as one that does not; of catches, those
    from that trial on."""
    if moment.captures is not None:
        return moment._replace(trials=began)
    return Moment(moment.after(began), is_ahead=False)
