"""The command ``pounce``: what can be asked for, in which words, and how answers are printed.

What takes long to import is imported by the command that needs it, so that help comes at once.
"""

import contextlib
import dataclasses
import difflib
import importlib.metadata
import io
import json
import math
import os
import re
import sys
import textwrap
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro
from tyro.conf import FlagCreatePairsOff, OmitArgPrefixes, Positional, UseAppendAction, arg

from app import report_cli, terminal
from app.experiment_cli import Experiment
from app.machine import available_cores
from app.report_cli import Report

if TYPE_CHECKING:
    from app import experiments, laboratory
    from app.headless import Output, Progress, RunResult
    from benchmarks.compare import Rates
    from learners.spec import RunSpec

EXIT_OK = 0
EXIT_FAILED = 1
EXIT_USAGE = 2
EXIT_INTERRUPTED = 130
"""As shells report a program that SIGINT ended."""
EXIT_PIPE_CLOSED = 141
"""As shells report a program that SIGPIPE ended."""

MAX_SEED = 2**63 - 1
MAX_RUNS = 100_000
MAX_WORKERS = 1_024
MAX_REPETITIONS = 1_000

_WINDOWS = (0, 1, 2, 3, 7)
"""Windows of the coarse learning curve that the table of results shows."""
_SHOWN_CHARACTERS = 40
_COLUMNS = 80
_NOTHING = "\N{EN DASH}"
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

_HIDDEN_HINT = ""
_Name = Annotated[Positional[str], arg(metavar="PRESET", help_behavior_hint=_HIDDEN_HINT)]
_Flag = Annotated[bool, arg(help_behavior_hint=_HIDDEN_HINT)]


class UsageError(Exception):
    """What was asked for makes no sense; the message says what does. Exit code 2."""


class WrongPresetError(UsageError):
    """A preset that cannot be used; the message has one line for each of its problems."""


# --- What can be asked for -----------------------------------------------------------------------
#
# Values stay texts until the checks below have seen them, so that every refusal reads the same.


@dataclass(frozen=True)
class Lab:
    """Open the lab in a browser: watch a learner, and steer it."""

    preset: Annotated[Positional[str], arg(metavar="[PRESET]")] = "timed"
    """A shipped preset, or a file."""
    host: Annotated[str, arg(metavar="IP")] = "127.0.0.1"
    """Address to listen on."""
    port: Annotated[str, arg(metavar="PORT")] = "8080"
    """Port to listen on; if it is busy, the next free one."""
    no_browser: _Flag = False
    """Print the address, and open no browser."""
    seed: Annotated[str, arg(metavar="N")] = "0"
    """Seed of the run."""
    save_dir: Annotated[str | None, arg(metavar="FOLDER", help_behavior_hint=_HIDDEN_HINT)] = None
    """Let *Save as preset* write into that folder as well."""
    results: Annotated[str, arg(metavar="FOLDER")] = "results"
    """Where experiments that are started in the page put their folders."""


@dataclass(frozen=True)
class Presets:
    """List the shipped presets."""


@dataclass(frozen=True)
class Run:
    """Run a preset over many seeds on all cores, without a page."""

    preset: _Name = ""
    """A shipped preset, or a file."""
    seeds: Annotated[str | None, arg(metavar="N", help_behavior_hint="(default: 1)")] = None
    """Run seeds 0 to N-1."""
    seed_list: Annotated[str | None, arg(metavar="N,N,...", help_behavior_hint=_HIDDEN_HINT)] = None
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
    json: _Flag = False
    """Print one JSON object and nothing else."""
    out: Annotated[str | None, arg(metavar="DIR", help_behavior_hint=_HIDDEN_HINT)] = None
    """Write the same to DIR as JSON, the learning curves as CSV, and the final tables."""
    force: _Flag = False
    """Let --out replace results of the same name."""


