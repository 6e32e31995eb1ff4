"""What one browser sees of runs side by side, as its frame is sent it: only what is new to it."""

import math
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import msgspec
from markupsafe import Markup

from app.charts.race import looks_of
from app.explain.beside import ahead_of_others, cell_rows, repertoire, standing
from app.explain.cell import CellReading, reading_at
from app.live.race import RaceStatus
from app.live.snapshot import Snapshot
from app.live.worker import FULL_SPEED
from app.page.panels.transport import speed_label
from app.page.side.messages import Compare, Point
from app.page.side.said import apart_said, looks_with, run_sent
from app.page.side.show import Hall, are_same
from app.page.time.walk import rates_of
from app.picture.counted import counted_by
from app.picture.layer import Extras, Layer
from app.picture.layers import LAYERS
from app.picture.layers.change import CHANGE
from app.picture.look import ALL, Look, heading_shown
from app.player.boards import world_key, world_sent
from app.server.channels import Channel
from app.util.html import element, joined
from app.words.numbers import rate_in_short
from app.words.plain import joined_by_and

_SLOWLY_S: Final = 0.25
"""How often what is read, and lines over boards, are made anew while runs go on."""
_SPEEDS: Final = (200.0, 2e3, 1e4, 2e4, 5e4, 1e5, 2e5, 1e6)
"""Steps a second there are to choose from."""


class View(NamedTuple):
    """What is looked at, and how."""

    hall: Hall
    shown: tuple[Snapshot, ...]
    """The moment, of each run."""
    step: int
    """Of it; what is shown may be one on the way there."""
    is_live: bool
    """Whether it is where the runs are now."""
    playing: bool
    """Whether that is another one soon."""
    direction: int
    rate: float
    """How fast the past plays, ..."""
    pace: float
    """... as a multiple of so many steps a second."""
    look: Look
    named: Snapshot
    """Of the run whose options the look names."""
    pair: Compare
    point: Point | None

    @property
    def looks(self) -> list[Look]:
        """At each run."""
        return [looks_with(self.look, self.named, one) for one in self.shown]

    @property
    def look_at_change(self) -> Look:
        """At what is different between two."""
        return self.look._replace(layer=CHANGE.key, hunts=False, option=0)

    @property
    def between(self) -> tuple[Snapshot, Snapshot] | None:
        """Of which runs a map of differences is to be seen: against which one, and which."""
        return (self.shown[self.pair.other], self.shown[self.pair.one]) if self.pair.shown else None


