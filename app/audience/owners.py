"""The learners of a class, one for each seat that has asked for it, in one thread.

The thread answers what people do first, and shows each of them at once what came of it. Between
that it makes steps, a slice of each learner in turn, and paints the boards that have changed, the
one that has waited longest first. Each of the two has a share of one processor and no more, for the
presenter's learner and page come before; and a learner that nobody looks at, or touches, is put
away. None of them has anything to do with the session.
"""

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Final

from app.audience.desk import Desk
from app.audience.offered import Offer
from app.audience.own import Kept, Own
from app.audience.own_view import ORDER, OwnView, Seat, own_part, seatless_part, waiting_part
from app.audience.pictures import Parts, by_what_they_miss, letter_of
from app.audience.taps import (
    AddOwn,
    AgainOwn,
    ExploreOwn,
    FreezeOwn,
    PlayOwn,
    SpeedOwn,
    StepOwn,
    Tap,
    TrialOwn,
)
from app.audience.wishes import LookOwn
from app.player.presented import FEWEST_SHOWN, OwnLearners
from app.server.turnstile import Turnstile
from app.server.watchers import Watcher
from learners.commands import CommandError

LEARNING_SHARE: Final = 0.35
"""Of one processor, for the steps of all of them."""
MAKING_SHARE: Final = 0.5
"""The same for those that are made again, for whom somebody waits."""
PAINTING_SHARE: Final = 0.25
"""The same for boards that nobody has asked for by doing something."""
MOST_AWAKE: Final = 64
"""Learners that are not put away; each holds some two megabytes."""
MOST_DESKS: Final = 400
"""Seats whose learners are kept; the one that was used the longest time ago makes room."""
REST_S: Final = 600.0
"""After so long a learner that nobody has touched is put away, though a page of it is open."""
BRIEF_REST_S: Final = 60.0
"""The same where another one waits for its place."""
GONE_S: Final = 30.0
"""After so long without a page it is put away."""

_TICK_S: Final = 0.1
"""Between two slices of one learner."""
_MOST_OWED_S: Final = 0.3
"""What is owed beyond this is forgiven, so that there are no bursts."""
_SLICE_STEPS: Final = 50_000
"""Made at once by one that is made again: some two milliseconds."""
ASKED_S: Final = 0.15
"""Between two pictures of one board at least, where somebody does something."""
_MOST_DEBT_S: Final = 0.5
"""What painting may be behind its share, for those who do something."""
_PAINT_S: Final = 0.25
"""Between two pictures of one board at least, while nobody does anything."""
_IDLE_S: Final = 0.5
_LEAST_S: Final = 0.01
"""Between two turns, unless somebody does something."""
_BEHIND_S: Final = 0.03
"""Before a page is tried again that has not taken in what came before."""
_OVERVIEW_S: Final = 1.0
_MOST_WAITING: Final = 2_000
"""Taps of all seats that have not been answered; far more than a class can make."""
_MOST_HELD: Final = 8
"""Taps of one seat whose learner is on its way."""

_CONTROL_OF: Final[dict[type, str]] = {
    PlayOwn: "play",
    StepOwn: "step",
    TrialOwn: "trial",
    SpeedOwn: "speed",
    AddOwn: "add_skill",
    ExploreOwn: "explore",
    FreezeOwn: "freeze",
    AgainOwn: "start_again",
}
_RESTS: Final = "It rests, as nobody has touched it for a while. Whatever you press wakes it."
_ANEW: Final = "The presenter has begun something else, so your learner began anew."
_HOLDS: Final = "The presenter asks what will come. Your learner waits until that is answered."
_BROKEN: Final = "An error stopped your learner, so it began anew."

log = logging.getLogger(__name__)