@dataclass(frozen=True)
class Bench:
    """Measure how fast the learners are on this machine."""

    presets: Annotated[
        Positional[tuple[str, ...]],
        arg(metavar="[PRESET ...]", help_behavior_hint="(default: all shipped ones)"),
    ] = ()
    """Shipped presets, or files."""
    json: _Flag = False
    """Print one JSON object and nothing else."""
    repetitions: Annotated[str, arg(metavar="N")] = "5"
    """Interleaved measurements, of which the median counts."""
    page: _Flag = False
    """Measure what the live page costs the learner, with no browser, one and five."""


Command = Lab | Presets | Run | Experiment | Report | Bench

COMMANDS: dict[str, type[Command]] = {
    "lab": Lab,
    "presets": Presets,
    "run": Run,
    "experiment": Experiment,
    "report": Report,
    "bench": Bench,
}

EXAMPLES: dict[type[Command], Sequence[str]] = {
    Lab: (
        "pounce",
        "pounce lab hierarchical_3 --seed 7",
        "pounce lab my-preset.yaml --port 9000 --no-browser",
    ),
    Presets: ("pounce presets",),
    Run: (
        "pounce run timed --seeds 3",
        "pounce run timed --seed-list 3,7 --trials 20000 --json",
        "pounce run standard_q --set world.size=60 --set learner.epsilon=0.05",
        "pounce run my-preset.yaml --seeds 30 --out results",
    ),
    Experiment: (
        "pounce experiment figure_4_1",
        "pounce experiment timing_circle_avoid --seeds 10 --dry-run",
        "pounce experiment my-experiment.yaml --out results --resume",
        "pounce experiment figure_4_2 --cluster tcp://HOST:8786",
    ),
    Report: report_cli.EXAMPLES,
    Bench: (
        "pounce bench",
        "pounce bench timed --repetitions 9",
        "pounce bench --json",
        "pounce bench --page --json",
    ),
}


@dataclass(frozen=True)
class Pounce:
    """A lab in which you see how the timing of skills changes what a learner learns.

    This is what ``pounce --help`` shows; the commands themselves are parsed one by one.
    """

    command: OmitArgPrefixes[
        Annotated[Lab, tyro.conf.subcommand("lab")]
        | Annotated[Presets, tyro.conf.subcommand("presets")]
        | Annotated[Run, tyro.conf.subcommand("run")]
        | Annotated[Experiment, tyro.conf.subcommand("experiment")]
        | Annotated[Report, tyro.conf.subcommand("report")]
        | Annotated[Bench, tyro.conf.subcommand("bench")]
    ] = dataclasses.field(default_factory=Lab)
    version: _Flag = False
    """Print the version."""


# --- From words to values ------------------------------------------------------------------------


def shown(value: str) -> str:
    """A user's text as a message quotes it: on one line, and not too long."""
    if len(value) > _SHOWN_CHARACTERS:
        value = value[: _SHOWN_CHARACTERS - 3] + "..."
    return repr(value)


def whole_number(option: str, text: str, low: int, high: int) -> int:
    """The number that an option was given.

    Raises:
        UsageError: it is not a whole number between the limits.
    """
    digits = text.isascii() and text.isdigit() and len(text) <= len(str(high))
    if not digits or not low <= int(text) <= high:
        raise UsageError(
            f"{option}: {shown(text)} is not allowed; allowed: a whole number, {low} to {high}"
        )
    return int(text)


def seeds_of(command: Run) -> Sequence[int]:
    """The seeds to run, in the order in which they were given.

    Raises:
        UsageError: the options that name them are wrong.
    """
    if command.seed_list is None:
        return range(whole_number("--seeds", command.seeds or "1", 1, MAX_RUNS))
    if command.seeds is not None:
        raise UsageError("--seeds and --seed-list exclude each other; allowed: one of them")
    seeds = [
        whole_number("--seed-list", part.strip(), 0, MAX_SEED)
        for part in command.seed_list.split(",")
    ]
    for index, seed in enumerate(seeds):
        if seed in seeds[:index]:
            raise UsageError(f"--seed-list: {seed} is there twice; allowed: each seed once")
    return seeds


