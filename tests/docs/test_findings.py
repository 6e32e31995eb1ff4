"""The findings of the thesis (chapters 3 and 4): over the runs of the replication, and over a few.

What a finding is, and how it is measured, is said in ``app/results/thesis/`` alone, and runs get
there as those of any experiment do. ``docs/replication.json`` holds what came out of the replication,
and a few other seeds must come out within four standard errors of that, so a change of nothing but
the random numbers does not break a test.
"""

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import NormalDist

import pytest

from app.analysis import estimates
from app.analysis.estimates import Estimate
from app.documents import experiments
from app.experiments.crews import Threads
from app.experiments.runner import run_experiment
from app.experiments.store import Folder
from app.replication.page import Found
from app.replication.write import NUMBERS
from app.results import read, thesis
from app.results.findings import Finding
from app.results.thesis import quantities
from tests.support.pages import ROOT

N_SEEDS = 3
STANDARD_ERRORS = 4
LEAST_MARGIN = 0.05
"""For what is the same over all runs."""
N_THREADS = 2

MEASURED: Mapping[str, Estimate] = {
    claim: Estimate(numbers[0], numbers[1], numbers[2], int(numbers[3]))
    for claim, numbers in Found.from_json(
        (ROOT / "docs" / NUMBERS).read_text("utf-8")
    ).estimates.items()
}
"""By claim: the sum that it speaks of, with its 95 % interval and the number of runs."""


def effects_in(folders: Sequence[Path]) -> dict[str, Estimate]:
    """The sum that each finding speaks of, by its claim, from folders of results."""
    rows = [row for folder in folders for row in read.read_folder(folder).rows]
    placed = thesis.placed_of(read.groups_of(rows))
    reader = read.Reader(read.widths_of(rows), thesis.quantities_of)
    found: dict[str, Estimate] = {}
    for finding in thesis.FINDINGS:
        effect = thesis.effect_of(finding, reader, placed, estimates.bootstrap_rng())
        assert effect is not None, thesis.untestable(finding, reader, placed)
        found[finding.claim] = effect.estimate
    return found


def few(n_seeds: int) -> str:
    """An experiment that makes a few runs of each place that findings speak of."""
    places = dict.fromkeys((t.world, t.learner) for f in thesis.FINDINGS for t in f.terms)
    presets = [
        {"preset": {**thesis.settings_of(place)}, "label": " ".join(place)} for place in places
    ]
    return json.dumps(
        {
            "presets": presets,
            "horizon": quantities.HORIZON,
            "metrics": ["final_reward"],
            "seeds": n_seeds,
        }
    )


@pytest.fixture(scope="module")
def over_a_few_seeds(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Estimate]:
    experiment = experiments.parse(few(N_SEEDS), "findings.yaml")
    path = tmp_path_factory.mktemp("findings") / "results"
    with Folder(path, experiment, resume=False, force=False) as results:
        run_experiment(experiment, results, Threads(N_THREADS))
    return effects_in([path])


def standard_error(estimate: Estimate, n_seeds: int) -> float:
    """Of a mean over so many seeds, from the interval of one over more."""
    tail = (1 - estimates.expanded_level(estimate.n)) / 2
    ends = 2 * NormalDist().inv_cdf(1 - tail)
    return (estimate.high - estimate.low) / ends * math.sqrt(estimate.n / n_seeds)


def test_every_finding_was_measured() -> None:
    assert [finding.claim for finding in thesis.FINDINGS] == list(MEASURED)


@pytest.mark.parametrize("finding", thesis.FINDINGS, ids=lambda finding: finding.claim)
def test_a_few_seeds_come_out_as_thirty_did(
    finding: Finding, over_a_few_seeds: dict[str, Estimate]
) -> None:
    expected, found = MEASURED[finding.claim], over_a_few_seeds[finding.claim]
    margin = max(STANDARD_ERRORS * standard_error(expected, found.n), LEAST_MARGIN)
    assert found.value == pytest.approx(expected.value, abs=margin)
