"""A lesson in one browser: its card, what is done on it, and what its frame is sent.

The lesson is one for all browsers, and so is where somebody is in it (:mod:`app.live.story`). What
a browser has for itself is whether it has chosen to be free of it, and an answer that is still
being given. All that is asked of the learner goes the way that a click in the panels goes.
"""

import json
import time
from collections.abc import Callable
from functools import partial
from typing import Any, Final, NamedTuple

import viser

from app.documents.lessons import LessonError
from app.documents.tree import MAX_BYTES, PresetError
from app.explain.chain import chain_html, chain_of
from app.lessons.markup import html_of
from app.lessons.predictions import answer_of
from app.lessons.story import (
    card_of,
    has,
    is_locked,
    may_go_on,
    question_of,
    revealed_on,
    shown,
    sureness_in_words,
    value_of,
)
from app.live.requests import LeaveLesson, MakeLive, Request, TakeLesson
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.live.story import Act, Answered, Committed, Hinted, Spoke, WentToCard
from app.page import keys
from app.page.confirm import confirm_for_all
from app.page.inbox import Inbox
from app.page.lesson import messages
from app.page.lesson.board import BoardAsk
from app.page.lesson.cards import (
    Shown,
    asked_sent,
    check_sent,
    learning_in_words,
    reveal_sent,
)
from app.page.lesson.controls import (
    FRAMES,
    Control,
    Headings,
    Layer,
    LookInto,
    OpenSide,
    RunExperiment,
    StartLessonAgain,
    Watch,
    controls_of,
    wanted,
)
from app.page.lesson.desk import Desk, Sitting
from app.page.lesson.does import Deed, GoTo, deeds_of
from app.page.lesson.done import opened_at
from app.page.lesson.learn import begun_again, listed, request_to_begin
from app.page.lesson.marked import Marked, place_in
from app.page.lesson.messages import FromLesson
from app.page.lesson.told import bar_asked, octants_asked
from app.page.panels.inspection import Inspection
from app.page.panels.view import View
from app.page.slots import slot_html
from app.page.time.asks import Asks
from app.page.time.messages import Guess as OnBar
from app.page.time.messages import Sketch
from app.page.time.outlook import Outlook
from app.page.time.panel import TimePanel
from app.page.time.walk import Ground, WalkError
from app.page.widgets import assign
from app.picture.look import Look, heading_shown
from app.player.classroom import Card as CardTold
from app.player.classroom import Classroom, Question
from app.server.callbacks import RefusedError
from app.server.channels import Channels
from app.util.texts import for_terminal
from learners.commands import Command

_IN_LESSON: Final = "<i hidden data-lesson-now></i>"
"""Has the page's script show the card, and no more than the lesson shows."""
_SETTLED_S: Final = 0.4
"""After so long an answer that is not changed any more is told to the session."""
_MOST_FAULT: Final = 2_000
"""Characters of what is said to be wrong."""
_OTHER_RUN: Final = "Another run is on the board than this lesson's."
_BACK: Final = "back_to_run"
"""The control that has the lesson's run be on the board."""
_BEFORE: Final = (
    "This is the moment before. What you do here makes a branch, and the lesson goes on with that."
)


class Rooms(NamedTuple):
    """The other parts of a browser that a lesson steers."""

    view: View
    outlook: Outlook
    asks: Asks
    time: TimePanel
    octants: BoardAsk
    marked: Marked
    inspection: Inspection
    open_side: Callable[[], object]
    watch: Callable[[], object]
    experiment: Callable[[str], object]
    """Runs an experiment, by its name, and shows what comes of it."""
    presents: Callable[[], bool]
    """Whether an audience is shown what this browser sees."""
    classroom: Classroom | None
    """A class, if there is one."""


