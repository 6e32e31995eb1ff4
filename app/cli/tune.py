"""The command ``pounce tune``: its words, its progress and its answers.

Like the command line, it imports what takes long only once it is needed.
"""

import contextlib
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, UseAppendAction, arg

from app.cli import terminal
from app.cli.answers import (
    EXIT_FAILED,
    EXIT_OK,
    HIDDEN_HINT,
    Flag,
    UsageError,
    WrongPresetError,
    complain,
    filled,
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
from app.words import typed
from app.words.numbers import counted, in_short

if TYPE_CHECKING:
    from app.analysis.estimates import Estimate
    from app.experiments.runner import Progress
    from app.experiments.tuning import Plan, Tuned
    from learners.spec import RunSpec

EXAMPLES = (
    "pounce tune static_appetite_fear",
    "pounce tune static_appetite_fear --set learner.selection=best_happiness --json",
    "pounce tune my-preset.yaml --weights 0,0.5,1,2 --save my-tuned.yaml",
)

_MAX_SEEDS = 1_000
_MAX_GRID = 50
_MAX_WEIGHT = 1_000
_FILES = (".yaml", ".yml")


@dataclass(frozen=True)
class Tune:
    """Find weights for the skills that a rule selects from, let in one at a time."""

    preset: Annotated[Positional[str], arg(metavar="PRESET", help_behavior_hint=HIDDEN_HINT)] = ""
    """A shipped preset, or a file; - is standard input."""
    seeds: Annotated[str, arg(metavar="N")] = "8"
    """Seeds by which the search finds the weights."""
    judge_seeds: Annotated[str, arg(metavar="N")] = "20"
    """Seeds that it has not seen, by which they are judged beside weights of 1."""
    first_seed: Annotated[str, arg(metavar="N")] = "0"
    """The first seed; those of the search count up from it, and then those of the judgement."""
    horizon: Annotated[
        str | None, arg(metavar="STEPS", help_behavior_hint="(default: 4 million)")
    ] = None
    """Steps of each run; the reward is the mean over them."""
    weights: Annotated[
        str | None, arg(metavar="W,W,...", help_behavior_hint="(default: 0, 1/16 to 16, doubled)")
    ] = None
    """Try these weights of each skill but the first, whose weight is 1."""
    set: Annotated[
        UseAppendAction[tuple[str, ...]],
        arg(metavar="KEY=VALUE", help_behavior_hint="(may be repeated)"),
    ] = ()
    """Another value for a key of the preset."""
    workers: Annotated[str | None, arg(metavar="N", help_behavior_hint="(default: all cores)")] = (
        None
    )
    """Runs at a time; makes no difference to what is found."""
    json: Flag = False
    """Print one JSON object and nothing else."""
    save: Annotated[str | None, arg(metavar="FILE", help_behavior_hint=HIDDEN_HINT)] = None
    """Write the preset with the weights that were found."""
    force: Flag = False
    """Let --save replace a file."""


def obey(command: Tune) -> int:
    """Find the weights and say what they are worth; returns the exit code.

    Raises:
        UsageError: the words make no sense, or the preset has no weights to be tuned.
    """
    workers = workers_of(command.workers)
    target = _target_of(command)
    if not command.preset:
        raise UsageError("PRESET is missing; allowed: a shipped preset (pounce presets) or a file")
    plan = _plan_of(command)
    spec = spec_of(command.preset, command.set)

    from app.documents.sources import called
    from app.experiments import tuning
    from app.experiments.crews import CrewError, Threads
    from app.experiments.seeds import SeedFailedError
    from app.experiments.task import prepare

    preset = called(command.preset)
    try:
        tuning.check(spec)
    except tuning.TuningError as error:
        raise WrongPresetError(f"{preset} {error}") from error
    prepare()
    with interrupts.undoing(), _progress(tuning.n_runs(spec, plan)) as on_progress:
        try:
            tuned = tuning.tune(spec, plan, lambda: Threads(workers), on_progress)
        except tuning.TuningError as error:
            raise WrongPresetError(f"{preset} {error}") from error
        except (SeedFailedError, CrewError) as error:
            complain(str(error))
            return EXIT_FAILED
        document = _document(preset, plan, tuned)
        if target is not None:
            try:
                _save(target, preset, plan, tuned)
            except OSError as error:
                complain(f"--save: {shown(str(target))} cannot be written: {error.strerror}")
                return EXIT_FAILED
    say(json.dumps(document, allow_nan=False) if command.json else _report(preset, plan, tuned))
    if target is not None and not command.json:
        say(f"\nThe preset with these weights is in {target}.")
    return EXIT_OK


# --- What is asked for ---------------------------------------------------------------------------


def _plan_of(command: Tune) -> "Plan":
    from app.documents.experiment_spec import MAX_STEPS
    from app.experiments.tuning import GRID, HORIZON, Plan
    from sim.rng import MAX_SEED

    n_seeds = whole_number("--seeds", command.seeds, 1, _MAX_SEEDS)
    n_judges = whole_number("--judge-seeds", command.judge_seeds, 1, _MAX_SEEDS)
    last = MAX_SEED - n_seeds - n_judges + 1
    first = whole_number("--first-seed", command.first_seed, 0, last)
    horizon = HORIZON
    if command.horizon is not None:
        horizon = whole_number("--horizon", command.horizon, 1, MAX_STEPS)
    seeds = range(first, first + n_seeds)
    judges = range(seeds.stop, seeds.stop + n_judges)
    return Plan(GRID if command.weights is None else _grid(command.weights), seeds, judges, horizon)


def _grid(text: str) -> Sequence[float]:
    parts = parts_of("--weights", text, "weights")
    if len(parts) > _MAX_GRID:
        raise UsageError(
            f"--weights: {len(parts)} weights are not allowed; allowed: 1 to {_MAX_GRID}"
        )
    grid: list[float] = []
    for part in parts:
        try:
            weight = typed.decimal(part, 0, _MAX_WEIGHT)
        except typed.NumeralError:
            raise UsageError(
                f"--weights: {shown(part)} is not allowed; allowed: numbers, 0 to {_MAX_WEIGHT},"
                " with commas between them"
            ) from None
        if weight in grid:
            raise UsageError(f"--weights: {weight:g} is there twice; allowed: each weight once")
        grid.append(weight)
    return sorted(grid)


def _target_of(command: Tune) -> Path | None:
    """Where the preset is to be written, which is looked at before anything is run."""
    if command.save is None:
        if command.force:
            raise UsageError("--force goes with --save; allowed: both, or neither")
        return None
    target = Path(command.save)
    if "\0" in command.save or target.suffix.lower() not in _FILES or target.is_dir():
        raise UsageError(
            f"--save: {shown(command.save)} is not allowed; allowed: a file that ends in .yaml"
        )
    if not target.absolute().parent.is_dir():
        raise UsageError(f"--save: {shown(command.save)} is in no folder; allowed: one there is")
    if os.path.lexists(target) and not command.force:
        raise UsageError(
            f"--save: {shown(command.save)} is there already; allowed: another file, or --force to"
            " replace it"
        )
    return target


@contextlib.contextmanager
def _progress(n_runs: int) -> "Iterator[Callable[[float, Progress], None]]":
    """What shows the progress on a terminal; nothing where there is none."""
    with terminal.progress_bar(n_runs, n_runs, with_time_left=True) as show:

        def tell(done: float, progress: "Progress") -> None:
            rate = f"{progress.steps_per_s / 1e6:.1f} M steps/s"
            show(done, f"{int(done)}/{n_runs} runs", rate)

        yield tell


# --- What came of it -----------------------------------------------------------------------------


def _seeds_in_words(seeds: Sequence[int]) -> str:
    if len(seeds) == 1:
        return f"seed {seeds[0]}"
    return f"seeds {seeds[0]} to {seeds[-1]}"


def _weights_in_words(weights: Mapping[str, float]) -> str:
    return ", ".join(f"{skill} {typed.plain(weight)}" for skill, weight in weights.items())


def _report(preset: str, plan: "Plan", tuned: "Tuned") -> str:
    from app.analysis.estimates import CONFIDENCE
    from app.experiments.tuning import AREA, END

    rows: list[Sequence[str]] = []
    for stage in tuned.stages:
        for tried in stage.tried:
            rewards = [each for each in tried.rewards.values() if not math.isnan(each)]
            ends = [number(end(rewards)) if rewards else number(None) for end in (min, max)]
            kept = "kept" if tried.weight == stage.weight else ""
            rows.append((stage.skill, typed.plain(tried.weight), number(tried.mean), *ends, kept))
    searched = table(("skill", "weight", "reward", "lowest", "highest", ""), rows)
    found = _weights_in_words(tuned.weights)
    names = {"tuned": found, "ones": "all weights 1", "difference": "difference"}
    judged = table(
        ("weights", "whole run", "last 2,000 trials"),
        [
            (name, *(_estimated(tuned.judged[metric][key]) for metric in (AREA, END)))
            for key, name in names.items()
        ],
    )
    horizon, n_judges = in_short(plan.horizon), len(plan.judge_seeds)
    return "\n\n".join(
        [
            filled(
                f"{preset}: reward is the mean per trial over {horizon} steps, and over"
                f" {_seeds_in_words(plan.seeds)}",
                "",
            ),
            filled(
                "Skills are let in one at a time. The first has the weight 1; each other one keeps"
                " the weight that was best beside those before it:",
                "",
            ),
            searched,
            *(
                filled(
                    f"Of {stage.skill} the best is at an end of what was tried, and one beyond it"
                    " may be better: see --weights.",
                    "",
                )
                for stage in tuned.stages
                if stage.is_at_an_end
            ),
            filled(
                f"Judged with {counted(n_judges, 'seed')} that the search has not seen"
                f" ({_seeds_in_words(plan.judge_seeds)}). In brackets are intervals of"
                f" {CONFIDENCE:.0%} confidence:",
                "",
            ),
            judged,
            filled(_verdict(tuned, AREA), ""),
        ]
    )


def _verdict(tuned: "Tuned", metric: str) -> str:
    from app.analysis.estimates import LEAST_RUNS

    difference = tuned.judged[metric]["difference"]
    if all(weight == 1 for weight in tuned.weights.values()):
        return "The search has kept weights of 1."
    if difference.n < LEAST_RUNS:
        return f"With fewer than {LEAST_RUNS} seeds an interval decides nothing."
    if not difference.excludes_zero:
        return "Over the whole run nobody can tell them from weights of 1."
    word = "better" if difference.value > 0 else "worse"
    return f"Over the whole run they are {word} than weights of 1."


def _estimated(estimate: "Estimate") -> str:
    if not estimate.has_interval:
        return number(estimate.value)
    return f"{number(estimate.value)} [{number(estimate.low)}, {number(estimate.high)}]"


def _document(preset: str, plan: "Plan", tuned: "Tuned") -> dict[str, Any]:
    """All that there is to say, as plain data for JSON."""
    return {
        "preset": preset,
        "settings": tuned.spec.model_dump(mode="json"),
        "horizon": plan.horizon,
        "seeds": [*plan.seeds],
        "judge_seeds": [*plan.judge_seeds],
        "stages": [
            {
                "skill": stage.skill,
                "weight": stage.weight,
                "tried": [
                    {
                        "weight": tried.weight,
                        "reward": _or_none(tried.mean),
                        "rewards": [_or_none(tried.rewards[seed]) for seed in plan.seeds],
                    }
                    for tried in stage.tried
                ],
            }
            for stage in tuned.stages
        ],
        "weights": dict(tuned.weights),
        "judged": {
            metric: {
                key: {
                    "mean": _or_none(found.value),
                    "low": _or_none(found.low),
                    "high": _or_none(found.high),
                    "n": found.n,
                }
                for key, found in estimates.items()
            }
            for metric, estimates in tuned.judged.items()
        },
    }


def _or_none(value: float) -> float | None:
    return None if math.isnan(value) else value


def _save(target: Path, preset: str, plan: "Plan", tuned: "Tuned") -> None:
    """Write the preset with its weights; raises `OSError` if it cannot be."""
    from app.util.files import write_whole

    write_whole(target, _preset(preset, plan, tuned.spec).encode())


def _preset(preset: str, plan: "Plan", spec: "RunSpec") -> str:
    from app.documents import presets
    from app.util.texts import as_text

    name = " ".join(as_text(preset).split())
    return (
        f"# {name}, its weights tuned in one at a time (section 5.2): by the mean reward over\n"
        f"# {plan.horizon:,} steps, with {_seeds_in_words(plan.seeds)}.\n{presets.dump(spec)}"
    )
