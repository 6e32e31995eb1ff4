"""What was just done to the learner by hand, said on the board, with the way to undo it.

It is one learner for all browsers, so all are told, of the newest change alone, and for a while. Of
what is done at a moment of the past the bar says it, to the browser that did it.
"""

import time
from typing import Final, NamedTuple

import viser

from app.explain.called import run_on_board
from app.explain.commands import command_in_words
from app.live.requests import GoBack, MakeLive, Request
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page import keys
from app.page.panels.steering import undoable
from app.page.slots import slot_html
from app.page.widgets import assign
from app.server.callbacks import RefusedError
from app.util.html import element
from learners.commands import Event, SetSchedule, Undo

SHOWN_S: Final = 15.0
"""How long it stands there: time to read it, and to get to the button by the keyboard."""


class Saying(NamedTuple):
    """What is said, and how it is undone."""

    text: str
    generation: int
    """Of the run that it is about."""
    way_back: Request | None = None
    label: str = "Undo"
    """Of the button that undoes it."""


def saying_html(saying: Saying | None) -> str:
    """What the stage shows of it."""
    if saying is None:
        return ""
    button = ""
    if saying.way_back is not None:
        button = element("button", saying.label, type="button", **{"data-press": keys.UNDO.code})
    return f"{element('span', saying.text)}{button}"


def _of_change(snapshot: Snapshot, event: Event) -> Saying:
    """What to say of a command that was given by hand."""
    if isinstance(event.command, Undo):
        taken_back = snapshot.control.history[event.command.number]
        text = f"Undone: {command_in_words(taken_back.command)}"
        before = next(iter(undoable(snapshot.control.history)), None)
        if before is None:
            return Saying(text, snapshot.generation)
        label = f"Undo too: {command_in_words(before.command)}"
        return Saying(text, snapshot.generation, Undo(before.number), label)
    words = command_in_words(event.command)
    # A Greek letter is a symbol, and has no other at the start of a sentence.
    words = words[:1].upper() + words[1:] if words[:1].isascii() else words
    can_be_undone = event in undoable(snapshot.control.history)
    return Saying(
        f"{words} at trial {event.trial:,}",
        snapshot.generation,
        Undo(event.number) if can_be_undone else None,
    )


def _of_run(status: Status, is_back: bool) -> Saying:
    """What to say of another run that has come on the board."""
    snapshot = status.snapshot
    if status.opened is not None:
        text = f"Opened: {run_on_board(status)}"
    elif is_back:
        text = f"Back to {run_on_board(status)}, trial {snapshot.trial:,}"
    elif status.is_shared:
        text = f"Opened: {snapshot.preset}, seed {snapshot.seed}, trial {snapshot.trial:,}"
    elif status.is_resumed:
        text = f"Resumed: {run_on_board(status)}, trial {snapshot.trial:,}"
    else:
        edited = any(isinstance(e.command, SetSchedule) for e in snapshot.control.history)
        plan = ", with the schedule as it was drawn" if edited else ""
        text = f"Started again: {snapshot.preset}, seed {snapshot.seed}{plan}"
    way_back = None if status.aside is None or is_back else GoBack()
    return Saying(text, snapshot.generation, way_back, f"Back to {status.aside}")


def _of_line(status: Status, former: int) -> Saying:
    """What to say of another line of the tree that has become the live run."""
    names = {line.number: line.name for line in status.lines}
    snapshot = status.snapshot
    text = f"Live now: {names[snapshot.generation]}, trial {snapshot.trial:,}"
    way_back = MakeLive(former)
    return Saying(text, snapshot.generation, way_back, f"Make {names[former]} live again")


def _undone_there(snapshot: Snapshot) -> Request:
    """What takes back the newest change of a moment that is not now, if it was made there."""
    newest = next(iter(undoable(snapshot.control.history)), None)
    if newest is None or newest.step != snapshot.step:
        raise RefusedError(
            "nothing was done by hand at this moment; Steer lists all changes up to here, and End"
            " goes back to the live run"
        )
    return Undo(newest.number)


class Said:
    """The stage's slot for it, in all browsers."""

    def __init__(self, gui: viser.GuiApi, status: Status) -> None:
        snapshot = status.snapshot
        self._slot = gui.add_html(slot_html("said", ""))
        self._saying: Saying | None = None
        self._until_s = 0.0
        self._generation = self._newest = snapshot.generation
        """Of the run that is shown, and the highest that was."""
        self._known = {snapshot.generation: _by_hand(snapshot)}
        """Of each run that was shown, what was done to it last when it was."""

    def update(self, status: Status, now_s: float) -> None:
        """Say what is new; ``now_s`` is of the clock ``time.monotonic``."""
        saying = self._found(status)
        if saying is not None:
            self._saying, self._until_s = saying, now_s + SHOWN_S
        elif now_s > self._until_s:
            self._saying = None
        assign(self._slot, "content", slot_html("said", saying_html(self._saying)))

    def undo(self, status: Status) -> Request:
        """What takes back what is said, or what was done at the very moment that is looked at.

        Args:
            status: what is true for the browser that wants it.

        Raises:
            RefusedError: nothing is said, or was done there; or it cannot be taken back.
        """
        if status.behind is not None:
            return _undone_there(status.snapshot)
        # What was done since the last frame was done just now, too.
        self.update(status, time.monotonic())
        saying = self._saying
        if saying is None or saying.generation != status.snapshot.generation:
            raise RefusedError(
                "nothing was done just now; Steer lists all changes by hand, and Run has the way"
                " back to the run before"
            )
        if saying.way_back is None:
            raise RefusedError("there is nothing else to take back")
        return saying.way_back

    def _found(self, status: Status) -> Saying | None:
        """What was done since the last moment, in the live run."""
        if status.behind is not None:
            return None
        snapshot = status.snapshot
        generation, newest = snapshot.generation, _by_hand(snapshot)
        is_known, known = generation in self._known, self._known.get(generation)
        self._known[generation] = newest
        former, self._generation = self._generation, generation
        is_back, self._newest = generation < self._newest, max(self._newest, generation)
        # A run that is back may have been changed before anybody has seen that it is.
        if newest is not None and is_known and newest != known:
            return _of_change(snapshot, newest)
        if generation == former:
            return None
        if {former, generation} <= {line.number for line in status.lines}:
            return _of_line(status, former)
        return _of_run(status, is_back)


def _by_hand(snapshot: Snapshot) -> Event | None:
    """What was done by hand last, were it to make void what came before."""
    history = snapshot.control.history
    return next((event for event in reversed(history) if event.author == "hand"), None)
