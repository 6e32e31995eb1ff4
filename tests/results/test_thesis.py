"""The thesis's findings: what they are measured by, and the rule that decides them."""

import dataclasses
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import stats

from app.analysis import estimates
from app.analysis.estimates import Contrast, Estimate
from app.documents import presets
from app.experiments.record import Record
from app.results import findings, read, spread, thesis
from app.results.findings import Finding, Margin
from app.results.spread import Region
from learners import measures
from learners.measures import FoldedValue
from sim import geometry
from sim.spec import N_HEADINGS, WorldSpec
from sim.world import CAPTURE, FLIGHT
from tests.support.folders import add_arrays, add_run, new_folder, pictures, seal

NO_PICTURES = pictures([], np.zeros((0, 18, 24)), np.zeros((0, 18, 24)))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return new_folder(tmp_path / "results with blanks, ünicode # and ?")


def of_margin(margin: Margin) -> Finding:
    return Finding("", "", "", "", (), margin)


ABOVE = of_margin(findings.named("above", 15, findings.REWARD))
BELOW = of_margin(findings.named("below", 15, findings.REWARD))
CLOSE = of_margin(findings.named("within", 15, findings.REWARD))


@pytest.mark.parametrize(
    ("finding", "low", "high", "n", "expected"),
    [
        (ABOVE, 16, 30, 10, findings.HOLDS),
        (ABOVE, 0, 14, 10, findings.FAILS),
        (ABOVE, 14, 16, 30, findings.UNDECIDED),
        (ABOVE, 16, 30, 9, findings.UNDECIDED),
        (BELOW, 0, 14, 10, findings.HOLDS),
        (BELOW, 16, 30, 10, findings.FAILS),
        (BELOW, 14, 16, 30, findings.UNDECIDED),
        (CLOSE, -14, 14, 10, findings.HOLDS),
        (CLOSE, 16, 30, 10, findings.FAILS),
        (CLOSE, -30, -16, 10, findings.FAILS),
        (CLOSE, -16, 0, 10, findings.UNDECIDED),
    ],
)
def test_the_rule(finding: Finding, low: float, high: float, n: int, expected: str) -> None:
    assert findings.verdict(finding, Estimate((low + high) / 2, low, high, n)) == expected


def effect(value: float, error: float, n: int = 30) -> Contrast:
    """A sum of so many runs, its interval that of the t distribution."""
    arm = stats.t.ppf(0.975, n - 1) * error
    return Contrast(Estimate(value, value - arm, value + arm, n), True, error, n - 1)


MORE_OR_LESS = st.floats(-40, 40, allow_nan=False)


@given(MORE_OR_LESS, st.floats(0.1, 20), st.sampled_from([ABOVE, BELOW, CLOSE]))
def test_alone_the_p_of_a_finding_says_what_its_interval_says(
    value: float, error: float, finding: Finding
) -> None:
    (found,) = findings.judged([(finding, effect(value, error))])
    assert found.p == found.corrected_p
    # A verdict by an interval lets an interval that ends at the bound meet it, near enough.
    assume(abs(found.p - 0.05) > 1e-6)
    assert found.corrected_verdict == found.verdict


@given(st.lists(st.tuples(MORE_OR_LESS, st.floats(0.1, 20)), max_size=12))
def test_among_others_a_finding_is_decided_the_same_or_not_at_all(
    sums: list[tuple[float, float]],
) -> None:
    every = [(finding, effect(*a)) for a in sums for finding in (ABOVE, BELOW, CLOSE)]
    for found in findings.judged(every):
        assert found.corrected_p >= found.p
        if abs(found.p - 0.05) > 1e-6:
            assert found.corrected_verdict in (found.verdict, findings.UNDECIDED)


def test_what_too_few_runs_say_is_not_tested_and_does_not_count_among_the_others() -> None:
    certain, few = effect(30, 5.5), effect(30, 0.1, n=9)
    alone, *others = findings.judged([(ABOVE, certain), (ABOVE, few), (ABOVE, few)])
    assert alone.corrected_p == alone.p
    assert all(np.isnan(found.p) for found in others)
    assert {found.corrected_verdict for found in others} == {findings.UNDECIDED}


