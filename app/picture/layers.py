"""What each layer shows: from a snapshot and a look to colours, heights, arrows, and words.

Pure functions. A layer works per state, in arrays ``(distance, direction)``, and spreads the
result over pixels at the end. Which headings take part is the frame's: all eight, each turned so
that the prey faces east, or one of them as the world is.
"""

import base64
import functools
from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from typing import Literal, NamedTuple

import numpy as np

from app.live.snapshot import Snapshot
from app.picture import pictures
from app.picture.look import FOLDED, Look, heading_shown
from app.picture.pictures import OUTCOME_SHAPES, Raster, Ruler, Shading, Theme, css, swatch_html
from app.words.numbers import of_any_size, round_numbers
from app.words.plain import HEADING_NAMES, MOVE_NAMES, plain
from learners.spec import MOVES
from sim import geometry
from sim.geometry import N_MOVES
from sim.spec import N_HEADINGS, WorldSpec
from sim.world import CAPTURE, FLIGHT, TIMEOUT

TIE = 1e-3
"""Options tie with the best that are worth less than it by no more than this share of it: about
a hundredth of a step nearer to capture."""
DECADES = 6
"""Powers of ten between the ends of a logarithmic scale of amounts."""
MOST_LINES = 10
"""Isochrones that a picture has at most."""
FEWEST_BETWEEN_LINES = 500
"""Trials from an isochrone to the next at least."""
TILE = 75
"""Pixels along each side of one of the eight small pictures."""

_LATTICE = 20
"""Arrows along each side of the board."""
_ARROW_LENGTH = 0.75
"""Of the distance between two arrows."""
_AGREEMENT = 0.5
"""Mean of the headings' unit vectors that is too short to be a direction."""
_LINE_SHADE = 0.3
"""Brightness of an isochrone as a share of what it runs through."""
_FAINT = 0.5
"""How strongly values cover the board below arrows, which are to be seen on it."""
_SOFT = 0.75
"""How strongly an outcome covers the board, so that dots of the same colour stand out."""

_MOVE_SIGNS = "↙↓↘←·→↖↑↗"


@dataclass(frozen=True, eq=False)
class SuccessMap:
    """How hunts without exploration end, by where they start."""

    outcomes: np.ndarray
    """(heading, y, x) int8: ``CAPTURE``, ``FLIGHT`` or ``TIMEOUT``; 0 where not known."""
    trial: int
    """Trial whose tables were followed."""
    generation: int
    """Run of the session to which they belong."""


@dataclass(frozen=True)
class Extras:
    """What layers show besides a snapshot."""

    success: SuccessMap | None = None


class Picture(NamedTuple):
    """What a layer draws."""

    colours: np.ndarray
    """(y * x, 3) uint8."""
    height: np.ndarray
    """(y * x,) float32: 0...1, or down to -1 for losses; 0 where nothing is known."""
    arrows: np.ndarray | None = None
    """(n, 2, 2) float32: tail and head, each in cells east and north of the prey."""
    regions: np.ndarray | None = None
    """(y * x,) int: which of the names holds in each cell, -1 for none."""
    names: tuple[str, ...] = ()
    """What stands on the board where its colour is to be seen, for those who cannot tell it."""


About = Literal["nothing", "option", "skill"]
Draw = Callable[[Snapshot, Look, Extras, Raster], Picture]
Words = Callable[[Snapshot, Look, Extras], str]


class Layer(NamedTuple):
    """One thing that the board can show."""

    key: str
    title: str
    draw: Draw
    """Draws on any raster; arrows are for a raster of one pixel for each cell."""
    legend: Words
    """HTML for a narrow panel: what the colours mean, and the limits of their scale."""
    caption: Words
    """One line on what is being seen, fit to stand in HTML."""
    about: About = "nothing"
    """Whether it shows one option, or one skill, of the look."""

    def paint(self, snapshot: Snapshot, look: Look, extras: Extras) -> Picture:
        """The picture on the board."""
        return self.draw(snapshot, look, extras, pictures.raster(snapshot.spec.world))


# Frames -------------------------------------------------------------------------------------


def _folds(look: Look) -> bool:
    return look.frame == FOLDED


def _in_frame(per_heading: np.ndarray, snapshot: Snapshot, look: Look) -> np.ndarray:
    """Maps of the headings that take part, ``(heading, distance, direction, ...)``.

    All eight, turned, where the picture is folded; otherwise one, as it is.
    """
    if not _folds(look):
        heading = heading_shown(look, snapshot.heading)
        return per_heading[heading : heading + 1]
    _, n_distances, n_directions = per_heading.shape[:3]
    flat = per_heading.reshape(-1, *per_heading.shape[3:])
    return flat.take(_fold_index(n_distances, n_directions), axis=0)


@functools.lru_cache(maxsize=8)
def _fold_index(n_distances: int, n_directions: int) -> np.ndarray:
    """(heading, distance, direction) int64: the state that each turned state was."""
    shape = (N_HEADINGS, n_distances, n_directions)
    return geometry.fold(np.arange(np.prod(shape)).reshape(shape), n_directions)


def _turned_moves() -> np.ndarray:
    """(heading, move) int64: how a move points when the prey of a heading is turned to the east."""
    number = {(int(x), int(y)): move for move, (x, y) in enumerate(geometry.MOVES)}
    compass = [number[int(x), int(y)] for x, y in geometry.HEADINGS]
    turned = np.full((N_HEADINGS, N_MOVES), geometry.STAY)
    for heading in range(N_HEADINGS):
        for direction in range(N_HEADINGS):
            turned[heading, compass[direction]] = compass[(direction - heading) % N_HEADINGS]
    return turned


