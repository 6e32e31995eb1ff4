"""One browser in a lesson: what is true for it now, and the ways in which it asks for something."""

import json
import time
from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple

import viser

from app.lessons.story import is_locked, question_of, revealed_on
from app.lessons.words import Words, words_of
from app.live.requests import Request
from app.live.status import Status
from app.live.story import Act, Answered
from app.page.lesson.board import BoardAsk
from app.page.lesson.cards import Shown
from app.page.lesson.controls import Control
from app.page.lesson.desk import Desk, Sitting
from app.page.lesson.marked import Marked
from app.page.lesson.vote import key_of
from app.page.panels.inspection import Inspection
from app.page.panels.view import View
from app.page.time.asks import Asks
from app.page.time.outlook import Outlook
from app.page.time.panel import TimePanel
from app.page.time.walk import Ground
from app.player.classroom import NOTHING_FOUND, Classroom
from app.util.texts import for_terminal

_MOST_FAULT: Final = 2_000
"""Characters of what is said to be wrong."""
_SETTLED_S: Final = 0.4
"""After so long an answer that is not changed any more is told to the session."""


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


class Draft(NamedTuple):
    """An answer that is being given, and that the session does not know yet."""

    question: str
    value: str
    """As JSON."""
    given_s: float
    is_told: bool = False
    """Whether the session has been told, whose answer takes a moment."""


class Sitter:
    """Of one browser. The render loop alone has to do with it."""

    def __init__(
        self,
        client: viser.ClientHandle,
        desk: Desk,
        rooms: Rooms,
        n_viewers: Callable[[], int],
        wake: Callable[[], object],
    ) -> None:
        """Prepare.

        Args:
            client: the browser.
            desk: knows which lesson is on.
            rooms: what a lesson steers.
            n_viewers: browsers that see the session.
            wake: lets the render loop draw at once.
        """
        self.client, self.desk, self.rooms = client, desk, rooms
        self.n_viewers, self.wake = n_viewers, wake
        self.seen: Status | None = None
        """What is true for this browser; None before anything was shown."""
        self.live: Status | None = None
        """How the live run stands."""
        self.ground: Ground | None = None
        """What is known of the lines."""
        self.is_free = False
        """Whether this browser has chosen to see all that there is."""
        self.fault: str | None = None
        """What could not be done, and why."""
        self.draft: Draft | None = None
        self.controls: tuple[Control, ...] = ()
        """Those that the card has."""
        self.before: int | None = None
        """Of the lines that there were when this browser went back to before, the newest."""

    @property
    def sitting(self) -> Sitting | None:
        """The lesson that is on; None if none is."""
        return None if self.live is None else self.desk.sitting(self.live)

    @property
    def taught(self) -> Sitting | None:
        """The lesson that this browser is in; None if there is none, or it is free of it."""
        return None if self.is_free else self.sitting

    @property
    def words(self) -> Words:
        """What is said around a lesson's own texts, in the language of the one that is on."""
        story = None if self.live is None else self.live.story
        return words_of("en" if story is None else story.language)

    @property
    def class_shown(self) -> Classroom | None:
        """The class that this browser presents to; None if there is none, or another one does."""
        return self.rooms.classroom if self.rooms.presents() else None

    # What is asked for

    def ask(self, request: Request) -> None:
        """Ask for something at the moment that this browser looks at; told in the card if it
        cannot be."""
        assert self.seen is not None
        assert self.ground is not None
        now_s = time.perf_counter()
        self.rooms.asks.take(request, self._refused, self.seen, self.ground, now_s)

    def tell(self, sitting: Sitting, act: Act) -> None:
        """Have something done in the lesson."""
        self.desk.tell(sitting.story, act)

    def tell_draft(self) -> None:
        """Have the answer be kept that is being given.

        It is shown until the session has it: else the card would be without an answer for a moment,
        in which nothing can be committed.
        """
        draft, sitting = self.draft, self.sitting
        if draft is None or draft.is_told or sitting is None:
            return
        self.draft = draft._replace(is_told=True)
        self.tell(sitting, Answered(draft.question, draft.value))

    def settle_draft(self, now_s: float) -> None:
        """Have the answer be kept that is being given, once it is not changed any more."""
        draft = self.draft
        if draft is not None and draft.is_told and self.desk.is_answered:
            self.draft = None
        elif draft is not None and now_s - draft.given_s >= _SETTLED_S:
            self.tell_draft()

    def say(self, text: str) -> None:
        """Say in the card what could not be done, or what was."""
        text = for_terminal(text)
        self.fault = (text[:1].upper() + text[1:])[:_MOST_FAULT]

    def _refused(self, reason: str) -> None:
        """Say why something could not be done. Called in any thread."""
        self.say(reason)
        self.wake()

    # What is known

    def shown(self, sitting: Sitting) -> Shown | None:
        """The guess of which the card tells what came of it; None if it tells of none."""
        story, spec = sitting.story, sitting.lesson.spec
        guess = revealed_on(sitting.index, story, spec)
        if guess is None:
            return None
        asked = spec.in_language(story.language).steps[guess.place].question
        assert asked is not None
        spread = self.desk.spread_of(sitting, guess)
        given, has_come = story.answers[guess.card.id], self.desk.has_come(story, guess)
        is_waited_for = given.shown is not None or has_come or sitting.card.see is not None
        return Shown(guess, asked, given, spread, has_come) if is_waited_for else None

    def draft_of(self, sitting: Sitting) -> str | None:
        """The answer to the card's question that is being given, as JSON."""
        question = question_of(sitting.card)
        draft = self.draft
        if draft is None or draft.question != question or is_locked(sitting.story, question):
            return None
        return draft.value

    def of_class(self, sitting: Sitting, question: str) -> Mapping[str, Any]:
        """What a class has answered to a question (``found`` of
        :class:`app.player.classroom.Classroom`), where this browser presents that."""
        classroom = self.class_shown
        key = key_of(sitting, question)
        return NOTHING_FOUND if classroom is None else classroom.found(key)


def drafted(question: str, value: Any) -> Draft:
    """An answer that is being given now."""
    return Draft(question, json.dumps(value), time.perf_counter())
