"""Hunts that one browser is shown slowly: the first ones of the session, and any wished for.

The first ones are the learner's own, and it is the session that slows them down. One that is
watched is made here of what is known at that moment, without random moves, and nothing is learned
in it; the learner goes on meanwhile, and its own predator is not drawn in that browser.
"""

import random
from collections.abc import Callable
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np

from app.charts.page.svg import frame_html, link
from app.explain.cell import policy_of
from app.live.opening import Opening, seen_at
from app.live.requests import SkipOpening
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page import keys
from app.page.inbox import Ask, Inbox, Intent
from app.page.scene.hunt import Chase
from app.page.scene.parts import Viewer
from app.page.slots import slot_html
from app.page.widgets import assign
from app.picture.look import Look, heading_shown
from app.picture.theme import Theme
from app.player.hunts import Way
from app.server.calls import Calls, address_of
from app.words.numbers import counted
from learners import hunts
from learners.hunts import Hunt
from sim.bits import U
from sim.spec import WorldSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT, World, start_of_trial

_SKIP, _WATCH, _STOP = "skip", "watch", "stop"
_CAME_TO: Final = {
    CAPTURE: "Caught after",
    FLIGHT: "Noticed after",
    TIMEOUT: "Out of time after",
}


class _Watched(NamedTuple):
    """A hunt that is being watched."""

    hunt: Hunt
    heading: int
    trial: int
    """Trials that had ended when it was made."""
    world: World
    spec: WorldSpec
    seen_s: np.ndarray
    """(step,): when each step is seen, on the clock of the render loop."""

    def way(self, now_s: float) -> Way:
        """What is seen of it by now."""
        steps = int(np.searchsorted(self.seen_s, now_s, side="right"))
        outcome = self.hunt.outcome if steps == self.hunt.steps else None
        return Way(self.hunt.cells[: steps + 1], self.heading, outcome)


def hunt_from_anywhere(snapshot: Snapshot, now_s: float) -> _Watched:
    """A hunt with what is known at a moment, from a start as trials have, shown from ``now_s`` on.

    No one hunt is like the one before, nor is any of them one of the learner's.
    """
    world, starts = snapshot.world, random.getrandbits(63)
    cell, heading = (int(part) for part in start_of_trial(world, U(starts), 0))
    hunt = hunts.hunt(world, policy_of(snapshot), cell, heading, seed=starts)
    return _Watched(
        hunt,
        heading,
        snapshot.trial,
        world,
        snapshot.spec.world,
        now_s + seen_at(hunt.steps),
    )


class Hunts:
    """What one browser is shown of them, and what it can do about it."""

    def __init__(
        self,
        client: Any,
        ask: Ask,
        calls: Calls,
        inbox: Inbox,
        wake: Callable[[], object],
    ) -> None:
        """``client`` is the browser's handle; ``wake`` lets the render loop draw at once."""
        self._client: Viewer = client
        self._skip = partial(ask, client, SkipOpening())
        self._calls, self._wake = calls, wake
        self._secret = calls.enter(lambda words: inbox.put(partial(self._called, words)))
        self._wanted = False
        """Whether another hunt is to be made."""
        self._watched: _Watched | None = None
        self._chase: tuple[Theme, Chase] | None = None
        client.gui.add_html(frame_html())
        self._slot = client.gui.add_html("")
        command = client.gui.add_command("Watch a hunt", hotkey=keys.WATCH.hotkey)
        command.on_trigger(Intent(lambda _, __: self._called(_WATCH)))

    @property
    def is_watching(self) -> bool:
        """Whether there is another hunt on this browser's board than the learner's."""
        return self._wanted or self._watched is not None

    def watch(self) -> None:
        """Show another hunt."""
        self._called(_WATCH)

    def leave(self) -> None:
        """Answer no more calls of this browser."""
        self._calls.leave(self._secret)

    def update(self, status: Status, look: Look, now_s: float) -> None:
        """Show a moment."""
        if self._wanted:
            self._wanted = False
            self._watched = hunt_from_anywhere(status.snapshot, now_s)
        watched = self._watched
        if watched is not None and watched.world.size != status.snapshot.world.size:
            # It lies on a board that is not there any more.
            watched = self._watched = None
        way = None if watched is None else watched.way(now_s)
        assign(self._slot, "content", slot_html("opening", self._said(status.opening, way)))
        if self._chase is not None and (watched is None or self._chase[0] != look.theme):
            self._chase[1].remove()
            self._chase = None
        if watched is not None and way is not None:
            self._draw(watched, way, look, heading_shown(look, status.snapshot.heading))

    def _draw(self, watched: _Watched, way: Way, look: Look, shown: int) -> None:
        with self._client.atomic():
            if self._chase is None:
                self._chase = look.theme, Chase(self._client.scene, "watched", look.theme)
            _, chase = self._chase
            here = chase.show(watched.world, watched.spec, look, way, shown)
            chase.name(watched.spec, look, way, here, shown)

    def _said(self, opening: Opening | None, way: Way | None) -> str:
        """What is said about hunts, with what one can do."""
        if self._watched is not None and way is not None:
            text = f"A hunt with what it knows at trial {self._watched.trial:,}."
            if way.outcome is not None:
                steps = counted(self._watched.hunt.steps, "step")
                text = f"{_CAME_TO[way.outcome]} {steps}."
            return self._told(text, (_WATCH, "Another"), (_STOP, "Stop"))
        if opening is None:
            return self._told("", (_WATCH, "Watch a hunt"))
        text = f"Its first hunts, slowed down to be seen: {opening.hunt} of {opening.of}."
        if opening.rising:
            text = "From here on it learns faster and faster."
        return self._told(text, (_SKIP, "Skip"))

    def _told(self, text: str, *choices: tuple[str, str]) -> str:
        address = partial(address_of, self._secret)
        links = "".join(f" {link(address, words, label)}" for words, label in choices)
        said = f"<span>{text}</span>" if text else ""
        return f'<p class="pounce-hunts">{said}{links}</p>'

    def _called(self, words: str) -> None:
        """Somebody clicked or pressed a key; whatever it says comes from the network."""
        if words == _SKIP:
            self._skip()
        elif words == _WATCH:
            self._wanted = True
        elif words == _STOP:
            self._wanted, self._watched = False, None
        self._wake()
