"""A lesson in one browser: its card, and what its frame is sent.

The lesson is one for all browsers, and so is where somebody is in it (:mod:`app.live.story`). What
a browser has for itself is whether it has chosen to be free of it, and an answer that is still
being given. All that is asked of the learner goes the way that a click in the panels goes.
"""

import json
from collections.abc import Callable
from functools import partial
from typing import Any, Final

import viser

from app.documents.lesson_cards import Card
from app.lessons.markup import html_of
from app.lessons.story import may_go_on, shown, sureness_in_words
from app.live.status import Status
from app.page import keys
from app.page.inbox import Inbox
from app.page.lesson.cards import asked_sent, check_sent, class_sent, reveal_sent
from app.page.lesson.controls import Control, StartLessonAgain, controls_of
from app.page.lesson.desk import Desk, Sitting
from app.page.lesson.dressing import Dressing
from app.page.lesson.hands import BACK_TO_RUN, Hands
from app.page.lesson.learn import listed
from app.page.lesson.messages import FromLesson
from app.page.lesson.sitter import Rooms, Sitter
from app.page.lesson.vote import card_told, class_question, key_of, outcome_of
from app.page.slots import slot_html
from app.page.time.walk import Ground
from app.page.widgets import assign
from app.picture.look import Look
from app.player.classroom import NOTHING_FOUND
from app.player.classroom import Card as CardTold
from app.server.channels import Channels

