"""From tables to colours, on tables small enough to know the answer."""

import itertools
import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.picture.colours import (
    OPTION_COLOURS,
    css,
    gain_colours,
    gradient_css,
    over_board,
    palette,
)
from app.picture.raster import on_raster, raster
from app.picture.shading import (
    FARTHEST_STEPS,
    Known,
    Scale,
    equivalent_steps,
    fixed_shading,
    known_of,
    nearness,
)
from app.picture.theme import DARK, LIGHT, Theme
from app.picture.value_maps import HATCH_COVER
from sim import geometry
from sim.spec import N_HEADINGS, WorldSpec
from tests.support.sight import JUST_NOTICEABLE, PLAINLY_APART, SIGHT, lab, linear, nearest

REWARD, GAMMA = 100.0, 0.9
THEMES = {"light": LIGHT, "dark": DARK}
both_themes = pytest.mark.parametrize("theme", THEMES.values(), ids=THEMES)

N_DISTANCES, N_DIRECTIONS = 3, 16
TURN = N_DIRECTIONS // N_HEADINGS
"""Sectors from one heading to the next."""


def nothing_known() -> np.ndarray:
    """A value map in which nothing has been learned."""
    return np.zeros((N_HEADINGS, N_DISTANCES, N_DIRECTIONS), np.float32)


def worth(steps: float) -> float:
    """Value of a state so many steps from certain capture."""
    return REWARD * GAMMA**steps


def known(**parts: float) -> Known:
    """A folded map of one state; parts that are not given stand for nothing known."""
    nothing = {"steps": math.nan, "gain": 0, "positive_share": 0, "negative_share": 0}
    return Known(**{name: np.array([[part]]) for name, part in {**nothing, **parts}.items()})


def folded(value: np.ndarray) -> Known:
    """What is known of a value map in the prey's own frame."""
    return known_of(geometry.fold(value, N_DIRECTIONS), REWARD, GAMMA)


def on_board(per_state: np.ndarray, world: WorldSpec) -> np.ndarray:
    """States ``(distance, direction, ...)`` spread over the board, ``(y, x, ...)``."""
    spread = on_raster(per_state, raster(world))
    return spread.reshape(world.size, world.size, *per_state.shape[2:])


def colour_of(state: Known, scale: Scale = "steps", reward: float = REWARD) -> list[int]:
    """Colour of the one state of a folded map."""
    return rounded(palette(gain_colours(), fixed_shading(scale, reward).level(state))[0, 0])


def rounded(colour: np.ndarray) -> list[int]:
    """A colour as the page gets it."""
    return np.rint(colour).astype(int).tolist()


# Equivalent distance to capture


@given(st.floats(0, FARTHEST_STEPS))
def test_a_state_worth_a_discounted_reward_is_that_many_steps_away(steps: float) -> None:
    assert equivalent_steps(np.array([worth(steps)]), REWARD, GAMMA) == pytest.approx(
        steps, abs=1e-9
    )


def test_distances_are_cut_off_at_both_ends_of_the_scale() -> None:
    values = np.array([3 * REWARD, REWARD, worth(FARTHEST_STEPS + 50)])
    steps = equivalent_steps(values, REWARD, GAMMA)
    assert steps.tolist() == [0.0, 0.0, FARTHEST_STEPS]


def test_the_smallest_float_is_far_away_and_no_error() -> None:
    tiny = np.array([np.finfo(np.float32).smallest_subnormal])
    assert equivalent_steps(tiny, REWARD, 0.99).tolist() == [FARTHEST_STEPS]


def test_a_state_of_no_value_or_less_has_no_distance() -> None:
    values = np.array([0.0, -0.0, -1e-30, -50.0])
    assert np.isnan(equivalent_steps(values, REWARD, GAMMA)).all()


# Folding


def test_a_place_seen_alike_by_all_headings_folds_to_one_state() -> None:
    value = nothing_known()
    for heading in range(N_HEADINGS):
        value[heading, 1, (5 + heading * TURN) % N_DIRECTIONS] = worth(7)
    seen = folded(value)
    assert seen.steps[1, 5] == pytest.approx(7, abs=1e-4)
    assert seen.gain[1, 5] == pytest.approx(worth(7), rel=1e-6)
    assert seen.positive_share[1, 5] == 1
    assert np.count_nonzero(seen.positive_share) == 1
    assert np.isnan(seen.steps).sum() == seen.steps.size - 1


