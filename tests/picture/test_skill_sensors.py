"""Skills with sensors of their own are drawn where they see what they know, for every heading."""

import dataclasses
import functools

import numpy as np
import pytest

from app.documents import presets
from app.live import snapshot
from app.live.snapshot import Snapshot
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import FOLDED, Look
from app.picture.raster import raster
from app.picture.theme import LIGHT
from learners import hunts
from learners.run import Run
from sim import geometry
from sim.geometry import MOVES
from sim.spec import N_HEADINGS, WorldSpec
from sim.world import cell_at
from tests.support.frames import unfold

COARSE = (
    "world.size=60",
    "world.n_directions=8",
    "world.n_distances=6",
    "world.skill_n_directions=24",
    "world.skill_n_distances=18",
)


@functools.cache
def moment() -> Snapshot:
    """Skills that see four times as many sectors as the selection, all tables full of values."""
    taken = snapshot.take(Run(presets.load("hierarchical_3", COARSE), 1), "hierarchical_3", 0)
    draw = np.random.default_rng(3)
    selection_q = draw.normal(size=taken.selection_q.shape).astype(np.float32)
    skill_q = draw.normal(size=taken.skill_q.shape).astype(np.float32)
    value = selection_q.max(axis=-1)
    return dataclasses.replace(taken, selection_q=selection_q, value=value, skill_q=skill_q)


def middle_cell(arrow: np.ndarray) -> tuple[int, int]:
    """The cell in whose middle an arrow lies, as an offset from the prey."""
    east, north = arrow.mean(axis=0)
    return round(float(east)), round(float(north))


def move_of(arrow: np.ndarray) -> int:
    """The move that an arrow is drawn for."""
    east, north = np.sign(np.rint((arrow[1] - arrow[0]) * 10)).astype(int)
    return MOVES.tolist().index([east, north])


def test_tables_have_the_shapes_that_are_stated() -> None:
    taken = moment()
    assert taken.selection_q.shape == (N_HEADINGS, 6, 8, 3)
    assert taken.skill_q.shape == (3, 18, 24, 9)


def test_a_skills_own_value_is_drawn_by_the_states_that_it_sees() -> None:
    taken = moment()
    world = taken.spec.world
    skill_q = np.zeros_like(taken.skill_q)
    ring, direction = 9, 5
    skill_q[1, ring, direction, 0] = 1
    shown = dataclasses.replace(taken, skill_q=skill_q)
    picture = LAYERS["skill"].paint(shown, Look(layer="skill", option=1), Extras())
    there = geometry.readings(world.of_skills).ravel() == ring * 24 + direction
    assert 0 < there.sum() < 60
    shown = (picture.colours != LIGHT.unknown).any(axis=1)
    np.testing.assert_array_equal(shown, there)


@pytest.mark.parametrize("heading", range(N_HEADINGS))
def test_arrows_of_the_flow_go_where_a_hunt_would(heading: int) -> None:
    taken = moment()
    world, policy = taken.world, hunts.greedy_moves(taken.selection_q, taken.skill_q)
    arrows = LAYERS["flow"].paint(taken, Look(layer="flow", frame=heading), Extras()).arrows
    assert arrows is not None
    assert len(arrows) > 300
    px, py = geometry.prey_xy(taken.spec.world)
    for arrow in arrows:
        east, north = middle_cell(arrow)
        cell = cell_at(world, px + east, py + north)
        hunt = hunts.hunt(world, policy, cell, heading, max_steps=1)
        assert move_of(arrow) == hunt.moves[0]


def test_arrows_of_a_skill_are_its_own_best_moves() -> None:
    taken = moment()
    arrows = LAYERS["skill"].paint(taken, Look(layer="skill", option=2), Extras()).arrows
    assert arrows is not None
    states = geometry.readings(taken.spec.world.of_skills)
    px, py = geometry.prey_xy(taken.spec.world)
    best = taken.skill_q[2].argmax(axis=-1).ravel()
    for arrow in arrows:
        east, north = middle_cell(arrow)
        assert move_of(arrow) == best[states[py + north, px + east]]


def test_the_folded_flow_is_that_of_every_heading_turned() -> None:
    """Where eight headings go the same way in the prey's own frame, so do the folded arrows."""
    taken = moment()
    # In the prey's frame: the selection takes one option; the skill goes towards the prey.
    one = np.full((N_HEADINGS, 6, 8, 3), -1.0, np.float32)
    one[..., 0] = 1.0
    skill_q = np.zeros_like(taken.skill_q)
    for direction in range(24):
        angle = np.pi + direction * 2 * np.pi / 24
        along = MOVES @ np.array([np.cos(angle), np.sin(angle)]) / np.maximum(np.hypot(*MOVES.T), 1)
        skill_q[0, :, direction] = along
    shown = dataclasses.replace(
        taken, selection_q=unfold(one, 8), value=one.max(axis=-1), skill_q=skill_q
    )
    arrows = LAYERS["flow"].paint(shown, Look(layer="flow", frame=FOLDED), Extras()).arrows
    assert arrows is not None
    assert len(arrows) > 250
    middles, ways = arrows.mean(axis=1), arrows[:, 1] - arrows[:, 0]
    inwards = -(middles * ways).sum(axis=1)
    inwards /= np.hypot(*middles.T) * np.hypot(*ways.T)
    assert (inwards > np.cos(np.radians(31))).all()


def test_rasters_know_the_power_of_the_rings_and_the_skills_sensors() -> None:
    even, standard = WorldSpec(ring_exponent=1.0), WorldSpec()
    for world in (even, standard):
        np.testing.assert_array_equal(raster(world).states, geometry.readings(world).ravel())
    finer = WorldSpec(n_directions=8, n_distances=6, skill_n_directions=24, skill_n_distances=18)
    np.testing.assert_array_equal(
        raster(finer).as_skills_see.states, geometry.readings(standard).ravel()
    )
    assert raster(finer, 75).as_skills_see.states.shape == (75 * 75,)
