"""What a hand does in a lesson: each message of its frame, judged and carried out."""

import time
from functools import partial
from typing import Any, Final

from app.documents.lessons import LessonError
from app.documents.tree import MAX_BYTES, PresetError
from app.lessons.predictions import answer_of
from app.lessons.story import is_locked, may_go_on, question_of
from app.lessons.words import Words
from app.live.requests import LeaveLesson, MakeLive, TakeLesson
from app.live.status import Status
from app.live.story import Committed, Hinted, Spoke, WentToCard
from app.page.confirm import confirm_for_all
from app.page.lesson import messages
from app.page.lesson.cards import learning_in_words
from app.page.lesson.controls import (
    Headings,
    Layer,
    LookInto,
    OpenSide,
    RunExperiment,
    StartLessonAgain,
    Watch,
    wanted,
)
from app.page.lesson.desk import Sitting
from app.page.lesson.does import Deed, GoTo, deeds_of
from app.page.lesson.done import layer_opened
from app.page.lesson.learn import begun_again, request_to_begin
from app.page.lesson.sitter import Sitter, drafted
from app.page.lesson.vote import class_question
from app.page.time.messages import Guess as OnBar
from app.page.time.messages import Sketch
from app.page.time.walk import WalkError
from app.player.classroom import Classroom
from app.server.callbacks import RefusedError
from learners.commands import Command

BACK_TO_RUN: Final = "back_to_run"
"""The control that has the lesson's run be on the board."""