def test_distances_are_averaged_over_the_headings_that_have_one() -> None:
    value = nothing_known()
    value[0, 2, 4] = worth(10)
    value[1, 2, 4 + TURN] = worth(30)
    value[2, 2, 4 + 2 * TURN] = -8
    seen = folded(value)
    # The mean of the distances, and not the distance of the mean value (which is near 15).
    assert seen.steps[2, 4] == pytest.approx(20, abs=1e-4)
    assert seen.gain[2, 4] == pytest.approx((worth(10) + worth(30)) / 2, rel=1e-6)
    assert seen.positive_share[2, 4] == 2 / N_HEADINGS
    assert seen.negative_share[2, 4] == 1 / N_HEADINGS


def test_nothing_known_folds_to_nothing() -> None:
    seen = folded(nothing_known())
    assert np.isnan(seen.steps).all()
    for part in (seen.gain, seen.positive_share, seen.negative_share):
        assert not part.any()


# Colours of states


@pytest.mark.parametrize("scale", ["steps", "linear"])
def test_certain_capture_is_the_end_of_the_colour_map(scale: Scale) -> None:
    certain = known(steps=0, gain=REWARD, positive_share=1)
    assert colour_of(certain, scale) == rounded(gain_colours()[-1])


def test_the_farthest_is_the_start_of_the_colour_map() -> None:
    far = known(steps=FARTHEST_STEPS, gain=1e-9, positive_share=1)
    assert colour_of(far) == rounded(gain_colours()[0])


def test_the_linear_scale_goes_by_value_up_to_the_reward() -> None:
    colours = gain_colours()
    for gain, level in ((0.0, 0.0), (25.0, 0.25), (100.0, 1.0), (250.0, 1.0)):
        state = known(steps=0, gain=gain, positive_share=1)
        assert colour_of(state, "linear") == rounded(colours[int(level * 255)])


def test_a_world_without_reward_still_has_a_scale() -> None:
    state = known(steps=0, gain=0, positive_share=0.5, negative_share=0.5)
    for scale in ("steps", "linear"):
        assert np.isfinite(fixed_shading(scale, 0.0).level(state)).all()


def test_nearness_runs_from_1_at_the_prey_to_0_at_the_far_end() -> None:
    steps = np.array([0, FARTHEST_STEPS / 4, FARTHEST_STEPS])
    assert nearness(steps).tolist() == [1.0, 0.5, 0.0]


def test_a_palette_is_read_by_level_and_clipped() -> None:
    colours = np.arange(5)[:, None] * np.ones(3)
    levels = np.array([-1, 0, 0.49, 0.5, 1, 7, np.nan])
    assert palette(colours, levels)[:, 0].tolist() == [0, 0, 1, 2, 4, 4, 0]


# On the board


def test_states_spread_over_the_board_in_the_rows_of_the_north() -> None:
    world = WorldSpec(size=21, n_directions=8, n_distances=2)
    east_and_north = np.zeros((2, 8))
    east_and_north[1, 0] = 1
    east_and_north[1, 2] = 2
    board = on_board(east_and_north, world)
    assert board.shape == (21, 21)
    assert board[10, 20] == 1  # (y, x): the middle of the eastern edge
    assert board[20, 10] == 2
    assert board[10, 0] == board[0, 10] == board[10, 10] == 0


def test_every_cell_of_the_board_gets_the_colour_of_its_state() -> None:
    world = WorldSpec(size=20)
    names = np.arange(world.n_skill_states).reshape(world.n_distances, world.n_directions)
    board = on_board(np.stack([names, -names], axis=-1), world)
    assert board.shape == (20, 20, 2)
    assert (board[..., 0] == -board[..., 1]).all()
    # The prey stands at (10, 10); by sector and ring of a grid of 20, worked out by hand.
    far = math.hypot(10, 10)
    for x, y in ((19, 10), (10, 19), (1, 10), (10, 1), (14, 14), (17, 3)):
        dx, dy = x - 10, y - 10
        direction = math.floor(math.degrees(math.atan2(dy, dx)) / 15 + 0.5) % 24
        ring = math.ceil(18 * (math.hypot(dx, dy) / far) ** (2 / 3) - 1e-9) - 1
        assert board[y, x, 0] == ring * 24 + direction


# CSS


def test_a_colour_is_written_with_whole_numbers() -> None:
    assert css((0, 128, 255)) == "rgb(0,128,255)"
    assert css(np.array([0.4, 127.6, 254.9])) == "rgb(0,128,255)"


