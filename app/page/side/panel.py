"""Runs side by side in one browser: which moment of them it looks at, and what comes of a hand."""

import math
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, Final

import viser

from app.live import requests
from app.live.race import thesis_four
from app.live.racer import Entry
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.live.worker import FULL_SPEED
from app.page import keys
from app.page.inbox import Inbox, Intent
from app.page.panels.transport import SPEEDS, slider_of, speed_of
from app.page.side import messages
from app.page.side.course import ground_of
from app.page.side.messages import FromSide
from app.page.side.show import Hall, SideShow
from app.page.side.sight import Sight, View
from app.page.slots import slot_html
from app.page.time.grounds import PLAIN_PACE
from app.page.time.walk import Ground, Walk, WalkError
from app.page.widgets import assign
from app.picture.look import Look
from app.server.callbacks import RefusedError
from app.server.channels import Channels
from learners.commands import CommandError
from learners.spec import RunSpec

_MOST_WAITING: Final = 256
FIRST_SPEED: Final = 2e4
"""At which a million steps take most of a minute: there is time to see who goes ahead."""
_TENTH: Final = 0.1
"""Of the slider of speeds."""
Presets = Callable[[], Mapping[str, RunSpec]]
"""Those there are to choose from, by name."""


class SidePanel:
    """Of one browser. The render loop opens and closes it, the show's thread does all else."""

    def __init__(
        self,
        client: viser.ClientHandle,
        session: Session,
        show: SideShow,
        channels: Channels,
        inbox: Inbox,
        presets: Presets,
    ) -> None:
        self._session, self._show, self._presets = session, show, presets
        self._inbox = inbox
        self._messages: deque[Any] = deque(maxlen=_MOST_WAITING)
        self._channel = channels.enter(FromSide, self._take, self._opened, page="side")
        self._sight = Sight(self._channel)
        self._frame_html = slot_html("side", self._channel.frame_html("Runs side by side"))
        # At the root of the main panel, which is there whatever tab is shown.
        self._slot = client.gui.add_html(slot_html("side", ""))
        command = client.gui.add_command("Runs side by side", hotkey=keys.SIDE.hotkey)
        command.on_trigger(Intent(lambda _, __: self.toggle()))
        self._look = Look()
        self._walk = Walk()
        self._is_new = True
        """Whether the frame knows nothing."""
        self._hall: Hall | None = None
        self._pair = messages.Compare(0, 1, False)
        self._point: messages.Point | None = None
        self._wished: int | None = None
        """Step of the moment of the past that is to be made."""
        self._past: tuple[Snapshot, ...] | None = None
        """The last that was."""
        self._fault: str | None = None

    # In the render loop

    @property
    def is_open(self) -> bool:
        """Whether this browser looks at runs side by side."""
        return self._slot.content == self._frame_html

    def toggle(self) -> None:
        """Look at runs side by side, or at one board again."""
        if self.is_open:
            self.close()
        else:
            self.open()

    def open(self, four: bool = False) -> None:
        """Look at runs side by side; with ``four`` let the thesis's learners race."""
        if four:
            self._take(messages.StartFour())
        assign(self._slot, "content", self._frame_html)
        self._show.enter(self)

    def close(self) -> None:
        """Look at one board again; the runs stay, and others may look at them."""
        assign(self._slot, "content", slot_html("side", ""))
        self._show.leave(self)

    def update(self, look: Look) -> None:
        """Say how this browser wants to see boards."""
        if look != self._look:
            self._look = look
            self._sight.hurry()

    def leave(self) -> None:
        """The browser has gone."""
        self._show.leave(self)
        self._channel.leave()

    # In the server's thread

    def _take(self, message: Any) -> None:
        self._messages.append(message)
        self._show.wake()

    def _opened(self) -> None:
        self._is_new = True
        self._show.wake()

    # In the show's thread

    def draw(self, hall: Hall | None, now_s: float) -> None:
        """Do what was asked for, which comes from the network, and send what is to be seen."""
        if self._is_new:
            self._is_new = False
            self._sight.forget()
        if hall is not self._hall:
            self._meet(hall)
        while self._messages:
            self._obey(self._messages.popleft(), hall, now_s)
        self._sight.send("choice", self._choice())
        if hall is None:
            self._sight.send("race", {"runs": []})
        else:
            self._sight.show(self._view(hall, now_s), now_s)

    def _meet(self, hall: Hall | None) -> None:
        """There are other runs, or none any more."""
        self._hall = hall
        self._walk, self._point = Walk(), None
        self._wished = self._past = self._fault = None
        n_runs = 2 if hall is None else len(hall.status.entries)
        self._pair = messages.Compare(n_runs - 2, n_runs - 1, self._pair.shown)
        self._sight.hurry()
        paused = None if hall is None else hall.race.paused_live
        if paused is not None:
            self._sight.say(f"Your run stands still at trial {paused:,} meanwhile.", refused=False)

    def _view(self, hall: Hall, now_s: float) -> View:
        """What is looked at now."""
        walk, ground = self._walk, _ground(hall)
        place = walk.at(now_s, ground)
        is_live = place is None
        return View(
            hall=hall,
            shown=self._at(hall, None if place is None else place.step),
            step=hall.status.step if place is None else place.step,
            is_live=is_live,
            playing=hall.status.playing if is_live else walk.direction != 0,
            direction=walk.direction or 1,
            rate=walk.rate,
            pace=ground.pace,
            look=self._look,
            named=self._session.status.snapshot,
            pair=self._pair,
            point=self._point,
        )

    def _at(self, hall: Hall, step: int | None) -> tuple[Snapshot, ...]:
        """All at a step, or at the last on the way there that was made; at None as they are now."""
        moments = hall.race.moments
        if step is None:
            if self._wished is not None:
                self._wished = self._past = None
                moments.forget(self)
            return hall.status.snapshots
        if step != self._wished:
            self._wished = step
            moments.want(self, step)
        fault = moments.fault(self)
        if fault is not None and fault != self._fault:
            self._sight.say(f"This moment could not be shown: {fault}")
        self._fault = fault
        self._past = moments.found(self) or self._past
        return self._past or hall.status.snapshots

    def _choice(self) -> dict[str, Any]:
        """What there is to choose from."""
        status = self._session.status
        snapshot = status.snapshot
        numbers = [line.number for line in status.lines] or [snapshot.generation]
        return {
            "lines": [{"line": one, "name": _line_name(status, one)} for one in numbers],
            "presets": list(self._presets()),
            "preset": snapshot.preset,
            "seed": snapshot.seed,
        }

    def say(self, text: str) -> None:
        """Say that something went wrong."""
        self._sight.say(text)

    # What a hand did

    def _obey(self, message: Any, hall: Hall | None, now_s: float) -> None:
        try:
            self._do(message, hall, now_s)
        except (WalkError, RefusedError, CommandError, ValueError) as error:
            self._sight.say(str(error))
        self._sight.hurry()

    def _do(self, message: Any, hall: Hall | None, now_s: float) -> None:
        match message:
            case messages.Start(runs=runs):
                self._start([self._entry(chosen) for chosen in runs])
            case messages.StartFour():
                self._start(self._four())
            case messages.End():
                self._session.submit(requests.EndRace(), self._sight.say)
            case messages.Close():
                self._inbox.put(self.close)
            case _:
                if hall is not None and not self._goes(message, hall, now_s):
                    self._steer(message, hall)

    def _goes(self, message: Any, hall: Hall, now_s: float) -> bool:
        """Go somewhere in the past, if that is what is wanted."""
        walk, ground = self._walk, _ground(hall)
        match message:
            case messages.Play(direction=direction) if not (walk.is_live and direction > 0):
                walk.play(direction, now_s, ground)
            case messages.Pause() if not walk.is_live:
                walk.pause(now_s, ground)
            case messages.Seek(step=step):
                walk.pause(now_s, ground)
                walk.seek(step, now_s, ground)
            case messages.Live():
                walk.go_live()
            case messages.GoBy(unit=unit, n=n):
                walk.go_by(unit, n, now_s, ground)
            case messages.SetRate(rate=rate):
                walk.set_rate(rate, now_s, ground)
            case _:
                return False
        return True

    def _steer(self, message: Any, hall: Hall) -> None:
        """Have the runs do something, or look at something else of them."""
        race, status = hall.race, hall.status
        match message:
            case messages.Play():
                race.play(self._sight.say)
            case messages.Pause():
                race.pause()
            case messages.StepOnce():
                self._walk.go_live()
                race.run_to(status.step + 1, self._sight.say)
            case messages.Faster(by=by):
                at = slider_of(status.speed) + by * _TENTH
                race.set_speed(speed_of(min(max(at, 0.0), SPEEDS)))
            case messages.SetSpeed(steps_per_s=speed):
                race.set_speed(max(speed, 1.0) if speed else FULL_SPEED)
            case messages.Compare(one=one, other=other):
                if max(one, other) < len(status.entries) and one != other:
                    self._pair = message
            case messages.Point():
                self._point = message
            case messages.Unpoint():
                self._point = None
            case _:
                pass

    def _start(self, entries: list[Entry]) -> None:
        status = self._session.status
        # A lesson says how fast runs are to learn, as it may wait for millions of steps.
        speed = FIRST_SPEED if status.story is None else max(status.speed, FIRST_SPEED)
        start = requests.StartRace(tuple(entries), speed=speed)
        self._session.submit(start, self._sight.say)

    def _four(self) -> list[Entry]:
        presets = self._presets()
        try:
            return list(thesis_four(presets.__getitem__, self._session.status.snapshot.seed))
        except KeyError as error:
            raise RefusedError(f"there is no preset {error.args[0]} here") from error

    def _entry(self, chosen: messages.Chosen) -> Entry:
        status = self._session.status
        if chosen.line is not None:
            return self._session.entry_of(chosen.line, _line_name(status, chosen.line))
        preset, seed = chosen.preset, chosen.seed
        spec = None if preset is None else self._presets().get(preset)
        if preset is None or spec is None or seed is None:
            raise RefusedError("that preset is not here any more")
        return Entry(f"{preset}, seed {seed}", preset, seed, spec)


def _line_name(status: Status, line: int) -> str:
    found = next((one for one in status.lines if one.number == line), None)
    return "live run" if found is None or found.is_live else found.name


def _ground(hall: Hall) -> Ground:
    speed = hall.status.speed
    pace = speed if math.isfinite(speed) else PLAIN_PACE
    return ground_of(hall.status.step, hall.events, max(pace, 1.0))