def test_of_many_findings_a_weak_one_is_left_undecided() -> None:
    weak = findings.judged([(ABOVE, effect(21, 2.5))] * 5)
    assert {found.verdict for found in weak} == {findings.HOLDS}
    assert {found.corrected_verdict for found in weak} == {findings.UNDECIDED}


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def placed_runs(
    folder: Path, seeds: Sequence[int], arrays: Mapping[str, np.ndarray] = {}
) -> tuple[read.Reader, thesis.Placed]:
    """Full runs of two learners, one of which captures always and one never."""
    found: dict[findings.Place, list[Record]] = {}
    for preset, share in (("timed", 1.0), ("standard_q", 0.0)):
        kept: dict[str, Any] = {**NO_PICTURES, **(arrays if preset == "timed" else {})}
        spec = presets.load(preset)
        for seed in seeds:
            trials, steps = spec.trials, 50 * spec.trials
            add_run(folder, seed, preset=preset, share=share, trials=trials, steps=steps)
            add_arrays(
                folder,
                f"k{len(list((folder / 'arrays').iterdir())) - 1}",
                outcome=np.full(spec.trials, CAPTURE if share else FLIGHT, np.int8),
                steps=np.full(spec.trials, 50, np.int32),
                introductions=np.zeros((0, 2), np.int64),
                introduced=np.zeros(0, "U32"),
                **kept,
            )
    seal(folder)
    for row in read.read_folder(folder).rows:
        settings = {k: v for k, v in row.settings.items() if k != "overrides"}
        run = dataclasses.replace(row, settings=settings)
        place = thesis.place_of(run)
        assert place is not None
        found.setdefault(place, []).append(run)
    return read.Reader(read.Widths(100_000, 1_000), thesis.quantities_of), found


def about(claim: str) -> Finding:
    """The finding with a claim."""
    (found,) = (finding for finding in thesis.FINDINGS if finding.claim == claim)
    return found


LEAD = about("timed ends above standard Q by a wide margin")


def test_a_finding_is_measured_by_seed(folder: Path) -> None:
    reader, placed = placed_runs(folder, range(10))
    effect = thesis.effect_of(LEAD, reader, placed, rng())
    assert effect is not None
    assert effect == estimates.Contrast(
        Estimate(150.0, 150.0, 150.0, 10), paired=True, error=0.0, freedom=9
    )
    assert findings.verdict(LEAD, effect.estimate) == findings.HOLDS


def test_with_few_seeds_nothing_is_decided(folder: Path) -> None:
    reader, placed = placed_runs(folder, range(9))
    effect = thesis.effect_of(LEAD, reader, placed, rng())
    assert effect is not None
    assert findings.verdict(LEAD, effect.estimate) == findings.UNDECIDED


# --- How far value has spread --------------------------------------------------------------------


def test_value_is_turned_into_the_preys_frame_and_averaged_as_steps() -> None:
    utility = np.full((N_HEADINGS, 2, 24), np.nan)
    # To the right of a prey that looks north and of one that looks west: 270 degrees from ahead.
    utility[2, 0, 0] = 100 * 0.9**10
    utility[4, 0, 6] = 100 * 0.9**30
    utility[4, 1, 6] = -3
    distance, share = measures.folded_value(utility, 100, 0.9)
    assert distance[0, 18] == pytest.approx(20)
    assert share[0, 18] == 2 / 8
    assert np.isfinite(distance).sum() == 1
    assert share.sum() == 2 / 8


def test_values_that_stand_for_no_distance_still_count() -> None:
    distance, share = measures.folded_value(np.ones((N_HEADINGS, 2, 24)), -1, 0.9)
    assert np.isnan(distance).all()
    assert (share == 1).all()


@pytest.mark.parametrize(
    ("region", "offset"),
    [
        (spread.RIGHT_FLANK, (0, -45)),
        (spread.LEFT_FLANK, (0, 45)),
        (spread.AHEAD_RIGHT, (30, -30)),
        (spread.INNER_RIGHT, (22, -28)),
        (spread.NEAR_BEHIND, (-10, 0)),
        (spread.FAR_BEHIND, (-40, 0)),
        (spread.SEEN, (15, 10)),
    ],
)
def test_regions_lie_where_their_names_say(region: Region, offset: tuple[int, int]) -> None:
    """The prey looks east, so its right is south."""
    spec = WorldSpec()
    x, y = (middle + along for middle, along in zip(geometry.prey_xy(spec), offset, strict=True))
    ring, direction = divmod(int(geometry.readings(spec)[y, x]), spec.n_directions)
    there = np.zeros((spec.n_distances, spec.n_directions))
    there[ring, direction] = 1
    assert region.of(there).sum() == 1


def test_what_is_seen_and_what_is_not() -> None:
    spec = WorldSpec()
    states = geometry.readings(spec)
    index = np.arange(spec.n_skill_states).reshape(spec.n_distances, spec.n_directions)
    seen = geometry.visible(spec)[0]
    assert seen[np.isin(states, spread.SEEN.of(index))].all()
    for region in (spread.RIGHT_FLANK, spread.AHEAD_RIGHT, spread.INNER_RIGHT):
        assert not seen[np.isin(states, region.of(index))].any()


def test_regions_say_how_far_away_they_are() -> None:
    assert spread.RIGHT_FLANK.cells == "35 to 58 cells"
    assert spread.SEEN.cells == "1 to 25 cells"


def test_the_moments_are_those_of_the_schedule() -> None:
    timed, standard = (
        presets.load(name).model_dump(mode="json") for name in ("timed", "standard_q")
    )
    assert spread.moments_of(timed) == {
        "approach only": 12_000,
        "circling": 14_500,
        "half way": 24_000,
        "the end": 48_000,
    }
    assert spread.moments_of(standard) == {}


