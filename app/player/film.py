"""A film: boards of many moments in few bytes, exact to the last colour.

What a board shows is a colour for each state (:mod:`app.player.boards`), and from one moment to the
next hardly any of them changes. So each plane of colours is written as places in a palette, which
has the colour for light pages and that for dark ones together, less the place of the moment before:
nearly all of that is 0, and deflates to little. Texts, and all else of a board, are in a table that
has each of them once; points of lines are whole numbers of ``1 / POINTS`` cells, each less the one
before it on its line.

``app/web/replay/film.js`` reads what is written here.
"""

import base64
import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Generic, NamedTuple, TypeVar

import numpy as np

POINTS: Final = 100
"""Parts of a cell in which points are written; boards round theirs to that."""
PLANES: Final = ("colours", "dots", "rising", "falling")
"""What of a board is a colour for each state; where one is not there it is as the first."""

Board = dict[str, Any]
"""A board as it is sent."""
Thing = TypeVar("Thing")


class View(NamedTuple):
    """What is seen of one moment in one way, on light pages and on dark ones."""

    light: Board
    dark: Board
    texts: tuple[str, ...]
    """What is read beside it."""


class Shot(NamedTuple):
    """One moment."""

    line: int
    step: int
    trial: int
    texts: tuple[str, ...]
    """What is read of it whatever is seen."""
    views: Mapping[str, View]
    """By their names; all shots have the same ones."""


@dataclass
class _Track:
    """One way to see all moments."""

    planes: dict[str, list[np.ndarray]] = field(default_factory=dict[str, list[np.ndarray]])
    """(state,) int64 each: the colour for light pages and that for dark ones as one number."""
    lines: list[Sequence[Mapping[str, Any]]] = field(
        default_factory=list[Sequence[Mapping[str, Any]]]
    )
    looks: list[tuple[str, ...]] = field(default_factory=list[tuple[str, ...]])
    """Of each of these lines what it looks like on light pages and on dark ones, as JSON."""
    hunts: list["_Hunt"] = field(default_factory=list["_Hunt"])
    rests: list[tuple[str, ...]] = field(default_factory=list[tuple[str, ...]])
    """All else of the boards, and texts."""


class _Hunt(NamedTuple):
    """The hunt on a board; the same one is on several."""

    light: str
    """All of it but the trail, as JSON."""
    dark: str
    trail: tuple[float, ...]


