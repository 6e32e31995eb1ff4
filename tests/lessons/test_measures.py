"""What lessons measure: by the bounds of the findings, in any world."""

import numpy as np
import pytest

from app.documents import presets
from app.documents.lesson_grammar import (
    OCTANTS,
    REGIONS,
    OfExperiment,
    Reading,
    Window,
)
from app.explain.shape import unseen
from app.lessons import regions
from app.lessons.measures import (
    LEADER_STEPS,
    MEASURES,
    Deeds,
    Racing,
    View,
    measured,
    view_of_run,
)
from app.results import spread
from learners import measures
from learners.kernel.state import tables
from learners.run import Run
from sim.spec import WorldSpec
from sim.world import CAPTURE

SPEC = presets.load("timed")
STANDARD = SPEC.world


@pytest.fixture(scope="module")
def run() -> Run:
    run = Run(SPEC, 3)
    run.advance(until_trial=4_000)
    return run


def found(name: str, view: View, args: object = None) -> object:
    return measured(Reading(name, args), view)


@pytest.mark.parametrize(
    ("region", "of_findings"),
    [("right_flank", spread.RIGHT_FLANK), ("left_flank", spread.LEFT_FLANK)],
)
def test_flanks_are_those_of_the_findings(region: str, of_findings: spread.Region) -> None:
    expected = np.zeros((STANDARD.n_distances, STANDARD.n_directions), bool)
    expected[of_findings.rings, list(of_findings.directions)] = True
    assert np.array_equal(regions.masks(STANDARD)[region], expected)


def test_a_run_is_measured_as_the_findings_measure_it(run: Run) -> None:
    q = np.nan_to_num(tables(run.spec, run.state)["selection_q"], nan=-np.inf).max(axis=-1)
    share = measures.folded_value(q, STANDARD.capture_reward, SPEC.learner.gamma).share
    view = view_of_run(run)
    assert found("reach", view, "right_flank") == spread.RIGHT_FLANK.of(share).mean()
    assert found("thinnest", view) == share[10:14].mean(axis=0).min()
    assert found("behind_share", view) == pytest.approx(share[:, 7:18].sum() / share.sum())
    assert found("value_states", view) == int((q > 0).sum())
    outcome = run.state.log_outcome[: run.trial]
    assert found("captures", view) == int((outcome == CAPTURE).sum())
    assert found("success", view) == (outcome[-500:] == CAPTURE).mean()
    reward = run.state.log_reward[: run.trial]
    assert found("reward", view, Window(500)) == reward[-500:].mean()
    assert found("reward", view, Window(None, 1_000, 1_500)) == reward[1_000:1_500].mean()
    assert found("reward", view, Window(None, 1_000, 4_001)) is None
    windows = Window(None, 0, 500), Window(None, 3_500, 4_000)
    assert found("change", view, windows) == reward[3_500:4_000].mean() - reward[:500].mean()


@pytest.mark.parametrize("n_directions", [8, 16, 24, 40, 48])
@pytest.mark.parametrize("n_distances", [2, 6, 18, 64])
@pytest.mark.parametrize("size", [20, 120, 400])
def test_regions_of_any_world(size: int, n_distances: int, n_directions: int) -> None:
    world = WorldSpec(size=size, n_distances=n_distances, n_directions=n_directions)
    masks = regions.masks(world)
    assert set(masks) == set(REGIONS)
    mirrored = (-np.arange(n_directions)) % n_directions
    for one, other in (("left_flank", "right_flank"), ("n", "s"), ("ne", "se"), ("nw", "sw")):
        assert np.array_equal(masks[one][:, mirrored], masks[other])
    assert masks["left_flank"].any()
    assert masks["behind"].any()
    assert not (masks["behind"] & masks["ahead"]).any()
    assert np.array_equal(masks["visual_field"], ~unseen(world))
    # Octants leave out no direction.
    octants = np.logical_or.reduce([masks[octant] for octant in OCTANTS])
    assert np.array_equal(octants.any(axis=0), np.ones(n_directions, bool)) or n_distances < 6
    assert not (octants & masks["visual_field"]).any()


def racing(name: str, rewards: list[float], length: int, *, is_over: bool = False) -> Racing:
    """One whose trials all take so many steps."""
    ends = length * np.arange(1, len(rewards) + 1)
    return Racing(name, np.array(rewards), ends, int(ends[-1]), is_over)


def test_who_leads_goes_by_the_last_steps_and_is_known_once_all_are_there() -> None:
    width = LEADER_STEPS // 10
    rises = racing("rises", [0.0] * 30 + [90.0] * 10, width)
    stays = racing("stays", [50.0] * 40, width)
    view = view_of_run(Run(SPEC, 0), Deeds(race=(rises, stays)))
    assert found("leader", view, 30 * width) == "stays"
    assert found("leader", view, 40 * width) == "rises"
    assert found("leader", view, 41 * width) is None
    # One that is over stands where it ended.
    over = racing("over", [99.0] * 20, width, is_over=True)
    view = view_of_run(Run(SPEC, 0), Deeds(race=(rises, over)))
    assert found("leader", view, 40 * width) == "over"
    assert found("leader", view_of_run(Run(SPEC, 0)), 40 * width) is None


def test_a_variant_is_held_against_another() -> None:
    columns = {"whole": {"final_reward": [80.0, 82.0]}, "less": {"final_reward": [60.0, 64.0]}}
    view = view_of_run(Run(SPEC, 0), Deeds(experiments={"ablation": columns}))

    def of(**stated: str) -> object:
        args = OfExperiment(name="ablation", quantity="final_reward", **stated)
        return found("experiment", view, args)

    assert of() == {"whole": 81.0, "less": 62.0}
    assert of(variant="less") == 62.0
    assert of(variant="less", against="whole") == -19.0
    assert of(variant="less", against="nobody") is None
    assert of(variant="nobody") is None


def test_every_measure_says_what_it_is() -> None:
    for name, measure in MEASURES.items():
        assert measure.title, name
        assert measure.title[0].islower()