def test_distances_are_averaged_over_all_headings_that_have_one() -> None:
    few = FoldedValue(np.array([[10.0, np.nan]]), np.array([[0.25, 0.0]]))
    many = FoldedValue(np.array([[30.0, np.nan]]), np.array([[0.75, 0.0]]))
    distance, share = spread.averaged([few, many])
    assert distance[0, 0] == 25
    assert np.isnan(distance[0, 1])
    assert share.tolist() == [[0.5, 0]]


def as_the_thesis_has_it() -> dict[str, np.ndarray]:
    """Value in a cone; then on the right flank; then ahead to the right; then all round."""
    share = np.zeros((4, 18, 24))
    share[:, :13, 7:17] = 1
    for moment, region in ((1, spread.RIGHT_FLANK), (2, spread.AHEAD_RIGHT)):
        for direction in region.directions:
            share[moment:, region.rings, direction] = 1
    share[3, 9:14] = 1
    share[3, 1:8] += 0.3
    distance = np.where(share > 0, 5.0 * np.arange(18)[:, np.newaxis], np.nan)
    return pictures([12_000, 14_500, 24_000, 48_000], np.minimum(share, 1), distance)


def verdicts(folder: Path, arrays: Mapping[str, np.ndarray]) -> dict[str, str | None]:
    """Verdicts on the findings on the spread of value, by what they measure; None for none."""
    reader, placed = placed_runs(folder, range(10), arrays)
    found: dict[str, str | None] = {}
    for finding in thesis.FINDINGS:
        if finding.topic.startswith("Spread of value"):
            effect = thesis.effect_of(finding, reader, placed, rng())
            name = finding.terms[0].quantity
            found[name] = effect and findings.verdict(finding, effect.estimate)
    assert len(found) >= 10
    return found


def test_value_that_spreads_as_the_thesis_has_it_bears_its_findings_out(folder: Path) -> None:
    assert set(verdicts(folder, as_the_thesis_has_it()).values()) == {findings.HOLDS}


def test_value_that_spreads_the_other_way_round_does_not(folder: Path) -> None:
    arrays = as_the_thesis_has_it()
    for name in ("value_share", "value_distance"):
        arrays[name] = np.roll(arrays[name][:, :, ::-1], 1, axis=2)
    found = verdicts(folder, arrays)
    assert found["behind, approach only"] == findings.HOLDS
    assert found["right flank, circling"] == findings.FAILS
    assert found["ahead to the right, half way"] == findings.FAILS


def test_value_that_does_not_spread_at_all_bears_out_nothing(folder: Path) -> None:
    nothing = np.zeros((4, 18, 24))
    trials = [12_000, 14_500, 24_000, 48_000]
    found = verdicts(folder, pictures(trials, nothing, np.full(nothing.shape, np.nan)))
    # Of no states at all there is no share, and no distance.
    assert found["behind, approach only"] is None
    assert found["far behind, approach only"] is None
    assert found["thinnest, the end"] == findings.FAILS
    # The two that say where value is not.
    held = {name for name, verdict in found.items() if verdict == findings.HOLDS}
    assert held == {
        "right flank, approach only",
        "ahead to the right, circling",
        "thinnest, half way",
    }


def test_moments_that_a_run_did_not_get_to_are_not_there(folder: Path) -> None:
    arrays = {name: values[:2] for name, values in as_the_thesis_has_it().items()}
    found = verdicts(folder, arrays)
    assert found["right flank, circling"] == findings.HOLDS
    assert found["thinnest, half way"] is None
    assert found["inner right, the end"] is None


@pytest.mark.parametrize(
    ("margin", "words"),
    [
        (findings.MUCH_MORE, "above 15"),
        (findings.CLOSE, "between ±15"),
        (findings.NOT_REACHED, "below 0.25 of the states"),
        (findings.named("above", 25, findings.STEPS), "above 25 steps"),
    ],
)
def test_conditions_are_put_in_words_with_their_units(margin: Margin, words: str) -> None:
    assert of_margin(margin).wanted == words


# --- The rule of margins -------------------------------------------------------------------------


def says(text: str, words: Sequence[str]) -> bool:
    return any(re.search(rf"\b{word}", text) for word in words)


@pytest.mark.parametrize("finding", thesis.FINDINGS, ids=lambda finding: finding.claim)
def test_margins_follow_from_the_words_of_claims(finding: Finding) -> None:
    margin, claim = finding.margin, finding.claim
    if margin in findings.MARGINS:
        assert says(claim, margin.words)
    else:
        assert not margin.words
        assert f"{margin.bound:g}" in claim
    # A strong word asks for a wide margin, whatever else is said.
    assert says(claim, findings.MUCH_MORE.words) == (margin == findings.MUCH_MORE)


def test_findings_say_where_the_thesis_has_them_and_what_it_says() -> None:
    assert all(re.fullmatch(r"[34](\.\d)+", finding.section) for finding in thesis.FINDINGS)
    assert all(finding.sentence.endswith(".") for finding in thesis.FINDINGS)
    claims = [finding.claim for finding in thesis.FINDINGS]
    assert len({*claims}) == len(claims)
