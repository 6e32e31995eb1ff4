"""A board as it is sent to the pages that draw it themselves (``app/web/player``): data for JSON.

A picture is a function of the state under each cell, and of the patterns that lie over the board.
So what goes out is a colour for each state, and not for each cell; which state lies where is sent
once for a world. What a layer looks like is decided by the layer alone: it paints on a raster of a
pixel for each state (:func:`app.picture.raster.by_state`).

Lengths are in cells, places east and north of the prey; colours of states are bytes in base64, the
others as CSS writes them.
"""

import base64
import functools
import hashlib
from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np

from app.live.snapshot import Snapshot
from app.picture import outlines
from app.picture.colours import css
from app.picture.contours import Contour
from app.picture.frames import folds, rim
from app.picture.layer import Extras, Layer, Picture
from app.picture.layers import LAYERS
from app.picture.look import ALL, Look, heading_shown
from app.picture.multiples import HALF_HEIGHT, SHARE, SIDE, TILES, all_headings
from app.picture.outlines import BOARD_UNITS
from app.picture.raster import PATTERNS, Raster, areas, by_state, raster, sensors_of
from app.picture.theme import OUTCOME_SHAPES, Theme
from app.player.hunts import arrow_middle, end_of, ends_of, names_of, placed, sketched, way_of
from app.player.names import middles
from app.player.tags import places_of
from sim.spec import N_HEADINGS, WorldSpec

_THIN: Final = 1.0
_THICK: Final = 2.5
_ARROW: Final = 4.0
_SMALL_ARROW: Final = 2.5
_PATH: Final = 2.0
"""Widths of lines in pixels, on a board as large as that of the lab."""
_DIGITS: Final = 2
"""Of a cell."""


def world_sent(world: WorldSpec) -> dict[str, Any]:
    """What a page has to know of a world before it can draw a board of it; sent once."""
    found = areas(world)
    return {
        "key": world_key(world),
        "size": world.size,
        "rim": rim(world),
        "field": world.vision_radius * world.scale,
        "n_states": len(found.states),
        "states": _base64(found.of_cells.astype("<u2")),
        "tiles": {
            "side": SIDE,
            "share": SHARE,
            "height": round(2 * HALF_HEIGHT, 6),
            "places": [[round(tile.east, 6), round(tile.north, 6)] for tile in TILES],
        },
    }


def world_key(world: WorldSpec) -> str:
    """The same for worlds that are drawn alike."""
    drawn = (*sensors_of(world), *sensors_of(world.of_skills), world.vision_radius)
    return hashlib.blake2b(repr(drawn).encode(), digest_size=6).hexdigest()


def board_sent(
    snapshot: Snapshot, look: Look, extras: Extras, rests: bool = False, named: bool = False
) -> dict[str, Any]:
    """All that is drawn of a moment; both parts, which may be sent apart (:func:`over_sent`).

    Args:
        snapshot: the moment.
        look: how it is seen.
        extras: what the layer shows besides.
        rests: whether the learner stands still: then a trial that has just ended is still shown.
        named: whether there are names on prey and predator.
    """
    look, picture = _painted(snapshot, look, extras)
    return _ground(snapshot, look, picture, rests, named) | _over(snapshot, look, picture)


def ground_sent(
    snapshot: Snapshot, look: Look, extras: Extras, rests: bool = False, named: bool = False
) -> dict[str, Any]:
    """The part of a board that changes with each moment: its colours, and the hunt."""
    look, picture = _painted(snapshot, look, extras)
    return _ground(snapshot, look, picture, rests, named)


def over_sent(snapshot: Snapshot, look: Look, extras: Extras) -> dict[str, Any]:
    """The other part: lines and words over the colours, which take longer to find than all
    colours; those that were shown stay until others come, if they are of the same view."""
    look, picture = _painted(snapshot, look, extras)
    return _over(snapshot, look, picture)


# Colours --------------------------------------------------------------------------------------


def _painted(snapshot: Snapshot, look: Look, extras: Extras) -> tuple[Look, Picture]:
    """The picture, its colours by states where it goes by states; and the look that it has."""
    layer, world = LAYERS[look.layer], snapshot.spec.world
    look = layer.heeded(look, snapshot.spec.learner)
    if look.frame == ALL:
        return look, all_headings(snapshot, look, layer, extras, _raster(layer, world, SIDE))
    return look, layer.draw(snapshot, look, extras, _raster(layer, world, world.size))


