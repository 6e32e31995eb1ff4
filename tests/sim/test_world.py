"""Geometry and events of the world, against their definitions."""

import math
from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from learners.kernel.state import CELL, HEADING
from learners.run import Run
from learners.spec import RunSpec
from sim import geometry, rng
from sim.bits import U
from sim.geometry import HEADINGS, MOVES, N_MOVES, STAY
from sim.spec import N_HEADINGS, WorldSpec
from sim.world import (
    FRAME_BIT,
    PREY_BIT,
    READING_SHIFT,
    World,
    board_xy,
    cell_at,
    compile_world,
    in_view,
    moved,
    skill_state_of,
    start_of_trial,
)
from tests.support.frames import unfold

sizes = st.integers(20, 160)
sectors = st.sampled_from([8, 16, 24, 32, 40, 48])

STANDARD = WorldSpec()
SIZES = (20, 27, 60)


def move_between(world: World, x: int, y: int, move: int) -> tuple[int, int]:
    """Grid coordinates after a move in the compiled world."""
    cell = moved(world.cell_word, world.clipped, world.move_step, U(cell_at(world, x, y)), U(move))
    return board_xy(world, cell)


def whole_offsets(size: int) -> tuple[np.ndarray, np.ndarray]:
    """East and north offsets of all cells from the prey, worked out afresh, ``[y, x]``."""
    y, x = np.mgrid[0:size, 0:size]
    return x - size // 2, y - size // 2


# Cells and moves


def test_moves_are_the_eight_neighbours_and_staying() -> None:
    neighbours = {(dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1)}
    assert {tuple(move) for move in MOVES.tolist()} == neighbours
    assert len(MOVES) == N_MOVES == 9
    assert MOVES[STAY].tolist() == [0, 0]


def test_headings_point_to_multiples_of_45_degrees_counter_clockwise_from_east() -> None:
    for heading, (dx, dy) in enumerate(HEADINGS.tolist()):
        degrees = math.degrees(math.atan2(dy, dx)) % 360
        assert degrees == pytest.approx(45 * heading)
        assert max(abs(dx), abs(dy)) == 1


@pytest.mark.parametrize("size", SIZES)
def test_cells_and_coordinates_are_each_others_inverse(size: int) -> None:
    world = compile_world(WorldSpec(size=size))
    cells = set()
    for x in range(size):
        for y in range(size):
            cell = cell_at(world, x, y)
            assert board_xy(world, cell) == (x, y)
            assert not int(world.cell_word[cell]) & int(FRAME_BIT)
            cells.add(cell)
    assert len(cells) == size * size


@pytest.mark.parametrize(("x", "y"), [(-1, 0), (0, -1), (20, 5), (5, 20)])
def test_a_cell_off_the_grid_is_refused(x: int, y: int) -> None:
    world = compile_world(WorldSpec(size=20))
    with pytest.raises(ValueError, match=rf"\({x}, {y}\) is off the grid; allowed: 0 to 19"):
        cell_at(world, x, y)


@pytest.mark.parametrize("size", SIZES)
def test_a_move_is_clipped_at_the_edge_each_coordinate_on_its_own(size: int) -> None:
    world = compile_world(WorldSpec(size=size))
    for x in range(size):
        for y in range(size):
            for move, (dx, dy) in enumerate(MOVES.tolist()):
                clipped = (min(max(x + dx, 0), size - 1), min(max(y + dy, 0), size - 1))
                assert move_between(world, x, y, move) == clipped


