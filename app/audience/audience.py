"""The audience of a lab: who looks, what each of them is shown, and how often.

A thread of its own paints each view once, however many look at it, and hands it to the port
(:mod:`app.server.watchers`). The lab tells it how things stand, and waits for nothing. The
presenter's view comes first; all others together have a small share of one processor, and are drawn
the less often the more of them there are.
"""

import asyncio
import logging
import secrets
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final

from app.audience import pictures
from app.audience.offered import offer_of
from app.audience.owners import Owners
from app.audience.past import Rarely
from app.audience.pictures import ORDER, Parts, by_what_they_miss, letter_of, part
from app.audience.room import Room, lesson_part
from app.audience.seats import MOST_SEATS, Seat, Seats
from app.audience.views import Seen, Subject, View
from app.audience.wishes import (
    Act,
    Answer,
    Follow,
    LookAround,
    LookOwn,
    Wish,
    look_of,
    offered_step,
    themed,
)
from app.live.past import Past
from app.live.places import Place
from app.live.status import Status
from app.picture.layer import Extras
from app.picture.look import Look
from app.player.boards import world_key
from app.player.presented import OwnLearners, Presented
from app.server.origin import Authority
from app.server.watchers import (
    MOST_GUESSES,
    MOST_SHORT_GUESSES,
    MOST_WATCHERS,
    Watcher,
    Watchers,
)
from sim.spec import WorldSpec

ASKED_S: Final = 0.12
"""Between two pictures at least, where the presenter has done something."""
COUNTED_S: Final = 0.15
"""After an answer of a class, until whoever gave it is told that it counts."""
_LEAST_S: Final = 0.03
_PLAIN_S: Final = 0.25
"""Between two at least while the learner goes on."""
_OVER_S: Final = 1.5
_WORDS_S: Final = 1.0
_BAR_S: Final = 5.0
_BAR_ASKED_S: Final = 0.5
OTHERS_SHARE: Final = 0.1
"""Of one processor, for all who look at something else than the presenter."""
_MOST_VIEWS: Final = 64
"""Views that are kept for those who look around; each holds a moment, of some hundred kilobytes."""
_IDLE_S: Final = 1.0

log = logging.getLogger(__name__)


