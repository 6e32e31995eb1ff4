"""The layers on tables made by hand, whose colours, arrows and words are known."""

import dataclasses
import functools
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.documents import presets
from app.live import snapshot
from app.live.snapshot import Snapshot
from app.picture.colours import (
    FARTHER,
    GLOW,
    NEARER,
    OPTION_COLOURS,
    STAKES,
    TRACES,
    Ramp,
    amount_colours,
    css,
    gain_colours,
    move_colours,
)
from app.picture.layer import Extras, Picture, SuccessMap
from app.picture.layers import LAYERS
from app.picture.layers.reach import MOST_LINES, line_step
from app.picture.legend import bar_marks
from app.picture.look import ALL, FOLDED, OF_TRIAL, Look
from app.picture.multiples import SIDE, TILES, all_headings, tile_at
from app.picture.options import greedy
from app.picture.raster import raster
from app.picture.shading import STEPS, Ruler
from app.picture.theme import DARK, LIGHT, Colour, Theme
from app.util.html import escaped
from app.words.numbers import of_any_size
from app.words.plain import HEADING_NAMES
from learners.run import Run
from learners.skill_spec import SkillWeights
from sim import geometry
from sim.geometry import MOVES, N_MOVES
from sim.spec import N_HEADINGS
from sim.world import CAPTURE, FLIGHT, TIMEOUT
from tests.support.frames import unfold
from tests.support.sight import JUST_NOTICEABLE, PLAINLY_APART, SIGHT, nearest

SIZE, RINGS, SECTORS = 120, 18, 24
MAP = (N_HEADINGS, RINGS, SECTORS)
APPROACH, CIRCLE, AVOID = 0, 1, 2
EAST, WEST, STAY = 5, 3, 4
AT_25 = 1 - (25 / 200) ** 0.5
"""Place of 25 steps on the scale of steps to capture."""
HOSTILE = "<img src=x onerror=alert(1)>"

every_layer = pytest.mark.parametrize("key", LAYERS)
both_themes = pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])


# Snapshots and pictures ---------------------------------------------------------------------


@functools.cache
def fresh(preset: str = "hierarchical_3", *settings: str) -> Snapshot:
    """A moment before the first step."""
    return snapshot.take(Run(presets.load(preset, settings), 1), preset, 0)


def made(base: Snapshot | None = None, **tables: Any) -> Snapshot:
    """A moment with some of its tables replaced; the value is that of the options unless given."""
    base = fresh() if base is None else base
    if "selection_q" in tables and "value" not in tables:
        tables["value"] = tables["selection_q"].max(axis=-1)
    return dataclasses.replace(base, **tables)


def zeros(*more: int) -> np.ndarray:
    return np.zeros((*MAP, *more), np.float32)


def state_at(east: int, north: int) -> tuple[int, int]:
    """Ring and sector of a place, counted from the prey."""
    flat = geometry.readings(fresh().spec.world)[60 + north, 60 + east]
    return divmod(int(flat), SECTORS)


def paint(key: str, moment: Snapshot, extras: Extras | None = None, **look: Any) -> Picture:
    return LAYERS[key].paint(moment, Look(layer=key, **look), extras or Extras())


def words(key: str, moment: Snapshot, extras: Extras | None = None, **look: Any) -> tuple[str, str]:
    """Legend and caption."""
    layer, looking = LAYERS[key], Look(layer=key, **look)
    extras = extras or Extras()
    return layer.legend(moment, looking, extras), escaped(layer.caption(moment, looking, extras))


def colour_at(picture: Picture, east: int, north: int) -> list[int]:
    return picture.colours.reshape(SIZE, SIZE, 3)[60 + north, 60 + east].tolist()


def of(colours: np.ndarray, level: float, cover: float = 1.0, theme: Theme = LIGHT) -> Any:
    """The colour at a level of a colour map, over the board."""
    board = np.array(theme.unknown, float)
    colour = colours[int(level * (len(colours) - 1))]
    return pytest.approx(np.rint(board + (colour - board) * cover), abs=1)


def gain(level: float, cover: float = 1.0) -> Any:
    return of(gain_colours(), level, cover)


def amount(ramp: Ramp, level: float) -> Any:
    return of(amount_colours(ramp, LIGHT), level)


def blank(theme: Theme = LIGHT) -> list[int]:
    return list(theme.unknown)


def everywhere(picture: Picture, colour: Colour) -> bool:
    return bool((picture.colours == colour).all())


def everywhere_blank(picture: Picture) -> bool:
    return everywhere(picture, LIGHT.unknown)


def successes(outcomes: np.ndarray, trial: int = 14_200, generation: int = 0) -> Extras:
    return Extras(SuccessMap(outcomes.astype(np.int8), trial, generation))


# The list -----------------------------------------------------------------------------------


def test_the_layers_are_in_the_order_of_their_hotkeys() -> None:
    assert list(LAYERS)[:10] == [
        *("value", "option", "chosen", "advantage", "visits"),
        *("reach", "now", "success", "skill", "flow"),
    ]
    assert all(layer.key == key for key, layer in LAYERS.items())


def test_three_layers_ask_which_option_they_are_about() -> None:
    about = {key: layer.about for key, layer in LAYERS.items() if layer.about != "nothing"}
    assert about == {"option": "option", "skill": "skill", "stake": "skill"}


def test_looks_and_extras_that_agree_can_share_a_picture() -> None:
    extras = successes(np.zeros((N_HEADINGS, SIZE, SIZE)))
    assert len({(Look(), extras), (Look(), extras), (Look(), Extras(extras.success))}) == 1


# State value and value of an option ---------------------------------------------------------


def at_one_place(amount: float, east: int = 20, north: int = 0) -> np.ndarray:
    """A map that knows something of one place, and says so for each heading as the world is."""
    table = zeros()
    table[(slice(None), *state_at(east, north))] = amount
    return table


def test_a_value_is_as_bright_as_it_is_near_to_capture() -> None:
    picture = paint("value", made(value=at_one_place(100 * 0.9**25)), frame=3)
    assert colour_at(picture, 20, 0) == gain(AT_25)
    assert colour_at(picture, -20, 0) == blank()


def known_by(headings: int) -> Snapshot:
    """A moment in which so many headings know a way from 20 cells ahead of the prey."""
    value = zeros()
    ring, sector = state_at(20, 0)
    for heading in range(headings):
        # Each heading looks three of the 24 sectors farther round.
        value[heading, ring, (sector + 3 * heading) % SECTORS] = 100 * 0.9**25
    return made(value=value)


def under_one_state() -> np.ndarray:
    """The cells with the state of the place 20 cells ahead of the prey."""
    ring, sector = state_at(20, 0)
    return raster(fresh().spec.world).states == ring * SECTORS + sector


def of_one_state(picture: Picture) -> list[list[int]]:
    """The colours that the cells of that state have."""
    return np.unique(picture.colours[under_one_state()], axis=0).tolist()


@pytest.mark.parametrize("headings", [4, 8])
def test_what_half_of_the_headings_know_is_in_full_colour(headings: int) -> None:
    picture = paint("value", known_by(headings))
    assert of_one_state(picture) == [gain(AT_25)]


@pytest.mark.parametrize("headings", [1, 3])
def test_what_fewer_headings_know_is_dotted_in_full_colour(headings: int) -> None:
    picture = paint("value", known_by(headings))
    kinds = of_one_state(picture)
    # Of three by three cells one is a dot.
    dots = (picture.colours != LIGHT.unknown).any(axis=1).sum()
    assert dots == pytest.approx(under_one_state().sum() / 9, abs=5)
    assert kinds == [gain(AT_25), blank()]


def test_a_line_runs_round_what_is_in_full_colour_and_round_nothing_else() -> None:
    ring, _ = state_at(20, 0)
    edges = [line for line in paint("value", known_by(8)).over().contours if line.is_edge]
    outer = geometry.ring_edges(fresh().spec.world)
    assert len(edges) == 1
    far = np.hypot(*edges[0].segments.reshape(-1, 2).T)
    assert far.min() == pytest.approx(outer[ring - 1])
    assert far.max() == pytest.approx(outer[ring])
    assert not paint("value", known_by(3)).over().contours[-1].segments.size


def test_what_expects_flight_is_hatched_where_that_is_wished() -> None:
    moment = made(value=at_one_place(-50))
    assert everywhere_blank(paint("value", moment, frame=0))
    picture = paint("value", moment, frame=0, flight=True)
    kinds, counts = np.unique(picture.colours, axis=0, return_counts=True)
    assert len(kinds) == 2
    assert counts.min() == pytest.approx(under_one_state().sum() / 4, abs=3)
    assert "expects to be noticed" in words("value", moment, flight=True)[0]
    assert "expects to be noticed" not in words("value", moment)[0]


