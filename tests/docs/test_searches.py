"""What searches found is what the experiments that try it on other seeds run.

``searches.json`` holds the best variants of the shipped searches. To write it anew, from the root
of the project::

    pounce experiment baselines_search
    pounce experiment timing_seven
    python -m tests.docs.test_searches results/baselines_search results/timing_seven
"""

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from app.documents import experiments
from app.results.read import groups_of, read_folder

KEPT = Path(__file__).with_name("searches.json")
CRITERIA = ("horizon_reward", "horizon_area")
"""What is searched for: the end, and speed."""
TRIED = [
    ("baselines", "standard Q, tuned for the end", "baselines_search", "standard_q", 0),
    ("baselines", "standard Q, tuned for speed", "baselines_search", "standard_q", 1),
    ("baselines", "timed, tuned for the end", "baselines_search", "timed", 0),
    ("baselines", "timed, tuned for speed", "baselines_search", "timed", 1),
    ("baselines", "timed, better schedule, tuned for speed", "baselines_search", "timed", 1),
    ("timing_test", "best of timing_seven", "timing_seven", "timed", 0),
]
"""An experiment and its variant, the search, the preset that was searched, and the criterion."""


@pytest.fixture(scope="module")
def kept() -> dict[str, Any]:
    return json.loads(KEPT.read_text(encoding="utf-8"))


def overrides_of(experiment: str, label: str) -> dict[str, Any]:
    variants = {variant.label: variant for variant in experiments.load(experiment).variants}
    return dict(variants[label].overrides)


@pytest.mark.parametrize("search", ["baselines_search", "timing_seven"])
def test_what_is_kept_is_of_the_search_that_is_shipped(search: str, kept: dict[str, Any]) -> None:
    for of_preset in kept[search].values():
        assert list(of_preset) == list(CRITERIA)
        for best in of_preset.values():
            assert overrides_of(search, best["variant"]) == best["sets"]


@pytest.mark.parametrize(("experiment", "label", "search", "preset", "criterion"), TRIED)
def test_what_is_tried_is_what_was_found(
    experiment: str, label: str, search: str, preset: str, criterion: int, kept: dict[str, Any]
) -> None:
    best = kept[search][preset][CRITERIA[criterion]]
    assert overrides_of(experiment, label) == best["sets"]


def test_nothing_is_tried_on_the_seeds_of_a_search() -> None:
    searched = {*experiments.load("baselines_search").seeds}
    searched |= {*experiments.load("timing_seven").seeds}
    for name, *_ in TRIED:
        assert not searched & {*experiments.load(name).seeds}


def best_of(folder: Path) -> dict[str, dict[str, dict[str, Any]]]:
    """The best variant of each preset by each criterion, in a folder of results."""
    found: dict[str, dict[str, dict[str, Any]]] = {}
    groups = groups_of(read_folder(folder).rows)
    for preset in dict.fromkeys(group.preset for group in groups):
        for column in CRITERIA:
            means = {
                group.label: sum(group.values(column)) / len(group.runs)
                for group in groups
                if group.preset == preset
            }
            label = max(means, key=lambda label: means[label])
            (best,) = (group for group in groups if group.label == label)
            entry = {"variant": label, "mean": round(means[label], 2), "sets": dict(best.overrides)}
            found.setdefault(preset, {})[column] = entry
    return found


def main() -> None:
    """Write ``searches.json`` anew, from the folders that are named."""
    found = {folder.name: best_of(folder) for folder in map(Path, sys.argv[1:])}
    KEPT.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
    sys.stdout.write(f"wrote {KEPT.name}: {', '.join(found)}\n")


if __name__ == "__main__":
    main()