class Owners:
    """All of them. Methods may be called from any thread."""

    def __init__(
        self,
        watchers: Callable[[], Sequence[Watcher]],
        send: Callable[[Iterable[tuple[bytes, Sequence[Watcher]]]], object],
    ) -> None:
        """Begin to work.

        Args:
            watchers: those who look now; of one that has a seat, ``seat`` is a :class:`Seat`.
            send: sends letters to some of them.
        """
        self._watchers, self._send = watchers, send
        self._offer: Offer | None = None
        self._told: Offer | None = None
        """What pages were told last that they can do."""
        self._desks: dict[Seat, Desk] = {}
        self._tapped: deque[tuple[Seat, Tap]] = deque()
        self._closed = False
        self._overview = OwnLearners(0, 0, ())
        self._overview_s = 0.0
        self._turn_of = 0
        self.steps_made = 0
        """By all of them that have learned on; not what was made again."""
        self._learning = Turnstile(LEARNING_SHARE, 0.05)
        self._making = Turnstile(MAKING_SHARE, 0.2)
        self._painting = Turnstile(PAINTING_SHARE, 0.05)
        self._learn_s = self._make_s = self._paint_s = 0.0
        """When each may go on."""
        self._changed = threading.Event()
        self._thread = threading.Thread(target=self._work, name="own learners", daemon=True)
        self._thread.start()

    # What others do

    def offer(self, offer: Offer) -> None:
        """Have all learners begin so, and their seats do this with them."""
        if offer != self._offer:
            self._offer = offer
            self.look()

    def tap(self, watcher: Watcher, tap: Tap) -> None:
        """Do what the seat of a page has asked for."""
        seat = watcher.seat
        if seat is not None and len(self._tapped) < _MOST_WAITING:
            self._tapped.append((seat, tap))
            self.look()

    def look(self) -> None:
        """See who is there, and what they wish."""
        self._changed.set()

    def learner_of(self, seat: Seat) -> Own | Kept | None:
        """The learner of a seat, to be looked at alone; None if it has none."""
        desk = self._desks.get(seat)
        return None if desk is None else desk.own or desk.kept

    @property
    def overview(self) -> OwnLearners:
        """How they stand, without saying whose any of them is."""
        return self._overview

    def close(self) -> None:
        """End all of them."""
        self._closed = True
        self.look()
        self._thread.join(timeout=2.0)

    # --- In the thread ----------------------------------------------------------------------------

    def _work(self) -> None:
        while not self._closed:
            try:
                due_s = self._turn(time.perf_counter())
            except Exception:
                # What goes wrong with one of them must not end the others.
                log.exception("own learners were held up")
                due_s = time.perf_counter() + _IDLE_S
            self._changed.wait(max(due_s - time.perf_counter(), 0.0))
            self._changed.clear()

    def _turn(self, now_s: float) -> float:
        """Do what is due; returns when to look again."""
        offer = self._offer
        if offer is None:
            return now_s + _IDLE_S
        self._see(offer, now_s)
        if offer != self._told:
            self._told = offer
            for desk in self._desks.values():
                if desk.own is not None:
                    self._stand(desk, offer, desk.own)
        self._answer(offer, now_s)
        due_s = min(
            self._make_again(offer),
            float("inf") if offer.holds else self._learn(),
            self._paint(offer),
            now_s + _IDLE_S,
        )
        self._sum_up(now_s)
        return now_s if self._tapped else max(due_s, now_s + _LEAST_S)

    # Who is there

    def _see(self, offer: Offer, now_s: float) -> None:
        pages: dict[Seat, list[Watcher]] = {}
        seatless: list[Watcher] = []
        for watcher in self._watchers():
            if watcher.seat is not None:
                pages.setdefault(watcher.seat, []).append(watcher)
            elif isinstance(watcher.wish, LookOwn):
                seatless.append(watcher)
        self._send_to(seatless, {"own": seatless_part()})
        # Where a class has ended nothing is kept of it.
        for seat in [seat for seat in self._desks if not seat.is_taken]:
            del self._desks[seat]
        for seat, watchers in pages.items():
            looking = [watcher for watcher in watchers if isinstance(watcher.wish, LookOwn)]
            desk = self._desks.get(seat)
            if desk is None:
                if not looking:
                    continue
                desk = self._desks[seat] = Desk(seat, offer.beginning, now_s)
            desk.there_s = now_s
            if looking != desk.looking:
                desk.looking, desk.is_stale, desk.is_behind = looking, True, True
        for seat, desk in self._desks.items():
            if seat not in pages:
                desk.looking = []
                if desk.own is not None and now_s - desk.there_s >= GONE_S:
                    desk.put_away(rests=False)
        self._wake_and_put_away(offer, now_s)

    def _wake_and_put_away(self, offer: Offer, now_s: float) -> None:
        awake = [desk for desk in self._desks.values() if desk.own is not None]
        for desk in awake:
            if desk.beginning != offer.beginning:
                desk.notice = _ANEW
                desk.begin(offer.beginning)
            elif now_s - desk.used_s >= REST_S:
                self._put_to_rest(desk, offer)
        for desk in self._desks.values():
            if desk.own is None and desk.looking and not desk.rests:
                self._wake(desk, offer, now_s)
        while len(self._desks) > MOST_DESKS:
            del self._desks[min(self._desks, key=lambda seat: self._desks[seat].used_s)]

    def _put_to_rest(self, desk: Desk, offer: Offer) -> None:
        assert desk.own is not None
        desk.own.playing, desk.notice = False, _RESTS
        self._stand(desk, offer, desk.own)
        desk.put_away(rests=True)

    def _wake(self, desk: Desk, offer: Offer, now_s: float) -> None:
        awake = [other for other in self._desks.values() if other.own is not None]
        if len(awake) >= MOST_AWAKE:
            longest = min(awake, key=lambda other: other.used_s)
            if now_s - longest.used_s < BRIEF_REST_S:
                desk.stand, desk.is_behind = waiting_part(desk.seat), True
                return
            self._put_to_rest(longest, offer)
        desk.rests, desk.is_stale = False, True
        desk.used_s = desk.learned_s = now_s
        if desk.notice == _RESTS:
            desk.notice = ""
        if desk.kept is None or desk.kept.beginning != offer.beginning:
            desk.notice = _ANEW if desk.kept is not None else ""
            desk.begin(offer.beginning)
        else:
            desk.own, desk.kept = Own.taken_up(desk.kept), None
        assert desk.own is not None
        self._stand(desk, offer, desk.own)

    # What they do

    def _answer(self, offer: Offer, now_s: float) -> None:
        """Do what was asked for by now, and show each of those who did what came of it."""
        touched: dict[Seat, Desk] = {}
        for _ in range(len(self._tapped)):
            seat, tap = self._tapped.popleft()
            desk = self._desks.get(seat)
            if desk is None:
                continue
            desk.used_s = now_s
            if desk.own is None:
                self._wake(desk, offer, now_s)
            if not _is_offered(tap, offer, desk):
                continue
            if desk.own is None or desk.own.is_on_its_way:
                if len(desk.held) < _MOST_HELD:
                    desk.held.append(tap)
                continue
            self._do(desk, tap)
            touched[seat] = desk
        for desk in touched.values():
            self._show_soon(desk, offer)

    def _show_soon(self, desk: Desk, offer: Offer) -> None:
        """Show what came of a tap: at once, but of one that taps and taps the picture comes later,
        and so it does where more is tapped than can be painted."""
        now_s = time.perf_counter()
        if now_s - desk.shown_s >= ASKED_S and self._paint_s - now_s < _MOST_DEBT_S:
            began_s = time.thread_time()
            self._show(desk, offer, asked=True)
            wait_s = self._painting.wait_s(now_s, time.thread_time() - began_s)
            self._paint_s = max(self._paint_s, now_s + wait_s)
            desk.shown_s = now_s
        elif desk.own is not None:
            self._stand(desk, offer, desk.own)
            self._send_missing(desk)

    def _do(self, desk: Desk, tap: Tap) -> None:
        assert desk.own is not None
        desk.notice, desk.is_stale = "", True
        was_learning = desk.own.learns
        try:
            desk.own.carry_out(tap)
        except CommandError as error:
            desk.notice = f"That cannot be done: {error}."
        if not was_learning:
            desk.owed, desk.learned_s = 0.0, time.perf_counter()

    def _make_again(self, offer: Offer) -> float:
        """Have those go on that are on their way; returns when they may again."""
        on_their_way = [
            desk for desk in self._desks.values() if desk.own is not None and desk.own.is_on_its_way
        ]
        # Whoever has had little made again comes first: nobody can keep the others waiting.
        on_their_way.sort(key=lambda desk: desk.made_s)
        for desk in on_their_way:
            while (now_s := time.perf_counter()) >= self._make_s:
                if self._tapped:
                    return now_s
                self._make_s = now_s + self._slice(desk, _SLICE_STEPS, self._making)
                if desk.own is None or not desk.own.is_on_its_way:
                    while desk.held:
                        self._do(desk, desk.held.popleft())
                    self._show(desk, offer, asked=True)
                    break
            else:
                return self._make_s
        return float("inf")

    def _learn(self) -> float:
        """Make a slice of each that is due; returns when the next one is."""
        learning = [d for d in self._desks.values() if d.own is not None and d.own.learns]
        if not learning:
            return float("inf")
        due_s = float("inf")
        # Where the share is used up, the next turn begins with who had none.
        first = self._turn_of % len(learning)
        for desk in (*learning[first:], *learning[:first]):
            now_s = time.perf_counter()
            if self._tapped or now_s < self._learn_s:
                return self._learn_s
            self._turn_of += 1
            if now_s - desk.learned_s >= _TICK_S:
                assert desk.own is not None
                speed = desk.own.speed
                owed = desk.owed + (now_s - desk.learned_s) * speed
                owed = min(owed, max(speed * _MOST_OWED_S, 1.0))
                desk.learned_s, desk.owed = now_s, owed - int(owed)
                if owed >= 1.0:
                    self._learn_s = now_s + self._slice(desk, int(owed), self._learning)
            due_s = min(due_s, desk.learned_s + _TICK_S)
        return due_s

    def _slice(self, desk: Desk, steps: int, budget: Turnstile) -> float:
        """Make steps; returns for how long such as these have to wait then."""
        assert desk.own is not None
        began_s = time.thread_time()
        try:
            made = desk.own.advance(steps)
            if budget is self._learning:
                self.steps_made += made
        except Exception:
            log.exception("an own learner stopped")
            desk.notice = _BROKEN
            desk.begin(desk.beginning)
        desk.is_stale = True
        took_s = time.thread_time() - began_s
        if budget is self._making:
            desk.made_s += took_s
        return budget.wait_s(time.perf_counter(), took_s)

    # What is seen of it

    def _paint(self, offer: Offer) -> float:
        """Paint one that has changed, if there is time; returns when to look again."""
        now_s = time.perf_counter()
        behind = [desk for desk in self._desks.values() if desk.is_behind]
        for desk in behind:
            self._send_missing(desk)
        again_s = now_s + _BEHIND_S if behind else float("inf")
        waiting = [
            desk
            for desk in self._desks.values()
            if desk.is_stale
            and desk.own is not None
            and not desk.own.is_on_its_way
            and any(watcher.is_ready for watcher in desk.looking)
        ]
        if not waiting:
            return again_s
        desk = min(waiting, key=lambda desk: desk.due_s)
        due_s = max(desk.due_s, self._paint_s)
        if now_s < due_s or self._tapped:
            return min(due_s, again_s)
        began_s = time.thread_time()
        self._show(desk, offer, asked=False)
        self._paint_s = now_s + self._painting.wait_s(now_s, time.thread_time() - began_s)
        return min(max(self._paint_s, min(desk.due_s for desk in waiting)), again_s)

    def _show(self, desk: Desk, offer: Offer, asked: bool) -> None:
        """Paint it for all pages that show it, and send them that."""
        now_s = time.perf_counter()
        own = desk.own
        assert own is not None
        status = own.status()
        desk.views = {
            dark: desk.views.get(dark) or OwnView(dark)
            for dark in {watcher.wish.dark for watcher in desk.looking}
        }
        for view in desk.views.values():
            view.paint(status, asked, now_s)
        self._stand(desk, offer, own)
        desk.is_stale = not all(view.is_of(status) for view in desk.views.values())
        sent = self._send_missing(desk)
        wait_s = desk.pace.wait_s(now_s, sent) if sent and not asked else 0.0
        desk.due_s = now_s + max(wait_s, _PAINT_S)

    def _stand(self, desk: Desk, offer: Offer, own: Own) -> None:
        controls = () if offer.holds else offer.controls
        notice = _HOLDS if offer.holds else desk.notice
        desk.stand = own_part(own, desk.seat, controls, notice)
        desk.is_behind = True

    def _send_missing(self, desk: Desk) -> int:
        """Send each page what it has not been sent yet; returns the bytes of the longest letter."""
        desk.is_behind = not all(watcher.is_ready for watcher in desk.looking)
        longest = 0
        for dark in {watcher.wish.dark for watcher in desk.looking}:
            group = [watcher for watcher in desk.looking if watcher.wish.dark == dark]
            longest = max(longest, self._send_to(group, desk.parts(dark)))
        return longest

    def _send_to(self, watchers: Iterable[Watcher], parts: Parts) -> int:
        letters = [
            (letter_of(content for _, content in missing), group)
            for missing, group in by_what_they_miss(parts, watchers, ORDER).items()
        ]
        if letters:
            self._send(letters)
        return max((len(letter) for letter, _ in letters), default=0)

    def _sum_up(self, now_s: float) -> None:
        if now_s - self._overview_s < _OVERVIEW_S:
            return
        self._overview_s = now_s
        for desk in self._desks.values():
            desk.learns = desk.own is not None and desk.own.learns
            if desk.own is not None and desk.own.run.trial > 0:
                desk.came_to = desk.own.run.trial, desk.own.reward
        known = [desk.came_to for desk in self._desks.values() if desk.came_to is not None]
        # In an order that says nothing of who they are.
        rewards = sorted(known, key=lambda one: (one[1], one[0]), reverse=True)
        self._overview = OwnLearners(
            len(self._desks),
            sum(desk.learns for desk in self._desks.values()),
            tuple(rewards) if len(rewards) >= FEWEST_SHOWN else (),
        )


def _is_offered(tap: Any, offer: Offer, desk: Desk) -> bool:
    """Whether a page of this seat has such a control."""
    if offer.holds:
        return False
    is_over = desk.own is not None and desk.own.is_over
    if isinstance(tap, AgainOwn) and is_over and "play" in offer.controls:
        return True
    return _CONTROL_OF[type(tap)] in offer.controls