def test_value_has_thin_lines_of_equal_steps() -> None:
    value = zeros()
    distance = np.arange(RINGS) * 10.0
    value[:] = 100 * 0.9 ** distance[None, :, None]
    lines = [line for line in paint("value", made(value=value)).over().contours if not line.is_edge]
    assert len(lines) == 3
    # 50 steps are the sixth ring everywhere, whose middle is half way between its edges.
    outer = geometry.ring_edges(fresh().spec.world)
    reached = np.hypot(*lines[1].segments.reshape(-1, 2).T)
    assert reached == pytest.approx((outer[4] + outer[5]) / 2)
    linear = paint("value", made(value=value), scale="linear")
    assert all(line.is_edge for line in linear.over().contours)


def test_a_linear_value_is_as_bright_as_it_is_large() -> None:
    picture = paint("value", made(value=at_one_place(50)), frame=0, scale="linear")
    assert colour_at(picture, 20, 0) == gain(0.5)


def test_the_value_of_an_option_is_its_own_and_not_the_best() -> None:
    values = zeros(3)
    values[..., APPROACH] = 100
    values[..., CIRCLE] = at_one_place(100 * 0.9**25)
    picture = paint("option", made(selection_q=values), option=CIRCLE, frame=0)
    assert colour_at(picture, 20, 0) == gain(AT_25)
    assert colour_at(picture, -20, 0) == blank()
    assert colour_at(paint("option", made(selection_q=values)), -20, 0) == gain(1)


def test_an_option_that_has_not_joined_is_blank_and_the_caption_says_so() -> None:
    values = zeros(3)
    values[..., APPROACH] = 5
    values[..., CIRCLE] = -np.inf
    moment = made(selection_q=values)
    assert everywhere_blank(paint("option", moment, option=CIRCLE))
    assert words("option", moment, option=CIRCLE)[1].startswith("circle clockwise is not among")


def test_the_caption_and_the_legend_of_an_option_name_it() -> None:
    for index, name in enumerate(["approach", "circle clockwise", "avoid"]):
        legend, caption = words("option", fresh(), option=index)
        assert name in legend
        assert name in caption


@pytest.mark.parametrize("option", [-3, 3, 99])
def test_a_look_at_an_option_of_another_run_shows_one_of_this(option: int) -> None:
    shown = AVOID if option > 0 else APPROACH
    values = np.random.default_rng(0).normal(size=(*MAP, 3)).astype(np.float32)
    moment = made(selection_q=values)
    there, stale = (paint("option", moment, option=index) for index in (shown, option))
    assert (there.colours == stale.colours).all()


# Limits -------------------------------------------------------------------------------------


def two_values(near: float, far: float) -> Snapshot:
    value = zeros()
    value[(0, *state_at(20, 0))] = near
    value[(5, *state_at(-20, 0))] = far
    return made(value=value)


def test_fixed_limits_stand_on_the_bar_alone() -> None:
    moment = fresh()
    for key in LAYERS:
        assert "fitted" not in words(key, moment)[0]
    assert "200+" in words("value", moment)[0]


def test_fitted_limits_are_those_of_all_headings_and_stated() -> None:
    moment = two_values(100 * 0.9**12, 100 * 0.9**48)
    near = paint("value", moment, frame=0, fitted=True)
    far = paint("value", moment, frame=5, fitted=True)
    assert colour_at(near, 20, 0) == gain(1)
    assert colour_at(far, -20, 0) == gain(0)
    legend = words("value", moment, frame=0, fitted=True)[0]
    assert "Colours fitted to what is there now: 48 steps to 12." in legend


def test_linear_limits_are_fitted_too() -> None:
    moment = two_values(40, 8)
    assert colour_at(paint("value", moment, frame=0, fitted=True, scale="linear"), 20, 0) == gain(1)
    legend = words("value", moment, fitted=True, scale="linear")[0]
    assert "Colours fitted to what is there now: 8 to 40." in legend


def test_limits_around_a_single_value_put_it_in_the_middle() -> None:
    assert colour_at(
        paint("value", made(value=at_one_place(7)), frame=0, fitted=True), 20, 0
    ) == gain(0.5)


@every_layer
@pytest.mark.parametrize("scale", ["steps", "linear"])
def test_with_nothing_to_fit_to_the_colours_are_the_fixed_ones(key: str, scale: Any) -> None:
    fixed, fitted = (paint(key, fresh(), fitted=fit, scale=scale) for fit in (False, True))
    assert same(fixed, fitted)


# Chosen skill -------------------------------------------------------------------------------


def preferring(option: int, by: float = 1.0, best: float = 10.0) -> np.ndarray:
    values = zeros(3)
    values[...] = best - by
    values[..., option] = best
    return values


@pytest.mark.parametrize("option", [APPROACH, CIRCLE, AVOID])
@both_themes
def test_the_chosen_skill_has_its_own_colour(option: int, theme: Theme) -> None:
    picture = paint("chosen", made(selection_q=preferring(option)), frame=2, theme=theme)
    assert (picture.colours == OPTION_COLOURS[option]).all()
    assert picture.arrows is None


def test_options_tie_within_a_thousandth_of_the_best() -> None:
    for by, ties in ((0.0, True), (0.009, True), (0.011, False)):
        picture = paint("chosen", made(selection_q=preferring(CIRCLE, by)), frame=0)
        chosen = (picture.colours == OPTION_COLOURS[CIRCLE]).all(axis=1)
        assert (chosen.any(), chosen.all()) == (not ties, not ties)


def test_losses_tie_within_a_thousandth_of_the_best_too() -> None:
    values = np.array([[-10.0, -10.009, -20], [-10.0, -10.011, -20], [0, 0, -1], [0, -1e-9, -1]])
    assert greedy(values.astype(np.float32)).tolist() == [-1, 0, -1, 0]


def test_an_option_that_is_not_there_is_never_chosen() -> None:
    values = np.array([[-np.inf, -7, -np.inf], [-np.inf, -np.inf, -np.inf]], np.float32)
    assert greedy(values).tolist() == [1, -1]


def test_the_folded_choice_is_that_of_at_least_half_of_the_headings() -> None:
    values = preferring(AVOID)
    values[:2] = preferring(CIRCLE)[:2]
    picture = paint("chosen", made(selection_q=values))
    assert colour_at(picture, 20, 0) == of(OPTION_COLOURS[[AVOID]], 1)


def split_between(*options: int) -> Picture:
    """The choice where as many headings are for each of these."""
    values = preferring(options[0])
    share = N_HEADINGS // len(options)
    for place, option in enumerate(options):
        values[place * share : (place + 1) * share] = preferring(option)[:share]
    return paint("chosen", made(selection_q=values))


def test_where_headings_disagree_it_is_hatched_in_no_skills_colour() -> None:
    picture = split_between(CIRCLE, AVOID)
    kinds, counts = np.unique(picture.colours, axis=0, return_counts=True)
    assert sorted(kinds.tolist()) == sorted([blank(), list(LIGHT.frozen)])
    assert counts.min() == pytest.approx(SIZE**2 / 4, rel=0.01)
    assert picture.regions is not None
    assert (picture.regions == -1).all()
    assert css(LIGHT.frozen) in words("chosen", fresh())[0]


def test_where_nothing_is_learned_no_choice_is_said_to_be_split() -> None:
    assert everywhere_blank(paint("chosen", made(selection_q=zeros(3))))


@every_layer
def test_every_legend_explains_the_start_zone_where_it_is_drawn(key: str) -> None:
    circles = css(LIGHT.zone)
    looks: list[tuple[dict[str, Any], bool]] = [
        ({}, False),
        ({"start_zone": True}, True),
    ]
    for look, is_drawn in looks:
        legend = words(key, fresh(), **look)[0]
        assert ("trials start between them" in legend) == is_drawn
        assert (circles in legend) == is_drawn


def test_the_legend_of_choices_lists_who_is_there() -> None:
    values = preferring(CIRCLE)
    values[..., AVOID] = -np.inf
    legend, _ = words("chosen", made(selection_q=values))
    assert "approach" in legend
    assert "circle clockwise" in legend
    assert "avoid" not in legend
    assert css(OPTION_COLOURS[CIRCLE]) in legend