def parse(argv: Sequence[str]) -> Command | Pounce | None:
    """What was asked for; None if it was help, which has been printed.

    Raises:
        UsageError: the words make no sense.
    """
    first = argv[0] if argv else ""
    if first in COMMANDS:
        return _parsed(COMMANDS[first], f"pounce {first}", argv[1:])
    if first and not first.startswith("-"):
        raise UsageError(_unknown_command(first))
    if first in ("-h", "--help", "--version"):
        return _parsed(Pounce, "pounce", argv)
    return _parsed(Lab, "pounce lab", argv)


def _unknown_command(word: str) -> str:
    close = difflib.get_close_matches(word, COMMANDS, n=1)
    hint = f"did you mean {close[0]}?" if close else f"to open a preset: pounce lab {word}"
    return f"{shown(word)} is not a command; allowed: {', '.join(COMMANDS)} ({hint})"


def _parsed(kind: type[Any], prog: str, argv: Sequence[str]) -> Any:
    for word in argv[:1]:
        # tyro's own options, which are not ours.
        if word.replace("_", "-").startswith("--tyro-"):
            raise UsageError(_unknown_word(kind, prog, [word]))
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            command, unknown = tyro.cli(
                kind,
                prog=prog,
                description=_description(kind),
                args=_one_value_for_each_set(argv),
                return_unknown_args=True,
                config=(FlagCreatePairsOff,),
            )
    except SystemExit as end:
        if not end.code:
            return None
        # Values are texts, so all that tyro itself can miss is one.
        option = re.search(r"--[a-z][a-z-]*", complaint.getvalue())
        name = option[0] if option else "an option"
        raise UsageError(f"{name}: its value is missing (see {prog} --help)") from end
    if unknown:
        raise UsageError(_unknown_word(kind, prog, unknown))
    return command


def _description(kind: type[Any]) -> str:
    text = (kind.__doc__ or "").splitlines()[0]
    if kind not in EXAMPLES:
        return text
    return "\n".join([text, "", "Examples:", *(f"  {line}" for line in EXAMPLES[kind])])


def _one_value_for_each_set(argv: Sequence[str]) -> list[str]:
    """``--set A=1 B=2`` as ``--set A=1 --set B=2``."""
    words: list[str] = []
    after_setting = False
    for word in argv:
        if words[-1:] == ["--set"]:
            after_setting = True
        elif after_setting and re.match(r"[A-Za-z_][\w.]*=", word):
            words.append("--set")
        else:
            after_setting = False
        words.append(word)
    return words


def _unknown_word(kind: type[Any], prog: str, unknown: Sequence[str]) -> str:
    word = next((word for word in unknown if word.startswith("-")), None)
    if word is None:
        return f"{shown(unknown[0])} is one word too many (see {prog} --help)"
    options = [f"--{field.name.replace('_', '-')}" for field in dataclasses.fields(kind)]
    close = difflib.get_close_matches(word, options, n=1)
    hint = f"did you mean {close[0]}?" if close else f"see {prog} --help"
    return f"{shown(word)} is not an option of {prog} ({hint})"


# --- Commands ------------------------------------------------------------------------------------


def _version() -> int:
    try:
        version = importlib.metadata.version("pounce-lab")
    except importlib.metadata.PackageNotFoundError:
        version = "(not installed)"
    _say(f"pounce {version}")
    return EXIT_OK


def _lab(command: Lab) -> int:
    port = whole_number("--port", command.port, 1, 65_535)
    seed = whole_number("--seed", command.seed, 0, MAX_SEED)
    if not command.host.strip():
        # An empty host would mean all addresses.
        raise UsageError("--host: '' is not allowed; allowed: an address of this machine")
    save_dir = None if command.save_dir is None else Path(command.save_dir)
    if save_dir is not None and not save_dir.is_dir():
        raise UsageError(f"--save-dir: {shown(str(save_dir))} is no folder; allowed: one there is")
    results = Path(command.results)
    if not command.results or (results.exists() and not results.is_dir()):
        raise UsageError(f"--results: {shown(command.results)} is not allowed; allowed: a folder")
    spec = _spec(command.preset, ())
    from app import presets
    from app.lab import run_lab

    try:
        return run_lab(
            spec=spec,
            preset=command.preset,
            seed=seed,
            presets={name: presets.load(name) for name in presets.shipped()},
            host=command.host,
            port=port,
            open_browser=not command.no_browser,
            save_dir=save_dir,
            results=results,
        )
    except OSError as error:
        raise UsageError(
            f"--host and --port: {shown(command.host)} and {port} cannot be listened on:"
            f" {error.strerror or error}; allowed: an address of this machine and a free port"
        ) from error


