"""The findings of the thesis (chapters 3 and 4): over the runs of the replication, and over a few.

What a finding is, and how it is measured, is said in ``app/results/thesis/`` alone, and runs get
there as those of any experiment do. ``docs/replication.json`` holds what came out of the
replication, and a few other seeds must come out within four standard errors of that, so a change of
nothing but the random numbers does not break a test.
"""

import json
import math

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

N_SEEDS = 2
STANDARD_ERRORS = 4
LEAST_MARGIN = 0.25
"""Share of a finding's bound: for what is the same in all runs, or in all but a few."""
N_THREADS = 2

KEPT = Found.from_json((ROOT / "docs" / NUMBERS).read_text("utf-8"))


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
    rows = read.read_folder(path).rows
    placed = thesis.placed_of(read.groups_of(rows))
    reader = read.Reader(read.widths_of(rows), thesis.quantities_of)
    found: dict[str, Estimate] = {}
    for finding in thesis.FINDINGS:
        effect = thesis.effect_of(finding, reader, placed, estimates.bootstrap_rng())
        assert effect is not None, thesis.untestable(finding, reader, placed)
        found[finding.claim] = effect.estimate
    return found


def test_every_finding_was_measured() -> None:
    assert [finding.claim for finding in thesis.FINDINGS] == list(KEPT.estimates)


@pytest.mark.parametrize("finding", thesis.FINDINGS, ids=lambda finding: finding.claim)
def test_a_few_seeds_come_out_as_many_did(
    finding: Finding, over_a_few_seeds: dict[str, Estimate]
) -> None:
    found = over_a_few_seeds[finding.claim]
    expected, _, _, n = KEPT.estimates[finding.claim]
    margin = STANDARD_ERRORS * KEPT.spreads[finding.claim] * math.sqrt(1 / found.n + 1 / n)
    least = LEAST_MARGIN * finding.margin.bound
    assert found.value == pytest.approx(expected, abs=max(margin, least))