@pytest.mark.parametrize("sight", SIGHT.values(), ids=SIGHT)
def test_six_skills_and_the_board_stay_apart_for_all_kinds_of_sight(sight: np.ndarray) -> None:
    boards = [np.array(theme.unknown, float) for theme in (LIGHT, DARK)]
    six = OPTION_COLOURS[:6]
    for index, colour in enumerate(six):
        others = np.array([*np.delete(six, index, axis=0), *boards])
        assert nearest(colour[None], others, sight) > PLAINLY_APART


@pytest.mark.parametrize("sight", SIGHT.values(), ids=SIGHT)
def test_opposite_moves_stay_apart_for_all_kinds_of_sight(sight: np.ndarray) -> None:
    colours = move_colours(LIGHT)
    for move in range(N_MOVES):
        opposite = N_MOVES - 1 - move
        if move != opposite:
            assert nearest(colours[[move]], colours[[opposite]], sight) > PLAINLY_APART


# Advantage, visits, learning now ------------------------------------------------------------


def worth(steps: float) -> float:
    """Value of a place so many steps from a certain capture."""
    return 100 * 0.9**steps


def test_the_advantage_is_the_steps_that_the_next_best_would_cost() -> None:
    values = zeros(3)
    values[..., APPROACH], values[..., CIRCLE], values[..., AVOID] = -40, worth(10), worth(15)
    picture = paint("advantage", made(selection_q=values))
    assert colour_at(picture, 20, 0) == amount(STAKES, np.sqrt(5 / 20))


@pytest.mark.parametrize("second", [worth(60), 0.0, -40.0])
def test_where_the_next_best_knows_no_way_the_advantage_is_the_largest(second: float) -> None:
    values = zeros(3)
    values[..., APPROACH], values[..., CIRCLE], values[..., AVOID] = -50, worth(10), second
    picture = paint("advantage", made(selection_q=values))
    assert colour_at(picture, 20, 0) == amount(STAKES, 1)


def test_where_not_even_the_best_knows_a_way_the_advantage_is_blank() -> None:
    values = zeros(3)
    values[..., APPROACH], values[..., CIRCLE], values[..., AVOID] = -50, -10, -20
    assert everywhere_blank(paint("advantage", made(selection_q=values)))
    linear = paint("advantage", made(selection_q=values), scale="linear")
    assert colour_at(linear, 20, 0) == amount(STAKES, 0.1)


def test_the_advantage_is_shown_where_at_least_half_of_the_headings_have_one() -> None:
    values = zeros(3)
    values[..., CIRCLE], values[..., AVOID] = worth(10), worth(15)
    for without, is_shown in ((4, True), (5, False)):
        values[:without, ..., CIRCLE] = -1
        values[:without, ..., AVOID] = -1
        values[:without, ..., APPROACH] = -1
        picture = paint("advantage", made(selection_q=values))
        assert (not everywhere_blank(picture)) == is_shown


def test_a_linear_advantage_is_a_share_of_the_reward() -> None:
    picture = paint("advantage", made(selection_q=preferring(CIRCLE, by=25)), scale="linear")
    assert colour_at(picture, 20, 0) == amount(STAKES, 0.25)


def test_no_advantage_is_blank() -> None:
    assert everywhere_blank(paint("advantage", made(selection_q=preferring(CIRCLE, by=0))))


def test_one_option_has_no_advantage_and_the_caption_says_why() -> None:
    values = zeros(3)
    values[..., APPROACH] = 10
    values[..., [CIRCLE, AVOID]] = -np.inf
    moment = made(selection_q=values)
    picture = paint("advantage", moment)
    assert everywhere_blank(picture)
    assert [label.text for label in picture.over().labels] == [
        "Only approach is there: no choice yet"
    ]
    assert words("advantage", moment)[1].startswith("Only approach is there")
    assert words("chosen", moment)[1].startswith("Only approach is there")
    assert (paint("chosen", moment).colours == OPTION_COLOURS[APPROACH]).all()


def visited(times: dict[tuple[int, int], float], heading: int) -> Snapshot:
    """A moment in which all cells were visited as often, but for those of the states at some
    places, for one heading: these so many times as often."""
    rings = geometry.readings(fresh().spec.world).ravel() // SECTORS
    of_ring = np.bincount(rings, minlength=RINGS) / SECTORS
    visits = np.zeros((*MAP, 3))
    visits[..., APPROACH] = of_ring[:, None] * 1_000_000
    for place, often in times.items():
        visits[(heading, *state_at(*place), APPROACH)] *= often
    return made(visits=visits.astype(np.uint32))


def test_visits_are_told_by_cells_as_a_multiple_of_the_average() -> None:
    moment = visited({(20, 0): 2, (-20, 0): 0, (0, 20): 1 / 8, (0, -20): 1 / 100}, heading=2)
    picture = paint("visits", moment, frame=2)
    # The scale goes from an eighth to eight times; a state has few of all cells.
    for place in ((-55, 0), (4, 3)):
        assert colour_at(picture, *place) == amount(TRACES, 1 / 2)
    assert colour_at(picture, 20, 0) == amount(TRACES, 4 / 6)
    for place in ((0, 20), (0, -20)):
        assert colour_at(picture, *place) == amount(TRACES, 0)
    assert colour_at(picture, -20, 0) == blank()


def test_folded_visits_are_the_mean_and_a_single_one_still_shows() -> None:
    picture = paint("visits", visited({(20, 0): 9}, heading=0))
    assert colour_at(picture, 20, 0) == amount(TRACES, 4 / 6)
    visits = np.zeros((*MAP, 3), np.uint32)
    visits[(0, *state_at(20, 0))] = [0, 8_000, 0]
    visits[(0, *state_at(-20, 0))] = [0, 1, 0]
    assert colour_at(paint("visits", made(visits=visits)), -20, 0) == amount(TRACES, 0)


def test_learning_glows_by_the_share_of_the_value_that_changed_and_goes_out() -> None:
    now, value = zeros(), zeros()
    places = {(20, 0): (2.0, 8.0), (-20, 0): (0.2, 8.0), (0, 20): (0.01, 0.01), (0, -20): (1, -4.0)}
    for place, (change, worth) in places.items():
        now[(0, *state_at(*place))], value[(0, *state_at(*place))] = change, worth
    picture = paint("now", made(learning_now=now, value=value), frame=0)
    assert colour_at(picture, 20, 0) == amount(GLOW, 0.5)
    # What is learned already wavers.
    assert colour_at(picture, -20, 0) == blank()
    # As plain where little is there yet, and where it is a loss.
    assert colour_at(picture, 0, 20) == amount(GLOW, 1)
    assert colour_at(picture, 0, -20) == amount(GLOW, 0.5)
    caption = "nowhere while the prey looks south"
    assert caption in words("now", made(learning_now=now, value=value), frame=6)[1]


@pytest.mark.parametrize("sight", SIGHT.values(), ids=SIGHT)
@both_themes
def test_the_three_amounts_and_the_value_are_told_apart_by_their_colours(
    theme: Theme, sight: np.ndarray
) -> None:
    ramps = [amount_colours(ramp, theme) for ramp in (TRACES, GLOW, STAKES)]
    for number, ramp in enumerate(ramps):
        others = [other for place, other in enumerate(ramps) if place != number]
        for level in (128, 255):
            same_level = np.stack([other[level] for other in others])
            assert nearest(ramp[[level]], same_level, sight) > PLAINLY_APART
        assert nearest(ramp, np.array([theme.unknown], float), sight) > 3 * JUST_NOTICEABLE


# First reach --------------------------------------------------------------------------------


def reached_by_ring(trials_per_ring: int) -> Snapshot:
    trial = np.arange(RINGS)[:, None] * trials_per_ring
    return made(first_reach=np.broadcast_to(trial, MAP).astype(np.int32))


def test_first_reach_is_bright_where_it_was_early() -> None:
    reach = np.full(MAP, -1, np.int32)
    reach[(0, *state_at(20, 0))] = 6_000
    picture = paint("reach", made(first_reach=reach), frame=0)
    assert colour_at(picture, 20, 0) == gain(0.5)
    assert colour_at(picture, -20, 0) == blank()


def test_what_fewer_than_half_of_the_headings_know_is_dotted_in_first_reach() -> None:
    for count in (3, 4):
        reach = np.full(MAP, -1, np.int32)
        reach[:count] = 6_000
        shown = paint("reach", made(first_reach=reach)).colours
        is_plain = (shown != LIGHT.unknown).any(axis=1)
        # A dot in each square of three by three cells, or everywhere.
        assert is_plain.mean() == pytest.approx(1 / 9 if count == 3 else 1.0, abs=0.01)