class Hands:
    """Of one browser. The render loop alone has to do with it."""

    def __init__(self, sitter: Sitter) -> None:
        self._sitter, self._desk, self._rooms = sitter, sitter.desk, sitter.rooms
        self.region: str | None = None
        """In which a place is to be looked into with the next moment."""
        self._parts: list[str] = []
        """Of a file that is being sent."""
        self._given: set[str] = set()
        """Controls by which a command was given that has not been answered yet: pressed twice, they
        give it once."""
        self._to_be_live: int | None = None
        """A line with which the card begins anew, once that is live."""

    def leave_card(self) -> None:
        """Another card is shown, or none any more."""
        sitter = self._sitter
        sitter.draft = sitter.fault = sitter.before = None
        self.region = self._to_be_live = None

    @property
    def _words(self) -> Words:
        return self._sitter.words

    # What comes from the frame

    def take(self, message: Any) -> None:
        """Do what a hand did; whatever it says comes from the network."""
        self._sitter.fault = None
        try:
            self._do(message)
        except (WalkError, RefusedError, ValueError, PresetError) as error:
            self._sitter.say(str(error))
        self._sitter.wake()

    def _do(self, message: Any) -> None:
        if self._sitter.live is None:
            # Nothing of it was shown yet.
            return
        match message:
            case messages.Start():
                self._start(message, self._sitter.live)
            case messages.Upload():
                self._take_part(message)
            case messages.Free():
                self._sitter.is_free = True
            case messages.BackToLesson():
                self._sitter.is_free = False
            case _:
                sitting = self._sitter.taught
                if sitting is not None:
                    self._do_in(message, sitting, self._sitter.live)

    def _start(self, message: messages.Start, live: Status) -> None:
        library, story = self._desk.library, live.stories.of(message.name)
        lesson = library.offered.get(message.name)
        if story is not None and not message.again:
            # What was begun is gone on with as it was then.
            lesson = library.of(story) or lesson
        if lesson is None:
            raise RefusedError(self._words.say("fault.no_lesson"))
        language = message.language or (story.language if story is not None else "")
        self._take_lesson(request_to_begin(lesson, language, message.again), live)

    def _take_lesson(self, request: TakeLesson, live: Status) -> None:
        """Take a lesson; where it brings another run, others who look are thought of."""
        self._sitter.is_free = False
        n_others = self._sitter.n_viewers() - 1
        story = live.stories.of(request.name)
        there = {line.number for line in live.lines}
        is_there = story is not None and story.took.run in there
        if n_others > 0 and not (is_there and not request.is_anew):
            at = "the run on the board. It is set aside, and can be taken up again."
            begin = partial(self._sitter.ask, request)
            confirm_for_all(self._sitter.client, n_others, "Begin the lesson", at, begin)
        else:
            self._sitter.ask(request)

    def _take_part(self, message: messages.Upload) -> None:
        """Take a part of a file; with the last one it is offered, or all is said that is wrong."""
        if message.part == 0:
            self._parts = []
        if message.part != len(self._parts) or message.part >= message.parts:
            self._parts = []
            raise RefusedError(self._words.say("fault.not_whole"))
        self._parts.append(message.text)
        if len(self._parts) < message.parts:
            return
        text, self._parts = "".join(self._parts), []
        if len(text.encode(errors="replace")) > MAX_BYTES:
            raise RefusedError(self._words.say("fault.too_large", n=MAX_BYTES))
        try:
            lesson = self._desk.library.add(text, message.name)
        except LessonError as error:
            self._sitter.say("\n".join(map(str, error.problems)))
            return
        self._sitter.say(self._words.say("fault.added", title=lesson.spec.title))

    def _do_in(self, message: Any, sitting: Sitting, live: Status) -> None:
        """Do something in the lesson that is on."""
        story, spec = sitting.story, sitting.lesson.spec
        match message:
            case messages.Leave():
                self._sitter.ask(LeaveLesson())
            case messages.SetLanguage(language=language) if language in spec.languages:
                self._sitter.tell(sitting, Spoke(language))
            case messages.Next() if may_go_on(story, spec) and not self.busy(sitting, live):
                self._rooms.outlook.walk.go_live()
                self._desk.go_on(sitting, live)
            case messages.Back() if sitting.index > 0:
                self._sitter.tell(sitting, WentToCard(sitting.index - 1))
            case messages.Go(card=card) if card <= min(story.furthest, len(spec.steps) - 1):
                self._sitter.tell(sitting, WentToCard(card))
            case messages.Answer(id=question, value=value):
                self._answer(question, value, sitting)
            case messages.Commit():
                self._commit(message, sitting)
            case messages.Hint():
                self._hint(sitting)
            case messages.Rewind():
                self._rewind(sitting, live)
            case messages.Use(control=control, value=value):
                found = wanted(self._sitter.controls, control, value)
                if control == BACK_TO_RUN and found is not None:
                    again = request_to_begin(sitting.lesson, story.language, is_anew=False)
                    self._take_lesson(again, live)
                elif found is not None and control not in self._given:
                    if isinstance(found, Command):
                        self._given.add(control)
                    self._use(found, sitting)
            case _:
                classroom = self._sitter.class_shown
                if classroom is not None:
                    self._ask_class(message, sitting, classroom)

    # Answers

    def _answer(self, question: str, value: Any, sitting: Sitting) -> None:
        """Take an answer that is being given, if it is one to what is asked now."""
        asked = sitting.lesson.spec.question_of(sitting.card)
        if question != question_of(sitting.card) or asked is None:
            return
        if not is_locked(sitting.story, question):
            answer_of(asked, value)
            self._sitter.draft = drafted(question, value)

    def chose_octants(self, chosen: frozenset[str]) -> None:
        """The board was clicked."""
        sitting = self._sitter.taught
        question = None if sitting is None else question_of(sitting.card)
        if sitting is not None and question is not None:
            self._answer(question, sorted(chosen), sitting)
            self._sitter.wake()

    def answered_on_bar(self, message: OnBar | Sketch) -> None:
        """A hand gave an answer on the time bar."""
        sitting = self._sitter.taught
        question = None if sitting is None else question_of(sitting.card)
        if sitting is None or question is None:
            return
        value: Any = message.trial if isinstance(message, OnBar) else None
        if isinstance(message, Sketch):
            value = [list(point) for point in message.points]
        try:
            self._answer(question, value, sitting)
        except ValueError as error:
            self._sitter.say(str(error))
        self._sitter.wake()

    def _commit(self, message: messages.Commit, sitting: Sitting) -> None:
        card = sitting.card
        asked = sitting.lesson.spec.question_of(card)
        if message.id != question_of(card) or asked is None:
            return
        if self._sitter.draft_of(sitting) is None and message.id not in sitting.story.answers:
            raise RefusedError(self._words.say("fault.no_answer"))
        self._sitter.tell_draft()
        confidence = message.confidence if asked.confidence and card.see is None else None
        self._sitter.tell(sitting, Committed(message.id, confidence))

    def _ask_class(self, message: Any, sitting: Sitting, classroom: Classroom) -> None:
        match message:
            case messages.AskClass():
                question = class_question(sitting)
                if question is not None:
                    classroom.ask(question)
            case messages.VoteAgain():
                classroom.vote_again()
            case messages.RevealClass():
                classroom.reveal()
            case messages.EndClass():
                classroom.end()
            case _:
                pass

    # What is done

    def _hint(self, sitting: Sitting) -> None:
        """Say a little more; the last hint does it."""
        card, index = sitting.card, sitting.index
        n_hints = sitting.story.hints.get(index, 0)
        if index in sitting.story.passed or n_hints >= len(card.steps_of_help):
            return
        self._sitter.tell(sitting, Hinted(index))
        began, seen = sitting.began, self._sitter.seen
        if n_hints + 1 < len(card.steps_of_help) or not card.does_it or card.do is None:
            return
        if began is not None and seen is not None:
            for deed in deeds_of(card, card.do, began.trial, seen, sitting.lesson):
                self._use(deed, sitting)

    def _rewind(self, sitting: Sitting, live: Status) -> None:
        """Look at the moment at which the card was entered; a command there makes a branch."""
        began = sitting.story.began.get(sitting.story.card)
        verdict = self._desk.verdict
        if began is None or verdict is None or verdict.state != "never":
            return
        self._rooms.time.go_to(began.place)
        self._sitter.before = max(line.number for line in live.lines)

    def _use(self, deed: Deed, sitting: Sitting) -> None:
        rooms = self._rooms
        match deed:
            case Layer(key=key):
                rooms.view.show(key, None)
                self._note_layer(key)
            case Headings(frame=frame):
                rooms.view.show(None, frame)
            case OpenSide():
                rooms.open_side()
            case Watch():
                rooms.watch()
            case RunExperiment(name=name):
                rooms.experiment(name)
            case LookInto(region=region):
                self.region = region
            case GoTo(trial=trial):
                self._go_to(trial)
            case StartLessonAgain():
                self._sitter.ask(begun_again(sitting.lesson, sitting.story, deed))
            case _:
                self._sitter.ask(deed)

    def _note_layer(self, key: str) -> None:
        seen = self._sitter.seen
        if seen is not None:
            self._desk.doings.note_opened([layer_opened(key)], seen.snapshot.step)

    def _go_to(self, trial: int) -> None:
        ground = self._sitter.ground
        if ground is not None:
            now_s, walk = time.perf_counter(), self._rooms.outlook.walk
            walk.pause(now_s, ground)
            walk.seek_trial(trial, now_s, ground)
            if self._sitter.live is not None:
                # What is asked next is meant there.
                self._sitter.seen = self._rooms.outlook.status(self._sitter.live, now_s, ground)

    # What it waits for

    def busy(self, sitting: Sitting, live: Status) -> str | None:
        """What the card waits for, in words; None if it waits for nothing."""
        story, trial, words = sitting.story, live.snapshot.trial, sitting.words
        if not sitting.has_run:
            return words.say("busy.other_run")
        if self._sitter.before is not None:
            return words.say("busy.before")
        if sitting.began is None:
            return words.say("busy.start", start=story.took.start, trial=trial)
        until = self._desk.goes_on_to(story)
        if until is not None:
            return learning_in_words(until, trial, words)
        do = sitting.card.do
        is_waited_for = do is not None and do.command == "experiment"
        if is_waited_for and sitting.index not in story.passed:
            return self._desk.doings.experiment(words)
        return None

    def settle(self, sitting: Sitting | None, live: Status) -> None:
        """See what has come of what was done."""
        if self._desk.is_answered:
            self._given.clear()
        if sitting is not None:
            self._branch_off(sitting, live)

    def _branch_off(self, sitting: Sitting, live: Status) -> None:
        """Have the branch be live that was made at the moment before, and the card begin anew."""
        place = self._rooms.outlook.place
        if place is not None:
            self._desk.doings.note("rewind", live.snapshot.step)
        if self._sitter.before is not None:
            if place is None:
                self._sitter.before = None
            elif place.line > self._sitter.before and not self._rooms.asks.is_branching:
                line = next((one for one in live.lines if one.number == place.line), None)
                self._sitter.before = None
                if line is not None:
                    self._to_be_live = line.number
                    self._sitter.ask(MakeLive(line.number, line.fork_step))
        if self._to_be_live is not None and live.snapshot.generation == self._to_be_live:
            self._to_be_live = None
            self._rooms.outlook.walk.go_live()
            self._sitter.tell(sitting, WentToCard(sitting.index, is_again=True))