_TURNED = _turned_moves()
_UNTURNED = np.argsort(_TURNED, axis=1)
"""(heading, move) int64: the move in the world that points so in the turned picture."""
_POINTING = geometry.MOVES / np.maximum(np.hypot(*geometry.MOVES.T), 1)[:, None]
"""(move, xy) float64: direction of a move, of length 1; 0 for staying."""


def _options_in_frame(snapshot: Snapshot, look: Look) -> np.ndarray:
    """Values ``(heading, distance, direction, option)`` of the headings that take part.

    Options that are moves are those of the picture, so they turn with it.
    """
    values = _in_frame(snapshot.selection_q, snapshot, look)
    if not (_folds(look) and _has_moves(snapshot)):
        return values
    return np.take_along_axis(values, _UNTURNED[:, None, None, :], axis=-1)


# Options ------------------------------------------------------------------------------------


def option_names(snapshot: Snapshot) -> tuple[str, ...]:
    """Options as people say them; not escaped."""
    if _has_moves(snapshot):
        return MOVE_NAMES
    return tuple(plain(skill) for skill in snapshot.spec.learner.skills)


def _has_moves(snapshot: Snapshot) -> bool:
    return snapshot.spec.learner.options == MOVES


def _name(snapshot: Snapshot, option: int) -> str:
    """An option's name, fit to stand in HTML."""
    return escape(option_names(snapshot)[option])


def _option(snapshot: Snapshot, look: Look) -> int:
    """The option that is shown: a look may still name one of a former run."""
    return min(max(look.option, 0), snapshot.selection_q.shape[-1] - 1)


def _present(snapshot: Snapshot) -> np.ndarray:
    """(n,) int64: options that have values, in order."""
    return np.flatnonzero(np.isfinite(snapshot.selection_q).any(axis=(0, 1, 2)))


def greedy(values: np.ndarray) -> np.ndarray:
    """The one best action along the last axis, -1 where others tie with it or none has a value."""
    # Actions first, because the reductions below are many times faster along that axis.
    by_action = np.ascontiguousarray(np.moveaxis(values, -1, 0))
    best = by_action.max(axis=0)
    rivals = by_action >= best - np.float32(TIE) * np.abs(best)
    clear = np.isfinite(best) & (rivals.sum(axis=0, dtype=np.int8) == 1)
    return np.where(clear, rivals.argmax(axis=0), -1)


def _colours_of_options(snapshot: Snapshot, theme: Theme) -> np.ndarray:
    """(option, 3) float64."""
    if _has_moves(snapshot):
        return pictures.move_colours(theme)
    return pictures.OPTION_COLOURS


# Values: state value, value of an option, a skill's own value -------------------------------


def _reward(snapshot: Snapshot) -> float:
    """Value of certain capture; never 0, for scales to end there."""
    world = snapshot.spec.world
    return max(world.capture_reward, world.flight_reward, 1e-9)


def _penalty(snapshot: Snapshot) -> float:
    """Size of the value of certain flight."""
    world = snapshot.spec.world
    return max(-world.flight_reward, -world.capture_reward, 1e-9)


def _or_zero(values: np.ndarray) -> np.ndarray:
    """Values, 0 where there is no option."""
    return np.where(np.isfinite(values), values, 0)


def _value_shading(snapshot: Snapshot, look: Look, values: np.ndarray) -> Shading:
    """The scale of a value map.

    Limits are fitted to all eight headings whatever the frame, so that what is seen in one frame
    compares with the others.

    Args:
        snapshot: the moment.
        look: whether to fit.
        values: all values of the map, any shape, finite.
    """
    reward = _reward(snapshot)
    fixed = pictures.fixed_shading(look.scale, reward, _penalty(snapshot))
    if not look.fitted:
        return fixed
    return pictures.fitted_shading(values, snapshot.spec.learner.gamma, fixed, reward)


def _value_map(
    values: np.ndarray, shading: Shading, snapshot: Snapshot, look: Look
) -> tuple[np.ndarray, np.ndarray]:
    """Colours ``(distance, direction, 3) uint8`` and heights ``(distance, direction) float32``."""
    known = pictures.known_of(values, _reward(snapshot), snapshot.spec.learner.gamma)
    colours = pictures.shaded(known, shading, look.theme)
    return colours, pictures.shaded_heights(known, shading)


def _spread(
    colours: np.ndarray, height: np.ndarray, raster: Raster, arrows: np.ndarray | None = None
) -> Picture:
    """A picture from colours and heights of states."""
    spread = pictures.on_raster
    return Picture(
        spread(colours.astype(np.uint8, copy=False), raster),
        spread(height.astype(np.float32, copy=False), raster),
        arrows,
    )


def _state_value_map(snapshot: Snapshot, look: Look) -> tuple[np.ndarray, np.ndarray]:
    values = _or_zero(snapshot.value)
    shading = _value_shading(snapshot, look, values)
    return _value_map(_in_frame(values, snapshot, look), shading, snapshot, look)