def test_isochrones_run_where_a_multiple_of_their_step_was_passed() -> None:
    moment = reached_by_ring(300)
    assert line_step(moment.first_reach) == 500
    picture = paint("reach", moment)
    outer = geometry.ring_edges(moment.spec.world)
    middle = (outer + np.array([0, *outer[:-1]])) / 2
    expected = {
        trial: np.interp(trial / 300, np.arange(RINGS), middle) for trial in range(500, 5_001, 500)
    }
    radii = [np.hypot(*line.segments.reshape(-1, 2).T) for line in picture.over().contours]
    assert [radius.mean() for radius in radii] == pytest.approx(list(expected.values()), abs=0.1)
    # All the way round the prey, and not along the edges of states.
    assert max(np.ptp(radius) for radius in radii) < 0.1


def test_the_numbers_on_the_lines_are_their_trials() -> None:
    picture = paint("reach", reached_by_ring(300))
    lines = {f"{500 * (k + 1):,}": line.segments for k, line in enumerate(picture.over().contours)}
    assert len(picture.over().labels) >= 5
    for label in picture.over().labels:
        apart = np.hypot(*(lines[label.text] - [label.east, label.north]).reshape(-1, 2).T)
        assert apart.min() < 1
        assert np.hypot(label.east, label.north) < 60
    places = np.array([(label.east, label.north) for label in picture.over().labels])
    near = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    assert near[~np.eye(len(places), dtype=bool)].min() > 8


def test_there_is_no_line_between_what_is_reached_and_what_is_not() -> None:
    reach = np.full(MAP, -1, np.int32)
    reach[:, :9] = 4_000
    picture = paint("reach", made(first_reach=reach))
    assert len(np.unique(picture.colours, axis=0)) == 2
    assert picture.over().contours == ()


@pytest.mark.parametrize(
    ("last", "step"),
    [
        (0, 500),
        (5_000, 500),
        (6_000, 1_000),
        (14_400, 2_000),
        (48_000, 5_000),
        (2_000_000, 200_000),
    ],
)
def test_the_step_of_the_isochrones_grows_with_the_trials(last: int, step: int) -> None:
    assert line_step(np.array([0, last, -1])) == step
    assert f"a line every {step:,} trials" in words("reach", made(first_reach=two(0, last)))[0]


def two(first: int, last: int) -> np.ndarray:
    reach = np.full(MAP, -1, np.int32)
    reach[0, 0, 0], reach[0, 0, 1] = first, last
    return reach


