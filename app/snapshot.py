"""What a run looks like at one moment: a copy that nobody changes any more.

The worker takes one between two slices of learning; views and panels read it and nothing else.
"""

from dataclasses import dataclass

import numpy as np

from learners import kernel, measures, rows
from learners.measures import Curve, Endings, Pace
from learners.run import Control, Run
from learners.spec import RunSpec
from learners.state import n_options_of
from sim.spec import N_HEADINGS
from sim.world import World

TRAIL_STEPS = 120
"""Steps of the running trial that the trail shows."""
RECENT_ENDS = 12
"""Ends of trials that a snapshot carries, for the flashes."""


@dataclass(frozen=True)
class TrialEnd:
    """Where and how a trial ended."""

    trial: int
    cell: int
    heading: int
    outcome: int


@dataclass(frozen=True)
class Snapshot:
    """One moment of one run. Arrays are copies."""

    preset: str
    spec: RunSpec
    seed: int
    generation: int
    """Counts the runs of a session, so that a view knows when another began."""
    world: World
    control: Control
    present: tuple[str, ...]
    selection_frozen: bool
    step: int
    trial: int
    trial_step: int
    cell: int
    heading: int
    selection_q: np.ndarray
    """(heading, distance, direction, option) float32, minus infinity where not present."""
    value: np.ndarray
    """(heading, distance, direction) float32: the largest of the present options' values."""
    first_reach: np.ndarray
    """(heading, distance, direction) int32: trial in which the value first rose, or -1."""
    option_visits: np.ndarray
    """(option,) int64: how often each option has been taken so far."""
    trail: np.ndarray
    """(step,) int64: cells of the running trial, oldest first, at most ``TRAIL_STEPS + 1``."""
    ends: tuple[TrialEnd, ...]
    """The most recent ends of trials, oldest first."""
    recent: Endings
    """How the last ``measures.RECENT_TRIALS`` trials ended."""
    pace: Pace
    curve: Curve


def curve_window(steps: int) -> int:
    """Steps of one window of a curve drawn with at most 250 points: 1, 2 or 5 times 10**k."""
    width = 1_000
    while steps > 250 * width:
        width = width * 5 // 2 if str(width)[0] == "2" else width * 2
    return width


def take(run: Run, preset: str, generation: int, curve: Curve | None = None) -> Snapshot:
    """Copy what is seen of a run; ``curve`` saves computing it again when it is recent enough."""
    state, spec = run.state, run.spec
    shape = (N_HEADINGS, spec.world.n_distances, spec.world.n_directions)
    n_options = n_options_of(spec)
    if curve is None:
        curve = measures.curve(spec.world, state, curve_window(run.step))
    return Snapshot(
        preset=preset,
        spec=spec,
        seed=run.seed,
        generation=generation,
        world=run.world,
        control=run.control,
        present=run.present,
        selection_frozen=run.selection_is_frozen,
        step=run.step,
        trial=run.trial,
        trial_step=int(state.tally[kernel.TRIAL_STEP]),
        cell=int(state.place[kernel.CELL]),
        heading=int(state.place[kernel.HEADING]),
        selection_q=rows.values(state.selection)[:, :n_options].reshape(*shape, n_options).copy(),
        value=rows.best(state.selection).reshape(shape).copy(),
        first_reach=state.first_reach.reshape(shape).copy(),
        option_visits=state.visits.reshape(-1, n_options).sum(axis=0, dtype=np.int64),
        trail=_trail(run),
        ends=_ends(run),
        recent=measures.endings(state, measures.RECENT_TRIALS),
        pace=measures.pace(state),
        curve=curve,
    )


def _trail(run: Run) -> np.ndarray:
    """Cells of the running trial in order, its start included while it is recent enough."""
    state = run.state
    made = int(state.tally[kernel.TRIAL_STEP])
    count = min(made, TRAIL_STEPS)
    steps = np.arange(run.step - count + 1, run.step + 1)
    cells = state.trail[steps % kernel.TRAIL_LENGTH].astype(np.int64)
    if made <= TRAIL_STEPS:
        start, _ = run.start_of(run.trial)
        cells = np.concatenate([[start], cells])
    return cells


def _ends(run: Run) -> tuple[TrialEnd, ...]:
    state = run.state
    trials = range(max(run.trial - RECENT_ENDS, 0), run.trial)
    return tuple(
        TrialEnd(
            trial=trial,
            cell=int(state.log_cell[trial]),
            heading=run.start_of(trial)[1],
            outcome=int(state.log_outcome[trial]),
        )
        for trial in trials
    )