@pytest.mark.parametrize("size", SIZES)
def test_the_prey_is_in_the_middle_and_nowhere_else(size: int) -> None:
    spec = WorldSpec(size=size)
    world = compile_world(spec)
    on_board = (world.cell_word & np.uint32(FRAME_BIT)) == 0
    on_prey = (world.cell_word & np.uint32(PREY_BIT)) != 0
    assert np.flatnonzero(on_board & on_prey).tolist() == [int(world.prey_cell)]
    assert board_xy(world, int(world.prey_cell)) == (size // 2, size // 2)
    assert geometry.prey_xy(spec) == (size // 2, size // 2)


@given(size=sizes, n_directions=sectors, n_distances=st.integers(2, 64))
def test_the_compiled_cells_say_what_the_geometry_says(
    size: int, n_directions: int, n_distances: int
) -> None:
    spec = WorldSpec(size=size, n_directions=n_directions, n_distances=n_distances)
    world = compile_world(spec)
    board = world.cell_word.reshape(size + 2, size + 2)[1:-1, 1:-1]
    np.testing.assert_array_equal(board >> np.uint32(READING_SHIFT), geometry.readings(spec))
    for heading, visible in enumerate(geometry.visible(spec)):
        np.testing.assert_array_equal(((board >> np.uint32(heading)) & 1).astype(bool), visible)
    dx, dy = whole_offsets(size)
    inner = (slice(1, -1), slice(1, -1))
    distance = np.sqrt(dx**2 + dy**2).astype(np.float32)
    np.testing.assert_array_equal(world.distance.reshape(size + 2, -1)[inner], distance)
    angle = world.angle.reshape(size + 2, -1)[inner]
    np.testing.assert_allclose(np.cos(angle) * distance, dx, atol=1e-4)
    np.testing.assert_allclose(np.sin(angle) * distance, dy, atol=1e-4)


# The visual field


@given(size=st.one_of(sizes, st.sampled_from([40, 80, 120, 160])), radius=st.integers(0, 120))
def test_the_visual_field_is_the_half_disc_ahead(size: int, radius: int) -> None:
    """Asked in whole numbers, so that cells on the circle and on the diameter count exactly."""
    visible = geometry.visible(WorldSpec(size=size, vision_radius=float(radius)))
    dx, dy = whole_offsets(size)
    near = (dx**2 + dy**2) * 120**2 <= (radius * size) ** 2
    for heading, (ahead_x, ahead_y) in enumerate(HEADINGS.tolist()):
        np.testing.assert_array_equal(visible[heading], near & (dx * ahead_x + dy * ahead_y > 0))


def test_the_visual_field_by_hand() -> None:
    """A prey at (60, 60) that faces east, then north-east."""
    visible = geometry.visible(STANDARD)
    east, north_east = visible[0], visible[1]
    assert east[60, 61]
    assert east[60, 60 + 27]
    assert not east[60, 60 + 28]
    assert not east[60, 60]
    assert not east[70, 60], "on the diameter"
    assert not east[60, 59]
    assert east[60 - 26, 61]
    assert north_east[79, 79]
    assert not north_east[80, 80], "27 < sqrt(20^2 + 20^2)"
    assert not north_east[70, 50], "on the diameter"


def test_a_move_onto_the_prey_is_judged_from_the_cell_it_came_from() -> None:
    world = compile_world(STANDARD)
    prey = world.cell_word[world.prey_cell]
    for heading in range(N_HEADINGS):
        for direction, (dx, dy) in enumerate(HEADINGS.tolist()):
            came_from = world.cell_word[cell_at(world, 60 + dx, 60 + dy)]
            apart = abs((direction - heading + 4) % 8 - 4)
            assert in_view(came_from, prey, U(heading)) == (apart <= 1)


def test_any_other_move_is_judged_from_where_it_ends() -> None:
    world = compile_world(STANDARD)
    east = U(0)
    seen = world.cell_word[cell_at(world, 61, 62)]
    unseen = world.cell_word[cell_at(world, 60, 62)]
    assert in_view(unseen, seen, east)
    assert not in_view(seen, unseen, east)


# Sensors


@given(size=sizes, n_distances=st.integers(2, 64), twice=st.integers(2, 6))
def test_every_cell_is_in_the_ring_whose_edges_enclose_it(
    size: int, n_distances: int, twice: int
) -> None:
    """d <= d_max * (k / n)^e, asked in whole numbers: d^2 * n^2e <= d_max^2 * k^2e."""
    spec = WorldSpec(size=size, n_distances=n_distances, ring_exponent=twice / 2)
    ring = geometry.readings(spec) // spec.n_directions
    dx, dy = whole_offsets(size)
    distance_squared = dx**2 + dy**2
    farthest_squared = int(distance_squared.max())
    outer = ring + 1
    scaled = distance_squared * n_distances**twice
    assert (scaled <= farthest_squared * outer**twice).all()
    inside = ring > 0
    beyond_inner = scaled > farthest_squared * ring**twice
    assert beyond_inner[inside].all()
    assert ring.min() == 0
    assert ring[0, 0] == n_distances - 1, "the last ring includes the far corner"


@given(size=sizes, n_distances=st.integers(2, 64))
def test_outer_edges_of_rings(size: int, n_distances: int) -> None:
    edges = geometry.ring_edges(WorldSpec(size=size, n_distances=n_distances))
    far = math.hypot(size // 2, size // 2)
    expected = [far * (k / n_distances) ** 1.5 for k in range(1, n_distances + 1)]
    np.testing.assert_allclose(edges, expected, rtol=1e-12)
    widths = np.diff(edges, prepend=0.0)
    assert (widths > 0).all()
    assert (np.diff(widths) > 0).all(), "near rings are thinner"


def test_rings_are_equally_wide_for_an_exponent_of_one_and_thinner_for_a_larger_one() -> None:
    first = {e: geometry.ring_edges(WorldSpec(ring_exponent=e))[0] for e in (1.0, 1.5, 3.0)}
    widths = np.diff(geometry.ring_edges(WorldSpec(ring_exponent=1.0)), prepend=0.0)
    np.testing.assert_allclose(widths, 60 * math.sqrt(2) / 18)
    assert first[1.0] > first[1.5] > first[3.0]


def test_a_cell_exactly_on_an_edge_belongs_to_the_ring_inside_it() -> None:
    """Size 54: d_max = 27 sqrt(2); the edge of ring 2 of 18 is d_max / 27 = sqrt(2)."""
    spec = WorldSpec(size=54)
    ring = geometry.readings(spec) // spec.n_directions
    assert ring[28, 28] == 1
    assert ring[27, 29] == 2


@given(size=sizes, n_directions=sectors)
def test_sectors_are_equal_centred_on_east_and_counter_clockwise(
    size: int, n_directions: int
) -> None:
    spec = WorldSpec(size=size, n_directions=n_directions)
    direction = geometry.readings(spec) % n_directions
    dx, dy = whole_offsets(size)
    # The bearing less that of the middle of the cell's sector is within half a sector.
    middle = direction * 2 * np.pi / n_directions
    along = dx * np.cos(middle) + dy * np.sin(middle)
    across = dy * np.cos(middle) - dx * np.sin(middle)
    beside = np.abs(np.arctan2(across, along))
    elsewhere = (dx != 0) | (dy != 0)
    assert (beside[elsewhere] < np.pi / n_directions).all()
    centre = size // 2
    quarter = n_directions // 4
    arms = direction[
        [centre, centre + 5, centre, centre - 5], [centre + 5, centre, centre - 5, centre]
    ]
    assert arms.tolist() == [0, quarter, 2 * quarter, 3 * quarter]
    assert direction[centre + 5, centre + 5] == n_directions // 8


@given(size=sizes, n_directions=sectors, radius=st.integers(1, 60))
def test_a_quarter_turn_shifts_the_direction_by_a_quarter_and_the_heading_by_two(
    size: int, n_directions: int, radius: int
) -> None:
    spec = WorldSpec(size=size, n_directions=n_directions, vision_radius=float(radius))
    dx, dy = whole_offsets(size)
    centre = size // 2
    # An even grid has no row of cells opposite to its first, so that row is left out.
    kept = (np.abs(dx) <= (size - 1) // 2) & (np.abs(dy) <= (size - 1) // 2)
    x, y = dx[kept], dy[kept]
    here = (y + centre, x + centre)
    turned = (x + centre, -y + centre)

    reading = geometry.readings(spec)
    ring, direction = reading // n_directions, reading % n_directions
    np.testing.assert_array_equal(ring[turned], ring[here])
    elsewhere = (x != 0) | (y != 0)
    np.testing.assert_array_equal(
        direction[turned][elsewhere],
        (direction[here][elsewhere] + n_directions // 4) % n_directions,
    )
    visible = geometry.visible(spec)
    for heading in range(N_HEADINGS):
        np.testing.assert_array_equal(visible[(heading + 2) % 8][turned], visible[heading][here])


@given(size=sizes, n_directions=sectors, n_distances=st.integers(2, 64))
def test_every_cell_reads_one_of_the_skill_states_of_which_each_heading_has_all(
    size: int, n_directions: int, n_distances: int
) -> None:
    spec = WorldSpec(size=size, n_directions=n_directions, n_distances=n_distances)
    reading = geometry.readings(spec)
    assert spec.n_readings == spec.n_skill_states == n_distances * n_directions
    assert spec.n_states == 8 * spec.n_readings
    assert reading.min() >= 0
    assert reading.max() < spec.n_readings


@given(
    size=sizes,
    skill_n_directions=st.none() | sectors,
    skill_n_distances=st.none() | st.integers(2, 64),
    ring_exponent=st.floats(1, 3),
)
def test_skills_have_the_sensors_that_are_stated_and_otherwise_those_of_the_selection(
    size: int,
    skill_n_directions: int | None,
    skill_n_distances: int | None,
    ring_exponent: float,
) -> None:
    spec = WorldSpec(
        size=size,
        n_directions=16,
        n_distances=11,
        skill_n_directions=skill_n_directions,
        skill_n_distances=skill_n_distances,
        ring_exponent=ring_exponent,
    )
    alone = WorldSpec(
        size=size,
        n_directions=skill_n_directions or 16,
        n_distances=skill_n_distances or 11,
        ring_exponent=ring_exponent,
    )
    assert spec.of_skills == alone
    assert spec.n_skill_states == alone.n_readings
    assert spec.n_states == 8 * 16 * 11
    world, skills = compile_world(spec), compile_world(alone)
    by_skills = skills.cell_word >> np.uint32(READING_SHIFT)
    by_selection = world.cell_word >> np.uint32(READING_SHIFT)
    for cell in cell_at(world, 0, 0), cell_at(world, size // 3, size - 1), int(world.prey_cell):
        read = skill_state_of(world.skill_states, U(cell), U(by_selection[cell]))
        assert read == by_skills[cell]
    same = (alone.n_directions, alone.n_distances) == (16, 11)
    assert (world.skill_states is None) == spec.shares_sensors == same


def test_the_standard_world_has_3456_states_and_432_skill_states() -> None:
    assert STANDARD.n_states == 3_456
    assert STANDARD.n_skill_states == 432


# The fold


@given(n_directions=sectors, n_rings=st.integers(1, 5), seed=st.integers(0, 2**32 - 1))
def test_unfold_is_the_inverse_of_fold(n_directions: int, n_rings: int, seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=(N_HEADINGS, n_rings, n_directions, 2))
    folded = geometry.fold(values, n_directions)
    assert folded.shape == values.shape
    np.testing.assert_array_equal(unfold(folded, n_directions), values)
    np.testing.assert_array_equal(geometry.fold(unfold(values, n_directions), n_directions), values)


@given(n_directions=sectors, n_rings=st.integers(1, 5), seed=st.integers(0, 2**32 - 1))
def test_the_fold_of_a_map_in_the_preys_frame_is_the_same_for_all_headings(
    n_directions: int, n_rings: int, seed: int
) -> None:
    own_frame = np.random.default_rng(seed).normal(size=(n_rings, n_directions))
    values = np.empty((N_HEADINGS, n_rings, n_directions))
    for heading in range(N_HEADINGS):
        for direction in range(n_directions):
            # Seen from the prey, the predator stands at this many sectors from straight ahead.
            from_ahead = (direction - heading * n_directions // 8) % n_directions
            values[heading, :, direction] = own_frame[:, from_ahead]
    for folded in geometry.fold(values, n_directions):
        np.testing.assert_array_equal(folded, own_frame)


def test_the_cell_straight_ahead_folds_to_direction_0() -> None:
    direction = geometry.readings(STANDARD) % 24
    marks = np.zeros((N_HEADINGS, 1, 24), dtype=bool)
    for heading, (dx, dy) in enumerate(HEADINGS.tolist()):
        marks[heading, 0, direction[60 + 10 * dy, 60 + 10 * dx]] = True
    folded = geometry.fold(marks, 24)
    assert folded[:, 0, 0].all()
    assert folded.sum() == N_HEADINGS


# Starts


def starts(spec: WorldSpec, seed: int, trials: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Offsets east and north from the prey and headings of the first trials of a seed."""
    world = compile_world(spec)
    stream = rng.streams(seed)[rng.STARTS]
    drawn = [start_of_trial(world, stream, trial) for trial in range(trials)]
    x, y = np.array([board_xy(world, int(cell)) for cell, _ in drawn]).T
    return x - spec.size // 2, y - spec.size // 2, np.array([int(h) for _, h in drawn])


def chi_square(counts: np.ndarray) -> float:
    """Distance of counts from all being equal."""
    expected = counts.sum() / counts.size
    return float(((counts - expected) ** 2 / expected).sum())


@given(
    size=st.sampled_from([20, 21, 60, 120, 150]),
    radius=st.sampled_from([(10.0, 60.0), (6.0, 6.0), (6.0, 60.0), (60.0, 60.0)]),
    seed=st.integers(0, 2**63 - 1),
)
def test_starts_lie_between_the_nearest_and_the_farthest_and_never_on_the_prey(
    size: int, radius: tuple[float, float], seed: int
) -> None:
    spec = WorldSpec(size=size, start_radius=radius)
    dx, dy, heading = starts(spec, seed, 40)
    distance = np.hypot(dx, dy)
    # The nearest cell is at most half a diagonal away; the edge takes off one cell at most.
    rounding = math.sqrt(0.5)
    assert (distance <= radius[1] * size / 120 + rounding).all()
    assert (distance >= radius[0] * size / 120 - rounding - (radius[0] == 60)).all()
    assert (distance > 0).all()
    for offset in (dx, dy):
        assert (offset + size // 2 >= 0).all()
        assert (offset + size // 2 < size).all()
    assert (heading >= 0).all()
    assert (heading < N_HEADINGS).all()


def test_radius_angle_and_heading_of_starts_are_uniform_and_independent() -> None:
    """Limits are the 99.9 % points of the distributions; the seed is fixed."""
    n = 20_000
    dx, dy, heading = starts(STANDARD, 7, n)
    radius = np.hypot(dx, dy)
    within = [(radius <= limit).mean() for limit in (20, 30, 40, 50)]
    np.testing.assert_allclose(within, [0.2, 0.4, 0.6, 0.8], atol=0.012)

    # Half an octant is added so that the axes, on which whole cells fall, are not a limit.
    octant = np.floor(np.arctan2(dy, dx) / (np.pi / 4) + 0.5).astype(int) % 8
    assert chi_square(np.bincount(octant, minlength=8)) < 24.3
    assert chi_square(np.bincount(heading, minlength=8)) < 24.3
    assert chi_square(np.bincount(octant * 8 + heading, minlength=64)) < 103.4
    far = (radius > 35).astype(int)
    assert chi_square(np.bincount(far * 8 + heading, minlength=16)) < 37.7
    assert chi_square(np.bincount(far * 8 + octant, minlength=16)) < 37.7


def test_following_starts_do_not_depend_on_each_other() -> None:
    dx, dy, heading = starts(STANDARD, 3, 20_000)
    assert chi_square(np.bincount(heading[:-1] * 8 + heading[1:], minlength=64)) < 103.4
    for values in (dx, dy):
        assert abs(np.corrcoef(values[:-1], values[1:])[0, 1]) < 0.025


def run_of(options: object, seed: int) -> Run:
    """A small run whose trials are short."""
    return Run(
        RunSpec.model_validate(
            {
                "world": {"size": 30, "step_limit": 40},
                "learner": {"options": options, "alpha": 0.5},
                "trials": 60,
            }
        ),
        seed,
    )


def starts_of(run: Run) -> list[tuple[int, int]]:
    """Cell and heading with which each trial of a run starts."""
    places = []
    for trial in range(run.spec.trials):
        run.advance(until_trial=trial)
        places.append((int(run.state.place[CELL]), int(run.state.place[HEADING])))
    return places


def test_learners_with_different_options_see_the_same_starts() -> None:
    """Common random numbers, although they spend their decisions differently."""
    moves, skills = run_of("moves", 5), run_of(["approach", "avoid"], 5)
    assert starts_of(moves) == starts_of(skills)
    assert moves.step != skills.step
    assert moves.state.streams[rng.DECISIONS] != skills.state.streams[rng.DECISIONS]


def test_a_start_is_a_function_of_seed_and_trial() -> None:
    run = run_of("moves", 5)
    stream = rng.streams(5)[rng.STARTS]
    in_any_order = {
        trial: start_of_trial(run.world, stream, trial) for trial in reversed(range(60))
    }
    alone = [(int(cell), int(heading)) for _, (cell, heading) in sorted(in_any_order.items())]
    assert starts_of(run) == alone
    assert starts_of(run_of("moves", 6)) != alone
    assert len(set(alone)) > 50


@pytest.mark.parametrize("seed", [-1, 2**63])
def test_a_seed_out_of_range_is_refused(seed: int) -> None:
    with pytest.raises(
        ValueError, match=rf"seed: {seed} is not allowed; allowed: 0 to {2**63 - 1}"
    ):
        rng.streams(seed)


# Scale


@pytest.mark.parametrize(
    ("size", "vision", "nearest", "farthest"), [(60, 13.5, 5.0, 30.0), (150, 33.75, 12.5, 75.0)]
)
def test_lengths_scale_with_the_size_and_the_step_limit_does_not(
    size: int, vision: float, nearest: float, farthest: float
) -> None:
    spec = WorldSpec(size=size)
    world = compile_world(spec)
    dx, dy = whole_offsets(size)
    seen = np.hypot(dx, dy)[geometry.visible(spec).any(axis=0)]
    assert vision - 0.5 < seen.max() <= vision
    assert (world.start_nearest, world.start_farthest) == pytest.approx((nearest, farthest))
    np.testing.assert_allclose(
        geometry.ring_edges(spec), geometry.ring_edges(STANDARD) * size / 120, rtol=1e-12
    )
    assert world.step_limit == 500
    distance = np.hypot(*starts(spec, 1, 2_000)[:2])
    assert nearest - 1 < distance.min() < nearest + 1
    assert farthest - 1 < distance.max() < farthest + 1


# Refusals


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ({"size": 19}, ["size\n", "input_value=19", "greater than or equal to 20"]),
        ({"size": 401}, ["size\n", "input_value=401", "less than or equal to 400"]),
        ({"size": 60.0}, ["size\n", "input_value=60.0", "valid integer"]),
        ({"size": True}, ["size\n", "input_value=True", "valid integer"]),
        ({"size": "60"}, ["size\n", "input_value='60'", "valid integer"]),
        ({"n_directions": 12}, ["n_directions\n", "input_value=12", "multiple of 8"]),
        ({"n_directions": 0}, ["n_directions\n", "input_value=0", "greater than or equal to 8"]),
        ({"n_directions": 56}, ["n_directions\n", "input_value=56", "less than or equal to 48"]),
        ({"n_distances": 1}, ["n_distances\n", "input_value=1", "greater than or equal to 2"]),
        ({"skill_n_directions": 12}, ["skill_n_directions\n", "input_value=12", "multiple of 8"]),
        ({"skill_n_distances": 1}, ["skill_n_distances\n", "greater than or equal to 2"]),
        ({"ring_exponent": 0.9}, ["ring_exponent\n", "greater than or equal to 1"]),
        ({"ring_exponent": 3.1}, ["ring_exponent\n", "less than or equal to 3"]),
        ({"n_distances": 65}, ["n_distances\n", "input_value=65", "less than or equal to 64"]),
        (
            {"vision_radius": -1.0},
            ["vision_radius\n", "input_value=-1.0", "greater than or equal to 0"],
        ),
        (
            {"vision_radius": 1001.0},
            ["vision_radius\n", "input_value=1001.0", "less than or equal to 1000"],
        ),
        ({"vision_radius": math.nan}, ["vision_radius\n", "input_value=nan", "finite"]),
        ({"step_limit": 0}, ["step_limit\n", "input_value=0", "greater than or equal to 1"]),
        (
            {"step_limit": 1_000_001},
            ["step_limit\n", "input_value=1000001", "less than or equal to 1000000"],
        ),
        ({"capture_reward": math.inf}, ["capture_reward\n", "input_value=inf", "finite"]),
        (
            {"flight_reward": -2e6},
            ["flight_reward\n", "input_value=-2000000", "greater than or equal to"],
        ),
        ({"start_radius": (0.5, 60.0)}, ["start_radius", "0.5", "allowed: 1 or more", "size 120"]),
        (
            {"size": 20, "start_radius": (5.0, 60.0)},
            ["nearest start, 5,", "allowed: 6 or more", "size 20"],
        ),
        ({"start_radius": (30.0, 20.0)}, ["start, 20,", "not be smaller than the nearest, 30"]),
        ({"start_radius": (10.0, 61.0)}, ["farthest start, 61,", "outside the grid", "up to 60"]),
        ({"start_radius": (10.0,)}, ["start_radius.1\n", "input_value=(10.0,)", "required"]),
        ({"start_radius": (10.0, math.inf)}, ["start_radius.1\n", "input_value=inf", "finite"]),
        ({"sizes": 60}, ["sizes\n", "input_value=60", "not permitted"]),
    ],
)
def test_a_refusal_names_the_value_and_what_is_allowed(
    stated: Mapping[str, object], said: list[str]
) -> None:
    with pytest.raises(ValidationError) as refusal:
        WorldSpec.model_validate(stated)
    for part in said:
        assert part in str(refusal.value)


def test_all_problems_of_the_starts_are_told_at_once() -> None:
    with pytest.raises(ValidationError) as refusal:
        WorldSpec(start_radius=(90.0, 80.0))
    assert "must not be smaller than the nearest, 90" in str(refusal.value)
    assert "80, lies outside the grid" in str(refusal.value)


@pytest.mark.parametrize(
    "stated",
    [
        {"size": 20, "start_radius": (6.0, 6.0)},
        {"size": 400, "n_directions": 48, "n_distances": 64},
        {"n_directions": 8, "n_distances": 2, "step_limit": 1, "vision_radius": 0.0},
        {"start_radius": [10, 60], "vision_radius": 27},
    ],
)
def test_the_limits_themselves_are_allowed(stated: Mapping[str, object]) -> None:
    compile_world(WorldSpec.model_validate(stated))


def test_a_world_cannot_be_changed_once_stated() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        STANDARD.size = 60