def test_a_gradient_has_evenly_spaced_colours_from_the_first_on() -> None:
    ramp = np.arange(256)[:, None] * np.ones(3)
    gradient = gradient_css(ramp)
    stops = [int(red) for red in re.findall(r"rgb\((\d+),\d+,\d+\)", gradient)]
    assert gradient.startswith("linear-gradient(to right,rgb(0,0,0),")
    assert 10 <= len(stops) <= 14
    assert set(np.diff(stops)) == {stops[1]}
    assert stops[-1] >= 250


def test_a_gradient_of_few_colours_shows_them_all() -> None:
    three = np.array([[0.0, 0, 0], [9, 9, 9], [255, 255, 255]])
    assert gradient_css(three) == (
        "linear-gradient(to right,rgb(0,0,0),rgb(9,9,9),rgb(255,255,255))"
    )


# Colour-blind sight

all_sights = pytest.mark.parametrize("sight", SIGHT.values(), ids=SIGHT)


def test_the_distance_of_colours_is_the_textbook_one() -> None:
    lightness = lab(np.array([[255, 255, 255], [0, 0, 0]]), SIGHT["ordinary"])
    assert lightness == pytest.approx(np.array([[100, 0, 0], [0, 0, 0]]), abs=1e-3)
    red = lab(np.array([[255, 0, 0]]), SIGHT["ordinary"])[0]
    assert red == pytest.approx([53.24, 80.09, 67.20], abs=0.02)


def test_red_and_green_are_hard_to_tell_apart_for_some() -> None:
    olive, brown = np.array([[110, 110, 40]]), np.array([[140, 95, 40]])
    assert nearest(olive, brown, SIGHT["ordinary"]) > 2 * nearest(
        olive, brown, SIGHT["deuteranopia"]
    )


@all_sights
@both_themes
def test_what_is_known_stands_out_from_the_board_for_all_kinds_of_sight(
    theme: Theme, sight: np.ndarray
) -> None:
    board = np.array([theme.unknown])
    assert nearest(gain_colours(), board, sight) > PLAINLY_APART
    hatch = over_board(np.array(theme.flight), HATCH_COVER, theme)
    assert nearest(hatch[None], board, sight) > PLAINLY_APART


@both_themes
def test_no_two_things_have_one_colour(theme: Theme) -> None:
    others = np.array(
        [
            *(theme.prey, theme.predator, theme.capture, theme.flight, theme.timeout),
            *(theme.forced, theme.frozen),
        ]
    )
    for index, colour in enumerate(others):
        rest = np.delete(others, index, axis=0)
        assert nearest(colour[None], rest, SIGHT["ordinary"]) > PLAINLY_APART
    skills = OPTION_COLOURS[:6]
    assert nearest(others, skills, SIGHT["ordinary"]) > PLAINLY_APART
    # What the prey sees is the prey's.
    assert theme.field == theme.prey


@all_sights
@both_themes
def test_value_and_flight_stay_apart_for_all_kinds_of_sight(
    theme: Theme, sight: np.ndarray
) -> None:
    assert nearest(gain_colours(), np.array([theme.flight]), sight) > PLAINLY_APART


@all_sights
def test_nearer_is_lighter_for_all_kinds_of_sight(sight: np.ndarray) -> None:
    lightness = lab(gain_colours(), sight)[:, 0]
    assert (np.diff(lightness) >= 0).all()
    assert lightness[-1] - lightness[0] > 45


@all_sights
@both_themes
def test_the_ends_of_trials_stay_apart_for_all_kinds_of_sight(
    theme: Theme, sight: np.ndarray
) -> None:
    kinds = [theme.capture, theme.flight, theme.timeout]
    for one, other in itertools.combinations(kinds, 2):
        assert nearest(np.array([one]), np.array([other]), sight) > 5 * JUST_NOTICEABLE


@both_themes
def test_text_and_marks_stand_out_from_the_board(theme: Theme) -> None:
    def luminance(colour: tuple[int, int, int]) -> float:
        return float(linear(np.array(colour)) @ [0.2126, 0.7152, 0.0722])

    def contrast(one: tuple[int, int, int]) -> float:
        dark, light = sorted([luminance(one), luminance(theme.unknown)])
        return (light + 0.05) / (dark + 0.05)

    # The limits of WCAG 2.1 for text and for graphics.
    assert contrast(theme.ink) >= 4.5
    for mark in (theme.prey, theme.predator, theme.capture, theme.flight, theme.timeout):
        assert contrast(mark) >= 3