def _presets() -> int:
    from app import presets

    shipped = presets.shipped()
    width = max(map(len, shipped))
    for name in shipped:
        _say(_filled(f"{name:{width}}  {presets.load(name).description}", " " * (width + 2)))
    _say("\nFiles:")
    for file in shipped.values():
        _say(f"  {file}")
    return EXIT_OK


def _run(command: Run) -> int:
    seeds = seeds_of(command)
    workers = available_cores()
    if command.workers is not None:
        workers = whole_number("--workers", command.workers, 1, MAX_WORKERS)
    if command.force and command.out is None:
        raise UsageError("--force goes with --out; allowed: both, or neither")
    if not command.preset:
        raise UsageError("PRESET is missing; allowed: a shipped preset (pounce presets) or a file")
    spec = _spec(command.preset, _settings(command))

    from app import headless

    with _output(command, seeds) as output, _progress(spec, command, len(seeds)) as on_progress:
        try:
            results = headless.run_seeds(
                spec,
                seeds,
                workers,
                on_progress=on_progress,
                on_finished=output.save_tables if output else lambda _: None,
            )
            document = headless.summary(command.preset, spec, results)
            if output:
                output.commit(document, results)
        except headless.SeedFailedError as error:
            _complain(str(error))
            return EXIT_FAILED
        except headless.OutputError as error:
            _complain(f"--out: {shown(str(command.out))} {error}")
            return EXIT_FAILED
    _say(headless.as_json(document) if command.json else _report(command.preset, results))
    return EXIT_OK


def _spec(preset: str, settings: Sequence[str]) -> "RunSpec":
    from app import presets

    try:
        return presets.load(preset, settings)
    except presets.PresetError as error:
        raise WrongPresetError(str(error)) from error


def _settings(command: Run) -> Sequence[str]:
    if command.trials is None:
        return command.set
    from learners.spec import MAX_TRIALS

    trials = whole_number("--trials", command.trials, 1, MAX_TRIALS)
    return (*command.set, f"trials={trials}")


@contextlib.contextmanager
def _output(command: Run, seeds: Sequence[int]) -> "Iterator[Output | None]":
    if command.out is None:
        yield None
        return
    if not command.out:
        raise UsageError("--out: '' is not allowed; allowed: a folder")
    from app.headless import Output, OutputError

    try:
        output = Output(Path(command.out), Path(command.preset).stem, seeds, command.force)
    except OutputError as error:
        raise UsageError(f"--out: {shown(command.out)} {error}") from error
    with output:
        yield output


@contextlib.contextmanager
def _progress(spec: "RunSpec", command: Run, n_runs: int) -> "Iterator[Callable[[Progress], None]]":
    """What shows the progress of a run on a terminal; nothing where there is none."""
    began = time.monotonic()
    with terminal.progress_bar(spec.trials * n_runs, n_runs, with_time_left=True) as show:

        def tell(progress: "Progress") -> None:
            rate = progress.steps / max(time.monotonic() - began, 1e-3) / 1e6
            show(progress.trials, f"{progress.runs}/{n_runs} runs", f"{rate:.1f} M steps/s")

        yield tell


