"""Films read back, as the replay page's script does it (``app/web/replay/film.js``)."""

import base64
import json
import zlib
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from app.player.film import POINTS, Board, Shot, View


def unpacked(data: bytes) -> list[Shot]:
    """The shots of a film, as they were added; planes that are as the first are there as well."""
    raw = zlib.decompress(data)
    end = 4 + int.from_bytes(raw[:4], "little")
    head = json.loads(raw[4:end])
    texts: list[str] = head["texts"]
    shots: list[tuple[int, int, int]] = head["shots"]
    reader = _Reader(raw, end)
    boards = {
        name: _boards(view, texts, len(shots), reader) for name, view in head["views"].items()
    }
    trails = reader.ways(head["trails"])
    views = {
        name: [
            _with_hunt(view, texts, trails, head["views"][name]["hunts"][number])
            for number, view in enumerate(each)
        ]
        for name, each in boards.items()
    }
    return [
        Shot(
            line=line,
            step=step,
            trial=trial,
            texts=tuple(_chosen(texts, head["said"][number])),
            views={name: each[number] for name, each in views.items()},
        )
        for number, (line, step, trial) in enumerate(shots)
    ]


class _Reader:
    def __init__(self, raw: bytes, place: int) -> None:
        self._raw, self._place = raw, place

    def ways(self, lengths: Sequence[int]) -> list[list[float]]:
        """Points of lines of so many each."""
        east, north = (self.numbers((sum(lengths),), 2).astype(np.int16) for _ in range(2))
        less = np.stack([east, north], axis=1).astype(np.int64)
        return [
            (np.cumsum(less[first:until], axis=0) / POINTS).ravel().tolist()
            for first, until in pairwise(np.cumsum([0, *lengths]).tolist())
        ]

    def numbers(self, shape: tuple[int, ...], n_bytes: int) -> np.ndarray:
        """Numbers as they were written, 0 to 256 ** n_bytes."""
        size = int(np.prod(shape))
        found = np.zeros(shape, np.int64)
        for byte in range(n_bytes):
            part = np.frombuffer(self._raw, np.uint8, size, self._place)
            found |= part.reshape(shape).astype(np.int64) << 8 * byte
            self._place += size
        return found


def _chosen(texts: list[str], places: Sequence[int]) -> list[str]:
    return [texts[place] for place in places]


def _boards(view: Mapping[str, Any], texts: list[str], n: int, reader: _Reader) -> list[View]:
    planes: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for name, plane in view["planes"].items():
        palette = np.frombuffer(base64.b64decode(plane["colours"]), np.uint8).reshape(-1, 6)
        n_bytes = 1 if len(palette) <= 256 else 2
        less = reader.numbers((n, plane["states"]), n_bytes)
        planes[name] = palette, np.cumsum(less, axis=0) & ((1 << 8 * n_bytes) - 1)
    lines = _lines(view, texts, reader.ways(view["lengths"]))
    found: list[View] = []
    for number in range(n):
        light, dark, *said = _chosen(texts, view["rests"][number])
        both: tuple[Board, Board] = json.loads(light), json.loads(dark)
        for side, board in enumerate(both):
            board["lines"] = [{**look[side], "points": at} for look, at in lines[number]]
            for name, (palette, places) in planes.items():
                colours = palette[places[number], 3 * side : 3 * side + 3]
                board[name] = base64.b64encode(colours.tobytes()).decode()
        found.append(View(*both, tuple(said)))
    return found


def _lines(
    view: Mapping[str, Any], texts: list[str], ways: Sequence[list[float]]
) -> list[list[tuple[list[Any], Sequence[list[float]]]]]:
    """The lines of each moment: what they look like, and where they go."""
    ends = np.cumsum([0, *view["ways"]]).tolist()
    lines = [
        (json.loads(look), ways[first:until])
        for look, (first, until) in zip(_chosen(texts, view["looks"]), pairwise(ends), strict=True)
    ]
    ends = np.cumsum([0, *view["lines"]]).tolist()
    return [lines[first:until] for first, until in pairwise(ends)]


def _with_hunt(
    view: View, texts: list[str], trails: Sequence[list[float]], hunt: Sequence[int]
) -> View:
    for board, text in zip((view.light, view.dark), hunt[:2], strict=True):
        found = json.loads(texts[text])
        board["hunt"] = found and {**found, "trail": trails[hunt[2]]}
    return view