class Film:
    """Shots, as they are added, and what is written of those that are kept."""

    def __init__(self) -> None:
        self.shots: list[tuple[int, int, int]] = []
        """Line, step and trial of each."""
        self._texts: list[tuple[str, ...]] = []
        self._tracks: dict[str, _Track] = {}

    def add(self, shot: Shot) -> None:
        """Add the next moment."""
        self.shots.append((shot.line, shot.step, shot.trial))
        self._texts.append(shot.texts)
        for name, view in shot.views.items():
            track = self._tracks.setdefault(name, _Track())
            _add_colours(track, view)
            track.lines.append(view.light["lines"])
            track.looks.append(
                tuple(
                    _json([_without(line, ["points"]) for line in both])
                    for both in zip(view.light["lines"], view.dark["lines"], strict=True)
                )
            )
            track.hunts.append(_hunt(view))
            track.rests.append((_rest(view.light), _rest(view.dark), *view.texts))

    def packed(self, kept: Sequence[int]) -> bytes:
        """Some of the shots, by their places, as bytes that are deflated."""
        table, trails = _Table[str](), _Table[tuple[float, ...]]()
        head: dict[str, Any] = {
            "points": POINTS,
            "shots": [self.shots[place] for place in kept],
            "said": [[table.place(text) for text in self._texts[place]] for place in kept],
        }
        body: list[bytes] = []
        head["views"] = {
            name: _packed(track, kept, table, trails, body) for name, track in self._tracks.items()
        }
        head["texts"] = table.things
        head["trails"] = [len(trail) // 2 for trail in trails.things]
        body += _ways(trails.things)
        start = json.dumps(head, separators=(",", ":"), ensure_ascii=False).encode()
        return zlib.compress(b"".join([len(start).to_bytes(4, "little"), start, *body]), 9)


def _packed(
    track: _Track,
    kept: Sequence[int],
    table: "_Table[str]",
    trails: "_Table[tuple[float, ...]]",
    body: list[bytes],
) -> dict[str, Any]:
    planes: dict[str, Any] = {}
    for name, colours in track.planes.items():
        palette, places = np.unique(
            np.stack([colours[place] for place in kept]), return_inverse=True
        )
        order = _in_order(palette)
        places = np.argsort(order)[places.reshape(len(kept), -1)]
        planes[name] = {"colours": _palette(palette[order]), "states": places.shape[1]}
        less = np.diff(places, axis=0, prepend=0)
        body += _bytes(less, 1 if len(palette) <= 256 else 2)
    lines = [track.lines[place] for place in kept]
    looks = [table.place(look) for place in kept for look in track.looks[place]]
    ways = [way for each in lines for line in each for way in line["points"]]
    body += _ways(ways)
    hunts = [track.hunts[place] for place in kept]
    return {
        "planes": planes,
        "lines": [len(each) for each in lines],
        "looks": looks,
        "ways": [len(line["points"]) for each in lines for line in each],
        "lengths": [len(way) // 2 for way in ways],
        "hunts": [
            [table.place(hunt.light), table.place(hunt.dark), trails.place(hunt.trail)]
            for hunt in hunts
        ],
        "rests": [[table.place(text) for text in track.rests[place]] for place in kept],
    }


class _Table(Generic[Thing]):
    """Things, each of them once."""

    def __init__(self) -> None:
        self._places: dict[Thing, int] = {}

    def place(self, thing: Thing) -> int:
        return self._places.setdefault(thing, len(self._places))

    @property
    def things(self) -> list[Thing]:
        return list(self._places)


def _add_colours(track: _Track, view: View) -> None:
    former = list(track.planes.get("colours", ()))
    for name in PLANES:
        if name in view.light or name in view.dark or name in track.planes:
            # One that comes late was as the first until then.
            track.planes.setdefault(name, list(former)).append(_together(view, name))


def _together(view: View, plane: str) -> np.ndarray:
    """(state,) int64: two colours as one number; where a plane is not there, those of the first."""
    parts = [
        np.frombuffer(base64.b64decode(board.get(plane, board["colours"])), np.uint8)
        .reshape(-1, 3)
        .astype(np.int64)
        for board in (view.light, view.dark)
    ]
    both = np.concatenate(parts, axis=1)
    return both @ (1 << 8 * np.arange(5, -1, -1, dtype=np.int64))


def _palette(numbers: np.ndarray) -> str:
    """Pairs of colours as base64 of six bytes each."""
    six = numbers.astype(">u8").view(np.uint8).reshape(-1, 8)[:, 2:]
    return base64.b64encode(six.tobytes()).decode()


def _in_order(numbers: np.ndarray) -> np.ndarray:
    """Colours as one follows another along their scale: then what changes little is a small number.

    From the first on, each is followed by the one among the rest that is most like it.
    """
    light = np.stack([numbers >> 8 * byte & 255 for byte in (5, 4, 3)], axis=1)
    rest = np.ones(len(numbers), bool)
    order = np.zeros(len(numbers), np.int64)
    for place in range(1, len(numbers)):
        rest[order[place - 1]] = False
        apart = np.abs(light - light[order[place - 1]]).sum(axis=1)
        order[place] = np.where(rest, apart, np.iinfo(np.int64).max).argmin()
    return order


def _bytes(numbers: np.ndarray, n_bytes: int) -> list[bytes]:
    """Whole numbers, of such as take more than one byte all low ones first."""
    whole = numbers.astype(np.int64) & ((1 << 8 * n_bytes) - 1)
    return [((whole >> 8 * byte) & 255).astype(np.uint8).tobytes() for byte in range(n_bytes)]


def _ways(ways: Sequence[Sequence[float]]) -> list[bytes]:
    """Points of lines, each less the one before it: all east of it, and then all north."""
    whole = [np.rint(np.array(way, np.float64).reshape(-1, 2) * POINTS) for way in ways]
    less = [np.diff(each, axis=0, prepend=0) for each in whole if each.size]
    flat = np.concatenate([np.zeros((0, 2)), *less])
    return _bytes(flat[:, 0], 2) + _bytes(flat[:, 1], 2)


def _hunt(view: View) -> _Hunt:
    light, dark = (board["hunt"] for board in (view.light, view.dark))
    trail = () if light is None else tuple(light["trail"])
    return _Hunt(_json(_without(light, ["trail"])), _json(_without(dark, ["trail"])), trail)


def _without(thing: Mapping[str, Any] | None, keys: Sequence[str]) -> dict[str, Any] | None:
    if thing is None:
        return None
    return {key: value for key, value in thing.items() if key not in keys}


def _json(thing: object) -> str:
    return json.dumps(thing, separators=(",", ":"), ensure_ascii=False)


def _rest(board: Board) -> str:
    """All of a board that is no colour of states, no line and no hunt."""
    return _json(_without(board, [*PLANES, "lines", "hunt"]))
