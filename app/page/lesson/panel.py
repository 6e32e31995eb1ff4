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
from app.documents.tree import MAX_BYTES
from app.lessons.markup import html_of
from app.lessons.story import (
    card_of,
    index_of,
    may_go_on,
    question_of,
    shown,
    sureness_in_words,
    value_of,
)
from app.live.requests import LeaveLesson, Request, TakeLesson
from app.live.status import Status
from app.live.story import Act, Answered, Committed, Hinted, Spoke, WentToCard
from app.page import keys
from app.page.confirm import confirm_for_all
from app.page.inbox import Inbox
from app.page.lesson import messages
from app.page.lesson.controls import (
    FRAMES,
    Control,
    Headings,
    Layer,
    OpenSide,
    StartLessonAgain,
    Wanted,
    Watch,
    controls_of,
    wanted,
)
from app.page.lesson.desk import Desk, Sitting
from app.page.lesson.learn import listed, request_to_begin
from app.page.lesson.messages import FromLesson
from app.page.lesson.vote import Vote, told_of
from app.page.panels.view import View
from app.page.slots import slot_html
from app.page.time.asks import Asks
from app.page.time.outlook import Outlook
from app.page.time.walk import Ground, WalkError
from app.page.widgets import assign
from app.player.classroom import Card
from app.server.callbacks import RefusedError
from app.server.channels import Channels
from app.util.texts import for_terminal

_IN_LESSON: Final = "<i hidden data-lesson-now></i>"
"""Has the page's script show the card, and no more than the lesson shows."""
_SETTLED_S: Final = 0.4
"""After so long an answer that is not changed any more is told to the session."""
_MOST_FAULT: Final = 2_000
"""Characters of what is said to be wrong."""