class Sight:
    """Of one browser. The show's thread alone has to do with it."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._sent: dict[str, object] = {}
        """What the frame was sent last, of each kind, ..."""
        self._parts: dict[str, Sequence[msgspec.Raw]] = {}
        """... and of boards."""
        self._shown: tuple[Snapshot, ...] = ()
        self._slowly_s = -math.inf

    def forget(self) -> None:
        """The frame knows nothing any more."""
        self._sent.clear()
        self._parts.clear()
        self.hurry()

    def hurry(self) -> None:
        """Something was asked for: what is made now and then is made now."""
        self._slowly_s = -math.inf

    def say(self, text: str, refused: bool = True) -> None:
        """Say something, as a rule why it was not done; may be called from any thread."""
        self._channel.send("said", {"text": text[:400], "refused": refused})

    def send(self, kind: str, content: dict[str, Any]) -> None:
        """Send something if it is other than what the frame has."""
        if self._sent.get(kind) != content:
            self._sent[kind] = content
            self._channel.send(kind, content)

    def show(self, view: View, now_s: float) -> None:
        """Send what is to be seen."""
        hall = view.hall
        self.send("race", _runs(hall.status))
        self._send_worlds(hall.status.snapshots)
        self.send("curves", {**hall.curves, "events": hall.events_sent})
        self.send("moment", _moment(view))
        # Whoever takes long to draw gets fewer pictures, and none is made for nothing.
        if not self._channel.waits("boards"):
            self._send_boards(view)
        is_other = not view.playing and not are_same(view.shown, self._shown)
        if is_other or now_s - self._slowly_s >= _SLOWLY_S:
            self._slowly_s, self._shown = now_s, view.shown
            self._send_slowly(view)

    def _send_worlds(self, snapshots: tuple[Snapshot, ...]) -> None:
        worlds = {world_key(one.spec.world): one.spec.world for one in snapshots}
        if self._sent.get("worlds") != list(worlds):
            self._sent["worlds"] = list(worlds)
            self._channel.send("worlds", {"worlds": [world_sent(one) for one in worlds.values()]})

    def _send_boards(self, view: View) -> None:
        rests = not view.playing
        boards = [
            view.hall.ground(place, one, look, None, rests)
            for place, (one, look) in enumerate(zip(view.shown, view.looks, strict=True))
        ]
        if view.between is not None:
            other, one = view.between
            pair = view.pair.other, view.pair.one
            boards.append(view.hall.ground(pair, one, view.look_at_change, other, rests))
        self._send_parts("boards", boards)

    def _send_slowly(self, view: View) -> None:
        """Send what is read, and lines over the boards."""
        overs = [
            view.hall.over(place, one, look, None)
            for place, (one, look) in enumerate(zip(view.shown, view.looks, strict=True))
        ]
        if view.between is not None:
            other, one = view.between
            pair = view.pair.other, view.pair.one
            overs.append(view.hall.over(pair, one, view.look_at_change, other))
        self._send_parts("overs", overs)
        self.send("readings", _readings(view))
        self.send("legend", _legend(view))
        self.send("compare", _comparison(view))
        self.send("cell", _cell(view))

    def _send_parts(self, kind: str, parts: list[msgspec.Raw]) -> None:
        """Send parts of boards if one of them is another one."""
        if not are_same(self._parts.get(kind, ()), parts):
            self._parts[kind] = parts
            self._channel.send(kind, {"boards": parts})


def _runs(status: RaceStatus) -> dict[str, Any]:
    """Which runs there are."""
    looks = looks_of([entry.preset for entry in status.entries])
    return {
        "runs": [
            {"name": entry.name, "about": repertoire(entry.spec), "seed": entry.seed, "look": look}
            for entry, look in zip(status.entries, looks, strict=True)
        ]
    }


def _moment(view: View) -> dict[str, Any]:
    """Where the playhead is; it moves with each frame."""
    status = view.hall.status
    return {
        "step": view.step,
        "end": status.step,
        "live": view.is_live,
        "playing": view.playing,
        "finished": status.finished,
        "direction": view.direction,
        "rate": view.rate,
        "rates": rates_of(status.step, view.pace),
        "error": status.error,
        "preparing": status.preparing,
    }


def _readings(view: View) -> dict[str, Any]:
    """What is read of the runs, who leads, and how fast they go."""
    status, hall = view.hall.status, view.hall
    names = [entry.name for entry in status.entries]
    leads = ahead_of_others(view.shown, view.step)
    digests = status.digests if view.is_live and status.digests else [""] * len(names)
    speed = 0.0 if math.isinf(status.speed) else status.speed
    speeds = [(one, speed_label(one)) for one in sorted({*_SPEEDS, speed} - {0.0})]
    return {
        "standing": str(standing(names, view.shown, view.step, status.common_starts)),
        "speed": speed,
        "speeds": [*speeds, (0.0, speed_label(FULL_SPEED))],
        "pace": _pace(status),
        "runs": [
            run_sent(
                one,
                status.stands[place] if view.is_live else "",
                hall.greedy.at(place, view.step),
                digests[place],
                place in leads,
                view.is_live,
            )
            for place, one in enumerate(view.shown)
        ],
    }


def _pace(status: RaceStatus) -> str:
    """How fast the runs go, or why they do not."""
    if not status.playing:
        return ""
    if all(status.stands):
        return "All are as far as they are known."
    return f"{rate_in_short(status.steps_per_s)} steps/s each"


def _legend(view: View) -> dict[str, Any]:
    """What the colours mean, and what each board shows."""
    layer, looks = LAYERS[view.look.layer], view.looks
    extras = [
        view.hall.extras(one, look, None) for one, look in zip(view.shown, looks, strict=True)
    ]
    return {
        "layer": layer.title_of(view.shown[0].spec.learner),
        "html": str(_colours_meant(view, layer, extras)),
        "captions": [layer.caption(*each) for each in zip(view.shown, looks, extras, strict=True)],
    }


def _colours_meant(view: View, layer: Layer, extras: Sequence[Extras]) -> Markup:
    """What colours mean: once where they mean the same in all runs, or else of which runs what."""
    names = [entry.name for entry in view.hall.status.entries]
    looks, learners = view.looks, [one.spec.learner for one in view.shown]
    meant = [
        (layer.title_of(learner), layer.lacks(learner), counted_by(learner)) for learner in learners
    ]
    firsts = [place for place, one in enumerate(meant) if meant.index(one) == place]
    legends = [layer.legend(view.shown[place], looks[place], extras[place]) for place in firsts]
    if len(firsts) == 1:
        return legends[0]
    parts: list[Markup] = []
    for first, legend in zip(firsts, legends, strict=True):
        of = joined_by_and(
            [name for name, one in zip(names, meant, strict=True) if one == meant[first]]
        )
        parts += [element("b", f"{layer.title_of(learners[first])}, {of}"), legend]
    return element("div", joined(parts, ""))


def _comparison(view: View) -> dict[str, Any]:
    """Of two of the runs, where they went different ways first, and what is different now."""
    pair, hall = view.pair, view.hall
    status = hall.status
    found = hall.apart.of(hall.race, pair.one, pair.other, status.step)
    one_name, other_name = status.entries[pair.one].name, status.entries[pair.other].name
    sent: dict[str, Any] = {
        "one": pair.one,
        "other": pair.other,
        "shown": pair.shown,
        "text": apart_said(found, (one_name, other_name), status.step, status.trials[pair.one]),
        "step": None if found is None else found.step,
        "caption": "",
        "legend": "",
    }
    if view.between is not None:
        other, one = view.between
        extras, look = Extras(since=other, names=(other_name, one_name)), view.look_at_change
        sent["caption"] = CHANGE.caption(one, look, extras)
        sent["legend"] = str(CHANGE.legend(one, look, extras))
    return sent


def _cell(view: View) -> dict[str, Any]:
    """What all runs know of the cell that is pointed at."""
    point = view.point
    if point is None:
        return {"rows": None, "east": 0, "north": 0}
    readings = [_reading(point, one, view.look) for one in view.shown]
    rows = [row._asdict() for row in cell_rows(readings)]
    return {"rows": rows, "east": point.east, "north": point.north}


def _reading(point: Point, snapshot: Snapshot, look: Look) -> CellReading | None:
    size = snapshot.world.size
    x, y = size // 2 + point.east, size // 2 + point.north
    if not (0 <= x < size and 0 <= y < size):
        return None
    heading = point.heading
    if heading is None or look.frame != ALL:
        heading = heading_shown(look, snapshot.heading)
    return reading_at(snapshot, x, y, heading)
