"""Runs side by side in one browser: which moment of them it looks at, and what comes of a hand."""

import math
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, Final

import msgspec
import viser

from app.charts.race import looks_of
from app.explain.beside import cell_rows, leaders, repertoire, standing
from app.explain.cell import CellReading, reading_at
from app.live import requests
from app.live.race import Entry, Race, RaceStatus, thesis_four
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.live.worker import FULL_SPEED
from app.page import keys
from app.page.inbox import Inbox, Intent
from app.page.panels.transport import SPEEDS, slider_of, speed_label, speed_of
from app.page.side import messages
from app.page.side.course import ground_of
from app.page.side.messages import FromSide
from app.page.side.said import apart_said, looks_with, run_sent
from app.page.side.show import Hall, SideShow, are_same
from app.page.slots import slot_html
from app.page.time.grounds import PLAIN_PACE
from app.page.time.walk import Ground, Walk, WalkError, rates_of
from app.page.widgets import assign
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.layers.change import CHANGE
from app.picture.look import ALL, Look, heading_shown
from app.player.boards import world_key, world_sent
from app.server.callbacks import RefusedError
from app.server.channels import Channels
from app.words.numbers import rate_in_short
from learners.commands import CommandError
from learners.spec import RunSpec

_SLOWLY_S: Final = 0.25
"""How often what is read, and lines over boards, are made anew while runs go on."""
_MOST_WAITING: Final = 256
_SPEEDS: Final = (200.0, 2e3, 1e4, 2e4, 5e4, 1e5, 2e5, 1e6)
"""Steps a second there are to choose from."""
_FIRST_SPEED: Final = 2e4
"""At which a million steps take most of a minute: there is time to see who goes ahead."""
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
        self._past: tuple[int, tuple[Snapshot, ...]] | None = None
        """The last moment of the past that was made, by its step."""
        self._sent: dict[str, object] = {}
        """What the frame was sent last, of each kind, by which it is told whether it is new."""
        self._slowly_s = 0.0

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
        self._look = look

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
            self._sent.clear()
        if hall is not self._hall:
            self._hall = hall
            self._walk, self._past, self._point = Walk(), None, None
            n_runs = 2 if hall is None else len(hall.status.entries)
            self._pair = messages.Compare(n_runs - 2, n_runs - 1, self._pair.shown)
        while self._messages:
            message = self._messages.popleft()
            try:
                self._do(message, hall, now_s)
            except (WalkError, RefusedError, CommandError, ValueError) as error:
                self._say(str(error))
        self._send("choice", self._choice())
        if hall is None:
            self._send("race", {"runs": []})
        else:
            self._send_race(hall, now_s)

    def _say(self, text: str, refused: bool = True) -> None:
        self._channel.send("said", {"text": text[:400], "refused": refused})

    def _send(self, kind: str, content: dict[str, Any]) -> None:
        """Send something if it is other than what the frame has."""
        if self._sent.get(kind) != content:
            self._sent[kind] = content
            self._channel.send(kind, content)

    # What is to be seen

    def _choice(self) -> dict[str, Any]:
        """What there is to choose from."""
        status = self._session.status
        snapshot = status.snapshot
        lines = [
            {"line": one.number, "name": _line_name(status, one.number)} for one in status.lines
        ]
        if not lines:
            lines = [{"line": snapshot.generation, "name": _line_name(status, snapshot.generation)}]
        return {
            "lines": lines,
            "presets": list(self._presets()),
            "preset": snapshot.preset,
            "seed": snapshot.seed,
        }

    def _send_race(self, hall: Hall, now_s: float) -> None:
        status = hall.status
        ground = _ground(hall)
        place = self._walk.at(now_s, ground)
        self._send("race", self._runs(hall))
        self._send_worlds(status.snapshots)
        self._send("curves", {**hall.curves, "events": _events(hall)})
        shown = status.snapshots if place is None else self._moment_at(hall.race, place.step)
        step = status.step if place is None else place.step
        is_live = place is None
        playing = status.playing if is_live else self._walk.direction != 0
        self._send("moment", self._moment(hall, step, is_live, playing, ground))
        if not self._channel.waits("boards"):
            self._send_boards(hall, shown, rests=not playing)
        if now_s - self._slowly_s >= _SLOWLY_S or not playing:
            self._slowly_s = now_s
            self._send("readings", self._readings(hall, shown, step, is_live))
            self._send_slowly(hall, shown)

    def _send_worlds(self, snapshots: tuple[Snapshot, ...]) -> None:
        worlds = {world_key(one.spec.world): one.spec.world for one in snapshots}
        if self._sent.get("worlds") != list(worlds):
            self._sent["worlds"] = list(worlds)
            self._channel.send("worlds", {"worlds": [world_sent(one) for one in worlds.values()]})

    def _runs(self, hall: Hall) -> dict[str, Any]:
        entries = hall.status.entries
        looks = looks_of([entry.preset for entry in entries])
        return {
            "runs": [
                {
                    "name": entry.name,
                    "seed": entry.seed,
                    "about": repertoire(entry.spec),
                    "look": look,
                }
                for entry, look in zip(entries, looks, strict=True)
            ],
            "alike": hall.status.common_starts,
        }

    def _moment_at(self, race: Race, step: int) -> tuple[Snapshot, ...]:
        if self._past is None or self._past[0] != step:
            self._past = step, race.snapshots_at(step)
        return self._past[1]

    def _moment(
        self, hall: Hall, step: int, is_live: bool, playing: bool, ground: Ground
    ) -> dict[str, Any]:
        """Where the playhead is; it moves with each frame."""
        status, walk = hall.status, self._walk
        return {
            "step": step,
            "end": status.step,
            "live": is_live,
            "playing": playing,
            "finished": status.finished,
            "direction": walk.direction or 1,
            "rate": walk.rate,
            "rates": rates_of(status.step, ground.pace),
            "error": status.error,
            "preparing": status.preparing,
        }

    def _readings(
        self, hall: Hall, shown: tuple[Snapshot, ...], step: int, is_live: bool
    ) -> dict[str, Any]:
        """What is read of the runs, and who leads."""
        status = hall.status
        names = [entry.name for entry in status.entries]
        lead = leaders(shown)
        nothing = [""] * len(shown)
        stands = status.stands if is_live else nothing
        digests = status.digests if is_live and status.digests else nothing
        return {
            "standing": str(standing(names, shown, step, status.common_starts)),
            **_pace(status),
            "runs": [
                run_sent(
                    one, stands[place], hall.greedy.at(place, step), digests[place], place in lead
                )
                for place, one in enumerate(shown)
            ],
        }

    def _send_boards(self, hall: Hall, shown: tuple[Snapshot, ...], rests: bool) -> None:
        boards = [
            hall.ground(place, one, looks_with(self._look, self._names, one), None, rests)
            for place, one in enumerate(shown)
        ]
        between = self._between(shown)
        if between is not None:
            one, other = between
            pair = (self._pair.one, self._pair.other)
            boards.append(hall.ground(pair, other, self._change_look, one, rests=False))
        self._send_parts("boards", boards)

    def _send_slowly(self, hall: Hall, shown: tuple[Snapshot, ...]) -> None:
        """Send what is read, and lines over the boards."""
        looks = [looks_with(self._look, self._names, one) for one in shown]
        overs = [
            hall.over(place, one, look, None)
            for place, (one, look) in enumerate(zip(shown, looks, strict=True))
        ]
        between = self._between(shown)
        if between is not None:
            pair = (self._pair.one, self._pair.other)
            overs.append(hall.over(pair, between[1], self._change_look, between[0]))
        self._send_parts("overs", overs)
        layer, first = LAYERS[self._look.layer], shown[0]
        extras = hall.extras(first, looks[0], None)
        captions = [
            layer.caption(one, look, hall.extras(one, look, None))
            for one, look in zip(shown, looks, strict=True)
        ]
        self._send(
            "legend",
            {
                "layer": layer.title,
                "html": str(layer.legend(first, looks[0], extras)),
                "captions": captions,
            },
        )
        self._send("compare", self._comparison(hall, shown))
        self._send("cell", self._cell(shown))

    def _send_parts(self, kind: str, parts: list[msgspec.Raw]) -> None:
        """Send parts of boards if one of them is another one."""
        known = self._sent.get(kind)
        if not (isinstance(known, list) and are_same(known, parts)):
            self._sent[kind] = parts
            self._channel.send(kind, {"boards": parts})

    @property
    def _names(self) -> Snapshot:
        """Whose options the look names."""
        return self._session.status.snapshot

    @property
    def _change_look(self) -> Look:
        return self._look._replace(layer=CHANGE.key, hunts=False, option=0)

    def _between(self, shown: tuple[Snapshot, ...]) -> tuple[Snapshot, Snapshot] | None:
        """The two runs of which a map of differences is to be seen."""
        pair = self._pair
        return (shown[pair.one], shown[pair.other]) if pair.shown else None

    def _comparison(self, hall: Hall, shown: tuple[Snapshot, ...]) -> dict[str, Any]:
        pair, entries = self._pair, hall.status.entries
        found = hall.apart.of(hall.race, pair.one, pair.other, hall.status.step)
        names = (entries[pair.one].name, entries[pair.other].name)
        between = self._between(shown)
        return {
            "one": pair.one,
            "other": pair.other,
            "shown": pair.shown,
            "text": apart_said(found, names, hall.status.step, hall.status.trials[pair.one]),
            "caption": ""
            if between is None
            else CHANGE.caption(between[1], self._change_look, Extras(since=between[0])),
            "step": None if found is None else found.step,
            "legend": ""
            if between is None
            else str(CHANGE.legend(between[1], self._change_look, Extras(since=between[0]))),
        }

    def _cell(self, shown: tuple[Snapshot, ...]) -> dict[str, Any]:
        point = self._point
        if point is None:
            return {"rows": None, "east": 0, "north": 0}
        readings = [self._reading(point, one) for one in shown]
        return {
            "rows": [row._asdict() for row in cell_rows(readings)],
            "east": point.east,
            "north": point.north,
        }

    def _reading(self, point: messages.Point, snapshot: Snapshot) -> CellReading | None:
        middle = snapshot.world.size // 2
        x, y = middle + point.east, middle + point.north
        if not (0 <= x < snapshot.world.size and 0 <= y < snapshot.world.size):
            return None
        heading = point.heading
        if heading is None or self._look.frame != ALL:
            heading = heading_shown(self._look, snapshot.heading)
        return reading_at(snapshot, x, y, heading)

    # What a hand did

    def _do(self, message: Any, hall: Hall | None, now_s: float) -> None:
        match message:
            case messages.Start(runs=runs):
                self._start([self._entry(chosen) for chosen in runs])
            case messages.StartFour():
                self._start(self._four())
            case messages.Close():
                self._inbox.put(self.close)
            case messages.End():
                self._session.submit(requests.EndRace(), self._say)
            case _:
                if hall is not None:
                    self._steer(message, hall, _ground(hall), now_s)

    def _steer(self, message: Any, hall: Hall, ground: Ground, now_s: float) -> None:
        walk, race = self._walk, hall.race
        match message:
            case messages.Play(direction=direction):
                if walk.is_live and direction > 0:
                    race.play(self._say)
                else:
                    walk.play(direction, now_s, ground)
            case messages.Pause():
                if walk.is_live:
                    race.pause()
                else:
                    walk.pause(now_s, ground)
            case messages.Faster(by=by):
                at = min(max(slider_of(hall.status.speed) + by / 10, 0.0), SPEEDS)
                race.set_speed(speed_of(at))
            case messages.SetSpeed(steps_per_s=speed):
                race.set_speed(max(speed, 1.0) if speed else FULL_SPEED)
            case messages.Seek(step=step):
                walk.pause(now_s, ground)
                walk.seek(step, now_s, ground)
            case messages.Live():
                walk.go_live()
            case messages.GoBy(unit=unit, n=n):
                walk.go_by(unit, n, now_s, ground)
            case messages.SetRate(rate=rate):
                walk.set_rate(rate, now_s, ground)
            case messages.Compare(one=one, other=other):
                if max(one, other) < len(hall.status.entries) and one != other:
                    self._pair = message
                    self._slowly_s = 0.0
            case messages.Point():
                self._point, self._slowly_s = message, 0.0
            case messages.Unpoint():
                self._point, self._slowly_s = None, 0.0
            case _:
                pass

    def _start(self, entries: list[Entry]) -> None:
        self._session.submit(requests.StartRace(tuple(entries), speed=_FIRST_SPEED), self._say)

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


def _pace(status: RaceStatus) -> dict[str, Any]:
    """How fast the runs go, and how fast they may."""
    speed = 0.0 if math.isinf(status.speed) else status.speed
    speeds = sorted({*_SPEEDS, speed} - {0.0})
    rate = f"{rate_in_short(status.steps_per_s)} steps/s each" if status.playing else ""
    return {
        "speed": speed,
        "speeds": [[one, speed_label(one)] for one in speeds] + [[0.0, speed_label(FULL_SPEED)]],
        "pace": rate,
    }


def _line_name(status: Status, line: int) -> str:
    found = next((one for one in status.lines if one.number == line), None)
    if found is None or found.is_live:
        return "live run"
    return found.name


def _ground(hall: Hall) -> Ground:
    speed = hall.status.speed
    pace = speed if math.isfinite(speed) else PLAIN_PACE
    return ground_of(hall.status.step, hall.events, max(pace, 1.0))


def _events(hall: Hall) -> list[dict[str, Any]]:
    return [
        {"step": one.step, "kind": one.kind, "text": one.text, "run": place}
        for place, one in hall.happenings
    ]
