"""The findings of the thesis (chapters 3 and 4): over the runs of the replication, and over a few.

What a finding is, and how it is measured, is said in ``app/results/thesis/`` alone, and runs get
there as those of any experiment do. ``findings.json`` holds what came out of the replication, as
``docs/replication.md`` has it. A few other seeds must come out within four standard errors of that,
so a change of nothing but the random numbers does not break a test. To measure again:
``python -m tests.docs.test_findings FOLDER...`` with the folders of :data:`EXPERIMENTS`, which
writes that file.
"""

import json
import math
import sys
from collections import Counter
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
from app.results import findings, read, thesis
from app.results.findings import FAILS, HOLDS, UNDECIDED, Finding
from app.results.thesis import quantities

N_SEEDS = 3
STANDARD_ERRORS = 4
LEAST_MARGIN = 0.05
"""For what is the same over all runs."""
N_THREADS = 2
EXPERIMENTS = (*thesis.FIGURES, "sentences")
"""The shipped experiments that make all the runs that findings speak of."""

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "replication.md"

TABLE = Path(__file__).with_name("findings.json")
MEASURED: Mapping[str, Estimate] = {
    claim: Estimate(*numbers) for claim, numbers in json.loads(TABLE.read_text("utf-8")).items()
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


@pytest.mark.parametrize("finding", thesis.FINDINGS, ids=lambda finding: finding.claim)
def test_the_page_has_what_was_measured(finding: Finding) -> None:
    value, low, high, _ = (format(part, finding.unit.form) for part in MEASURED[finding.claim])
    shown = f"{value} [{low}, {high}]".replace("-", "\N{MINUS SIGN}")
    assert shown in PAGE.read_text("utf-8")


@pytest.mark.parametrize("file", [PAGE, ROOT / "README.md"], ids=lambda file: file.name)
def test_pages_count_what_holds(file: Path) -> None:
    n = Counter(findings.verdict(f, MEASURED[f.claim]) for f in thesis.FINDINGS)
    assert (
        f"f {n.total()} findings {n[HOLDS]} hold, {n[FAILS]} do not, {n[UNDECIDED]} are undecided"
    ) in " ".join(file.read_text("utf-8").split())


def main() -> None:
    """Measure everything in folders of results, and write it down."""
    found = effects_in([Path(name) for name in sys.argv[1:]])
    lines = [
        f"  {json.dumps(claim)}: {json.dumps([*(float(f'{part:.7g}') for part in sums), n])}"
        for claim, (*sums, n) in found.items()
    ]
    TABLE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