def _draw_value(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    return _spread(*_state_value_map(snapshot, look), raster)


def _option_values(snapshot: Snapshot, look: Look) -> np.ndarray:
    """Values of the option that is shown, ``(heading, distance, direction)``, all headings.

    As they are; but a move is one of the picture, so that its values are those of another move
    of the world for each heading of a folded picture.
    """
    option, values = _option(snapshot, look), snapshot.selection_q
    if _folds(look) and _has_moves(snapshot):
        return _or_zero(values[np.arange(N_HEADINGS), ..., _UNTURNED[:, option]])
    return _or_zero(values[..., option])


def _draw_option(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    values = _option_values(snapshot, look)
    shading = _value_shading(snapshot, look, values)
    shown = _in_frame(values, snapshot, look)
    return _spread(*_value_map(shown, shading, snapshot, look), raster)


def _skill_values(snapshot: Snapshot, look: Look) -> np.ndarray | None:
    """The local table of the skill that is shown, ``(distance, direction, move)``, if any."""
    if not len(snapshot.skill_q):
        return None
    return snapshot.skill_q[_option(snapshot, look)]


def _skill_shading(snapshot: Snapshot, look: Look, values: np.ndarray) -> Shading:
    """A linear scale, both ways to what a skill is worth that earns the most at every step."""
    learner = snapshot.spec.learner
    weights = learner.reward_of(learner.skills[_option(snapshot, look)])
    # A move covers at most the diagonal of a cell, towards the prey or round it.
    earned = np.sqrt(2.0) * (max(abs(weights.gain), abs(weights.arc)) or 1.0)
    most = float(earned / (1.0 - learner.gamma))
    fixed = pictures.fixed_shading("linear", most, most)
    return pictures.fitted_shading(values, learner.gamma, fixed, most) if look.fitted else fixed


def _draw_skill(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    table = _skill_values(snapshot, look)
    if table is None:
        return _blank(look, raster)
    values = table.max(axis=-1)[None]
    shading = _skill_shading(snapshot, look, values)
    colours, height = _value_map(values, shading, snapshot, look)
    faint = pictures.over_board(colours, _FAINT, look.theme)
    arrows = _arrows(greedy(table)[None], snapshot.spec.world)
    return _spread(faint, height, raster, arrows)


def _blank(look: Look, raster: Raster) -> Picture:
    """The empty board."""
    n_pixels = len(raster.cells)
    board = np.array(look.theme.unknown, np.uint8)
    return Picture(np.tile(board, (n_pixels, 1)), np.zeros(n_pixels, np.float32))


# Choices: the chosen option, the advantage, the policy's flow -------------------------------


def _draw_chosen(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    choice = greedy(_options_in_frame(snapshot, look))
    options = range(snapshot.selection_q.shape[-1])
    votes = np.stack([(choice == option).sum(axis=0, dtype=np.int8) for option in options])
    most = votes.max(axis=0)
    # As many headings for another option would make the colour an accident.
    alone = (votes == most).sum(axis=0) == 1
    winner = votes.argmax(axis=0)
    colours = _colours_of_options(snapshot, look.theme)[winner]
    cover = np.where(alone, most / len(choice), 0.0)
    _, height = _state_value_map(snapshot, look)
    # Nine colours are too many to keep apart, so moves are drawn as what they are, too.
    arrows = _arrows(choice, snapshot.spec.world) if _has_moves(snapshot) else None
    picture = _spread(pictures.over_board(colours, cover, look.theme), height, raster, arrows)
    if _has_moves(snapshot) or _lone_option(snapshot) is not None:
        return picture
    regions = pictures.on_raster(np.where(cover > 0, winner, -1), raster)
    names = tuple(plain(skill) for skill in snapshot.spec.learner.skills)
    return picture._replace(regions=regions, names=names)


def _advantages(values: np.ndarray) -> np.ndarray:
    """Best minus second best along the last axis, float64; 0 where there are not two."""
    best = np.full(values.shape[:-1], -np.inf)
    second = best.copy()
    for option in range(values.shape[-1]):
        value = values[..., option]
        np.maximum(second, np.minimum(best, value), out=second)
        np.maximum(best, value, out=best)
    return np.subtract(best, second, out=np.zeros_like(best), where=np.isfinite(second))


def _advantage_ruler(snapshot: Snapshot, look: Look) -> Ruler:
    fixed = Ruler(0.0, _reward(snapshot)) if look.scale == "linear" else _decades(snapshot)
    if not look.fitted:
        return fixed
    return _fitted(_advantages(snapshot.selection_q), fixed, _least(snapshot))


def _draw_advantage(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    values = _in_frame(snapshot.selection_q, snapshot, look)
    amount = _advantages(values).mean(axis=0)
    amount[amount < _least(snapshot)] = 0.0
    return _draw_amount(amount, _advantage_ruler(snapshot, look), look, raster)


def _moves_of_policy(snapshot: Snapshot, look: Look) -> np.ndarray:
    """The move that the whole hierarchy makes, ``(heading, distance, direction)``; -1 for ties.

    In the frame of the picture.
    """
    if _has_moves(snapshot):
        return greedy(_options_in_frame(snapshot, look))
    option = greedy(_in_frame(snapshot.selection_q, snapshot, look))
    of_skill = greedy(snapshot.skill_q)
    every = np.arange(of_skill[0].size).reshape(of_skill.shape[1:])
    state = _in_frame(np.broadcast_to(every, (N_HEADINGS, *every.shape)), snapshot, look)
    # An option of -1 wraps to some skill here, and is taken out again below.
    move = of_skill.ravel().take(option * every.size + state, mode="wrap")
    clear = (option >= 0) & (move >= 0)
    if _folds(look):
        move = _TURNED[np.arange(N_HEADINGS)[:, None, None], move]
    return np.where(clear, move, -1)


def _draw_flow(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    colours, height = _state_value_map(snapshot, look)
    faint = pictures.over_board(colours, _FAINT, look.theme)
    arrows = _arrows(_moves_of_policy(snapshot, look), snapshot.spec.world)
    return _spread(faint, height, raster, arrows)


def _arrows(moves: np.ndarray, world: WorldSpec) -> np.ndarray:
    """Arrows of one length on a lattice over the board, ``(n, 2, 2) float32``.

    They point the mean way of the headings; where these disagree, or stay, there is none.

    Args:
        moves: ``(heading, distance, direction)``, -1 where there is none to show.
        world: the board.
    """
    places, states = _lattice(world.size, world.n_directions, world.n_distances)
    move = moves.reshape(len(moves), -1)[:, states]
    mean = (_POINTING[move] * (move >= 0)[..., None]).mean(axis=0)
    length = np.hypot(mean[:, 0], mean[:, 1])
    shown = length > _AGREEMENT
    # A board of few cells has an arrow on each; a larger one on every so many.
    spacing = max(world.size / _LATTICE, 1.0)
    half = mean[shown] / length[shown, None] * (spacing * _ARROW_LENGTH / 2)
    return np.stack([places[shown] - half, places[shown] + half], axis=1).astype(np.float32)


@functools.lru_cache(maxsize=8)
def _lattice(size: int, n_directions: int, n_distances: int) -> tuple[np.ndarray, np.ndarray]:
    """Cells that carry arrows: ``(n, xy)`` from the prey, and ``(n,)`` their states.

    All but the prey's own, where no arrow means anything.
    """
    world = WorldSpec(size=size, n_directions=n_directions, n_distances=n_distances)
    raster = pictures.raster(world, min(_LATTICE, size))
    prey = np.array(geometry.prey_xy(world))
    places = np.stack([raster.cells % size, raster.cells // size], axis=1) - prey
    kept = places.any(axis=1)
    return places[kept], raster.states[kept]


# Amounts: visits, learning now --------------------------------------------------------------


def _decades(snapshot: Snapshot) -> Ruler:
    """Differences of value, up to what an end of a trial is worth."""
    return Ruler(_least(snapshot), max(_reward(snapshot), _penalty(snapshot)), "log")


def _least(snapshot: Snapshot) -> float:
    """Differences of value below this are not worth showing."""
    return max(_reward(snapshot), _penalty(snapshot)) * 10.0**-DECADES


def _fitted(amounts: np.ndarray, fixed: Ruler, least: float) -> Ruler:
    """The ruler between the ends of the amounts that are shown, those from ``least`` on."""
    there = amounts[amounts >= least]
    return Ruler(float(there.min()), float(there.max()), fixed.kind) if len(there) else fixed


def _draw_amount(amount: np.ndarray, ruler: Ruler, look: Look, raster: Raster) -> Picture:
    """Amounts ``(distance, direction)``, blank where 0."""
    there = amount > 0
    level = np.where(there, ruler.place(amount), 0.0)
    colours = pictures.palette(pictures.heat_colours(look.theme), level)
    return _spread(pictures.over_board(colours, there, look.theme), level, raster)


def _visits(snapshot: Snapshot) -> np.ndarray:
    """(heading, distance, direction) float64."""
    return snapshot.visits.sum(axis=-1, dtype=np.float64)


def _visits_ruler(snapshot: Snapshot, look: Look) -> Ruler:
    fixed = Ruler(1.0, 10.0**DECADES, "log")
    return _fitted(_visits(snapshot), fixed, fixed.low) if look.fitted else fixed


def _draw_visits(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    mean = _in_frame(_visits(snapshot), snapshot, look).mean(axis=0)
    return _draw_amount(mean, _visits_ruler(snapshot, look), look, raster)


def _now_ruler(snapshot: Snapshot, look: Look) -> Ruler:
    fixed = _decades(snapshot)
    return _fitted(snapshot.learning_now, fixed, fixed.low) if look.fitted else fixed


def _draw_now(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    mean = _in_frame(snapshot.learning_now, snapshot, look).mean(axis=0, dtype=np.float64)
    # What fades never ends; below the scale it counts as over.
    mean[mean < _least(snapshot)] = 0.0
    return _draw_amount(mean, _now_ruler(snapshot, look), look, raster)


# First reach --------------------------------------------------------------------------------


def _reach_ruler(snapshot: Snapshot, look: Look) -> Ruler:
    """Trials; by the square root, because value spreads fast at first and slowly later."""
    reached = snapshot.first_reach[snapshot.first_reach >= 0]
    if look.fitted and len(reached):
        return Ruler(float(reached.min()), float(reached.max()), "root")
    return Ruler(0.0, float(max(snapshot.spec.trials, snapshot.trial, 1)), "root")


def line_step(first_reach: np.ndarray) -> int:
    """Trials between isochrones, so that there are at most ``MOST_LINES`` of them."""
    reached = first_reach[first_reach >= 0]
    first, last = (int(reached.min()), int(reached.max())) if len(reached) else (0, 0)
    steps = map(int, round_numbers(FEWEST_BETWEEN_LINES))
    return next(step for step in steps if last // step - first // step <= MOST_LINES)


def _draw_reach(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    turned = _in_frame(snapshot.first_reach, snapshot, look)
    reached = turned >= 0
    count = reached.sum(axis=0)
    trial = pictures.mean_of(np.where(reached, turned, 0), count, np.nan)
    level = 1.0 - _reach_ruler(snapshot, look).place(trial)
    share = count / len(turned)
    gain = pictures.palette(pictures.gain_colours(), level)
    picture = _spread(
        pictures.over_board(gain, share, look.theme), np.nan_to_num(level) * share, raster
    )
    line = _isochrones(trial, line_step(snapshot.first_reach), raster)
    dark = pictures.over_board(gain * _LINE_SHADE, share, look.theme).reshape(-1, 3)
    picture.colours[line] = dark[raster.states[line]]
    return picture


def _isochrones(trial: np.ndarray, step: int, raster: Raster) -> np.ndarray:
    """Pixels of the lines: the later of two neighbours with a multiple of ``step`` between them.

    Args:
        trial: ``(distance, direction)``: when value came, NaN where it has not.
        step: trials from line to line.
        raster: where the lines are drawn.
    """
    band = np.where(np.isnan(trial), -1, np.nan_to_num(trial) // step).astype(np.int64).ravel()
    first, second = band[raster.states[raster.seams]].T
    crossed = (first != second) & (first >= 0) & (second >= 0)
    later = np.where(second > first, raster.seams[:, 1], raster.seams[:, 0])
    return later[crossed]


# Success ------------------------------------------------------------------------------------


def _success(snapshot: Snapshot, extras: Extras) -> SuccessMap | None:
    """The success map, if there is one of this run and of this board."""
    success = extras.success
    shape = (N_HEADINGS, snapshot.spec.world.size, snapshot.spec.world.size)
    if success is None or success.generation != snapshot.generation:
        return None
    return success if success.outcomes.shape == shape else None


def _draw_success(snapshot: Snapshot, look: Look, extras: Extras, raster: Raster) -> Picture:
    success = _success(snapshot, extras)
    if success is None:
        return _blank(look, raster)
    if not _folds(look):
        heading = heading_shown(look, snapshot.heading)
        outcome = success.outcomes[heading].ravel()[raster.cells]
        colours = _outcome_colours(look.theme)[outcome]
        return Picture(colours, (outcome == CAPTURE).astype(np.float32))
    # One more element, not known, stands for all that lies off the board.
    flat = np.append(success.outcomes.ravel(), np.int8(0))
    outcome = flat.take(_turned_cells(snapshot.spec.world.size)[:, raster.cells])
    caught = np.count_nonzero(outcome == CAPTURE, axis=0)
    share = caught / np.maximum(np.count_nonzero(outcome, axis=0), 1)
    colours = pictures.over_board(np.array(look.theme.capture), share, look.theme)
    return Picture(colours, share.astype(np.float32))


def _outcome_colours(theme: Theme) -> np.ndarray:
    """(outcome, 3) uint8, the first for what is not known."""
    colours = np.array([theme.of_outcome(outcome) for outcome in range(4)])
    return pictures.over_board(colours, _SOFT, theme)


@functools.lru_cache(maxsize=4)
def _turned_cells(size: int) -> np.ndarray:
    """(heading, y * x) int32: cell of ``(heading, y, x)`` under a cell of the turned picture.

    The nearest; one past the last where the board does not reach.
    """
    world = WorldSpec(size=size)
    px, py = geometry.prey_xy(world)
    east, north = (part.ravel() for part in geometry.offsets(world))
    cells = np.full((N_HEADINGS, size * size), N_HEADINGS * size * size, np.int32)
    for heading in range(N_HEADINGS):
        turn = heading * np.pi / 4
        x = np.rint(east * np.cos(turn) - north * np.sin(turn)).astype(np.int64) + px
        y = np.rint(east * np.sin(turn) + north * np.cos(turn)).astype(np.int64) + py
        inside = (x >= 0) & (x < size) & (y >= 0) & (y < size)
        cells[heading, inside] = ((heading * size + y) * size + x)[inside]
    return cells


# Legends ------------------------------------------------------------------------------------


def _legend(look: Look, title: str, parts: list[str], frame: str, height: str) -> str:
    """A legend with what all of them share.

    Args:
        look: how the board is seen.
        title: what the colours stand for, as HTML.
        parts: what explains the colours, as HTML.
        frame: how the board lies, and what that means for the layer.
        height: what the height of the surface stands for.
    """
    notes = [frame]
    if look.field:
        notes.append("The half-disc is what the prey sees.")
    if look.surface:
        notes.append(f"Height: {height}.")
    return (
        '<div style="padding:0 0.7em;font-size:0.8em;line-height:1.5;overflow-wrap:anywhere">'
        f"<div>{title}</div>{''.join(parts)}<div>{_dots(look.theme)}</div>{_circles(look)}"
        f'<div style="opacity:0.7">{" ".join(notes)}</div></div>'
    )


def _dots(theme: Theme) -> str:
    """What moves and flashes on the board."""
    kinds = {CAPTURE: "capture", FLIGHT: "flight", TIMEOUT: "time-out"}
    ends = (
        swatch_html(css(theme.of_outcome(outcome)), kind, shape=OUTCOME_SHAPES[outcome])
        for outcome, kind in kinds.items()
    )
    return f"Dots: {''.join(ends)}{swatch_html(css(theme.predator), 'predator', shape='circle')}"


def _circles(look: Look) -> str:
    """What the start zone is, where it is drawn."""
    if not look.start_zone or look.surface:
        return ""
    return f"<div>Circles: {swatch_html(css(look.theme.zone), 'trials start between them')}</div>"


def _frame(snapshot: Snapshot, look: Look, each: str) -> str:
    """How the board lies, and what a place of a folded picture shows."""
    if _folds(look):
        return f"The board is turned so that the prey looks right; each place shows {each}."
    return f"North is up, and the prey looks {_facing(snapshot, look)}."


def _facing(snapshot: Snapshot, look: Look) -> str:
    return HEADING_NAMES[heading_shown(look, snapshot.heading)]


_MEAN = "the mean over its eight headings, paler where fewer of them know anything"
_MEAN_AMOUNT = "the mean over its eight headings"


def _limits(look: Look, low: str, high: str) -> str:
    """Says where the colours begin and end, and why there."""
    why = "fitted to what is there now" if look.fitted else "fixed"
    return f"<div>Limits {why}: {low} to {high}.</div>"


def _steps(steps: float) -> str:
    return f"{steps:.0f}" if steps >= 10 else f"{steps:.2g}"


def _trials(trial: float) -> str:
    return f"{trial:,.0f}"


def _turned_bar(ruler: Ruler, write: Callable[[float], str], colours: np.ndarray) -> str:
    """A bar whose low end is on the right, where the colours are brightest."""
    marks = [(1.0 - place, text) for place, text in pictures.ticks(ruler, write)]
    return pictures.bar_html(pictures.gradient_css(colours), marks)


def _not_known(theme: Theme, text: str) -> str:
    return swatch_html(css(theme.unknown), text)


def _losses(shading: Shading, theme: Theme, text: str, cover: float = 1.0) -> str:
    worst = pictures.loss_colours(np.linspace(0.0, 1.0, 12), theme)
    gradient = pictures.gradient_css(pictures.over_board(worst, cover, theme))
    return swatch_html(gradient, f"{text}, 0 to -{of_any_size(shading.penalty)}", width="4em")


def _value_parts(shading: Shading, look: Look, cover: float = 1.0) -> tuple[str, list[str]]:
    """What to add on how a value is measured, and the bar of its scale with its limits."""
    gain, colours = shading.gain, pictures.over_board(pictures.gain_colours(), cover, look.theme)
    if shading.scale == "steps":
        bar = _turned_bar(gain, _steps, colours)
        low, high = f"{_steps(gain.high)} steps", _steps(gain.low)
        return ", as steps to certain capture", [bar, _limits(look, low, high)]
    marks = pictures.ticks(gain, of_any_size)
    bar = pictures.bar_html(pictures.gradient_css(colours), marks)
    return "", [bar, _limits(look, of_any_size(gain.low), of_any_size(gain.high))]


def _value_legend(
    snapshot: Snapshot, look: Look, what: str, shading: Shading, more: str = "", cover: float = 1.0
) -> str:
    """Legend of a map of values of the global reward."""
    measure, parts = _value_parts(shading, look, cover)
    loss = _losses(shading, look.theme, "expects flight", cover)
    known = f"<div>{loss}{_not_known(look.theme, 'not known')}</div>"
    return _legend(
        look,
        what + measure,
        [*parts, known, more],
        _frame(snapshot, look, _MEAN),
        "the value, higher where brighter; what expects flight sinks",
    )


def _legend_value(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    shading = _value_shading(snapshot, look, _or_zero(snapshot.value))
    return _value_legend(snapshot, look, "Value of a state", shading)


def _legend_option(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    name = _name(snapshot, _option(snapshot, look))
    shading = _value_shading(snapshot, look, _option_values(snapshot, look))
    return _value_legend(snapshot, look, f"Value of {name}", shading)


def _legend_skill(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    table = _skill_values(snapshot, look)
    frame = "A skill does not know where the prey looks: this is its table as it is, north up."
    if table is None:
        return _legend(look, "No skill", [], frame, "nothing")
    name = _name(snapshot, _option(snapshot, look))
    shading = _skill_shading(snapshot, look, table.max(axis=-1))
    _, parts = _value_parts(shading, look, _FAINT)
    known = (
        f"<div>{_losses(shading, look.theme, 'below 0', _FAINT)}"
        f"{_not_known(look.theme, 'nothing learned')}</div>"
        "<div>Arrows: its best move; none where moves tie.</div>"
    )
    title = f"What {name} expects of its own reward"
    return _legend(look, title, [*parts, known], frame, "what the skill expects")


def _legend_chosen(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    colours = _colours_of_options(snapshot, look.theme)
    kind = "move" if _has_moves(snapshot) else "skill"
    if _has_moves(snapshot):
        key = _compass(colours)
    else:
        key = "".join(
            swatch_html(css(colours[option]), _name(snapshot, int(option)))
            for option in _present(snapshot)
        )
    blank = "split" if _folds(look) else f"no {kind} clearly best"
    parts = [f"<div>{key}{_not_known(look.theme, blank)}</div>"]
    each = f"the {kind} that most of its eight headings choose, paler where fewer do"
    frame = _frame(snapshot, look, each)
    return _legend(look, f"The {kind} of most value", parts, frame, "the value of the state")


def _compass(colours: np.ndarray) -> str:
    """The nine moves where they point."""
    cells = "".join(
        f'<span style="background:{css(colours[move])};text-align:center;border-radius:2px;'
        f'color:{"#fff" if colours[move].mean() < 128 else "#111"}"'
        f' title="{MOVE_NAMES[move]}">{_MOVE_SIGNS[move]}</span>'
        for move in (6, 7, 8, 3, 4, 5, 0, 1, 2)
    )
    return (
        '<span style="display:inline-grid;grid-template-columns:repeat(3,1.6em);gap:2px;'
        f'vertical-align:middle;margin:0.2em 1em 0.2em 0">{cells}</span>'
    )


def _amount_parts(ruler: Ruler, look: Look, nothing: str) -> list[str]:
    bar = pictures.bar_html(
        pictures.gradient_css(pictures.heat_colours(look.theme)), pictures.ticks(ruler, of_any_size)
    )
    limits = _limits(look, of_any_size(ruler.low), of_any_size(ruler.high))
    return [bar, limits, f"<div>{_not_known(look.theme, nothing)}</div>"]


def _legend_advantage(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    ruler = _advantage_ruler(snapshot, look)
    kind = "move" if _has_moves(snapshot) else "skill"
    parts = _amount_parts(ruler, look, "no difference")
    title = f"Value of the best {kind} less that of the next"
    return _legend(look, title, parts, _frame(snapshot, look, _MEAN_AMOUNT), "the difference")


def _legend_visits(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    parts = _amount_parts(_visits_ruler(snapshot, look), look, "never visited")
    title = "Learning steps made in a state, by powers of ten"
    frame = _frame(snapshot, look, _MEAN_AMOUNT)
    return _legend(look, title, parts, frame, "steps, by powers of ten")


def _legend_now(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    parts = _amount_parts(_now_ruler(snapshot, look), look, "no change lately")
    title = "Change of value lately, by powers of ten, fading"
    frame = _frame(snapshot, look, _MEAN_AMOUNT)
    return _legend(look, title, parts, frame, "change, by powers of ten")


def _legend_reach(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    ruler, colours = _reach_ruler(snapshot, look), pictures.gain_colours()
    bar = pictures.bar_html(pictures.gradient_css(colours[::-1]), pictures.ticks(ruler, _trials))
    line = css(colours[128] * _LINE_SHADE)
    key = (
        f"{swatch_html(line, f'a line every {line_step(snapshot.first_reach):,} trials')}"
        f"{_not_known(look.theme, 'not yet')}"
    )
    limits = _limits(look, f"trial {_trials(ruler.low)}", _trials(ruler.high))
    return _legend(
        look,
        "Trial in which value first rose",
        [bar, limits, f"<div>{key}</div>"],
        _frame(
            snapshot, look, "the mean over the headings that value has reached, paler where few"
        ),
        "the earlier, the higher",
    )


def _legend_success(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    theme = look.theme
    if _folds(look):
        board, full = np.array(theme.unknown), np.array(theme.capture)
        shades = board + (full - board) * np.linspace(0, 1, 12)[:, None]
        marks = [(k / N_HEADINGS, str(k)) for k in range(0, N_HEADINGS + 1, 2)]
        parts = [
            pictures.bar_html(pictures.gradient_css(shades), marks),
            f"<div>Limits fixed: 0 to {N_HEADINGS} of the {N_HEADINGS} headings.</div>",
        ]
        title = "Headings for which a hunt from here ends in capture"
    else:
        colours = _outcome_colours(theme)
        kinds = {CAPTURE: "capture", FLIGHT: "flight", TIMEOUT: "time-out", 0: "not known"}
        key = "".join(swatch_html(css(colours[kind]), text) for kind, text in kinds.items())
        parts = [f"<div>{key}</div>"]
        title = "How a hunt from here ends"
    frame = _frame(snapshot, look, "for how many of its eight headings")
    return _legend(look, title, parts, frame, "the share of hunts that end in capture")


def _legend_flow(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    shading = _value_shading(snapshot, look, _or_zero(snapshot.value))
    none = "moves tie or the headings disagree" if _folds(look) else "moves tie"
    arrows = f"<div>Arrows: the move that is made; none where {none}.</div>"
    return _value_legend(snapshot, look, "Faint: value of a state", shading, arrows, _FAINT)


# Captions -----------------------------------------------------------------------------------


def _caption_value(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    if not _or_zero(snapshot.value).any():
        return "Nothing has been learned yet: no place is worth anything."
    if look.scale == "linear":
        return "What each place is worth: it falls so fast with distance that little else shows."
    return (
        "How far from a capture the learner takes itself to be: the brighter, the nearer."
        " Violet places expect to be noticed."
    )


def _caption_option(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    option = _option(snapshot, look)
    name = _name(snapshot, option)
    if option not in _present(snapshot):
        return f"{name} is not among the skills now, so it has no value anywhere."
    if _has_moves(snapshot):
        frame = " (directions as drawn)" if _folds(look) else ""
        return f"What a place is worth if the next move is {name}{frame}, and the best after that."
    return f"What a place is worth if {name} makes the next move, and the best skill those after."


def _lone_option(snapshot: Snapshot) -> str | None:
    """What to say where there is nothing to choose from."""
    present = _present(snapshot)
    if len(present) > 1:
        return None
    return f"Only {_name(snapshot, int(present[0]))} is there" if len(present) else "None is there"


def _caption_chosen(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    lone = _lone_option(snapshot)
    if lone is not None:
        return f"{lone}, so there is no choice yet."
    kind = "move" if _has_moves(snapshot) else "skill"
    if _folds(look):
        return (
            f"The {kind} that most of the eight headings would choose in each place: paler where"
            " fewer agree, blank where they are split."
        )
    return (
        f"The {kind} that the learner takes in each place when it does not explore; blank where"
        " none is clearly best."
    )


def _caption_advantage(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    lone = _lone_option(snapshot)
    if lone is not None:
        return f"{lone}: there is nothing to choose from, so nothing to see."
    kind = "move" if _has_moves(snapshot) else "skill"
    return f"Where the choice matters: how much more the best {kind} is worth than the next best."


def _caption_visits(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    return "Where the learner has been: how many of its steps started in each place."


def _caption_reach(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    if not (snapshot.first_reach >= 0).any():
        return "When value came to each place: it has not come to any yet."
    return (
        "When value came to each place: bright early, dark late; from one dark line to the next"
        f" it took {line_step(snapshot.first_reach):,} trials."
    )


def _caption_now(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    if _in_frame(snapshot.learning_now, snapshot, look).any():
        return (
            "Where values are changing right now; while it learns, the glow fades within seconds."
        )
    if _folds(look):
        return "Where values are changing right now: nowhere."
    facing = _facing(snapshot, look)
    return f"Where values are changing right now: nowhere while the prey looks {facing}."


def _caption_success(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    success = _success(snapshot, extras)
    if success is None:
        return "How a hunt without exploration would end from each place: being worked out."
    when = f"with what was learned by trial {success.trial:,}"
    if _folds(look):
        return (
            "For how many of the eight headings a hunt without exploration from here ends in"
            f" capture, {when}."
        )
    return f"How a hunt without exploration from here ends, {when}."


def _caption_skill(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    table = _skill_values(snapshot, look)
    if table is None:
        return "This learner has no skills, only the nine moves."
    option = _option(snapshot, look)
    name = _name(snapshot, option)
    if not table.any():
        return f"{name} has learned nothing yet."
    absent = "" if option in _present(snapshot) else " It is not among the skills now."
    return (
        f"What {name} has learned for itself: bright where it expects much of its own reward,"
        f" arrows for its best move.{absent}"
    )


def _caption_flow(snapshot: Snapshot, look: Look, extras: Extras) -> str:
    if (_moves_of_policy(snapshot, look) < 0).all():
        return "Which way the predator would go from each place: no move is clearly best yet."
    return "Which way the predator would go from each place if it never explored."


LAYERS: dict[str, Layer] = {
    layer.key: layer
    for layer in (
        Layer("value", "State value", _draw_value, _legend_value, _caption_value),
        Layer(
            "option", "Value of one option", _draw_option, _legend_option, _caption_option, "option"
        ),
        Layer("chosen", "Chosen skill", _draw_chosen, _legend_chosen, _caption_chosen),
        Layer("advantage", "Advantage", _draw_advantage, _legend_advantage, _caption_advantage),
        Layer("visits", "Visits", _draw_visits, _legend_visits, _caption_visits),
        Layer("reach", "First reach", _draw_reach, _legend_reach, _caption_reach),
        Layer("now", "Learning now", _draw_now, _legend_now, _caption_now),
        Layer("success", "Success from here", _draw_success, _legend_success, _caption_success),
        Layer("skill", "Skill's own value", _draw_skill, _legend_skill, _caption_skill, "skill"),
        Layer("flow", "Policy flow", _draw_flow, _legend_flow, _caption_flow),
    )
}
"""By key, in the order of their hotkeys 1...9 and 0."""


# All headings at once -----------------------------------------------------------------------

_TILES_PER_ROW = 4


def all_headings_png(snapshot: Snapshot, look: Look, layer: Layer, extras: Extras) -> bytes:
    """A layer for each heading by itself, four to a row from east on counter-clockwise, as a PNG.

    North is up in each; a mark shows where the prey looks.
    """
    raster = pictures.raster(snapshot.spec.world, TILE)
    theme = look.theme
    n_rows = N_HEADINGS // _TILES_PER_ROW
    pitch = TILE + 1
    image = np.empty((n_rows * pitch - 1, _TILES_PER_ROW * pitch - 1, 3), np.uint8)
    image[:] = theme.border
    mark = _marks()
    for heading in range(N_HEADINGS):
        picture = layer.draw(snapshot, look._replace(frame=heading), extras, raster)
        tile = picture.colours.reshape(TILE, TILE, 3)
        rows, columns = mark[heading]
        tile[rows, columns] = theme.prey
        top, left = heading // _TILES_PER_ROW * pitch, heading % _TILES_PER_ROW * pitch
        image[top : top + TILE, left : left + TILE] = tile[::-1]
    return pictures.png(image)


@functools.cache
def _marks() -> list[tuple[np.ndarray, np.ndarray]]:
    """For each heading the rows and columns of a dot with a line the way the prey looks."""
    middle, reach = TILE // 2, 9
    marks = []
    for east, north in geometry.HEADINGS:
        length = np.arange(round(reach / np.hypot(east, north)) + 1)
        rows = np.concatenate([np.repeat([-1, 0, 1], 3), north * length])
        columns = np.concatenate([np.tile([-1, 0, 1], 3), east * length])
        marks.append((middle + rows, middle + columns))
    return marks


def small_multiples_html(png: bytes) -> str:
    """The eight small pictures as wide as the panel, with what they are."""
    data = base64.b64encode(png).decode("ascii")
    names = ", ".join(HEADING_NAMES)
    return (
        '<div style="padding:0 0.7em;font-size:0.8em;line-height:1.5">'
        f'<img src="data:image/png;base64,{data}" alt="The layer for each heading: {names}"'
        ' style="width:100%;display:block;image-rendering:pixelated">'
        '<div style="opacity:0.7">Each heading by itself, north up; the mark shows where the prey'
        " looks.</div></div>"
    )