_TELLS: Final = frozenset(
    {
        "play",
        "step",
        "trial",
        "speed",
        "add_skill",
        "explore",
        "freeze",
        "plan",
        "undo",
        "start_again",
    }
)
"""Controls that would tell what comes of it before it is asked for, or change what is asked about:
they are there on cards on which something is to be done, until it is."""
_IN_LESSON: Final = "<i hidden data-lesson-now></i>"
"""Has the page's script show the card, and no more than the lesson shows."""


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
        self._sitter = Sitter(client, desk, rooms, n_viewers, wake)
        self._hands = Hands(self._sitter)
        self._dressing = Dressing(self._sitter, self._hands)
        self._sent: bytes | None = None
        self._channel = channels.enter(
            FromLesson,
            lambda message: inbox.put(partial(self._hands.take, message)),
            lambda: inbox.put(self._opened),
            page="lesson",
        )
        self._frame_html = str(self._channel.frame_html("Lesson"))
        # At the root of the main panel, which is there whatever tab is shown.
        self._slot = client.gui.add_html(slot_html("lesson", self._frame_html))

    def leave(self) -> None:
        """Send nothing more, and take nothing; an answer that is being given is kept."""
        self._sitter.tell_draft()
        self._channel.leave()

    @property
    def told(self) -> CardTold | None:
        """What an audience is told of the card that this browser sees; None if it sees none."""
        sitting = self._sitter.taught
        return None if sitting is None else card_told(sitting)

    @property
    def is_seen_closely(self) -> bool:
        """Whether it is asked what is known, or told why: no hunt is to cover that."""
        sitting = self._sitter.taught
        return sitting is not None and sitting.card.kind in ("see", "why")

    def _opened(self) -> None:
        """The frame is there, or there again, and knows nothing."""
        self._sent = None
        self._sitter.wake()

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
        sitter = self._sitter
        sitter.seen, sitter.live, sitter.ground = seen, live, ground
        if sitter.sitting is None:
            sitter.is_free = False
        sitting = sitter.taught
        self._dressing.update(sitting, seen.snapshot, look)
        self._hands.settle(sitting, live)
        sitter.settle_draft(now_s)
        hint = "" if sitting is None else _IN_LESSON
        assign(self._slot, "content", slot_html("lesson", self._frame_html + hint))
        state = {
            "list": listed(sitter.desk.library, live),
            "fault": sitter.fault or self._unreadable(live),
            "free": sitter.is_free,
            "lesson": self._lesson(sitter.sitting, seen, live),
        }
        encoded = json.dumps(state).encode()
        if encoded != self._sent:
            self._sent = encoded
            self._channel.send("lesson", state)

    def _unreadable(self, live: Status) -> str | None:
        """That a lesson is on that this pounce cannot read; None if none is."""
        is_unreadable = live.story is not None and self._sitter.sitting is None
        return self._sitter.words.say("fault.unreadable") if is_unreadable else None

    def take(self, message: Any) -> None:
        """Do what a hand did in the frame."""
        self._hands.take(message)

    def take_cell(self, cell: tuple[int, int] | None) -> bool:
        """Take a click on a cell of the board (:meth:`Dressing.take_cell`)."""
        return self._dressing.take_cell(cell)

    # What the frame is sent

    def _lesson(self, sitting: Sitting | None, seen: Status, live: Status) -> dict[str, Any] | None:
        if sitting is None:
            return None
        story, index = sitting.story, sitting.index
        spec = sitting.lesson.spec.in_language(story.language)
        names, card = shown(story, spec), spec.steps[index]
        acts = card.kind == "free" or (card.kind == "do" and not may_go_on(story, spec))
        if not acts and not live.playing:
            names -= _TELLS
        busy = self._hands.busy(sitting, live)
        self._sitter.controls = self._all_controls(sitting, names, seen)
        is_last = index + 1 == len(spec.steps)
        news = self._sitter.desk.library.news_of(story, sitting.words)
        sure = sureness_in_words(live.stories, sitting.words) if is_last else ""
        said = [news, sure]
        notes = card.notes if self._sitter.rooms.presents() else None
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
            "controls": [control.sent for control in self._sitter.controls],
            "inspect": self._dressing.inspected,
            "notes": None if notes is None else str(html_of(notes)),
            "next": may_go_on(story, spec) and busy is None,
            "last": is_last,
            "said": " ".join(filter(None, said)),
            "vote": self._vote(sitting),
        }

    def _vote(self, sitting: Sitting) -> dict[str, Any] | None:
        classroom = self._sitter.class_shown
        if classroom is None:
            return None
        told = self._sitter.shown(sitting)
        if told is not None and told.is_ready:
            outcome = outcome_of(reveal_sent(told, NOTHING_FOUND, sitting.words))
            classroom.come_out(key_of(sitting, told.guess.card.id), outcome)
        is_askable = class_question(sitting) is not None
        return classroom.state(key_of(sitting, sitting.card.id), is_askable)

    def _all_controls(
        self, sitting: Sitting, names: frozenset[str], seen: Status
    ) -> tuple[Control, ...]:
        if not sitting.has_run:
            wants = {None: StartLessonAgain()}
            label = sitting.words.say("control.back_to_run")
            return (Control(BACK_TO_RUN, label, "button", wants, main=True),)
        look = self._sitter.rooms.view.look
        began = 0 if sitting.began is None else sitting.began.trial
        return controls_of(names, sitting.card, seen, began, look, sitting.words)

    def _card(self, sitting: Sitting, busy: str | None) -> dict[str, Any]:
        story, index = sitting.story, sitting.index
        spec = sitting.lesson.spec.in_language(story.language)
        card, n_hints = spec.steps[index], story.hints.get(index, 0)
        verdict = self._sitter.desk.verdict
        told = self._sitter.shown(sitting)
        of_class = self._sitter.of_class(sitting, card.id if told is None else told.guess.card.id)
        return {
            "kind": card.kind,
            "id": card.id,
            "html": str(html_of(card.words)),
            "ask": asked_sent(card, spec, story, self._sitter.draft_of(sitting)),
            "reveal": class_sent(of_class)
            if told is None
            else reveal_sent(told, of_class, sitting.words),
            "check": check_sent(card, index in story.passed, verdict, sitting.words),
            "hints": [str(html_of(hint)) for hint in card.hints[:n_hints]],
            "next_hint": None if index in story.passed else _next_hint(card, n_hints),
            "busy": busy,
        }


def _next_hint(card: Card, n_hints: int) -> str | None:
    """Whether one hint more says something, or does it; None if there is no more."""
    left = len(card.steps_of_help) - n_hints
    if left <= 0:
        return None
    return "does" if left == 1 and card.does_it else "says"