class Rooms(NamedTuple):
    """The other parts of a browser that a lesson steers."""

    view: View
    outlook: Outlook
    asks: Asks
    open_side: Callable[[], object]
    watch: Callable[[], object]
    vote: Vote


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
        self._looked_at: tuple[str, int] | None = None
        """The lesson and the card as which this browser's board was dressed last."""
        self._draft: tuple[str, str, float] | None = None
        """A question, an answer that the session has not been told, and when it was given."""
        self._parts: list[str] = []
        """Of a file that is being sent."""
        self._controls: tuple[Control, ...] = ()
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
    def told(self) -> Card | None:
        """What a class is told of the card that this browser sees; None if it sees none."""
        sitting = self._sitting
        return None if sitting is None or self._is_free else told_of(sitting)

    @property
    def _sitting(self) -> Sitting | None:
        return None if self._live is None else self._desk.sitting(self._live)

    def _opened(self) -> None:
        """The frame is there, or there again, and knows nothing."""
        self._sent = None
        self._wake()

    # What the frame is sent

    def update(self, seen: Status, live: Status, ground: Ground, now_s: float) -> None:
        """Show what is true.

        Args:
            seen: what is true for this browser.
            live: how the live run stands.
            ground: what is known of the lines.
            now_s: the time.
        """
        self._seen, self._live, self._ground = seen, live, ground
        sitting = self._sitting
        if sitting is None:
            self._is_free, self._looked_at, self._draft = False, None, None
        elif not self._is_free:
            self._dress(sitting)
        if self._draft is not None and now_s - self._draft[2] >= _SETTLED_S:
            self._tell_draft()
        is_in = sitting is not None and not self._is_free
        hint = _IN_LESSON if is_in else ""
        assign(self._slot, "content", slot_html("lesson", self._frame_html + hint))
        state = self._state(sitting, seen, live)
        encoded = json.dumps(state).encode()
        if encoded != self._sent:
            self._sent = encoded
            self._channel.send("lesson", state)

    def _dress(self, sitting: Sitting) -> None:
        """Have the board be seen as the card wants it, once for each time that it is gone to."""
        story = sitting.story
        key = (story.name, story.card)
        if key == self._looked_at:
            return
        self._looked_at, self._draft, self._fault = key, None, None
        look = card_of(story, sitting.lesson.spec).look
        if look is not None:
            frame = None if look.frame is None else FRAMES[look.frame]
            self._rooms.view.show(look.layer, frame)
        self._rooms.outlook.walk.go_live()

    def _state(self, sitting: Sitting | None, seen: Status, live: Status) -> dict[str, Any]:
        return {
            "list": listed(self._desk.library, live),
            "fault": self._fault,
            "free": self._is_free,
            "lesson": None if sitting is None else self._lesson(sitting, seen, live),
        }

    def _lesson(self, sitting: Sitting, seen: Status, live: Status) -> dict[str, Any]:
        story = sitting.story
        spec = sitting.lesson.spec.in_language(story.language)
        names = shown(story, spec)
        look = self._rooms.view.look
        card, index = card_of(story, spec), index_of(story, spec)
        self._controls = controls_of(names, card, seen, look.layer, look.frame)
        is_last = index + 1 == len(spec.steps)
        news = self._desk.library.news_of(story, live.is_shared)
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
            "card": self._card(sitting, live),
            "controls": [control.sent for control in self._controls],
            "inspect": None,
            "notes": None if card.notes is None else str(html_of(card.notes)),
            "next": may_go_on(story, spec) and self._busy(sitting, live) is None,
            "last": is_last,
            "said": " ".join(
                part for part in (news, sureness_in_words(live.stories) if is_last else "") if part
            ),
            "vote": self._rooms.vote.state(sitting),
        }

    def _card(self, sitting: Sitting, live: Status) -> dict[str, Any]:
        story = sitting.story
        spec = sitting.lesson.spec.in_language(story.language)
        card, index = card_of(story, spec), index_of(story, spec)
        n_hints = story.hints.get(index, 0)
        return {
            "kind": card.kind,
            "id": card.id,
            "html": str(html_of(card.words)),
            "ask": self._ask_of(sitting),
            "reveal": None,
            "check": None,
            "hints": [str(html_of(hint)) for hint in card.hints[:n_hints]],
            "more_hints": n_hints < len(card.steps_of_help),
            "back": False,
            "busy": self._busy(sitting, live),
        }

    def _ask_of(self, sitting: Sitting) -> dict[str, Any] | None:
        story = sitting.story
        spec = sitting.lesson.spec.in_language(story.language)
        card = card_of(story, spec)
        question, asked = question_of(card), spec.question_of(card)
        if question is None or asked is None:
            return None
        given = story.answers.get(question)
        answer = value_of(given)
        if self._draft is not None and self._draft[0] == question:
            answer = json.loads(self._draft[1])
        return {
            "kind": asked.ask,
            "options": [[value, str(html_of(words))] for value, words in asked.choices],
            "low": asked.low,
            "high": asked.high,
            "unit": asked.unit,
            "from": asked.first,
            "to": asked.end,
            "confidence": asked.confidence and card.see is None,
            "answer": answer,
            "said": None if given is None else given.confidence,
            "locked": given is not None and given.locked,
        }

    def _busy(self, sitting: Sitting, live: Status) -> str | None:
        """What the card waits for, in words; None if it waits for nothing."""
        story = sitting.story
        if not sitting.has_run:
            return "Another run is on the board than this lesson's."
        if story.card not in story.began:
            start = sitting.lesson.spec.setup.start
            return f"The learner learns up to trial {start:,}, where this lesson begins …"
        until = self._desk.goes_on_to(story)
        if until is not None:
            return f"It learns on to trial {until:,}; it is in trial {live.snapshot.trial:,} …"
        return None

    # What comes from the frame

    def take(self, message: Any) -> None:
        """Do what a hand did; whatever it says comes from the network."""
        self._fault = None
        try:
            self._do(message)
        except (WalkError, RefusedError, ValueError) as error:
            self._say(str(error))
        self._wake()

    def _say(self, text: str) -> None:
        text = for_terminal(text)
        self._fault = text[:1].upper() + text[1:_MOST_FAULT]

    def _do(self, message: Any) -> None:
        if self._live is None:
            # Nothing of it was shown yet.
            return
        match message:
            case messages.Start():
                self._start(message)
            case messages.Upload():
                self._take_part(message)
            case _:
                sitting = self._sitting
                if sitting is not None:
                    self._do_in(message, sitting, self._live)

    def _start(self, message: messages.Start) -> None:
        live = self._live
        assert live is not None
        lesson = self._desk.library.offered.get(message.name)
        story = live.stories.of(message.name)
        begun = None if story is None else self._desk.library.of(story)
        if not message.again and begun is not None:
            # What was begun is gone on with as it was then.
            lesson = begun
        if lesson is None:
            raise RefusedError("that lesson is not here any more")
        language = message.language or (story.language if story is not None else "")
        self._take_lesson(request_to_begin(lesson, language, message.again))

    def _take_lesson(self, request: TakeLesson) -> None:
        """Take a lesson; where it brings another run, others who look are asked for."""
        live = self._live
        assert live is not None
        self._is_free, self._looked_at = False, None
        n_others = self._n_viewers() - 1
        story = live.stories.of(request.name)
        lines = {line.number for line in live.lines}
        is_there = story is not None and story.took.run in lines and not request.is_anew
        if n_others > 0 and not is_there:
            at = "the run on the board. It is set aside, and can be taken up again."
            confirm_for_all(
                self._client, n_others, "Begin the lesson", at, partial(self._ask, request)
            )
            return
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
            case messages.Free():
                self._is_free = True
            case messages.BackToLesson():
                self._is_free, self._looked_at = False, None
                if not sitting.has_run:
                    self._take_lesson(request_to_begin(sitting.lesson, story.language, False))
            case messages.SetLanguage(language=language) if language in spec.languages:
                self._tell(sitting, Spoke(language))
            case messages.Next() if may_go_on(story, spec) and not self._busy(sitting, live):
                self._rooms.outlook.walk.go_live()
                self._desk.go_on(sitting, live)
            case messages.Back() if story.card > 0:
                self._tell(sitting, WentToCard(index_of(story, spec) - 1))
            case messages.Go(card=card) if card <= min(story.furthest, len(spec.steps) - 1):
                self._tell(sitting, WentToCard(card))
            case messages.Answer():
                self._answer(message, sitting)
            case messages.Commit():
                self._commit(message, sitting)
            case messages.Hint():
                self._hint(sitting)
            case (
                messages.AskClass()
                | messages.VoteAgain()
                | messages.RevealClass()
                | messages.EndClass()
            ):
                self._rooms.vote.take(message, sitting, None)
            case messages.Use(control=control, value=value):
                found = wanted(self._controls, control, value)
                if found is not None:
                    self._use(found, sitting)
            case _:
                pass

    # Answers

    def _answer(self, message: messages.Answer, sitting: Sitting) -> None:
        card = card_of(sitting.story, sitting.lesson.spec)
        given = sitting.story.answers.get(message.id)
        if message.id != question_of(card) or (given is not None and given.locked):
            return
        value = json.dumps(message.value, allow_nan=False)
        self._draft = (message.id, value, time.perf_counter())

    def _commit(self, message: messages.Commit, sitting: Sitting) -> None:
        story, spec = sitting.story, sitting.lesson.spec
        card = card_of(story, spec)
        asked = spec.question_of(card)
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

    # What is done

    def _hint(self, sitting: Sitting) -> None:
        story, spec = sitting.story, sitting.lesson.spec
        card, index = card_of(story, spec), index_of(story, spec)
        if story.hints.get(index, 0) < len(card.steps_of_help):
            self._tell(sitting, Hinted(index))

    def _use(self, found: Wanted, sitting: Sitting) -> None:
        match found:
            case Layer(key=key):
                self._rooms.view.show(key, None)
            case Headings(frame=frame):
                self._rooms.view.show(None, frame)
            case OpenSide():
                self._rooms.open_side()
            case Watch():
                self._rooms.watch()
            case StartLessonAgain():
                again = request_to_begin(sitting.lesson, sitting.story.language, False)
                self._ask(again)
            case _:
                self._ask(found)

    def _tell(self, sitting: Sitting, act: Act) -> None:
        self._desk.tell(sitting.story, act)

    def _ask(self, request: Request) -> None:
        """Ask for something at the moment that this browser looks at; told in the card if not."""
        seen, ground = self._seen, self._ground
        assert seen is not None
        assert ground is not None
        self._rooms.asks.take(request, self._refused, seen, ground, time.perf_counter())

    def _refused(self, reason: str) -> None:
        """Say why something could not be done. Called in any thread."""
        self._say(reason)
        self._wake()