class Audience:
    """All who look at one lab. Methods may be called from any thread."""

    def __init__(
        self,
        past_of: Callable[[int], Past | None],
        host: str,
        port: int,
        *,
        code: str | None = None,
        names: Sequence[Authority] = (),
        most: int | None = None,
        is_class: bool = False,
        has_own: bool = False,
    ) -> None:
        """Open the port.

        Args:
            past_of: the past of a line, by its number.
            host: address to listen on.
            port: port to listen on.
            code: without which nobody is let in; None if whoever comes is.
            names: under which the port is reached besides.
            most: so many may look, if it is not as many as usual.
            is_class: whether those who look have seats, and answer what the presenter asks.
            has_own: whether each of them has a learner of their own.

        Raises:
            OSError: the host is not an address of this machine, or the port is not free.
        """
        self.code: str | None = code
        self._addresses: tuple[str, ...] | None = None
        self._past = Rarely(past_of, self._wake)
        self._changed = threading.Event()
        self._closed = self._wakes_soon = False
        self._live: Status | None = None
        self._presented: Presented | None = None
        self._views: dict[Seen, View] = {}
        self._worlds: dict[str, bytes] = {}
        """What is sent of worlds, by their keys."""
        self._others_s = 0.0
        """When one of those may be painted next that is not the presenter's."""
        self._lab = part("lab", {"lab": secrets.token_urlsafe(6)})
        self.seats: Seats | None = None
        if is_class or has_own:
            self.seats = Seats(MOST_SEATS if most is None else most)
        self.room: Room | None = None
        if is_class and self.seats is not None:
            self.room = Room(self.seats, self._taken, self._wake, self._joined)
        self.watchers = Watchers(
            host,
            port,
            Wish,
            self._come,
            names=names,
            code=code,
            most=MOST_WATCHERS if most is None else most,
            most_guesses=MOST_SHORT_GUESSES if is_class else MOST_GUESSES,
            seats=self.seats,
            acts=Act if self.seats is not None else None,
            act=self._heard,
        )
        self.owners: Owners | None = None
        if has_own:
            self.owners = Owners(lambda: self.watchers.all, self.watchers.send)
        self._offered: tuple[object, ...] = ()
        """Of what own learners were last told how they begin."""
        self._thread = threading.Thread(target=self._work, name="audience", daemon=True)
        self._thread.start()

    @property
    def addresses(self) -> tuple[str, ...]:
        """Addresses to open, that on this machine first."""
        if self._addresses is None:
            # They are tried, which takes a while.
            self._addresses = self.watchers.addresses
        return self._addresses

    @property
    def n_watchers(self) -> int:
        """How many look."""
        return len(self.watchers.all)

    @property
    def own(self) -> OwnLearners | None:
        """How the learners stand that those have of their own who look; None if they have none."""
        return None if self.owners is None else self.owners.overview

    @property
    def classroom(self) -> Room | None:
        """They as a class that answers; None if they only look."""
        return self.room

    def show(self, live: Status, presented: Presented | None) -> None:
        """Show them how the run stands, and what the presenter sees; None before one has come."""
        if self.owners is not None:
            self._offer(self.owners, live)
        former, self._live, self._presented = self._presented, live, presented
        if self.room is not None and presented is not None and not presented.is_away:
            self.room.poll.show(None if presented.card is None else presented.card.id)
        if (former and _subject(former)) != (presented and _subject(presented)):
            self._wake()

    def close(self) -> None:
        """Let nobody look any more."""
        self._closed = True
        self._wake()
        self._thread.join(timeout=2.0)
        self._past.stop()
        if self.owners is not None:
            self.owners.close()
        self.watchers.close()

    def _wake(self) -> None:
        self._changed.set()

    def _wake_soon(self) -> None:
        """Have those be told that it counts who have answered; called on the event loop."""
        if not self._wakes_soon:
            self._wakes_soon = True
            asyncio.get_running_loop().call_later(COUNTED_S, self._wake_now)

    def _wake_now(self) -> None:
        self._wakes_soon = False
        self._wake()

    def _come(self) -> None:
        """Somebody has come, gone or wished."""
        self._wake()
        if self.owners is not None:
            self.owners.look()

    def _heard(self, watcher: Watcher, act: Act) -> None:
        if isinstance(act, Answer):
            if self.room is not None and self.room.answer(watcher.seat, act):
                self._wake_soon()
        elif self.owners is not None:
            self.owners.tap(watcher, act)

    def _offer(self, owners: Owners, live: Status) -> None:
        """Have own learners begin as the live run did, or as the lesson says that is on."""
        snapshot = live.snapshot
        of = (snapshot.preset_spec, snapshot.preset, snapshot.seed, live.opened, live.story)
        # Told with each frame, and long to compare.
        if not _are_same(of, self._offered):
            self._offered = of
            offer = offer_of(live)
            if offer is not None:
                owners.offer(offer)

    def _taken(self) -> Iterator[Seat]:
        return (watcher.seat for watcher in self.watchers.all if watcher.seat is not None)

    def _joined(self) -> dict[str, str | None]:
        # Another machine cannot reach the address that this one has for itself.
        return {"code": self.code, "address": (self.addresses[1:] or self.addresses)[0]}

    # --- In the thread ----------------------------------------------------------------------------

    def _work(self) -> None:
        while not self._closed:
            began_s = time.perf_counter()
            try:
                due_s = self._turn(began_s)
            except Exception:
                # A view that cannot be painted is nobody's who presents or learns.
                log.exception("a view of the audience could not be painted")
                due_s = began_s + _IDLE_S
            # However many come and wish, this is done so often and not more.
            time.sleep(_LEAST_S)
            self._changed.wait(max(due_s - time.perf_counter(), 0.0))
            self._changed.clear()

    def _turn(self, now_s: float) -> float:
        """Paint what is due, and send it; returns when to look again."""
        live, presented, watchers = self._live, self._presented, self.watchers.all
        groups = self._grouped(watchers, live, presented)
        due_s = now_s + _IDLE_S
        if presented is not None and live is not None:
            for seen in groups:
                view = self._views.setdefault(seen, View())
                if seen.is_presenters:
                    due_s = min(due_s, self._paint_if_due(view, seen, live, presented, now_s))
            due_s = min(due_s, self._paint_another(groups, live, presented, now_s))
        own = [watcher for watcher in watchers if isinstance(watcher.wish, LookOwn)]
        self._send(groups, own)
        self._tidy(groups)
        return due_s

    def _grouped(
        self, watchers: Sequence[Watcher], live: Status | None, presented: Presented | None
    ) -> dict[Seen, list[Watcher]]:
        groups: dict[Seen, list[Watcher]] = {}
        for watcher in watchers:
            wish = watcher.wish
            if wish is not None and not isinstance(wish, LookOwn):
                groups.setdefault(self._seen(wish, live, presented), []).append(watcher)
        places = {seen.place for seen in groups if seen.place is not None}
        if live is not None:
            name = live.snapshot.preset
            self._past.want((place, name) for place in places)
        return groups

    def _seen(
        self, wish: Follow | LookAround, live: Status | None, presented: Presented | None
    ) -> Seen:
        if isinstance(wish, Follow) or live is None or presented is None:
            return Seen(None, wish.dark)
        look = look_of(wish)
        return Seen(look, wish.dark, self._place(wish, live, presented))

    def _place(self, wish: LookAround, live: Status, presented: Presented) -> Place | None:
        line = int(presented.moment["line"])
        end_step = _end_of(line, live)
        if wish.step is None or end_step is None:
            return None
        if line == live.snapshot.generation and wish.step >= end_step:
            return None
        return Place(line, offered_step(wish.step, end_step, presented.events))

    # Painting

    def _paint_if_due(
        self, view: View, seen: Seen, live: Status, presented: Presented, now_s: float
    ) -> float:
        """Paint the presenter's view if that is due; returns when it is due next."""
        subject = _subject(presented)
        if view.subject != subject:
            due_s = view.at_s + ASKED_S
        else:
            due_s = max(view.due_s, view.at_s + _PLAIN_S)
        if now_s < due_s:
            return due_s
        look = themed(presented.look, seen.dark)
        former, view.subject = view.subject, subject
        asked = former != subject
        view.is_answer = former is None or former.done != subject.done
        stand = {"follows": True, "away": presented.is_away}
        self._paint(view, presented.status, look, presented.extras, presented, asked, now_s)
        self._around(view, stand, presented.moment, live)
        return now_s + _PLAIN_S

    def _paint_another(
        self,
        groups: Mapping[Seen, Sequence[Watcher]],
        live: Status,
        presented: Presented,
        now_s: float,
    ) -> float:
        """Paint one of the other views, if there is time; returns when to look again."""
        others = [seen for seen in groups if not seen.is_presenters]
        if not others:
            return now_s + _IDLE_S
        if now_s < self._others_s:
            return self._others_s
        waiting = sorted(others, key=lambda seen: self._views[seen].at_s)
        for seen in waiting:
            view = self._views[seen]
            is_due = now_s >= max(view.due_s, view.at_s + _PLAIN_S)
            if is_due and self._paint_around(view, seen, live, presented, now_s):
                took_s = time.perf_counter() - now_s
                self._others_s = now_s + took_s / OTHERS_SHARE
                return self._others_s
        return now_s + _PLAIN_S

    def _paint_around(
        self, view: View, seen: Seen, live: Status, presented: Presented, now_s: float
    ) -> bool:
        """Paint what somebody looks at who looks around; whether anything had to be painted."""
        assert seen.look is not None
        shown = live
        if seen.place is not None:
            snapshot = self._past.at(seen.place)
            if snapshot is None:
                return False
            shown = live.seen_at(snapshot, playing=False)
        is_first = not view.parts
        self._paint(view, shown, seen.look, Extras(), presented, is_first, now_s)
        stand = {"follows": False, "away": presented.is_away}
        line = int(presented.moment["line"])
        self._around(view, stand, pictures.moment_on_bar(live, shown, seen.place, line), live)
        view.at_s = now_s
        return True

    def _paint(
        self,
        view: View,
        status: Status,
        look: Look,
        extras: Extras,
        presented: Presented,
        asked: bool,
        now_s: float,
    ) -> None:
        """Make those parts anew that are due."""
        view.at_s = now_s
        of = (status.snapshot, look, extras.success, extras.since, status.playing)
        if not _are_same(of, view.ground_of):
            view.ground_of = of
            view.parts["world"] = self._world_part(status.snapshot.spec.world)
            view.parts["ground"] = pictures.ground_part(status, look, extras)
        if not _are_same(of, view.over_of) and (asked or now_s - view.over_s >= _OVER_S):
            view.over_of, view.over_s = of, now_s
            view.parts["over"] = pictures.over_part(status, look, extras)
        words_of = (status, look)
        if not _are_same(words_of, view.words_of) and (asked or now_s - view.words_s >= _WORDS_S):
            view.words_of, view.words_s = words_of, now_s
            view.parts |= pictures.word_parts(status, look, extras)
        if presented.bar is not None and now_s - view.bar_s >= (_BAR_ASKED_S if asked else _BAR_S):
            view.bar_s = now_s
            view.parts["bar"] = part("bar", {"bar": presented.bar})

    def _world_part(self, world: WorldSpec) -> bytes:
        key = world_key(world)
        if key not in self._worlds:
            # There is one at a time, or two where somebody looks at another moment.
            self._worlds = dict(list(self._worlds.items())[-1:])
            self._worlds[key] = pictures.world_part(world)
        return self._worlds[key]

    def _around(
        self,
        view: View,
        stand: Mapping[str, object],
        moment: Mapping[str, object],
        live: Status,
    ) -> None:
        view.parts["stand"] = part(
            "stand", {"begun": True, "own": self.owners is not None, **stand}
        )
        view.parts["moment"] = part("moment", moment)
        view.parts["offer"] = pictures.offer_part(live)

    # Sending

    def _send(self, groups: Mapping[Seen, Sequence[Watcher]], own: Sequence[Watcher]) -> None:
        """Send each what they have not been sent yet; to those who look at an ``own`` learner, what
        is not of the board."""
        letters: list[tuple[bytes, list[Watcher]]] = []
        told = {"lab": self._lab, "lesson": self._lesson_part()}
        waiting = {"stand": part("stand", {"begun": False})}
        for seen, watchers in groups.items():
            view = self._views.get(seen)
            has_begun = view is not None and bool(view.parts)
            parts = {**(view.parts if view is not None and has_begun else waiting), **told}
            if not has_begun and self._presented is not None:
                # What it had stays until there is something else.
                continue
            sizes: list[int] = []
            for missing, group in by_what_they_miss(parts, watchers, ORDER, self._theirs).items():
                letter = letter_of(content for _, content in missing)
                letters.append((letter, group))
                if all(kind != "lab" for kind, _ in missing):
                    sizes.append(len(letter))
            if view is not None and sizes:
                # However much the presenter has done, the run is seen to go on right after it.
                now_s = time.perf_counter()
                wait_s = 0.0 if view.is_answer else view.pace.wait_s(now_s, max(sizes))
                view.due_s, view.is_answer = now_s + wait_s, False
        parts = {"stand": part("stand", {"begun": True, "own": True}), **told}
        for missing, group in by_what_they_miss(parts, own, ORDER, self._theirs).items():
            letters.append((letter_of(content for _, content in missing), group))
        if letters:
            self.watchers.send(letters)

    def _lesson_part(self) -> bytes:
        card = None if self._presented is None else self._presented.card
        return lesson_part(card) if self.room is None else self.room.lesson_part(card)

    def _theirs(self, watcher: Watcher) -> Parts:
        return {} if self.room is None else self.room.parts_of(watcher.seat)

    def _tidy(self, groups: Mapping[Seen, Sequence[Watcher]]) -> None:
        """Forget views at which nobody looks, but for the newest of them."""
        unused = [seen for seen in self._views if seen not in groups]
        for seen in unused[: max(len(self._views) - _MOST_VIEWS, 0)]:
            del self._views[seen]


def _subject(presented: Presented) -> Subject:
    status, moment = presented.status, presented.moment
    done = (
        presented.look,
        presented.is_away,
        status.snapshot.generation,
        status.playing,
        status.answered,
        moment["live"],
        None if moment["live"] else moment["step"],
        presented.card,
    )
    return Subject(done, (status.error, presented.events))


def _end_of(line: int, live: Status) -> int | None:
    """Steps of a line that are known; None if it is not here."""
    if line == live.snapshot.generation:
        return live.snapshot.step
    return next((one.until_step for one in live.lines if one.number == line), None)


def _are_same(one: tuple[object, ...], other: tuple[object, ...]) -> bool:
    # Snapshots and what holds them can be long to compare.
    return len(one) == len(other) and all(
        a is b or (isinstance(a, Look | bool | int | str) and a == b)
        for a, b in zip(one, other, strict=True)
    )
