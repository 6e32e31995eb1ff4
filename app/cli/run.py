"""The command ``pounce run``: its words, its progress and its answers.

Like the command line, it imports what takes long only once it is needed.
"""

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, UseAppendAction, arg

from app.cli import terminal
from app.cli.answers import (
    EXIT_FAILED,
    EXIT_OK,
    HIDDEN_HINT,
    Flag,
    UsageError,
    complain,
    number,
    parts_of,
    say,
    shown,
    spec_of,
    table,
    whole_number,
    workers_of,
)
from app.util import interrupts
from app.words.numbers import counted

if TYPE_CHECKING:
    from app.experiments.output import Output
    from app.experiments.runner import Progress
    from app.experiments.seeds import Result

EXAMPLES = (
    "pounce run timed --seeds 3",
    "pounce run timed --seed-list 3,7 --trials 20000 --json",
    "pounce run standard_q --set world.size=60 --set learner.epsilon=0.05",
    "pounce run my-preset.yaml --seeds 30 --out results",
)

_RUN_HEADER = (
    "seed",
    "trials",
    "steps",
    "seconds",
    "captures",
    "flights",
    "time-outs",
    "reward",
    "digest",
)


@dataclass(frozen=True)
class Run:
    """Run a preset over many seeds on all cores, without a page."""

    preset: Annotated[Positional[str], arg(metavar="PRESET", help_behavior_hint=HIDDEN_HINT)] = ""
    """A shipped preset, or a file; - is standard input."""
    seeds: Annotated[str | None, arg(metavar="N", help_behavior_hint="(default: 1)")] = None
    """Run seeds 0 to N-1."""
    seed_list: Annotated[str | None, arg(metavar="N,N,...", help_behavior_hint=HIDDEN_HINT)] = None
    """Run these seeds."""
    trials: Annotated[
        str | None, arg(metavar="N", help_behavior_hint="(default: the preset's)")
    ] = None
    """Trials of each run."""
    set: Annotated[
        UseAppendAction[tuple[str, ...]],
        arg(metavar="KEY=VALUE", help_behavior_hint="(may be repeated)"),
    ] = ()
    """Another value for a key of the preset."""
    workers: Annotated[str | None, arg(metavar="N", help_behavior_hint="(default: all cores)")] = (
        None
    )
    """Runs at a time; makes no difference to their results."""
    json: Flag = False
    """Print one JSON object and nothing else."""
    out: Annotated[str | None, arg(metavar="DIR", help_behavior_hint=HIDDEN_HINT)] = None
    """Write the same to DIR as JSON, the learning curves as CSV, and the final tables."""
    force: Flag = False
    """Let --out replace results of the same name."""


def obey(command: Run) -> int:
    """Make the runs and say what came of them; returns the exit code.

    Raises:
        UsageError: the words make no sense.
    """
    seeds = seeds_of(command)
    workers = workers_of(command.workers)
    if command.force and command.out is None:
        raise UsageError("--force goes with --out; allowed: both, or neither")
    if not command.preset:
        raise UsageError("PRESET is missing; allowed: a shipped preset (pounce presets) or a file")
    spec = spec_of(command.preset, _settings(command))

    from app.documents.sources import called
    from app.experiments import seeds as runs
    from app.experiments.crews import CrewError, Threads
    from app.experiments.output import OutputError
    from app.experiments.task import prepare

    prepare()
    with (
        interrupts.undoing(),
        _output(command, seeds) as output,
        _progress(len(seeds)) as on_progress,
    ):
        try:
            on_tables = output.save_tables if output else None
            results = runs.run_seeds(spec, seeds, Threads(workers), on_progress, on_tables)
            document = runs.summary(called(command.preset), spec, results)
            if output:
                output.commit(document, runs.curves_csv(results))
        except (runs.SeedFailedError, CrewError) as error:
            complain(str(error))
            return EXIT_FAILED
        except OutputError as error:
            complain(f"--out: {shown(str(command.out))} {error}")
            return EXIT_FAILED
    say(document if command.json else _report(called(command.preset), results))
    return EXIT_OK