def _experiment(command: Experiment) -> int:
    workers = available_cores()
    if command.workers is not None:
        workers = whole_number("--workers", command.workers, 1, MAX_WORKERS)
    address = command.cluster
    if address is not None and command.workers is not None:
        raise UsageError("--cluster and --workers exclude each other; allowed: one of them")
    n_seeds = None
    if command.seeds is not None:
        n_seeds = whole_number("--seeds", command.seeds, 1, MAX_RUNS)
    if command.out is not None and not command.out:
        raise UsageError("--out: '' is not allowed; allowed: a folder")
    if command.resume and command.force:
        raise UsageError("--resume and --force exclude each other; allowed: one of them")
    from app import experiment_cli, experiments, presets

    if address is not None and not experiment_cli.is_address(address):
        raise UsageError(
            f"--cluster: {shown(address)} is not allowed; allowed: tcp://HOST:PORT of a running"
            " Dask scheduler, or tls://HOST:PORT"
        )

    if not command.experiment:
        names = ", ".join(experiments.shipped())
        raise UsageError(f"EXPERIMENT is missing; allowed: {names}, or a file")

    try:
        wanted = experiment_cli.wanted(command, n_seeds)
    except presets.PresetError as error:
        raise WrongPresetError(str(error)) from error
    from app.laboratory import ClusterError
    from app.results import FolderError

    try:
        # Before the folder, of which --force clears what is there.
        crew = experiment_cli.crew_of(address, workers)
    except ClusterError as error:
        raise UsageError(f"--cluster: {shown(address or '')} {error}") from error
    with crew:
        if command.dry_run:
            try:
                _say(experiment_cli.planned(command, wanted, crew.size))
            except FolderError as error:
                raise UsageError(str(error)) from error
            return EXIT_OK
        return _carried_out(command, wanted, crew)


def _carried_out(
    command: Experiment, wanted: "experiments.Experiment", crew: "laboratory.Crew"
) -> int:
    from app import experiment_cli
    from app.laboratory import ClusterError
    from app.results import FolderError

    try:
        folder = experiment_cli.folder_of(command, wanted)
    except FolderError as error:
        raise UsageError(str(error)) from error
    with folder:
        try:
            outcome = experiment_cli.carried_out(wanted, folder, crew)
        except FolderError as error:
            _complain(f"{shown(str(folder.path))} {error}")
            return EXIT_FAILED
        except ClusterError as error:
            _complain(f"{shown(command.cluster or '')} {error}")
            return EXIT_FAILED
        except KeyboardInterrupt:
            _complain(f"interrupted; what is finished is in {folder.path}, and --resume goes on")
            return EXIT_INTERRUPTED
        _say(experiment_cli.report(command, wanted, folder, outcome))
    return EXIT_FAILED if outcome.failed else EXIT_OK


def _bench(command: Bench) -> int:
    from app import presets

    repetitions = whole_number("--repetitions", command.repetitions, 1, MAX_REPETITIONS)
    specs = {name: _spec(name, ()) for name in command.presets or presets.shipped()}
    if command.page:
        return _bench_page(command, specs, repetitions)
    from benchmarks.compare import MismatchError, compare

    try:
        with terminal.status() as on_progress:
            found = compare(specs, repetitions, on_progress)
    except MismatchError as error:
        _complain(str(error))
        return EXIT_FAILED
    for note in found["notes"]:
        _complain(_filled(note))
    learners = found["learners"]
    _say(json.dumps({"learners": learners}) if command.json else _speeds(learners))
    return EXIT_OK


def _bench_page(command: Bench, specs: "dict[str, RunSpec]", repetitions: int) -> int:
    from benchmarks.page import compare_page

    preset = command.presets[0] if command.presets else "timed"
    with terminal.status() as on_progress:
        found = compare_page(specs[preset], preset, specs, repetitions, on_progress)
    if command.json:
        _say(json.dumps(found))
        return EXIT_OK
    _say(f"Rate of {preset} beside the page, as a share of its headless rate:")
    for n_clients, ratio in found["clients"].items():
        _say(f"  {n_clients} browsers  {ratio:.2f}")
    return EXIT_OK


# --- What is printed -----------------------------------------------------------------------------


def _say(text: str) -> None:
    sys.stdout.write(text + "\n")