class LessonPanel:
    """Of one browser. The render loop alone has to do with it."""

    def __init__(
        self,
        client: viser.ClientHandle,
        desk: Desk,
        rooms: Rooms,
        channels: Channels,
        inbox: Inbox,
        n_viewers: Callable[[], int],
        wake: Callable[[], object],
    ) -> None:
        """Show no lesson yet.

        Args:
            client: the browser.
            desk: knows which lesson is on.
            rooms: what a lesson steers.
            channels: where its frame's is made.
            inbox: where what that sends waits for the render loop.
            n_viewers: browsers that see the session.
            wake: lets the render loop draw at once.
        """
        self._client, self._desk, self._rooms = client, desk, rooms
        self._n_viewers, self._wake = n_viewers, wake
        self._seen: Status | None = None
        self._live: Status | None = None
        self._ground: Ground | None = None
        self._sent: bytes | None = None
        self._fault: str | None = None
        self._is_free = False
        self._dressed: tuple[str, int] | None = None
        """The lesson and the card as which this browser's board was dressed last."""
        self._draft: tuple[str, str, float] | None = None
        """A question, an answer that the session has not been told, and when it was given."""
        self._parts: list[str] = []
        """Of a file that is being sent."""
        self._controls: tuple[Control, ...] = ()
        self._asked: tuple[Any, Any] = (None, None)
        """What the board and the bar are asked."""
        self._region: str | None = None
        """In which a place is to be looked into with the next moment."""
        self._cell: tuple[int, int] | None = None
        """That is looked into."""
        self._inspected: tuple[object, str | None] = (None, None)
        """Of which cell and moment, and what is said of it."""
        self._before: int | None = None
        """Of the lines that there were when this browser went back to before, the newest."""
        self._to_be_live: int | None = None
        """A line with which the card begins anew, once that is live."""
        self._channel = channels.enter(
            FromLesson,
            lambda message: inbox.put(partial(self.take, message)),
            lambda: inbox.put(self._opened),
            page="lesson",
        )
        self._frame_html = self._channel.frame_html("Lesson")
        # At the root of the main panel, which is there whatever tab is shown.
        self._slot = client.gui.add_html(slot_html("lesson", self._frame_html))

    def leave(self) -> None:
        """Send nothing more, and take nothing."""
        self._channel.leave()

    @property
    def told(self) -> CardTold | None:
        """What an audience is told of the card that this browser sees; None if it sees none."""
        sitting = self._in
        if sitting is None:
            return None
        language = sitting.story.language
        spec = sitting.lesson.spec.in_language(language)
        card = spec.steps[sitting.index]
        html = str(html_of(card.words))
        return CardTold(card.id, spec.title, sitting.index, len(spec.steps), html, language)

    @property
    def _sitting(self) -> Sitting | None:
        return None if self._live is None else self._desk.sitting(self._live)

    @property
    def _in(self) -> Sitting | None:
        """The lesson that this browser is in; None if there is none, or it is free of it."""
        return None if self._is_free else self._sitting

    def _opened(self) -> None:
        """The frame is there, or there again, and knows nothing."""
        self._sent = None
        self._wake()

    # With each frame

    def update(self, seen: Status, live: Status, ground: Ground, look: Look, now_s: float) -> None:
        """Show what is true.

        Args:
            seen: what is true for this browser.
            live: how the live run stands.
            ground: what is known of the lines.
            look: how this browser sees the board.
            now_s: the time.
        """
        self._seen, self._live, self._ground = seen, live, ground
        if self._sitting is None:
            self._is_free = False
        sitting = self._in
        if sitting is None:
            self._undress()
        else:
            self._dress(sitting)
            self._branch_off(sitting, live)
        if self._draft is not None and now_s - self._draft[2] >= _SETTLED_S:
            self._tell_draft()
        self._show_on_board(sitting, seen.snapshot, look)
        assign(
            self._slot,
            "content",
            slot_html("lesson", self._frame_html + (_IN_LESSON if sitting else "")),
        )
        state = {
            "list": listed(self._desk.library, live),
            "fault": self._fault,
            "free": self._is_free,
            "lesson": self._lesson(self._sitting, seen, live),
        }
        encoded = json.dumps(state).encode()
        if encoded != self._sent:
            self._sent = encoded
            self._channel.send("lesson", state)

    def _dress(self, sitting: Sitting) -> None:
        """Have the board be seen as the card wants it, once for each time that it is gone to."""
        story = sitting.story
        key = (story.name, story.card)
        if key == self._dressed:
            return
        self._undress()
        self._dressed, self._fault = key, None
        card = sitting.card
        if card.look is not None:
            frame = None if card.look.frame is None else FRAMES[card.look.frame]
            self._rooms.view.show(card.look.layer, frame)
        if card.why is not None:
            self._region = card.why.inspect

    def _undress(self) -> None:
        """Leave the card that was shown."""
        if self._dressed is not None:
            self._rooms.outlook.walk.go_live()
            self._rooms.inspection.look_into(None)
        self._dressed = self._draft = self._region = self._cell = None
        self._before = self._to_be_live = None

    def _branch_off(self, sitting: Sitting, live: Status) -> None:
        """Have the branch be live that was made at the moment before, and the card begin anew."""
        place = self._rooms.outlook.place
        if place is not None:
            self._desk.doings.note("rewind", live.snapshot.step)
        if self._before is not None:
            if place is None:
                self._before = None
            elif place.line > self._before and not self._rooms.asks.is_branching:
                line = next((one for one in live.lines if one.number == place.line), None)
                self._before = None
                if line is not None:
                    self._to_be_live = line.number
                    self._ask(MakeLive(line.number, line.fork_step))
        if self._to_be_live is not None and live.snapshot.generation == self._to_be_live:
            self._to_be_live = None
            self._rooms.outlook.walk.go_live()
            self._tell(sitting, WentToCard(sitting.index, is_again=True))

    def _show_on_board(self, sitting: Sitting | None, snapshot: Snapshot, look: Look) -> None:
        """Mark what the card speaks of, look into a place, and ask what is asked there."""
        if sitting is None:
            self._rooms.marked.show(None, snapshot, look)
            self._put_questions(None, None)
            return
        card = sitting.card
        self._rooms.marked.show(None if card.look is None else card.look.mark, snapshot, look)
        heading = heading_shown(look, snapshot.heading)
        if self._region is not None:
            region, self._region = self._region, None
            self._look_into(place_in(region, snapshot, heading), snapshot, heading)
        key = (self._cell, snapshot.generation, snapshot.step, heading)
        if self._cell is None:
            self._inspected = (None, None)
        elif key != self._inspected[0] and not (self._live and self._live.playing):
            self._inspected = (key, chain_html(chain_of(snapshot, *self._cell, heading)))
        self._put_questions(*self._questions(sitting))

    def _look_into(self, cell: tuple[int, int], snapshot: Snapshot, heading: int) -> None:
        self._cell, self._inspected = cell, (None, None)
        self._rooms.inspection.look_into(cell)
        self._desk.doings.note_opened(opened_at(cell, snapshot, heading), snapshot.step)

    def take_cell(self, cell: tuple[int, int] | None) -> bool:
        """Take a click on a cell of the board, if a lesson has to do with that.

        Args:
            cell: its column and row; None off the board.

        Returns:
            Whether nothing else is to come of it.
        """
        sitting, seen = self._in, self._seen
        if sitting is None or seen is None:
            return False
        if has(shown(sitting.story, sitting.lesson.spec), "inspect") and cell is not None:
            heading = heading_shown(self._rooms.view.look, seen.snapshot.heading)
            self._look_into(cell, seen.snapshot, heading)
            self._wake()
        return True

    def _questions(self, sitting: Sitting) -> tuple[Any, Any]:
        """What the board and the bar are asked: the card's question, or what came of one."""
        story, spec = sitting.story, sitting.lesson.spec
        card, question = sitting.card, question_of(sitting.card)
        told = self._shown(sitting)
        if told is not None and told.is_ready:
            asked, question, given = told.asked, told.guess.card.id, value_of(told.given)
            locked, own, spread = True, told.own, told.spread
        else:
            found = spec.question_of(card)
            if found is None or question is None:
                return None, None
            asked, given, own, spread = found, value_of(story.answers.get(question)), None, None
            locked = is_locked(story, question)
            if self._draft is not None and self._draft[0] == question:
                given = json.loads(self._draft[1])
        if asked.ask == "sectors":
            others = self._of_class(question)
            shares = None
            if others is not None and others["n"]:
                counts = others["counts"].items()
                shares = {octant: count / others["n"] for octant, count in counts}
            return octants_asked(given, locked, own, spread, shares), None
        return None, bar_asked(asked, question, given, locked, own, spread)

    def _put_questions(self, board: Any, bar: Any) -> None:
        if board != self._asked[0]:
            self._rooms.octants.ask(board, self._chose_octants)
        if bar != self._asked[1]:
            self._rooms.time.ask(bar, self._answered_on_bar)
        self._asked = (board, bar)

    def _shown(self, sitting: Sitting) -> Shown | None:
        """Of which guess this card tells what came of it."""
        story, spec = sitting.story, sitting.lesson.spec
        guess = revealed_on(sitting.index, story, spec)
        if guess is None:
            return None
        asked = spec.in_language(story.language).steps[guess.place].question
        assert asked is not None
        spread = self._desk.spread_of(sitting, guess)
        return Shown(guess, asked, story.answers[guess.card.id], spread)

    def _of_class(self, question: str) -> dict[str, Any] | None:
        """What a class has answered to a question, where this browser presents that."""
        classroom = self._rooms.classroom
        if classroom is None or not self._rooms.presents():
            return None
        return classroom.found(question)

    # What the frame is sent

    def _lesson(self, sitting: Sitting | None, seen: Status, live: Status) -> dict[str, Any] | None:
        if sitting is None:
            return None
        story, index = sitting.story, sitting.index
        spec = sitting.lesson.spec.in_language(story.language)
        names, card = shown(story, spec), spec.steps[index]
        busy = self._busy(sitting, live)
        self._controls = self._all_controls(sitting, names, seen)
        is_last = index + 1 == len(spec.steps)
        news = self._desk.library.news_of(story, live.is_shared)
        said = [news, sureness_in_words(live.stories) if is_last else ""]
        classroom = self._rooms.classroom if self._rooms.presents() else None
        notes = card.notes if self._rooms.presents() else None
        return {
            "name": story.name,
            "title": spec.title,
            "language": story.language,
            "languages": list(spec.languages),
            "n": len(spec.steps),
            "at": index,
            "furthest": min(story.furthest, len(spec.steps) - 1),
            "show": sorted(names),
            "keys": keys.keys_of(names),
            "card": self._card(sitting, busy),
            "controls": [control.sent for control in self._controls],
            "inspect": self._inspected[1],
            "notes": None if notes is None else str(html_of(notes)),
            "next": may_go_on(story, spec) and busy is None,
            "last": is_last,
            "said": " ".join(filter(None, said)),
            "vote": None if classroom is None else classroom.state(card.id),
        }

    def _all_controls(
        self, sitting: Sitting, names: frozenset[str], seen: Status
    ) -> tuple[Control, ...]:
        if not sitting.has_run:
            wants = {None: StartLessonAgain()}
            return (Control(_BACK, "Back to the lesson's run", "button", wants, main=True),)
        look = self._rooms.view.look
        return controls_of(names, sitting.card, seen, look.layer, look.frame)

    def _card(self, sitting: Sitting, busy: str | None) -> dict[str, Any]:
        story, index = sitting.story, sitting.index
        spec = sitting.lesson.spec.in_language(story.language)
        card, n_hints = spec.steps[index], story.hints.get(index, 0)
        draft = self._draft
        question = question_of(card)
        verdict = self._desk.verdict
        told = self._shown(sitting)
        is_never = verdict is not None and verdict.state == "never"
        of_class = None if told is None else self._of_class(told.guess.card.id)
        return {
            "kind": card.kind,
            "id": card.id,
            "html": str(html_of(card.words)),
            "ask": asked_sent(
                card, spec, story, draft[1] if draft and draft[0] == question else None
            ),
            "reveal": reveal_sent(told, of_class),
            "check": check_sent(card, index in story.passed, verdict),
            "hints": [str(html_of(hint)) for hint in card.hints[:n_hints]],
            "more_hints": n_hints < len(card.steps_of_help) and index not in story.passed,
            "back": is_never and index not in story.passed and self._before is None,
            "busy": busy,
        }

    def _busy(self, sitting: Sitting, live: Status) -> str | None:
        """What the card waits for, in words; None if it waits for nothing."""
        story, trial = sitting.story, live.snapshot.trial
        if not sitting.has_run:
            return _OTHER_RUN
        if self._before is not None:
            return _BEFORE
        if sitting.began is None:
            start = story.took.start
            return f"It learns up to trial {start:,}, where this begins; it is in trial {trial:,} …"
        until = self._desk.goes_on_to(story)
        return None if until is None else learning_in_words(until, trial)

    # What comes from the frame

    def take(self, message: Any) -> None:
        """Do what a hand did; whatever it says comes from the network."""
        self._fault = None
        try:
            self._do(message)
        except (WalkError, RefusedError, ValueError, PresetError) as error:
            self._say(str(error))
        self._wake()

    def _say(self, text: str) -> None:
        text = for_terminal(text)
        self._fault = (text[:1].upper() + text[1:])[:_MOST_FAULT]

    def _do(self, message: Any) -> None:
        if self._live is None:
            # Nothing of it was shown yet.
            return
        match message:
            case messages.Start():
                self._start(message, self._live)
            case messages.Upload():
                self._take_part(message)
            case messages.Free():
                self._is_free = True
            case messages.BackToLesson():
                self._is_free = False
            case _:
                sitting = self._in
                if sitting is not None:
                    self._do_in(message, sitting, self._live)

    def _start(self, message: messages.Start, live: Status) -> None:
        library, story = self._desk.library, live.stories.of(message.name)
        lesson = library.offered.get(message.name)
        if story is not None and not message.again:
            # What was begun is gone on with as it was then.
            lesson = library.of(story) or lesson
        if lesson is None:
            raise RefusedError("that lesson is not here any more")
        language = message.language or (story.language if story is not None else "")
        self._take_lesson(request_to_begin(lesson, language, message.again), live)

    def _take_lesson(self, request: TakeLesson, live: Status) -> None:
        """Take a lesson; where it brings another run, others who look are thought of."""
        self._is_free, self._dressed = False, None
        n_others = self._n_viewers() - 1
        story = live.stories.of(request.name)
        there = {line.number for line in live.lines}
        is_there = story is not None and story.took.run in there
        if n_others > 0 and not (is_there and not request.is_anew):
            at = "the run on the board. It is set aside, and can be taken up again."
            begin = partial(self._ask, request)
            confirm_for_all(self._client, n_others, "Begin the lesson", at, begin)
        else:
            self._ask(request)

    def _take_part(self, message: messages.Upload) -> None:
        """Take a part of a file; with the last one it is offered, or all is said that is wrong."""
        if message.part == 0:
            self._parts = []
        if message.part != len(self._parts) or message.part >= message.parts:
            self._parts = []
            raise RefusedError("the file has not come whole; choose it again")
        self._parts.append(message.text)
        if len(self._parts) < message.parts:
            return
        text, self._parts = "".join(self._parts), []
        if len(text.encode(errors="replace")) > MAX_BYTES:
            raise RefusedError(f"the file is too large; allowed: at most {MAX_BYTES:,} bytes")
        try:
            lesson = self._desk.library.add(text, message.name)
        except LessonError as error:
            self._say("\n".join(map(str, error.problems)))
            return
        self._say(f"“{lesson.spec.title}” is in the list now.")

    def _do_in(self, message: Any, sitting: Sitting, live: Status) -> None:
        """Do something in the lesson that is on."""
        story, spec = sitting.story, sitting.lesson.spec
        match message:
            case messages.Leave():
                self._ask(LeaveLesson())
            case messages.SetLanguage(language=language) if language in spec.languages:
                self._tell(sitting, Spoke(language))
            case messages.Next() if may_go_on(story, spec) and not self._busy(sitting, live):
                self._rooms.outlook.walk.go_live()
                self._desk.go_on(sitting, live)
            case messages.Back() if sitting.index > 0:
                self._tell(sitting, WentToCard(sitting.index - 1))
            case messages.Go(card=card) if card <= min(story.furthest, len(spec.steps) - 1):
                self._tell(sitting, WentToCard(card))
            case messages.Answer(id=question, value=value):
                self._answer(question, value, sitting)
            case messages.Commit():
                self._commit(message, sitting)
            case messages.Hint():
                self._hint(sitting)
            case messages.Rewind():
                self._rewind(sitting, live)
            case messages.Use(control=control, value=value):
                found = wanted(self._controls, control, value)
                if control == _BACK and found is not None:
                    again = request_to_begin(sitting.lesson, story.language, is_anew=False)
                    self._take_lesson(again, live)
                elif found is not None:
                    self._use(found, sitting)
            case _ if self._rooms.classroom is not None and self._rooms.presents():
                self._ask_class(message, sitting, self._rooms.classroom)
            case _:
                pass

    # Answers

    def _answer(self, question: str, value: Any, sitting: Sitting) -> None:
        """Take an answer that is being given, if it is one to what is asked now."""
        asked = sitting.lesson.spec.question_of(sitting.card)
        if question != question_of(sitting.card) or asked is None:
            return
        if not is_locked(sitting.story, question):
            answer_of(asked, value)
            self._draft = (question, json.dumps(value), time.perf_counter())

    def _chose_octants(self, chosen: frozenset[str]) -> None:
        """The board was clicked."""
        sitting = self._in
        question = None if sitting is None else question_of(sitting.card)
        if sitting is not None and question is not None:
            self._answer(question, sorted(chosen), sitting)
            self._wake()

    def _answered_on_bar(self, message: OnBar | Sketch) -> None:
        """A hand gave an answer on the time bar."""
        sitting = self._in
        question = None if sitting is None else question_of(sitting.card)
        if sitting is None or question is None:
            return
        value: Any = message.trial if isinstance(message, OnBar) else None
        if isinstance(message, Sketch):
            value = [list(point) for point in message.points]
        try:
            self._answer(question, value, sitting)
        except ValueError as error:
            self._say(str(error))
        self._wake()

    def _commit(self, message: messages.Commit, sitting: Sitting) -> None:
        card = sitting.card
        asked = sitting.lesson.spec.question_of(card)
        if message.id != question_of(card) or asked is None:
            return
        self._tell_draft()
        confidence = message.confidence if asked.confidence and card.see is None else None
        self._tell(sitting, Committed(message.id, confidence))

    def _tell_draft(self) -> None:
        draft, self._draft = self._draft, None
        sitting = self._sitting
        if draft is not None and sitting is not None:
            self._tell(sitting, Answered(draft[0], draft[1]))

    def _ask_class(self, message: Any, sitting: Sitting, classroom: Classroom) -> None:
        story = sitting.story
        spec = sitting.lesson.spec.in_language(story.language)
        card = card_of(story, spec)
        asked, question = spec.question_of(card), question_of(card)
        match message:
            case messages.AskClass() if asked is not None and question is not None:
                if asked.ask in ("sketch", "order") or asked.ask is None:
                    raise RefusedError("a class can be asked a choice, a number, a place or a time")
                low, high = asked.low, asked.high
                if asked.ask == "moment":
                    low, high = asked.first, asked.end
                sent = Question(
                    id=card.id,
                    kind=asked.ask,
                    html=str(html_of(card.words)),
                    options=tuple((value, str(html_of(text))) for value, text in asked.choices),
                    unit=asked.unit,
                    language=story.language,
                )
                if low is not None:
                    sent = sent._replace(low=low)
                if high is not None:
                    sent = sent._replace(high=high)
                classroom.ask(sent)
            case messages.VoteAgain():
                classroom.vote_again()
            case messages.RevealClass():
                told = self._shown(sitting)
                outcome = None if told is None or not told.is_ready else reveal_sent(told, None)
                classroom.reveal(outcome)
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
        self._tell(sitting, Hinted(index))
        began, seen = sitting.began, self._seen
        if n_hints + 1 < len(card.steps_of_help) or not card.does_it or card.do is None:
            return
        if began is not None and seen is not None:
            for deed in deeds_of(card.do, began.trial, seen, sitting.lesson.run_spec):
                self._use(deed, sitting)

    def _rewind(self, sitting: Sitting, live: Status) -> None:
        """Look at the moment at which the card was entered; a command there makes a branch."""
        began = sitting.story.began.get(sitting.story.card)
        verdict = self._desk.verdict
        if began is None or verdict is None or verdict.state != "never":
            return
        self._rooms.time.go_to(began.place)
        self._before = max(line.number for line in live.lines)

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
                self._region = region
            case GoTo(trial=trial):
                self._go_to(trial)
            case StartLessonAgain():
                self._ask(begun_again(sitting.lesson, sitting.story, deed))
            case _:
                self._ask(deed)

    def _note_layer(self, key: str) -> None:
        seen = self._seen
        if seen is not None:
            self._desk.doings.note_opened([layer_opened(key)], seen.snapshot.step)

    def _go_to(self, trial: int) -> None:
        ground = self._ground
        if ground is not None:
            now_s, walk = time.perf_counter(), self._rooms.outlook.walk
            walk.pause(now_s, ground)
            walk.seek_trial(trial, now_s, ground)
            if self._live is not None:
                # What is asked next is meant there.
                self._seen = self._rooms.outlook.status(self._live, now_s, ground)

    def _tell(self, sitting: Sitting, act: Act) -> None:
        self._desk.tell(sitting.story, act)

    def _ask(self, request: Request) -> None:
        """Ask for something at the moment that this browser looks at; told in the card if not."""
        seen, ground = self._seen, self._ground
        assert seen is not None
        assert ground is not None
        now_s = time.perf_counter()
        self._rooms.asks.take(request, self._refused, seen, ground, now_s)

    def _refused(self, reason: str) -> None:
        """Say why something could not be done. Called in any thread."""
        self._say(reason)
        self._wake()