def seeds_of(command: Run) -> Sequence[int]:
    """The seeds to run, in the order in which they were given.

    Raises:
        UsageError: the options that name them are wrong.
    """
    from app.documents.experiment_spec import MAX_RUNS
    from sim.rng import MAX_SEED

    if command.seed_list is None:
        return range(whole_number("--seeds", command.seeds or "1", 1, MAX_RUNS))
    if command.seeds is not None:
        raise UsageError("--seeds and --seed-list exclude each other; allowed: one of them")
    parts = parts_of("--seed-list", command.seed_list, "seeds")
    if len(parts) > MAX_RUNS:
        raise UsageError(
            f"--seed-list: {len(parts)} seeds are not allowed; allowed: 1 to {MAX_RUNS}"
        )
    seeds: dict[int, None] = {}
    for part in parts:
        seed = whole_number("--seed-list", part.strip(), 0, MAX_SEED)
        if seed in seeds:
            raise UsageError(f"--seed-list: {seed} is there twice; allowed: each seed once")
        seeds[seed] = None
    return tuple(seeds)


def _settings(command: Run) -> Sequence[str]:
    if command.trials is None:
        return command.set
    from learners.names import MAX_TRIALS

    trials = whole_number("--trials", command.trials, 1, MAX_TRIALS)
    return (*command.set, f"trials={trials}")


@contextlib.contextmanager
def _output(command: Run, seeds: Sequence[int]) -> "Iterator[Output | None]":
    if command.out is None:
        yield None
        return
    if not command.out:
        raise UsageError("--out: '' is not allowed; allowed: a folder")
    from app.documents.sources import STDIN, STDIN_NAME
    from app.experiments.output import Output, OutputError

    name = STDIN_NAME if command.preset == STDIN else Path(command.preset).stem
    try:
        output = Output(Path(command.out), name, seeds, command.force)
    except OutputError as error:
        raise UsageError(f"--out: {shown(command.out)} {error}") from error
    with output:
        yield output


@contextlib.contextmanager
def _progress(n_runs: int) -> "Iterator[Callable[[Progress], None]]":
    """What shows the progress of runs on a terminal; nothing where there is none."""
    with terminal.progress_bar(1.0, n_runs, with_time_left=True) as show:

        def tell(found: "Progress") -> None:
            rate = f"{found.steps_per_s / 1e6:.1f} M steps/s"
            show(found.share, f"{found.done}/{n_runs} runs", rate)

        yield tell


def _report(preset: str, results: "Sequence[Result]") -> str:
    runs = table(
        _RUN_HEADER,
        [
            (
                str(record.seed),
                str(record.trials),
                str(record.steps),
                f"{record.seconds:.2f}",
                *(f"{record.values[name]:.0f}" for name in ("captures", "flights", "timeouts")),
                number(record.values["final_reward"]),
                record.digest[:12],
            )
            for record in (result.record for result in results)
        ],
    )
    seeds = counted(len(results), "seed")
    return (
        f"{preset}: reward is the mean of the last 2,000 trials\n\n{runs}\n\n"
        f"Mean reward per trial in windows of steps, over {seeds}:\n\n{_windows(results)}"
    )


def _windows(results: "Sequence[Result]") -> str:
    """The learning curve in windows up to its end: means over the runs that went through each."""
    from app.analysis.estimates import PHASE_STEPS

    def millions(place: int) -> str:
        return f"{place * PHASE_STEPS / 1e6:g}"

    rows: list[tuple[str, str]] = []
    for place in range(max(result.phases.size for result in results)):
        through = [result.phases[place] for result in results if place < result.phases.size]
        rows.append((f"{millions(place)}–{millions(place + 1)} M", number(_mean(through))))
    last = _mean(result.record.values["final_reward"] for result in results)
    return table(("steps", "reward"), [*rows, ("last 2,000 trials", number(last))])


def _mean(values: Iterable[float]) -> float:
    there = [float(value) for value in values if not math.isnan(value)]
    return sum(there) / len(there) if there else math.nan