def _raster(layer: Layer, world: WorldSpec, side: int) -> Raster:
    return by_state(world, side) if layer.by == "state" else raster(world, side)


def _colours(picture: Picture, look: Look) -> dict[str, str]:
    """The colours of states, and those on a pattern where that makes a difference."""
    if LAYERS[look.layer].by == "cell":
        return {"colours": _base64(picture.colours)}
    n_boards = N_HEADINGS if look.frame == ALL else 1
    # (board, pattern, state, 3), all boards of a pattern after those of the one before.
    each = picture.colours.reshape(n_boards, len(PATTERNS), -1, 3).transpose(1, 0, 2, 3)
    sent = {"colours": _base64(each[0])}
    for pattern, colours in zip(PATTERNS[1:], each[1:], strict=True):
        if not np.array_equal(colours, each[0]):
            sent[pattern] = _base64(colours)
    return sent


def _base64(array: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")


# The part that changes with each moment ---------------------------------------------------------


def _ground(
    snapshot: Snapshot, look: Look, picture: Picture, rests: bool, named: bool
) -> dict[str, Any]:
    layer = LAYERS[look.layer]
    turns = "frame" in layer.heeds_of(snapshot.spec.learner, look.option)
    shown = heading_shown(look, snapshot.heading)
    return {
        "world": world_key(snapshot.spec.world),
        "view": _view(snapshot, look),
        "by": layer.by,
        **_colours(picture, look),
        "prey": shown if turns else None,
        "sees": look.field and turns,
        "round": folds(look),
        "tiles": look.frame == ALL,
        "theme": _theme(look.theme),
        "hunt": None if look.frame == ALL else _hunt(snapshot, look, shown, rests, named),
    }


def _view(snapshot: Snapshot, look: Look) -> str:
    """What is looked at and how, so that lines over another one are not drawn over this one."""
    shown = heading_shown(look, snapshot.heading)
    return f"{world_key(snapshot.spec.world)} {look.layer} {look.option} {look.frame} {shown}"


@functools.lru_cache(maxsize=4)
def _theme(theme: Theme) -> dict[str, Any]:
    colours = {name: css(getattr(theme, name)) for name in theme._fields}
    return {"dark": theme.is_dark, **colours}


def _hunt(snapshot: Snapshot, look: Look, shown: int, rests: bool, named: bool) -> dict[str, Any]:
    world, theme = snapshot.spec.world, look.theme
    ends = ends_of(snapshot, look, shown, theme)
    sent: dict[str, Any] = {
        "heading": snapshot.heading,
        "turned": shown != snapshot.heading,
        "predator": None,
        "trail": [],
        "words": [],
        "ends": [
            [*_numbers(place, world), OUTCOME_SHAPES[outcome], css(colour)]
            for place, outcome, colour in zip(
                ends.places, ends.outcomes.tolist(), ends.colours, strict=True
            )
        ],
    }
    if not look.hunts:
        return sent
    way = way_of(snapshot, rests)
    path = placed(snapshot.world, world, look, way.shown, way.heading, shown)
    sent["predator"] = _numbers(path[-1], world)
    if look.trail:
        sent["trail"] = _numbers(path, world)
    if way.outcome is not None and way.outcome in OUTCOME_SHAPES:
        colour = css(theme.of_outcome(way.outcome))
        sent["ended"] = {"shape": OUTCOME_SHAPES[way.outcome], "colour": colour}
    tags = names_of(world, look, way, path[-1], shown) if named else end_of(way, path[-1])
    places = places_of(tags, [arrow_middle(shown)] if named else [])
    sent["words"] = [
        [tag.text, *_numbers(np.array(place), world)]
        for tag, place in zip(tags, places, strict=True)
    ]
    return sent


def _numbers(points: np.ndarray, world: WorldSpec) -> list[float]:
    """Points in board units as a flat list in cells."""
    return _rounded(points * (world.size / BOARD_UNITS))


def _rounded(points: np.ndarray) -> list[float]:
    return np.round(points, _DIGITS).ravel().tolist()


# Lines and words ----------------------------------------------------------------------------------


def _over(snapshot: Snapshot, look: Look, picture: Picture) -> dict[str, Any]:
    world = snapshot.spec.world
    over = picture.over()
    named = _with_regions(picture, world) if look.frame != ALL else picture
    labels = [*middles(named), *over.labels]
    lines = [
        *_outlines(snapshot, look),
        *_contours(over.contours, world, folds(look)),
        *_arrows(picture, look, world),
    ]
    return {
        "over": _view(snapshot, look),
        "lines": lines,
        "labels": [[label.text, *_rounded(np.array(label[1:]))] for label in labels],
    }


def _with_regions(picture: Picture, world: WorldSpec) -> Picture:
    """A picture by states whose regions are spread over the board's cells."""
    if picture.regions is None or picture.regions.size == world.size**2:
        return picture
    return picture._replace(regions=picture.regions[areas(world).of_cells])


def _outlines(snapshot: Snapshot, look: Look) -> Iterable[dict[str, Any]]:
    """What may be wished over any layer."""
    if look.frame == ALL:
        return
    world, theme, is_round = snapshot.spec.world, look.theme, folds(look)
    if look.grid:
        yield _line(outlines.grid(world, is_round), theme.lines, _THIN, world)
    if look.sensors:
        about_skill = LAYERS[look.layer].about == "skill"
        sensors = outlines.sensors(world.of_skills if about_skill else world, is_round)
        yield _line(sensors, theme.border, _THIN, world)
    if look.start_zone:
        yield _line(outlines.start_zone(world), theme.zone, _PATH, world)
    if look.paths and look.hunts:
        shown = heading_shown(look, snapshot.heading)
        for path in snapshot.paths:
            way = outlines.segments(sketched(snapshot, look, path, shown))
            yield _line(way, theme.of_outcome(path.outcome), _PATH, world)


def _contours(
    contours: Sequence[Contour], world: WorldSpec, is_round: bool
) -> Iterable[dict[str, Any]]:
    for contour in contours:
        parts, _ = outlines.contour_lines([contour], world, is_round)
        if len(parts):
            yield _line(parts, contour.colour, _THICK if contour.is_edge else _THIN, world)


def _arrows(picture: Picture, look: Look, world: WorldSpec) -> Iterable[dict[str, Any]]:
    """Arrows by their colours: each as its tail and its head."""
    if picture.arrows is None or not len(picture.arrows):
        return
    unit = BOARD_UNITS / world.size
    there = outlines.within(picture.arrows * unit, world, folds(look))
    inks = picture.arrow_colours
    if inks is None:
        inks = np.broadcast_to(np.array(look.theme.ink, np.uint8), (len(there), 3))
    width = _SMALL_ARROW if look.frame == ALL else _ARROW
    colours, number = np.unique(inks[there], axis=0, return_inverse=True)
    for index, colour in enumerate(colours):
        arrows = picture.arrows[there][number.ravel() == index]
        ends = [_rounded(arrow) for arrow in arrows.astype(np.float64)]
        yield {"colour": css(colour), "width": width, "points": ends, "arrows": True}


def _line(
    parts: np.ndarray, colour: np.ndarray | tuple[int, int, int], width: float, world: WorldSpec
) -> dict[str, Any]:
    """Segments ``(n, 2, 2)`` in board units; those that follow each other are one line."""
    cells = np.round(parts * (world.size / BOARD_UNITS), _DIGITS)
    starts = np.flatnonzero((cells[1:, 0] != cells[:-1, 1]).any(axis=1)) + 1
    points = [
        np.concatenate([run[:1, 0], run[:, 1]]).ravel().tolist() for run in np.split(cells, starts)
    ]
    return {"colour": css(colour), "width": width, "points": points}


def described(snapshot: Snapshot, look: Look) -> str:
    """What the board is, for those who cannot see it."""
    size = snapshot.spec.world.size
    title = LAYERS[look.layer].title_of(snapshot.spec.learner)
    return f"The board, {size} by {size} cells, the prey in its middle. Layer: {title}."
