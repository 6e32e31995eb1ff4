"""The findings of the thesis (chapters 3 and 4): over the runs of the replication, and over a few.

What a finding is, and how it is measured, is said in ``app/results/thesis/`` alone, and runs get
there as those of any experiment do. ``findings.json`` holds what came out of the replication, as
``docs/replication.md`` has it. A few other seeds must come out within four standard errors of that,
so a change of nothing but the random numbers does not break a test. To measure again:
``python -m tests.docs.test_findings FOLDER...`` with the folders of :data:`EXPERIMENTS`, which
writes that file, the table of that page, and the counts there and in the README.
"""

import json
import math
import re
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
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
LEAST_MARGIN = 0.25
"""Share of a finding's bound: for what is the same in all runs, or in all but a few."""
N_THREADS = 2
EXPERIMENTS = ("figure_4_1", "figure_4_2", "figure_4_3", "sentences")
"""The shipped experiments that make all the runs that findings speak of."""

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "replication.md"
COUNTING = (PAGE, ROOT / "README.md")
"""Pages that count what holds."""
BEGINS, ENDS = "<!-- findings -->\n", "<!-- end of findings -->\n"
"""Marks between which the page has the table."""
COUNTS = re.compile(r"\b\d+ findings \d+ hold, \d+ do not, \d+ are undecided".replace(" ", r"\s+"))
"""How pages count what holds, over however many lines."""

TABLE = Path(__file__).with_name("findings.json")


class Measured(NamedTuple):
    """What came out of a finding."""

    estimate: Estimate
    spread: float
    """Standard deviation of the sum that it speaks of, of one run of each learner."""


def read_table() -> dict[str, Measured]:
    """What was written down, by claim."""
    found = json.loads(TABLE.read_text("utf-8"))
    return {claim: Measured(Estimate(*sums), spread) for claim, (*sums, spread) in found.items()}


MEASURED: Mapping[str, Measured] = read_table()


def measured_in(folders: Sequence[Path]) -> dict[str, Measured]:
    """What comes out of each finding, by its claim, from folders of results."""
    rows = [row for folder in folders for row in read.read_folder(folder).rows]
    placed = thesis.placed_of(read.groups_of(rows))
    reader = read.Reader(read.widths_of(rows), thesis.quantities_of)
    found: dict[str, Measured] = {}
    for finding in thesis.FINDINGS:
        effect = thesis.effect_of(finding, reader, placed, estimates.bootstrap_rng())
        assert effect is not None, thesis.untestable(finding, reader, placed)
        variance = 0.0
        for term in finding.terms:
            traces = reader.traces(placed[term.world, term.learner])
            values = [trace.quantities[term.quantity] for trace in traces]
            variance += term.weight**2 * float(np.var(values, ddof=1))
        found[finding.claim] = Measured(effect.estimate, math.sqrt(variance))
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
def over_a_few_seeds(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Measured]:
    experiment = experiments.parse(few(N_SEEDS), "findings.yaml")
    path = tmp_path_factory.mktemp("findings") / "results"
    with Folder(path, experiment, resume=False, force=False) as results:
        run_experiment(experiment, results, Threads(N_THREADS))
    return measured_in([path])


def test_every_finding_was_measured() -> None:
    assert [finding.claim for finding in thesis.FINDINGS] == list(MEASURED)


@pytest.mark.parametrize("finding", thesis.FINDINGS, ids=lambda finding: finding.claim)
def test_a_few_seeds_come_out_as_many_did(
    finding: Finding, over_a_few_seeds: dict[str, Measured]
) -> None:
    (expected, spread), (found, _) = MEASURED[finding.claim], over_a_few_seeds[finding.claim]
    margin = STANDARD_ERRORS * spread * math.sqrt(1 / found.n + 1 / expected.n)
    least = LEAST_MARGIN * finding.margin.bound
    assert found.value == pytest.approx(expected.value, abs=max(margin, least))


def table_of(measured: Mapping[str, Measured]) -> str:
    """Every finding beside its sentence, with what was measured, as a table in Markdown."""
    rows = [["the thesis says", "tested", "measured [95 %]", "runs", "verdict"], ["---"] * 5]
    before = Finding("", "", "", "", (), findings.MORE)
    for finding in thesis.FINDINGS:
        if (finding.topic, finding.section) != (before.topic, before.section):
            rows.append([f"**{finding.topic} ({finding.section})**", "", "", "", ""])
        sentence = "" if finding.sentence == before.sentence else finding.sentence
        estimate = measured[finding.claim].estimate
        value, low, high = (format(part, finding.unit.form) for part in estimate[:3])
        number = f"{value} [{low}, {high}]".replace("-", "\N{MINUS SIGN}")
        found = findings.verdict(finding, estimate)
        verdict = f"**{found}**" if found == FAILS else found
        rows.append([sentence, finding.claim, number, str(estimate.n), verdict])
        before = finding
    return "".join(
        "|" + "".join(f" {cell} |" if cell else " |" for cell in row) + "\n" for row in rows
    )


def counts_of(measured: Mapping[str, Measured]) -> list[int]:
    """How many findings there are, and how many hold, do not, and are undecided."""
    n = Counter(findings.verdict(f, measured[f.claim].estimate) for f in thesis.FINDINGS)
    return [n.total(), n[HOLDS], n[FAILS], n[UNDECIDED]]


def test_the_page_has_what_was_measured() -> None:
    _, rest = PAGE.read_text("utf-8").split(BEGINS)
    assert rest.split(ENDS)[0] == table_of(MEASURED)


@pytest.mark.parametrize("file", COUNTING, ids=lambda file: file.name)
def test_pages_count_what_holds(file: Path) -> None:
    (found,) = COUNTS.finditer(file.read_text("utf-8"))
    assert [int(number) for number in re.findall(r"\d+", found.group())] == counts_of(MEASURED)


def main() -> None:
    """Measure everything in folders of results, and write it down."""
    lines = [
        f"  {json.dumps(claim)}: "
        + json.dumps([*(float(f"{part:.7g}") for part in (value, low, high)), n, round(spread, 4)])
        for claim, ((value, low, high, n), spread) in measured_in(
            [Path(name) for name in sys.argv[1:]]
        ).items()
    ]
    TABLE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    # As it is written, so that page and file round alike.
    found = read_table()
    before, rest = PAGE.read_text("utf-8").split(BEGINS)
    after = rest.split(ENDS)[1]
    PAGE.write_text(before + BEGINS + table_of(found) + ENDS + after, encoding="utf-8")
    for file in COUNTING:
        counts = iter(counts_of(found))
        text = COUNTS.sub(
            lambda match, counts=counts: re.sub(r"\d+", lambda _: str(next(counts)), match.group()),
            file.read_text("utf-8"),
        )
        file.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
