"""The time bar of one browser: what its frame is sent, and what is done of what comes back."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any, Final, NamedTuple

import msgspec
import viser

from app.analysis.estimates import Axis
from app.charts.bar.axis import axis_of, last_trial
from app.charts.bar.model import rewards_of
from app.charts.bar.rule import watched_at
from app.charts.page.svg import frame_html
from app.live import requests
from app.live.places import Place
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.inbox import Inbox
from app.page.slots import slot_html
from app.page.time import messages
from app.page.time.asked import Answered, Asked, Asking
from app.page.time.asks import Asks
from app.page.time.bars import Bars
from app.page.time.messages import FromFrame
from app.page.time.outlook import Outlook
from app.page.time.walk import Ground, Walk, WalkError, rates_of
from app.schedule import edits
from app.server.callbacks import RefusedError
from app.server.channels import Channels
from learners.commands import SetSchedule
from learners.schedule_spec import ScheduleSpec

_GONE: Final = "What you looked at is not there any more. This is the live run."
_NOT_DONE: Final = "What you did while the branch was being made is not done."
Edit = messages.EditBlock | messages.AddExploration | messages.DeleteBlock
"""What goes by the plan as it is, and so waits for a branch that is being made."""
_MOST_WAITING: Final = 32


class Deeds(NamedTuple):
    """What a bar can have done besides walking."""

    choose: Callable[[str], object]
    """Shows a block in the fields of the plan, by its id."""
    test: Callable[[viser.ClientHandle, int], object]
    """Runs what a line does over many seeds."""


class TimePanel:
    """The bar of one browser, in the slot below the board."""

    def __init__(
        self,
        client: viser.ClientHandle,
        outlook: Outlook,
        asks: Asks,
        channels: Channels,
        bars: Bars,
        inbox: Inbox,
        deeds: Deeds,
        wake: Callable[[], object],
    ) -> None:
        """``wake`` lets the render loop draw at once."""
        self._client, self._outlook, self._asks = client, outlook, asks
        self._bars, self._deeds, self._wake = bars, deeds, wake
        self._unit: Axis = "trials"
        self._bar: msgspec.Raw | None = None
        self._moment: dict[str, Any] | None = None
        self._note = ""
        self._asking = Asking()
        self._plan: ScheduleSpec | None = None
        """What was asked for last and has not been answered."""
        self._fault: str | None = None
        self._to_be_live: int | None = None
        """A line with which this browser is to be live, once that is."""
        self._waiting: list[Any] = []
        """Edits that are meant for a branch that is not there yet."""
        self._left = -1
        """The line that it branches off."""
        self._seen: Status | None = None
        self._live: Status | None = None
        self._ground: Ground | None = None
        self._channel = channels.enter(
            FromFrame,
            lambda message: inbox.put(partial(self.take, message)),
            lambda: inbox.put(self._opened),
        )
        # At the root of the main panel, which is there whatever tab is shown.
        client.gui.add_html(frame_html())
        client.gui.add_html(slot_html("bar", self._channel.frame_html("Time bar")))

    @property
    def is_shown(self) -> bool:
        """Whether anything has been shown yet; before, nothing is taken from the frame."""
        return self._ground is not None

    @property
    def bar(self) -> msgspec.Raw | None:
        """The bar that it shows; None as long as there is none."""
        return self._bar

    @property
    def moment(self) -> dict[str, Any] | None:
        """Where it is on the bar (:func:`moment_sent`); None before anything is shown."""
        return self._moment

    @property
    def asked(self) -> Asked | None:
        """What is asked on it."""
        return self._asking.asked

    def say(self, text: str, refused: bool = False) -> None:
        """Say something in the frame. May be called from any thread."""
        self._channel.send("said", {"text": text, "refused": refused})

    def ask(self, asked: Asked | None, answered: Answered | None = None) -> None:
        """Ask something on the bar from now on, or nothing any more.

        As long as it is open nobody goes through time by the bar.

        Args:
            asked: the question, with all that is known of its answer.
            answered: hears of each answer; the question is to be asked again with it.
        """
        self._asking.ask(asked, answered)
        self._wake()

    def go_to(self, place: Place | None) -> None:
        """Look at a moment, and stand still there; None is one that is not known."""
        if place is None or self._ground is None:
            self.say("That moment is not known any more.", refused=True)
            return
        now_s, walk = time.perf_counter(), self._outlook.walk
        try:
            walk.pause(now_s, self._ground)
            walk.look(place.line, place.step, now_s, self._ground)
        except WalkError as error:
            self.say(str(error), refused=True)
        self._wake()

    def leave(self) -> None:
        """Send nothing more, and take nothing."""
        self._channel.leave()

    # What the frame is sent

    def update(
        self,
        seen: Status,
        live: Status,
        ground: Ground,
        chosen: str,
        is_answered: bool,
        now_s: float,
    ) -> None:
        """Show what is true.

        Args:
            seen: what is true for this browser.
            live: how the live run stands.
            ground: what is known of the lines.
            chosen: id of the block that stands out.
            is_answered: whether the live run has answered all that was asked.
            now_s: the time.
        """
        self._seen, self._live, self._ground = seen, live, ground
        if is_answered:
            self._plan = None
        if self._to_be_live == ground.live:
            self._to_be_live = None
            self._outlook.walk.go_live()
        if self._outlook.walk.lost():
            self.say(_GONE)
        fault = self._outlook.fault
        if fault is not None and fault != self._fault:
            self.say(f"This moment could not be shown: {fault}", refused=True)
        self._fault = fault
        line = self._outlook.walk.line(ground)
        viewer = self._outlook.viewer
        unit, view = ("trials" if self._asking.asked else self._unit), self._asking.view
        bar = self._bars.sent(viewer, line, seen, live, ground, unit, chosen, now_s, view)
        if bar is not None and bar is not self._bar:
            self._bar = bar
            self._channel.send("bar", {"bar": bar})
        asked = self._asking.news()
        if asked is not None:
            self._channel.send("ask", asked)
        moment = moment_sent(self._outlook.walk, self._outlook.place, live, ground, seen.snapshot)
        if moment != self._moment:
            self._moment = moment
            self._channel.send("moment", moment)
        if self._asks.note != self._note:
            self._note = self._asks.note
            self._channel.send("note", {"text": self._note})
        if self._waiting and not self._asks.is_branching:
            self._take_waiting()

    def _take_waiting(self) -> None:
        """Do what waited for a branch, once that is shown."""
        place = self._outlook.place
        if place is None:
            # It has gone back; the live run is not to have that.
            self._waiting = []
            self.say(_NOT_DONE, refused=True)
        elif place.line == self._left:
            # There is no branch, and that has been told.
            self._waiting = []
        elif self._outlook.is_there:
            waiting, self._waiting = self._waiting, []
            for message in waiting:
                self.take(message)

    def _opened(self) -> None:
        """The frame is there, or there again, and knows nothing."""
        self._bar = self._moment = None
        self._note = ""
        self._asking.forget()
        self._wake()

    # What comes from the frame

    def take(self, message: Any) -> None:
        """Do what a hand did; whatever it says comes from the network."""
        try:
            self._do(message)
        except (WalkError, RefusedError, ValueError) as error:
            self.say(str(error)[:400], refused=True)
        self._wake()

    def _do(self, message: Any) -> None:
        live, seen, ground = self._live, self._seen, self._ground
        if live is None or seen is None or ground is None:
            # Nothing of it was shown yet.
            return
        if isinstance(message, Edit) and (self._asks.is_branching or self._waiting):
            if len(self._waiting) >= _MOST_WAITING:
                raise RefusedError("a branch is being made; wait until it is there")
            if not self._waiting:
                self._left = self._outlook.walk.line(ground)
            self._waiting.append(message)
            return
        if not self._walk(message, live, ground, time.perf_counter()):
            self._act(message, seen, ground)

    def _walk(self, message: Any, live: Status, ground: Ground, now_s: float) -> bool:
        """Go somewhere in the past, if that is what is wanted."""
        walk = self._outlook.walk
        match message:
            case messages.Seek(step=step):
                walk.pause(now_s, ground)
                walk.seek(step, now_s, ground)
            case messages.SeekTrial(trial=trial):
                walk.pause(now_s, ground)
                walk.seek_trial(trial, now_s, ground)
            case messages.Live():
                walk.go_live()
            case messages.Look(line=line):
                walk.look(line, self._same_time(line, ground), now_s, ground)
            case messages.Play(direction=direction) if not (walk.is_live and direction > 0):
                walk.play(direction, now_s, ground)
            case messages.Pause() if not walk.is_live:
                walk.pause(now_s, ground)
            case messages.SetRate(rate=rate):
                walk.set_rate(rate, now_s, ground)
            case messages.GoBy(unit=unit, n=n):
                walk.go_by(unit, n, now_s, ground)
            case messages.SetLoop(on=on):
                line = walk.line(ground)
                marks = [mark.place.step for mark in live.marks if mark.place.line == line]
                walk.set_loop(on, marks, now_s, ground)
            case messages.SetA():
                walk.set_a(now_s, ground)
            case messages.SetStops(on=on):
                walk.stops = on
            case messages.SetHolds(on=on):
                walk.holds = on
            case messages.SetUnit(unit=unit):
                self._unit = unit
            case _:
                return False
        return True

    def _act(self, message: Any, seen: Status, ground: Ground) -> None:
        """Have the session do something, or another panel."""
        match message:
            case messages.Play():
                self._ask(requests.Play(), seen, ground)
            case messages.Pause():
                self._ask(requests.Pause(), seen, ground)
            case messages.EditBlock() | messages.AddExploration() | messages.DeleteBlock():
                plan = seen.snapshot.spec.schedule if self._plan is None else self._plan
                self._plan = edited(plan, message, edits.now_of(seen.snapshot))
                self._ask(SetSchedule(self._plan), seen, ground)
            case messages.ChooseBlock(id=id):
                self._deeds.choose(id)
            case messages.AddMark(text=text, line=line, step=step):
                self._ask(requests.AddMark(Place(line, step), text), seen, ground)
            case messages.RemoveMark(number=number):
                self._ask(requests.RemoveMark(number), seen, ground)
            case messages.NameLine(line=line, name=name):
                self._ask(requests.NameLine(line, name), seen, ground)
            case messages.DeleteLine(line=line):
                self._ask(requests.DeleteLine(line), seen, ground)
            case messages.BringBack(line=line):
                self._ask(requests.BringBack(line), seen, ground)
            case messages.MakeLive(line=line):
                self._to_be_live = line
                self._ask(requests.MakeLive(line), seen, ground, self._stay)
            case messages.TryOverSeeds(line=line):
                self._deeds.test(self._client, line)
            case messages.Guess() | messages.Sketch():
                snapshot = seen.snapshot
                self._asking.take(message, last_trial(snapshot), rewards_of(snapshot))
            case _:
                pass

    def _same_time(self, line: int, ground: Ground) -> int | None:
        """Where to look at another line: at the step that is looked at, or at its end."""
        place = self._outlook.place
        return None if place is None or line == ground.live else place.step

    def _stay(self) -> None:
        self._to_be_live = None

    def _ask(
        self,
        request: requests.Request,
        seen: Status,
        ground: Ground,
        refused: Callable[[], object] = lambda: None,
    ) -> None:
        def refuse(reason: str) -> None:
            refused()
            self.say(reason, refused=True)

        self._asks.take(request, refuse, seen, ground, time.perf_counter())


def edited(plan: ScheduleSpec, message: Edit, now: edits.Now) -> ScheduleSpec:
    """A plan after what a hand did to it.

    Raises:
        ValueError: that cannot be had.
    """
    match message:
        case messages.EditBlock(id=id, at=at, trials=trials, probability=probability):
            return edits.changed(plan, id, now, at=at, trials=trials, probability=probability)
        case messages.AddExploration(skill=skill, at=at, trials=trials, probability=probability):
            return edits.with_episode(plan, skill, at, trials, probability, now)
        case messages.DeleteBlock(id=id):
            return edits.without(plan, id, now)


def moment_sent(
    walk: Walk, place: Place | None, live: Status, ground: Ground, seen: Snapshot
) -> dict[str, Any]:
    """What the frame is told of where a browser is, with each frame in which that changes.

    ``seen`` is the moment that is shown there, which may be one on the way to the place.
    """
    now = live.snapshot
    line = walk.line(ground)
    course = ground.course_of(line)
    step, trial = now.step, now.trial
    if place is not None and course is not None:
        step, trial = place.step, course.trial_of_step(place.step)
    loop, a = walk.loop, walk.a
    if loop is not None and loop.line != line:
        loop = None
    return {
        "line": line,
        "step": step,
        "trial": trial,
        "live": place is None,
        "behind_trials": now.trial - trial,
        "behind_steps": now.step - step,
        "playing": live.playing if place is None else walk.direction != 0,
        "direction": walk.direction or 1,
        "rate": walk.rate,
        "rates": rates_of(0 if course is None else course.end_step, ground.pace),
        "a": None if a is None else {"line": a.line, **_point(a.line, a.step, ground)},
        "loop": loop
        and {"a": _point(line, loop.first, ground), "b": _point(line, loop.until, ground)},
        "holds": walk.holds,
        "stops": walk.stops,
        "until_step": _until_step(live),
        "watched": watched_at(seen),
    }


def _point(line: int, step: int, ground: Ground) -> dict[str, int]:
    course = ground.course_of(line)
    return {"step": step, "trial": 0 if course is None else course.trial_of_step(step)}


def _until_step(live: Status) -> int | None:
    """Steps that will have been made where the live run is to stand still, as far as one knows."""
    if live.runs_to is None:
        return None
    axis = axis_of(live.snapshot, "trials")
    ahead = max(live.runs_to - int(axis.progress.trials[-1]), 0)
    return int(axis.progress.steps[-1] + ahead * axis.pace)
