"""What greedy reward costs a run of an experiment: ``python -m benchmarks.greedy [ROUNDS]``.

Each shipped preset is run at full length, with no greedy hunts, with those after its last trial,
and with a greedy curve beside these, in turns; what is printed is the median of the ratios of the
processor times to those of the run without, each taken beside the other.
"""

import statistics
import sys
import time
from dataclasses import replace

from app.documents import experiments, presets
from app.experiments.task import Task, perform, prepare, tasks_of
from app.metrics import NAMES, wants_greedy

EVERY = 2_000
"""Trials from one point of the curve to the next."""


def seconds_of(task: Task) -> float:
    """Processor time that a run takes, with all that is kept of it."""
    began = time.thread_time()
    found = perform(task)
    assert found is not None, "nobody ends it"
    assert not found.error, found.error
    return time.thread_time() - began


def ratios_of(task: Task, rounds: int) -> tuple[float, float]:
    """How many times as long a run takes with greedy hunts at its end, and with a curve as well."""
    bare = tuple(name for name in NAMES if not wants_greedy([name]))
    ways = (
        replace(task, metrics=bare, greedy_every=0),
        replace(task, metrics=NAMES, greedy_every=0),
        replace(task, metrics=NAMES, greedy_every=EVERY),
    )
    found = [[seconds_of(way) for way in ways] for _ in range(rounds)]
    ends, curves = zip(*((end / none, all_ / none) for none, end, all_ in found), strict=True)
    return statistics.median(ends), statistics.median(curves)


def main(rounds: int) -> None:
    """Measure each preset and print a line of it."""
    prepare(NAMES)
    for name in presets.shipped():
        experiment = experiments.parse(f"presets: [{name}]\n", "greedy.yaml")
        (_, task), *_ = tasks_of(experiment)
        seconds_of(task)  # may compile
        end, curve = ratios_of(task, rounds)
        print(f"{name}: {end - 1:+.1%} with the end, {curve - 1:+.1%} with a point every {EVERY:,}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 9)