def _complain(text: str) -> None:
    sys.stderr.write(text + "\n")


def _filled(text: str, indent: str = "  ") -> str:
    """A text in lines that fit a terminal, those after the first indented."""
    return textwrap.fill(text, _COLUMNS, subsequent_indent=indent, break_on_hyphens=False)


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Rows of texts in columns, aligned to the right but for the first."""
    lines = [header, *rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        " ".join(
            cell.rjust(width) if column else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    )


def _number(value: float | None, form: str = ".1f") -> str:
    return _NOTHING if value is None or math.isnan(value) else format(value, form)


def _report(preset: str, results: "Sequence[RunResult]") -> str:
    runs = table(
        _RUN_HEADER,
        [
            (
                str(result.seed),
                str(result.trials),
                str(result.steps),
                f"{result.seconds:.2f}",
                str(result.captures),
                str(result.flights),
                str(result.timeouts),
                _number(result.mean_reward_last_2000),
                result.digest[:12],
            )
            for result in results
        ],
    )
    seeds = "1 seed" if len(results) == 1 else f"{len(results)} seeds"
    return (
        f"{preset}: reward is the mean of the last 2,000 trials\n\n{runs}\n\n"
        f"Mean reward per trial in windows of steps, over {seeds}:\n\n{_windows(results)}"
    )


def _windows(results: "Sequence[RunResult]") -> str:
    """The learning curve in a few windows, the mean over the runs that got to them."""
    from app.headless import PHASE_STEPS

    million = PHASE_STEPS / 1e6
    header = [f"{w * million:g}{_NOTHING}{(w + 1) * million:g} M" for w in _WINDOWS]
    means = [
        _mean(r.phases.reward[w] for r in results if w < r.phases.reward.size) for w in _WINDOWS
    ]
    header.append("last 2,000 trials")
    means.append(_mean(result.mean_reward_last_2000 for result in results))
    return table(["steps", *header], [["reward", *map(_number, means)]])


def _mean(values: Iterable[float]) -> float:
    there = [float(value) for value in values if not math.isnan(value)]
    return sum(there) / len(there) if there else math.nan


def _speeds(learners: "Mapping[str, Rates]") -> str:
    rows = [
        (
            name,
            f"{rates['steps_per_s'] / 1e6:.2f}",
            _number(rates["ratio_to_c"], ".2f"),
            _number(rates["ratio_to_plain"], ".2f"),
            _number(rates["ratio_to_python"], ".0f"),
        )
        for name, rates in learners.items()
    ]
    return table(["learner", "M steps/s", "x C", "x plain", "x Python"], rows)


# --- The program ---------------------------------------------------------------------------------


def _obey(command: Command | Pounce | None) -> int:
    match command:
        case None:
            return EXIT_OK
        case Pounce():
            return _version()
        case Lab():
            return _lab(command)
        case Presets():
            return _presets()
        case Run():
            return _run(command)
        case Experiment():
            return _experiment(command)
        case Report():
            return report_cli.report(command)
        case Bench():
            return _bench(command)


def main(argv: Sequence[str] | None = None) -> int:
    """Do what the command line says; returns the exit code."""
    for stream in (sys.stdout, sys.stderr):
        # Where the terminal knows no such character, better an escape than a traceback.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        code = _answer(sys.argv[1:] if argv is None else argv)
        sys.stdout.flush()
    except BrokenPipeError:
        # Nobody reads on. What is still to be flushed at exit must have somewhere to go.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for stream in (sys.stdout, sys.stderr):
            os.dup2(nowhere, stream.fileno())
        return EXIT_PIPE_CLOSED
    return code


def _answer(argv: Sequence[str]) -> int:
    try:
        return _obey(parse(argv))
    except WrongPresetError as error:
        _complain(str(error))
        return EXIT_USAGE
    except UsageError as error:
        _complain(_filled(str(error)))
        return EXIT_USAGE
    except KeyboardInterrupt:
        _complain("interrupted")
        return EXIT_INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
