"""Golden runs: (preset, seed, trials) gives the same tables today and tomorrow.

``golden.json`` holds their digests. A change that is meant to change what is learned writes it
anew, with ``python -m tests.learners.test_golden`` from the project's root.
"""

import json
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from app.documents import presets
from learners.commands import Explore, FreezeSelection, FreezeSkills, Introduce, StopExploring
from learners.kernel.state import digest
from learners.run import Run

GOLDEN = Path(__file__).with_name("golden.json")
REGENERATE = "python -m tests.learners.test_golden"
SEED = 7
TRIALS = 2_000


def _shipped(name: str, *settings: str) -> Run:
    run = Run(presets.load(name, settings), SEED)
    run.advance(until_trial=TRIALS)
    return run


def _commanded() -> Run:
    """All skills introduced by hand, with every other kind of command in between."""
    run = Run(presets.load("timed"), SEED)
    run.advance(until_trial=500)
    run.apply(Introduce("circle_clockwise", 100))
    run.advance(max_steps=1_234)
    run.apply(Explore("approach", 200, 0.5))
    run.advance(until_trial=900)
    run.apply(Introduce("avoid", 50))
    run.apply(StopExploring("circle_clockwise"))
    run.apply(FreezeSkills(True))
    run.advance(until_trial=1_200)
    run.apply(FreezeSkills(False))
    run.apply(FreezeSelection(True))
    run.advance(max_steps=5_000)
    run.apply(FreezeSelection(False))
    run.advance(until_trial=TRIALS)
    return run


RUNS: dict[str, Callable[[], Run]] = {
    **{name: lambda name=name: _shipped(name) for name in presets.shipped()},
    "timed, all skills by hand": _commanded,
    "hierarchical_3, 60, 16 x 11": lambda: _shipped(
        "hierarchical_3", "world.size=60", "world.n_directions=16", "world.n_distances=11"
    ),
}


def entry(run: Run) -> dict[str, object]:
    """What is kept of a golden run."""
    return {"seed": SEED, "trials": run.trial, "steps": run.step, "digest": digest(run.state)}


@pytest.fixture(scope="module")
def golden() -> dict[str, dict[str, object]]:
    return json.loads(GOLDEN.read_text(encoding="utf-8"))


def test_every_golden_run_is_known(golden: dict[str, dict[str, object]]) -> None:
    assert list(golden) == list(RUNS), f"to write it anew: {REGENERATE}"


@pytest.mark.parametrize("name", RUNS)
def test_a_golden_run_is_as_it_was(name: str, golden: dict[str, dict[str, object]]) -> None:
    assert entry(RUNS[name]()) == golden[name], (
        f"what is learned has changed; if that is meant, write it anew: {REGENERATE}"
    )


def main() -> None:
    """Write ``golden.json`` anew."""
    entries = {name: entry(run()) for name, run in RUNS.items()}
    GOLDEN.write_text(json.dumps(entries, indent=2) + "\n", encoding="utf-8")
    sys.stdout.write(f"wrote {GOLDEN.name}: {len(entries)} runs\n")


if __name__ == "__main__":
    main()