@given(st.integers(0, 2_000_000), st.integers(0, 2_000_000))
def test_there_are_never_more_lines_than_can_be_told_apart(one: int, other: int) -> None:
    step = line_step(np.array([one, other, -1]))
    assert abs(one // step - other // step) <= MOST_LINES <= 12


# Success ------------------------------------------------------------------------------------


def test_success_shows_how_a_hunt_from_each_cell_ends() -> None:
    outcomes = np.zeros((N_HEADINGS, SIZE, SIZE), np.int8)
    outcomes[3, 60, 80], outcomes[3, 60, 81], outcomes[3, 60, 82] = CAPTURE, FLIGHT, TIMEOUT
    outcomes[3, 40:50, 40:50] = FLIGHT
    outcomes[3, 80:90, 80:90] = TIMEOUT
    picture = paint("success", fresh(), successes(outcomes), frame=3)
    assert colour_at(picture, 20, 0) == of(np.array([LIGHT.capture]), 0, 0.75)
    assert colour_at(picture, 23, 0) == blank()
    board = picture.colours.reshape(SIZE, SIZE, 3)
    for place, colour in ((slice(40, 50), LIGHT.flight), (slice(80, 90), LIGHT.timeout)):
        kinds = np.unique(board[place, place].reshape(-1, 3), axis=0).tolist()
        assert sorted(kinds) == sorted([blank(), list(colour)])


def test_the_hatches_of_flights_and_of_timeouts_run_across_each_other() -> None:
    lines: list[np.ndarray] = []
    for outcome in (FLIGHT, TIMEOUT):
        everywhere_so = successes(np.full((N_HEADINGS, SIZE, SIZE), outcome))
        picture = paint("success", fresh(), everywhere_so, frame=0)
        board = (picture.colours != LIGHT.unknown).any(axis=1).reshape(SIZE, SIZE)
        lines.append(board)
    assert (lines[0][:-1, :-1] == lines[0][1:, 1:]).all()
    assert (lines[1][1:, :-1] == lines[1][:-1, 1:]).all()


def test_folded_success_is_what_happens_for_most_headings_each_turned_its_way() -> None:
    outcomes = np.full((N_HEADINGS, SIZE, SIZE), FLIGHT, np.int8)
    # A place 20 behind and 10 to the left of the prey, for the four headings along the axes.
    for heading, (east, north) in {0: (-20, 10), 2: (-10, -20), 4: (20, -10), 6: (10, 20)}.items():
        outcomes[heading, 60 + north, 60 + east] = CAPTURE
    # Straight ahead at 45 degrees the nearest cell is exact.
    for heading in (1, 3, 5, 7):
        east, north = geometry.HEADINGS[heading] * 7
        outcomes[heading, 60 + north, 60 + east] = CAPTURE
    picture = paint("success", fresh(), successes(outcomes))
    half = of(np.array([LIGHT.capture]), 0, 0.3)
    assert colour_at(picture, -20, 10) == half
    assert colour_at(picture, 10, 0) == half
    colours = [blank(), list(LIGHT.flight)]
    caught = [colour for colour in picture.colours.tolist() if colour not in colours]
    assert 2 <= len(caught) <= 6


def test_places_that_some_headings_do_not_have_count_those_that_do() -> None:
    outcomes = np.full((N_HEADINGS, SIZE, SIZE), CAPTURE, np.int8)
    full = of(np.array([LIGHT.capture]), 0, 0.75)
    kinds = np.unique(paint("success", fresh(), successes(outcomes)).colours, axis=0).tolist()
    assert kinds == [full]


def test_success_tells_apart_who_is_noticed_and_who_runs_out_of_time_and_says_why() -> None:
    legend, _ = words("success", fresh())
    for word in ("caught", "noticed", "out of time", "for ever"):
        assert word in legend
    for colour in (LIGHT.flight, LIGHT.timeout):
        assert legend.count(css(colour)) == 2


def test_success_says_as_of_which_trial() -> None:
    extras = successes(np.full((N_HEADINGS, SIZE, SIZE), CAPTURE))
    assert "trial 14,200" in words("success", fresh(), extras)[1]
    assert "trial 14,200" in words("success", fresh(), extras, frame=2)[1]


@pytest.mark.parametrize(
    "extras",
    [
        Extras(),
        successes(np.ones((N_HEADINGS, SIZE, SIZE)), generation=1),
        successes(np.ones((N_HEADINGS, 60, 60))),
    ],
    ids=["none", "another run", "another board"],
)
@pytest.mark.parametrize("frame", [FOLDED, 1])
def test_without_a_success_map_of_this_run_the_board_is_blank(extras: Extras, frame: int) -> None:
    assert everywhere_blank(paint("success", fresh(), extras, frame=frame))
    assert "being worked out" in words("success", fresh(), extras, frame=frame)[1]


# A skill's own value ------------------------------------------------------------------------


def skill_tables(skill: int, move: int, value: float) -> np.ndarray:
    tables = np.zeros((3, RINGS, SECTORS, N_MOVES), np.float32)
    tables[skill, ..., move] = value
    return tables


def test_a_skills_value_is_a_share_of_what_it_can_earn_and_its_arrows_are_its_moves() -> None:
    most = np.sqrt(2) / (1 - 0.9)
    moment = made(skill_q=skill_tables(CIRCLE, EAST, most / 2))
    picture = paint("skill", moment, option=CIRCLE)
    assert colour_at(picture, 20, 0) == gain(0.5)
    assert picture.arrows is not None
    assert picture.arrow_colours is not None
    assert (picture.arrow_colours == LIGHT.ink).all()
    assert 390 <= len(picture.arrows) <= 450
    tail, head = picture.arrows[:, 0], picture.arrows[:, 1]
    # Three quarters of the six cells between two arrows.
    assert head - tail == pytest.approx(np.broadcast_to([4.5, 0.0], tail.shape), abs=1e-4)
    assert np.abs((head + tail) / 2 % 1).max() < 1e-3


def test_where_a_skills_moves_tie_or_stay_there_is_no_arrow() -> None:
    tied = skill_tables(CIRCLE, EAST, 5)
    tied[CIRCLE, ..., WEST] = 5
    for tables in (tied, skill_tables(CIRCLE, STAY, 5)):
        arrows = paint("skill", made(skill_q=tables), option=CIRCLE).arrows
        assert arrows is not None
        assert arrows.shape == (0, 2, 2)


def test_a_skill_looks_the_same_in_every_frame() -> None:
    tables = np.random.default_rng(1).normal(size=(3, RINGS, SECTORS, N_MOVES))
    moment = made(skill_q=tables.astype(np.float32))
    first, *others = (paint("skill", moment, option=1, frame=f) for f in (FOLDED, OF_TRIAL, 0, 5))
    for other in others:
        assert same(first, other)


SEARCH = 4
"""Number of the command whose table sees the prey's heading."""


def commanding(search_q: np.ndarray | None = None, **tables: Any) -> Snapshot:
    """A moment of a manager, what searches having ``(heading, distance, direction, move)``."""
    base = fresh("feudal")
    skill_q = np.zeros_like(base.skill_q)
    if search_q is not None:
        skill_q[SEARCH] = search_q
    return made(base, skill_q=skill_q, **tables)


def moving(ways: np.ndarray) -> np.ndarray:
    """Values by which the best move in all places is one for each heading."""
    values = np.zeros((*MAP, N_MOVES), np.float32)
    values[np.arange(N_HEADINGS), ..., ways] = 1
    return values


def test_what_searches_is_shown_as_it_is_for_one_heading() -> None:
    ways = np.array([EAST, EAST, EAST, WEST, WEST, WEST, WEST, WEST])
    for heading, east in ((2, 4.5), (6, -4.5)):
        taken = dataclasses.replace(commanding(moving(ways) * 0.5), heading=heading)
        picture = paint("skill", taken, option=SEARCH, frame=OF_TRIAL)
        # A capture is told to it as 1, and nothing is worth more.
        assert colour_at(picture, 20, 0) == gain(0.5)
        assert picture.arrows is not None
        way = picture.arrows[:, 1] - picture.arrows[:, 0]
        assert way == pytest.approx(np.broadcast_to([east, 0.0], way.shape), abs=1e-4)
        legend, caption = words("skill", taken, option=SEARCH, frame=OF_TRIAL)
        assert f"the prey looks {HEADING_NAMES[heading]}." in legend
        assert caption.startswith("What search has learned for itself")
        blind, _ = words("skill", taken, option=SEARCH - 1)
        assert "What obeys a command does not know where the prey looks" in blind


def test_the_flow_of_what_sees_headings_goes_by_each() -> None:
    values = zeros(5)
    values[..., SEARCH] = 1
    # Towards where the prey looks, whichever that is: the same way in all turned pictures.
    compass = [MOVES.tolist().index(way) for way in geometry.HEADINGS.tolist()]
    taken = commanding(moving(np.array(compass)), selection_q=values)
    for frame, (east, north) in ((FOLDED, (4.5, 0.0)), (0, (4.5, 0.0)), (2, (0.0, 4.5))):
        arrows = paint("flow", taken, frame=frame).arrows
        assert arrows is not None
        assert len(arrows) > 350
        way = arrows[:, 1] - arrows[:, 0]
        assert way == pytest.approx(np.broadcast_to([east, north], way.shape), abs=1e-4)


def test_a_manager_chooses_a_command() -> None:
    values = zeros(5)
    values[..., SEARCH] = 1
    legend, caption = words("chosen", commanding(selection_q=values))
    assert "The command of most value" in legend
    assert caption.startswith("The command that at least half of the prey")


def test_a_learner_of_moves_has_no_skills_to_show() -> None:
    moment = fresh("standard_q")
    assert everywhere_blank(paint("skill", moment))
    assert words("skill", moment)[1] == "This learner has no skills, only the nine moves."


def test_a_skill_that_is_gone_still_has_its_table() -> None:
    values = zeros(3)
    values[..., CIRCLE] = -np.inf
    moment = made(selection_q=values, skill_q=skill_tables(CIRCLE, EAST, 5))
    assert words("skill", moment, option=CIRCLE)[1].endswith("It is not among the skills now.")
    assert words("skill", moment, option=AVOID)[1] == "avoid has learned nothing yet."


# Policy flow --------------------------------------------------------------------------------


def test_the_flow_is_the_move_of_the_chosen_skill() -> None:
    tables = skill_tables(CIRCLE, EAST, 5) + skill_tables(AVOID, 7, 5)
    values = preferring(CIRCLE)
    west = np.cos(np.arange(SECTORS) * 2 * np.pi / SECTORS) < -0.01
    values[:, :, west] = preferring(AVOID)[:, :, west]
    arrows = paint("flow", made(selection_q=values, skill_q=tables), frame=4).arrows
    assert arrows is not None
    middle, way = arrows.mean(axis=1), arrows[:, 1] - arrows[:, 0]
    far = np.abs(middle[:, 0]) > 8
    expected = np.where(middle[:, :1] > 0, [4.5, 0.0], [0.0, 4.5])
    assert way[far] == pytest.approx(expected[far], abs=1e-4)


def test_the_folded_flow_turns_moves_with_the_prey() -> None:
    values = np.zeros((*MAP, N_MOVES), np.float32)
    for heading, (east, north) in enumerate(geometry.HEADINGS):
        move = int(np.flatnonzero((MOVES[:, 0] == east) & (MOVES[:, 1] == north))[0])
        values[heading, ..., move] = 1
    moment = made(fresh("standard_q"), selection_q=values)
    ahead = paint("flow", moment).arrows
    assert ahead is not None
    assert ahead[:, 1] - ahead[:, 0] == pytest.approx(
        np.broadcast_to([4.5, 0.0], (len(ahead), 2)), abs=1e-4
    )
    north = paint("flow", moment, frame=2).arrows
    assert north is not None
    assert north[:, 1] - north[:, 0] == pytest.approx(
        np.broadcast_to([0.0, 4.5], (len(north), 2)), abs=1e-4
    )
    assert (paint("chosen", moment).colours == move_colours(LIGHT)[EAST].round()).all()
    option = paint("option", moment, option=EAST, scale="linear", fitted=True)
    assert (paint("option", moment, option=WEST).colours == LIGHT.unknown).all()
    assert not (option.colours == LIGHT.unknown).all(axis=1).any()


def test_the_folded_flow_of_skills_turns_with_the_prey_too() -> None:
    bearing = np.arange(SECTORS) * 2 * np.pi / SECTORS
    nearness = -(MOVES[:, 0] * np.cos(bearing)[:, None] + MOVES[:, 1] * np.sin(bearing)[:, None])
    towards = nearness / np.maximum(np.hypot(*MOVES.T), 1)
    tables = np.zeros((3, RINGS, SECTORS, N_MOVES), np.float32)
    tables[APPROACH] = towards
    arrows = paint("flow", made(selection_q=preferring(APPROACH), skill_q=tables)).arrows
    assert arrows is not None
    assert len(arrows) > 350
    middle, way = arrows.mean(axis=1), arrows[:, 1] - arrows[:, 0]
    inwards = -(middle * way).sum(axis=1) / np.hypot(*middle.T) / 4.5
    assert inwards.min() > np.cos(np.radians(35))


def test_headings_that_disagree_have_no_arrow() -> None:
    tables = skill_tables(CIRCLE, EAST, 5)
    moment = made(selection_q=preferring(CIRCLE), skill_q=tables)
    folded, alone = paint("flow", moment).arrows, paint("flow", moment, frame=0).arrows
    assert folded is not None
    assert alone is not None
    assert len(folded) == 0
    assert len(alone) >= 390


@pytest.mark.parametrize(("agreeing", "drawn"), [(4, False), (5, True)])
def test_an_arrow_needs_more_than_half_of_the_headings(agreeing: int, drawn: bool) -> None:
    values = np.zeros((*MAP, N_MOVES), np.float32)
    values[..., EAST] = 1
    values = np.stack([turned_moves(values[h], h) for h in range(N_HEADINGS)])
    values[agreeing:] = 0
    arrows = paint("flow", made(fresh("standard_q"), selection_q=values)).arrows
    assert arrows is not None
    assert (len(arrows) > 0) == drawn


def test_each_arrow_of_the_flow_has_the_colour_of_the_skill_that_makes_the_move() -> None:
    tables = skill_tables(CIRCLE, EAST, 5) + skill_tables(AVOID, 7, 5)
    values = preferring(CIRCLE)
    values[:5] = preferring(AVOID)[:5]
    moment = made(selection_q=values, skill_q=tables)
    for heading, skill in ((0, AVOID), (7, CIRCLE)):
        picture = paint("flow", moment, frame=heading, theme=DARK)
        assert everywhere(picture, DARK.unknown)
        assert picture.arrow_colours is not None
        assert picture.arrows is not None
        assert picture.arrow_colours.shape == (len(picture.arrows), 3)
        assert (picture.arrow_colours == OPTION_COLOURS[skill]).all()
        legend = words("flow", moment, theme=DARK)[0]
        assert css(OPTION_COLOURS[skill]) in legend
    assert paint("flow", noisy(base=fresh("standard_q"))).arrow_colours is None


def test_on_a_light_board_the_arrows_of_skills_are_darker_than_their_areas() -> None:
    moment = made(selection_q=preferring(APPROACH), skill_q=skill_tables(APPROACH, EAST, 5))
    picture = paint("flow", moment, frame=0)
    assert picture.arrow_colours is not None
    board = np.array([LIGHT.unknown], float)
    assert nearest(picture.arrow_colours[:1], board, SIGHT["ordinary"]) > 3 * PLAINLY_APART


def test_before_anything_is_learned_the_flow_says_that_no_move_is_best() -> None:
    assert words("flow", fresh())[1].endswith("no move is clearly best yet.")


# Change since A -----------------------------------------------------------------------------


def since(steps: float, north: float | None = None) -> Extras:
    """A moment A at which a place east of the prey was so many steps from a capture, by heading 0.

    Another one, north of it, was as many as that if it is given.
    """
    return Extras(since=away(steps, north, step=0))


def away(steps: float, north: float | None = None, step: int = 1_000) -> Snapshot:
    """A moment at which a place is so many steps from a capture, and one in the north."""
    value = at_one_place(100 * 0.9**steps)
    if north is not None:
        value += at_one_place(100 * 0.9**north, 0, 40)
    return made(value=value, step=step)


def shown_at_east(moment: Snapshot, extras: Extras, **look: Any) -> list[int]:
    return colour_at(paint("change", moment, extras, frame=0, **look), 20, 0)


@both_themes
def test_a_place_that_came_nearer_has_another_hue_than_one_that_went_away(theme: Theme) -> None:
    for change, ramp in ((-20, NEARER), (20, FARTHER), (-50, NEARER), (80, FARTHER)):
        level = min(abs(change) / 50, 1) ** 0.5
        expected = of(amount_colours(ramp, theme), level, theme=theme)
        assert shown_at_east(away(90 + change), since(90), theme=theme) == expected


def test_where_less_than_a_step_changed_it_is_neither_and_not_the_board() -> None:
    same = shown_at_east(away(20.9), since(20))
    assert same == shown_at_east(away(19.1), since(20)) == shown_at_east(away(20), since(20))
    assert same != blank()
    assert shown_at_east(away(21.1), since(20)) == amount(FARTHER, (1.1 / 50) ** 0.5)


@both_themes
def test_what_is_newly_known_and_what_no_longer_is_have_hatches_of_their_own(
    theme: Theme,
) -> None:
    nowhere = made(value=zeros())
    looks: list[np.ndarray] = []
    for moment, extras, ramp in (
        (away(20), Extras(since=nowhere), NEARER),
        (nowhere, since(20), FARTHER),
    ):
        picture = paint("change", moment, extras, frame=0, theme=theme)
        strong = np.rint(amount_colours(ramp, theme)[-1])
        colours = {tuple(colour) for colour in picture.colours.tolist()}
        assert colours == {theme.unknown, tuple(strong.astype(int).tolist())}
        drawn = (picture.colours != np.array(theme.unknown)).any(axis=1)
        looks.append(drawn)
        place = on_board(state_at(20, 0))
        assert drawn[place].any()
        assert not drawn[place].all()
        assert not drawn[~place].any()
    assert (looks[0] != looks[1]).any()


def on_board(state: tuple[int, int]) -> np.ndarray:
    """Which cells are of a state."""
    readings = geometry.readings(fresh().spec.world).ravel()
    return np.asarray(readings == state[0] * SECTORS + state[1])


def test_a_folded_change_is_the_mean_of_those_who_knew_a_way_at_both_moments() -> None:
    then, now = zeros(), zeros()
    for heading in range(N_HEADINGS):
        place = (heading, 9, (3 + heading * SECTORS // N_HEADINGS) % SECTORS)
        then[place] = 100 * 0.9**60 if heading < 5 else 0
        now[place] = 100 * 0.9 ** (60 - 10 * heading) if heading else 0
    moment, extras = made(value=now), Extras(since=made(value=then))
    picture = paint("change", moment, extras)
    shown = picture.colours[on_board((9, 3))]
    # Of the headings 1 to 4: nearer by 10 to 40 steps.
    assert shown[0].tolist() == amount(NEARER, 0.5**0.5)
    assert (shown == shown[0]).all()
    then[2] = then[3] = 0
    # Fewer than half of all knew it: it is new.
    fewer = paint("change", moment, Extras(since=made(value=then))).colours[on_board((9, 3))]
    assert len(np.unique(fewer, axis=0)) == 2


def test_the_line_runs_round_what_is_known_at_the_moment_itself() -> None:
    over = paint("change", away(20), since(20, north=30), frame=0).over()
    (line,) = over.contours
    assert line.is_edge
    assert np.hypot(*line.segments.reshape(-1, 2).T).max() < 30


def test_each_moment_is_told_in_the_steps_of_its_own_reward_and_discount() -> None:
    base = fresh()
    learner = base.spec.learner.model_copy(update={"gamma": 0.8})
    patient = made(base, spec=base.spec.model_copy(update={"learner": learner}))
    moment = made(patient, value=at_one_place(100 * 0.8**20))
    assert shown_at_east(moment, since(20)) == shown_at_east(away(20), since(20))


@pytest.mark.parametrize("sight", SIGHT.values(), ids=SIGHT)
@both_themes
def test_nearer_and_farther_are_told_apart_and_are_no_outcomes_nor_values(
    theme: Theme, sight: np.ndarray
) -> None:
    ramps = [amount_colours(ramp, theme) for ramp in (NEARER, FARTHER)]
    for level in (0, 64, 128, 192, 255):
        assert nearest(ramps[0][[level]], ramps[1][[level]], sight) > PLAINLY_APART
    board = np.array([theme.unknown], float)
    ends = np.array([theme.capture, theme.flight], float)
    for ramp in ramps:
        assert nearest(ramp, board, sight) > 3 * JUST_NOTICEABLE
        assert nearest(ramp, ends, sight) > PLAINLY_APART
        assert nearest(ramp[128:], gain_colours(), SIGHT["ordinary"]) > PLAINLY_APART
    same = np.array([shown_at_east(away(20), since(20), theme=theme)], float)
    # A small change is near to none.
    for other in (ramps[0][128:], ramps[1][128:], board):
        assert nearest(same, other, sight) > 3 * JUST_NOTICEABLE


def test_a_change_is_told_in_numbers() -> None:
    legend, caption = words("change", away(15, north=30), since(40, north=25), frame=0)
    assert "nearer by 20" in legend
    assert "farther by 20" in legend
    assert "what changed since A, trial 0" in legend
    east, north = (on_board(state_at(*place)).sum() for place in ((20, 0), (0, 40)))
    assert caption == (
        f"Since A, trial 0: a capture is nearer in {east / (east + north):.0%} of the area that"
        f" has value, farther in {north / (east + north):.0%}."
    )
    nowhere = made(value=zeros(), step=1_000)
    nothing = words("change", nowhere, Extras(since=made(value=zeros())))[1]
    assert nothing == "Since A, trial 0: no way to a capture is known at either moment."
    gone = words("change", nowhere, since(20), frame=0)[1]
    assert gone.endswith("farther in 0%, no longer known in 100%.")
    later = away(15, step=0)
    assert words("change", later, Extras(since=away(40)))[1].startswith("Beside A, trial 0: ")
    moment = away(20)
    assert "this is A itself" in words("change", moment, Extras(since=moment))[1]


def test_side_by_side_the_numbers_are_of_all_headings_each_by_itself() -> None:
    then, now = zeros(), zeros()
    then[0, 9, 3] = then[5, 9, 3] = 100 * 0.9**40
    now[0, 9, 3], now[5, 9, 3] = 100 * 0.9**20, 100 * 0.9**60
    moment, extras = made(value=now, step=1_000), Extras(since=made(value=then))
    caption = words("change", moment, extras, frame=ALL)[1]
    assert "nearer in 50% of the area that has value, farther in 50%." in caption
    # What no half of the headings knows is not in the folded picture.
    assert "nearer in 0% of" in words("change", moment, extras)[1]


def test_the_ends_of_a_fitted_change_are_its_largest_on_both_sides() -> None:
    fixed = words("change", away(15, north=30), since(40, north=25), frame=0)[0]
    assert re.findall(r">([\d.+]+)</span>", fixed) == ["50+", "20", "5", "0", "5", "20", "50+"]
    fitted = words("change", away(15, north=30), since(40, north=25), frame=0, fitted=True)[0]
    assert re.findall(r">([\d.+]+)</span>", fitted) == ["25", "5", "0", "5", "25"]
    assert "25 steps nearer to as many farther" in fitted
    assert "nearer by 5" in fitted


def test_without_a_the_layer_says_how_to_set_it() -> None:
    for shown in words("change", away(20)):
        assert "The key A makes the moment that you look at A" in shown
    other = made(fresh("timed", "world.size=60"))
    for shown in words("change", away(20), Extras(since=other)):
        assert "another world" in shown
    assert everywhere_blank(paint("change", away(20), Extras(since=other)))


NAMES = ("standard_q", "timed")


def test_the_difference_of_two_runs_names_both() -> None:
    extras = Extras(since=away(40, north=25, step=1_000), names=NAMES)
    legend, caption = words("change", away(15, north=30), extras, frame=0)
    for said in ("nearer for timed by 20", "nearer for standard_q by 20", "known to timed alone"):
        assert said in legend
    assert "timed and standard_q, at step 1,000" in legend
    east, north = (on_board(state_at(*place)).sum() for place in ((20, 0), (0, 40)))
    assert caption == (
        f"timed and standard_q, at step 1,000: a capture is nearer for timed in"
        f" {east / (east + north):.0%} of the area that has value, nearer for standard_q in"
        f" {north / (east + north):.0%}."
    )
    since_a = paint("change", away(15, north=30), Extras(since=extras.since), frame=0)
    of_two = paint("change", away(15, north=30), extras, frame=0)
    assert np.array_equal(of_two.colours, since_a.colours)


def test_the_difference_of_two_runs_says_where_there_is_none_and_where_one_stands_at_its_end() -> (
    None
):
    moment = away(20)
    same = words("change", moment, Extras(since=away(20), names=NAMES), frame=0)[1]
    assert same == "timed and standard_q, at step 1,000: each knows what the other knows."
    nowhere, at_end = made(value=zeros(), step=1_000), made(value=zeros(), step=600)
    unknown = words("change", nowhere, Extras(since=at_end, names=NAMES))[1]
    assert unknown == (
        "timed and standard_q, at step 1,000 and 600: neither knows a way to a capture."
    )
    other = Extras(since=made(fresh("timed", "world.size=60")), names=NAMES)
    for shown in words("change", moment, other):
        assert "Difference of timed and standard_q" in shown
        assert "cannot be set against one another" in shown


# Frames -------------------------------------------------------------------------------------


def noisy(seed: int = 2, base: Snapshot | None = None) -> Snapshot:
    """A moment in which every table is noise."""
    base = fresh() if base is None else base
    rng = np.random.default_rng(seed)
    shape = base.selection_q.shape
    return made(
        base,
        selection_q=(rng.normal(size=shape) * 30).astype(np.float32),
        first_reach=rng.integers(-1, 20_000, size=shape[:3]).astype(np.int32),
        visits=rng.integers(0, 1_000, size=shape).astype(np.uint32),
        learning_now=rng.random(shape[:3]).astype(np.float32),
        skill_q=rng.normal(size=base.skill_q.shape).astype(np.float32),
        heading=3,
    )


def noisy_extras(base: Snapshot) -> Extras:
    """Ends of hunts, and a moment A, that are noise."""
    size = base.spec.world.size
    ends = np.random.default_rng(3).integers(0, 4, size=(N_HEADINGS, size, size))
    return dataclasses.replace(successes(ends), since=noisy(4, base))


def only(moment: Snapshot, heading: int) -> Snapshot:
    """The same moment, every other heading as that one."""
    names = ("selection_q", "value", "first_reach", "visits", "learning_now")
    tables = {name: getattr(moment, name) for name in names}
    return made(
        moment,
        **{name: np.repeat(table[[heading]], N_HEADINGS, axis=0) for name, table in tables.items()},
    )


def same(one: Picture, other: Picture) -> bool:
    """Whether two pictures are equal, their colours to the last bit."""
    lines = zip(one.over().contours, other.over().contours, strict=True)
    flat = ("colours", "arrows", "arrow_colours", "regions", "names")
    return all(
        a is b if a is None or b is None else np.array_equal(a, b)
        for a, b in ((getattr(one, name), getattr(other, name)) for name in flat)
    ) and all(np.allclose(a.segments, b.segments) for a, b in lines)


@every_layer
def test_a_fixed_heading_shows_its_own_rows(key: str) -> None:
    moment, extras = noisy(), noisy_extras(fresh())
    heading = 6
    alone = only(moment, heading)
    assert extras.success is not None
    assert extras.since is not None
    ends = successes(np.repeat(extras.success.outcomes[[heading]], N_HEADINGS, axis=0))
    turned = dataclasses.replace(ends, since=only(extras.since, heading))
    seen = paint(key, moment, extras, frame=heading)
    assert same(seen, paint(key, alone, turned, frame=0))
    assert key in ("skill", "stake", "traces") or not same(
        seen, paint(key, moment, extras, frame=5)
    )


@every_layer
def test_the_frame_of_the_trial_is_that_of_its_heading(key: str) -> None:
    moment, extras = noisy(), noisy_extras(fresh())
    seen = paint(key, moment, extras, frame=OF_TRIAL)
    assert same(seen, paint(key, moment, extras, frame=moment.heading))


FOLDING = [
    (preset, key)
    for preset in ("hierarchical_3", "standard_q")
    for key in LAYERS
    # Success folds by cells; a skill's table, and so the flow of skills, does not turn.
    if key not in ("success", "skill") and (preset, key) != ("hierarchical_3", "flow")
]


@pytest.mark.parametrize(("preset", "key"), FOLDING)
def test_what_all_headings_agree_on_folds_to_itself(preset: str, key: str) -> None:
    moment = noisy(base=fresh(preset))
    names = ("selection_q", "value", "first_reach", "visits", "learning_now")
    tables: dict[str, np.ndarray] = {}
    for name in names:
        ahead = np.repeat(getattr(moment, name)[:1], N_HEADINGS, axis=0)
        tables[name] = unfold(ahead, SECTORS)
    if preset == "standard_q":
        for heading in range(N_HEADINGS):
            tables["selection_q"][heading] = turned_moves(tables["selection_q"][heading], heading)
    moment = made(moment, **tables)
    # Heading 0 looks east already.
    assert same(paint(key, moment, option=2), paint(key, moment, option=2, frame=0))


def turned_moves(values: np.ndarray, heading: int) -> np.ndarray:
    """Values of moves that each point ``heading`` eighths of a turn further round."""
    turned = values.copy()
    angle = heading * np.pi / 4
    for move, (x, y) in enumerate(MOVES):
        if move == STAY:
            continue
        bearing = np.arctan2(y, x) + angle
        way = np.rint([np.cos(bearing), np.sin(bearing)])
        target = int(np.flatnonzero((way == MOVES).all(axis=1))[0])
        turned[..., target] = values[..., move]
    return turned


@every_layer
def test_the_legend_says_how_the_board_lies(key: str) -> None:
    folded = words(key, fresh())[0]
    north = words(key, fresh(), frame=2)[0]
    if key == "skill":
        assert "North is up." in folded
    else:
        assert "are turned so that it looks right" in folded
        assert "North is up, and the prey looks north." in north
    assert ("what it sees" in folded) == ("frame" in LAYERS[key].heeds_of(fresh().spec.learner))
    assert "what it sees" not in words(key, fresh(), field=False)[0]


# Words --------------------------------------------------------------------------------------


@every_layer
@pytest.mark.parametrize("frame", [FOLDED, 2])
def test_captions_are_one_line_that_a_room_can_read(key: str, frame: int) -> None:
    for moment in (fresh(), noisy(), fresh("standard_q")):
        _, caption = words(key, moment, noisy_extras(fresh()), frame=frame)
        assert "\n" not in caption
        assert 20 <= len(caption) <= 160
        assert caption.endswith(".")


@every_layer
def test_a_hostile_name_stays_a_name(key: str) -> None:
    base = noisy()
    learner = base.spec.learner.model_copy(
        update={
            "options": ("approach", HOSTILE, "avoid"),
            "custom_skills": {HOSTILE: SkillWeights(approach=1.0)},
        }
    )
    moment = made(base, spec=base.spec.model_copy(update={"learner": learner}))
    shown = "".join(words(key, moment, option=CIRCLE))
    assert "<img" not in shown
    if key in ("option", "skill", "chosen"):
        assert "&lt;img src=x onerror=alert(1)&gt;" in shown


def test_the_marks_of_a_bar_do_not_run_into_each_other() -> None:
    for ruler in (STEPS, Ruler(0, 100), Ruler(1, 1e6, "log"), Ruler(0, 48_000, "root")):
        marks = bar_marks(ruler, of_any_size)
        places = [place for place, _ in marks]
        assert len(marks) >= 4
        assert (np.diff(places) > 0.05).all()
        assert [places[0], places[-1]] == [0, 1]


def test_the_bar_of_the_value_runs_from_far_to_near() -> None:
    legend, _ = words("value", fresh())
    marks = re.findall(r"left:([\d.]+)%[^>]*>([^<]+)<", legend)
    assert {("0.0", "200+"), ("50.0", "50"), ("100.0", "0")} <= set(marks)


# All headings -------------------------------------------------------------------------------


def side_by_side(key: str, moment: Snapshot, extras: Extras | None = None) -> list[np.ndarray]:
    """Colours ``(y, x, 3)`` of the eight, from the south-west of each."""
    picture = all_headings(moment, Look(layer=key, frame=ALL), LAYERS[key], extras or Extras())
    return list(picture.colours.reshape(N_HEADINGS, SIDE, SIDE, 3))


def test_the_eight_are_the_headings_from_east_on_each_by_itself() -> None:
    value = zeros()
    value[...] = 100 * 0.9 ** (5.0 * np.arange(N_HEADINGS))[:, None, None]
    for heading, tile in enumerate(side_by_side("value", made(value=value))):
        alone = paint("value", made(value=value), frame=heading)
        assert tile[3, 3].tolist() == colour_at(alone, -54, -54)


def test_north_is_up_in_each_of_the_eight() -> None:
    tile = side_by_side("value", made(value=at_one_place(100 * 0.9**25, 0, 40)))[5]
    is_known = (tile != LIGHT.unknown).any(axis=-1)
    assert is_known[SIDE // 2 :].any()
    assert not is_known[: SIDE // 2].any()


def test_the_eight_have_names_and_lie_two_by_four_as_one_reads() -> None:
    picture = all_headings(fresh(), Look(frame=ALL), LAYERS["value"], Extras())
    assert [label.text for label in picture.over().labels] == [
        f"prey faces {name}" for name in HEADING_NAMES
    ]
    for label, tile in zip(picture.over().labels, TILES, strict=True):
        assert label.east == tile.east * SIZE
        # Above its own, and below that above.
        assert tile_at(tile.east, tile.north) is tile
        assert tile_at(label.east / SIZE, label.north / SIZE) is None
    columns, rows = np.array([(tile.east, tile.north) for tile in TILES]).T
    assert (np.diff(columns.reshape(2, 4)) > 0).all()
    assert columns[:4].tolist() == columns[4:].tolist()
    assert (rows[:4] > 0).all()
    assert (rows[4:] < 0).all()


def test_arrows_and_their_colours_lie_in_their_own_heading() -> None:
    tables = skill_tables(CIRCLE, EAST, 5)
    moment = made(selection_q=preferring(CIRCLE), skill_q=tables)
    picture = all_headings(moment, Look(layer="flow", frame=ALL), LAYERS["flow"], Extras())
    assert picture.arrows is not None
    assert picture.arrow_colours is not None
    assert len(picture.arrows) == len(picture.arrow_colours) > 8 * 90
    found = [tile_at(*(middle / SIZE).tolist()) for middle in picture.arrows.mean(axis=1)]
    counts = [found.count(tile) for tile in TILES]
    assert sum(counts) == len(picture.arrows)
    assert len(set(counts)) == 1


# Every world, every moment ------------------------------------------------------------------

WORLDS = {
    "standard": (),
    "coarse": ("world.n_directions=8", "world.n_distances=6"),
    "fine": ("world.n_directions=48", "world.n_distances=64"),
    "small": ("world.size=20",),
    "odd": ("world.size=37", "world.n_distances=2"),
    "no rewards": ("world.capture_reward=0", "world.flight_reward=0"),
    "turned about": ("world.capture_reward=-5", "world.flight_reward=3"),
    "short-sighted": ("learner.gamma=0",),
    "skills that see finer": (
        "world.n_directions=8",
        "world.n_distances=6",
        "world.skill_n_directions=24",
        "world.skill_n_distances=18",
    ),
    "skills that see coarser": ("world.skill_n_distances=2", "world.ring_exponent=1"),
    "binary local rewards": ("learner.local_rewards=binary", "world.size=30"),
}
LOOKS: list[dict[str, Any]] = [
    {"theme": theme, "frame": frame, "scale": scale, "fitted": fitted}
    for theme, frame, scale, fitted in [
        (LIGHT, FOLDED, "steps", False),
        (DARK, FOLDED, "linear", True),
        (DARK, OF_TRIAL, "steps", True),
        (LIGHT, 7, "linear", False),
    ]
]


def sound(key: str, moment: Snapshot, extras: Extras, look: Look) -> None:
    """A picture of this layer is one that a board can show, whatever the moment."""
    layer, n_cells = LAYERS[key], moment.spec.world.size**2
    picture = layer.paint(moment, look, extras)
    assert picture.colours.shape == (n_cells, 3)
    assert picture.colours.dtype == np.uint8
    if picture.arrows is not None:
        assert picture.arrows.dtype == np.float32
        assert picture.arrows.shape[1:] == (2, 2)
        assert len(picture.arrows) <= 450
        assert np.isfinite(picture.arrows).all()
    legend = layer.legend(moment, look, extras)
    assert legend.count("<div") == legend.count("</div>")
    assert "nan" not in legend
    assert layer.caption(moment, look, extras)
    if look.frame == FOLDED:
        all_of_it = all_headings(moment, look._replace(frame=ALL), layer, extras)
        assert all_of_it.colours.shape == (N_HEADINGS * SIDE**2, 3)


@every_layer
@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("preset", ["timed", "standard_q"])
@pytest.mark.filterwarnings("error")
def test_every_layer_shows_every_world(key: str, world: str, preset: str) -> None:
    before = fresh(preset, *WORLDS[world])
    extras = (Extras(), noisy_extras(before))
    for moment in (before, noisy(base=before), unknown(before)):
        for place, look in enumerate(LOOKS):
            # In turn, but for the layer that draws them.
            for more in extras if key in ("success", "change") else extras[place % 2 :][:1]:
                sound(key, moment, more, Look(layer=key, option=1, **look))


def unknown(base: Snapshot) -> Snapshot:
    """A moment in which no option is present."""
    return made(base, selection_q=np.full_like(base.selection_q, -np.inf))


@every_layer
@pytest.mark.filterwarnings("error")
def test_every_layer_shows_a_large_world(key: str) -> None:
    moment = noisy(base=fresh("timed", "world.size=400"))
    sound(key, moment, noisy_extras(moment), Look(layer=key))


@every_layer
def test_what_is_not_known_is_the_empty_board(key: str) -> None:
    assert everywhere_blank(paint(key, unknown(fresh())))


finite = st.floats(-1e6, 1e6, width=32)
entries = st.one_of(st.just(0.0), st.just(float("-inf")), finite, st.sampled_from([1e-38, 100.0]))


@given(
    column=st.lists(st.lists(entries, min_size=3, max_size=3), min_size=1, max_size=12),
    reach=st.lists(st.integers(-1, 2_000_000), min_size=1, max_size=12),
    key=st.sampled_from(list(LAYERS)),
    look=st.sampled_from(LOOKS),
    option=st.integers(-1, 12),
)
def test_no_table_breaks_a_layer(
    column: list[list[float]], reach: list[int], key: str, look: dict[str, Any], option: int
) -> None:
    base = fresh("timed", *WORLDS["coarse"])
    shape = base.selection_q.shape
    n_states = int(np.prod(shape[:3]))
    values = np.resize(np.array(column, np.float32), (n_states, 3)).reshape(shape)
    moment = made(
        base,
        selection_q=values,
        learning_now=np.abs(np.nan_to_num(values[..., 0], neginf=0)),
        first_reach=np.resize(np.array(reach, np.int32), shape[:3]),
    )
    since = made(base, selection_q=values[::-1])
    sound(key, moment, Extras(since=since), Look(layer=key, option=option, **look))
