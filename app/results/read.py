"""Results as they lie on disk, read back: a table of runs, and the log of each."""

import json
import math
import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from app.analysis import estimates
from app.analysis.estimates import Axis, Band, Windows
from app.analysis.passages import Passage
from app.analysis.sweeps import BETWEEN, short_names
from app.documents import experiments
from app.documents.experiment_spec import Stop
from app.experiments import archive, table
from app.experiments.archive import ArchiveError
from app.experiments.record import Origin, Record, records_of
from app.experiments.seed_lists import SeedLists
from app.experiments.table import DamageError, UnreadableError, VersionError
from app.metrics.course import GreedyCurve
from app.results.horizon import Horizon, UpTo, common, is_measured, up_to, with_values
from app.util.texts import as_text
from learners import measures
from sim.spec import WorldSpec
from sim.world import CAPTURE

AXES: tuple[Axis, ...] = ("steps", "trials")
"""What learning curves are drawn against."""

_WIDEST_TRIALS = 1_000


_T = TypeVar("_T")


class ResultsError(Exception):
    """Results cannot be read or reported on; the message says why, and what can be."""


class DamagedError(ResultsError):
    """The results of a folder are damaged."""


# --- The table of results ------------------------------------------------------------------------


@dataclass(frozen=True)
class Folder:
    """A folder of results."""

    path: Path
    name: str
    """Of the experiment."""
    rows: Sequence[Record]
    lost: Sequence[Record]
    """Runs that count as missing, since their arrays are damaged or gone; not among the rows."""
    command: str
    """That made the results."""
    metrics: Sequence[str]
    """Columns that were measured, first the one that is charted if it is a mean."""
    description: str
    """What the experiment is about, in its own words."""
    planned: int
    """Runs that the experiment makes in all, those that fail included."""


@dataclass
class Group:
    """Runs that differ in nothing but their seeds."""

    label: str
    preset: str
    overrides: Mapping[str, Any]
    runs: list[Record] = field(default_factory=list)

    def by_seed(self, column: str) -> dict[int, float]:
        """A scalar of each run."""
        return {run.seed: run.values[column] for run in self.runs}

    def values(self, column: str) -> list[float]:
        """A scalar of each run, in the order of the runs."""
        return [run.values[column] for run in self.runs]

    def passages(self, column: str) -> dict[int, Passage]:
        """After how many steps something was reached, by each run of which it was measured."""
        return passages_of(self.runs, column)


def passages_of(runs: Iterable[Record], column: str) -> dict[int, Passage]:
    """After how many steps runs reached something, by seed, if it was measured of them.

    Args:
        runs: of different seeds.
        column: a passage.
    """
    found = ((run, run.values[column]) for run in runs)
    return {
        run.seed: Passage(at if math.isfinite(at) else run.steps, not math.isfinite(at))
        for run, at in found
        if not math.isnan(at)
    }


def read_folder(path: Path) -> Folder:
    """Read the table of results in a folder.

    Raises:
        ResultsError: it is missing, of another version, or damaged.
    """
    shown = repr(str(path))
    if not path.is_dir():
        raise ResultsError(f"{shown} is no folder; allowed: one that pounce experiment has written")
    if not (path / "results.sqlite").is_file():
        raise ResultsError(f"{shown} holds no results: there is no results.sqlite in it")
    try:
        if not table.has_table(path):
            raise ResultsError(f"no run is over in {shown}: there is nothing to report yet")
        about, found = table.load(path)
        origin = _origin_in(path, about)
        rows = records_of(found, origin)
        labels = _names_in(about, "variants")
        seeds = SeedLists.noted(about)
        command, description = _command_of(path, about), str(about["description"])
        name = str(about["name"])
        planned = sum(map(seeds.n_of, labels))
    except VersionError as error:
        raise ResultsError(
            f"{shown} holds results of version {error}, and this program reads version"
            f" {table.SCHEMA_VERSION}; allowed: a report by the program that wrote them"
        ) from error
    except DamageError as error:
        salvage = (
            "; allowed: pounce experiment with --salvage, which goes on with these"
            if error.whole
            else ""
        )
        raise DamagedError(f"{shown} holds a damaged results.sqlite: {error}{salvage}") from error
    except (UnreadableError, OSError) as error:
        raise ResultsError(f"{shown} cannot be read: {error}") from error
    except (ValueError, TypeError, KeyError) as error:
        raise DamagedError(f"{shown} holds a damaged results.sqlite: {error}") from error
    lost = {row.key for row in rows if not row.error and not _has_arrays(row)}
    return Folder(
        path=path,
        name=name,
        rows=_in_order(labels, (row for row in rows if row.key not in lost)),
        lost=_in_order(labels, (row for row in rows if row.key in lost)),
        command=command,
        metrics=origin.metrics,
        description=description,
        planned=planned,
    )


def _has_arrays(run: Record) -> bool:
    return archive.is_whole(run.origin.folder, run.key, run.arrays)


def _in_order(labels: Iterable[str], rows: Iterable[Record]) -> list[Record]:
    """Runs by variant and seed; in the table they stand in the order in which they ended.

    Variants are in the order of the labels, the others by name.
    """
    places = {label: place for place, label in enumerate(labels)}

    def place(run: Record) -> tuple[int, int, str, str, int]:
        known = places.get(run.variant, len(places))
        return known, len(run.overrides), run.variant, run.key if run.error else "", run.seed

    return sorted(rows, key=place)


def _names_in(meta: Mapping[str, Any], key: str) -> Sequence[str]:
    found = json.loads(meta[key])
    if not isinstance(found, list) or not all(isinstance(name, str) for name in found):
        raise ValueError(f"{key} are not a list of names")
    return found


def _origin_in(path: Path, meta: Mapping[str, Any]) -> Origin:
    stop, steps = json.loads(meta["stop"]), json.loads(meta["steps"])
    limited = stop is not None or steps is not None
    return Origin(
        path,
        _names_in(meta, "metrics"),
        limited,
        None if stop is None else Stop(**stop),
        json.loads(meta["horizon"]),
        json.loads(meta["steps_alone"]),
    )


def _command_of(path: Path, meta: Mapping[str, Any]) -> str:
    """What made the results."""
    count = SeedLists.noted(meta).n_counting_up
    counted = [] if count is None else ["--seeds", str(count)]
    source = str(meta["source"])
    if not source:
        # An experiment of the page has no file, and a name alone does not say where its file is.
        name = str(meta["name"])
        source = name if name in experiments.shipped() else str(path / "experiment.yaml")
    return as_text(shlex.join(["pounce", "experiment", source, *counted, "--out", str(path)]))


def groups_of(rows: Iterable[Record]) -> list[Group]:
    """Runs that are over, together with those of the same variant and settings.

    Where some may have ended early, they are no runs of the same as those that may not, or that
    may have by another condition. Variants of several folders that only share a label are told
    apart by their folders.
    """
    found: dict[str, Group] = {}
    for run in rows:
        if not run.error:
            settings = {**run.settings, "description": ""}
            ending = run.origin.limited, run.origin.stop and run.origin.stop.model_dump()
            parts = [run.variant, run.preset_name, run.overrides, settings, ending]
            group = Group(run.variant, run.preset_name, run.overrides)
            found.setdefault(json.dumps(parts, sort_keys=True), group).runs.append(run)
    groups = list(found.values())
    _tell_apart(groups)
    return groups


def _tell_apart(groups: Iterable[Group]) -> None:
    """Put the names of their folders before labels that variants of several folders share."""
    by_label: dict[str, list[Group]] = {}
    for group in groups:
        by_label.setdefault(group.label, []).append(group)
    for label, alike in by_label.items():
        folders = [tuple(dict.fromkeys(run.origin.folder for run in group.runs)) for group in alike]
        if len(set(folders)) > 1:
            names = folder_names(folder for several in folders for folder in several)
            for group, several in zip(alike, folders, strict=True):
                group.label = f"{', '.join(names[folder] for folder in several)}: {label}"


def folder_names(folders: Iterable[Path]) -> dict[Path, str]:
    """Names of folders; the whole path of those whose names are alike."""
    names = {folder: folder.resolve().name for folder in folders}
    counts = Counter(names.values())
    return {path: as_text(name if counts[name] == 1 else path) for path, name in names.items()}


def with_short_names(groups: Sequence[Group]) -> tuple[Sequence[Group], str]:
    """Variants with short labels, and a sentence on what these are made of.

    Variants that set the same keys are told apart by the values of those that differ. Where
    somebody has named one of them, all keep their labels, and nothing is said.
    """
    if len(groups) < 2:
        return groups, ""
    found = short_names(
        [group.label for group in groups],
        [group.preset for group in groups],
        [group.overrides for group in groups],
        groups[0].runs[0].settings,
    )
    if found is None:
        return groups, ""
    named = [replace(group, label=name) for group, name in zip(groups, found.of, strict=True)]
    order = ", in this order" if len(found.what) > 1 else ""
    return named, f"Variants are named by their values of {BETWEEN.join(found.what)}{order}."


def measured(groups: Iterable[Group], column: str) -> bool:
    """Whether any run has a value in a column."""
    return any(math.isfinite(value) for group in groups for value in group.values(column))


# --- The log of a run ----------------------------------------------------------------------------


class Pictures(NamedTuple):
    """How far value had spread at some moments of a run, in the prey's own frame.

    As :func:`learners.measures.folded_value` has it: direction 0 is straight ahead of the prey,
    and directions count counter-clockwise.
    """

    moments: np.ndarray
    """(moment,) int64: trials that were about to start; the last one may be that after the end."""
    share: np.ndarray
    """(moment, ring, direction) float32: share of the headings with a value above 0."""
    distance: np.ndarray
    """(moment, ring, direction) float32: mean steps to capture that these values stand for; NaN
    where there is none."""

    def at(self, trial: int) -> measures.FoldedValue | None:
        """The picture taken before a trial; None if there is none."""
        (found,) = np.nonzero(self.moments == trial)
        if not found.size:
            return None
        return measures.FoldedValue(self.distance[found[0]], self.share[found[0]])


class Log(NamedTuple):
    """What a run's arrays say of its trials."""

    outcome: np.ndarray
    """(trial,) int8."""
    reward: np.ndarray
    """(trial,) float64."""
    steps: np.ndarray
    """(trial,) int64: that each trial took."""
    joined: Mapping[str, tuple[int, int]]
    """Trial and step of each skill that joined after the start."""
    pictures: Pictures
    greedy: GreedyCurve
    """Of no points where none were measured."""
    facts: Mapping[str, float]
    """By name: what its probes found, as :mod:`app.experiments.facts` has it."""


Measure = Callable[[Record, Log], Mapping[str, float]]
"""Names and values of the quantities that are kept of a log."""


@dataclass(frozen=True)
class Widths:
    """Windows of the learning curves."""

    steps: int
    trials: int
    trials_by_steps: int = measures.CURVE_WINDOW_TRIALS
    """Trials in a window of a curve that is drawn against steps."""

    def of(self, axis: Axis, windows: Windows = "steps") -> int:
        """The width of a window, in what it is counted in."""
        if axis == "trials":
            return self.trials
        return self.steps if windows == "steps" else self.trials_by_steps


def widths_of(rows: Iterable[Record]) -> Widths:
    """Round widths of windows that suit the longest of the runs that are over."""
    runs = [run for run in rows if not run.error]
    steps = max((run.steps for run in runs), default=1)
    trials = max((run.trials for run in runs), default=1)
    return Widths(
        estimates.window_width(steps, measures.CURVE_WINDOW_STEPS),
        estimates.window_width(trials, _WIDEST_TRIALS),
        estimates.window_width(trials, measures.CURVE_WINDOW_TRIALS),
    )


class Trace(NamedTuple):
    """What is kept of a run's log, which is a thousand times as large."""

    seed: int
    curves: Mapping[Axis, np.ndarray]
    """(window,) float64 each: mean reward per trial, NaN where no trial ended."""
    by_trials: tuple[np.ndarray, np.ndarray]
    """(window,) each: mean reward of windows of trials, and the step at which they ended."""
    greedy: GreedyCurve
    up_to: UpTo
    quantities: Mapping[str, float]
    introductions: Mapping[str, tuple[int, int]]
    """Trial and step of each skill that joined after the start."""
    ended: tuple[int, int]
    """Trial and step at which it ended."""
    met: tuple[int, int] | None
    """Trial and step at which its stop condition was met and ended it; None if it never was."""


def read_log(run: Record) -> Log:
    """Read the log of a run.

    Raises:
        ArchiveError: its arrays are missing or damaged.
    """
    found = archive.unpacked(
        archive.read(run.origin.folder, run.key, run.arrays), run.trials, run.steps
    )
    pictures = Pictures(found.moments, found.value_share, found.value_distance)
    world = WorldSpec.model_validate(run.settings["world"])
    if pictures.share.shape[1:] != (world.n_distances, world.n_directions):
        raise ArchiveError("its pictures of the value do not fit its world")
    reward = measures.rewards(world, found.outcome)
    greedy, facts = found.greedy, found.facts
    return Log(found.outcome, reward, found.steps, found.joined, pictures, greedy, facts)


def _trace_of(run: Record, log: Log, widths: Widths, measure: Measure) -> Trace:
    curves: dict[Axis, np.ndarray] = {
        axis: estimates.windowed(log.reward, log.steps, widths.of(axis), axis) for axis in AXES
    }
    ended = log.outcome.size, int(log.steps.sum())
    met = ended if _is_met(log, run.origin.stop) else None
    width = widths.trials_by_steps
    by_trials = estimates.windowed(log.reward, log.steps, width, "trials")
    return Trace(
        seed=run.seed,
        curves=curves,
        by_trials=(by_trials, estimates.window_ends(log.steps, width)),
        greedy=log.greedy,
        up_to=up_to(log.reward, log.steps, run.steps),
        quantities=measure(run, log),
        introductions=log.joined,
        ended=ended,
        met=met,
    )


def _is_met(log: Log, stop: Stop | None) -> bool:
    """Whether the last look that was taken at a run found it good enough."""
    n_trials = log.outcome.size
    if stop is None or n_trials < stop.trials or n_trials % stop.every:
        return False
    captures = int((log.outcome[-stop.trials :] == CAPTURE).sum())
    return captures >= stop.success * stop.trials


@dataclass
class Reader:
    """Reads logs and notes those that cannot be read; what is kept of them is read once."""

    widths: Widths
    measure: Measure
    folders: Mapping[Path, str] = field(default_factory=dict)
    """Names of folders, to tell their runs apart; empty where there is but one."""
    on_read: Callable[[int], object] = lambda _: None
    """Told how many logs have been read."""
    unreadable: dict[str, str] = field(default_factory=dict)
    """By name of the run: why its log cannot be read."""
    _traces: dict[tuple[Path, str], Trace | None] = field(default_factory=dict)

    def traces(self, runs: Iterable[Record]) -> list[Trace]:
        """What is kept of the logs of runs, without those that cannot be read."""
        found = (self._trace(run) for run in runs)
        return [trace for trace in found if trace is not None]

    def band(self, runs: Iterable[Record], axis: Axis, windows: Windows = "steps") -> Band:
        """The learning curve of runs, averaged, with its interval.

        Args:
            runs: of one learner.
            axis: what it is drawn against.
            windows: what its windows are counted in, where that is steps.
        """
        traces, rng = self.traces(runs), estimates.bootstrap_rng()
        width = self.widths.of(axis, windows)
        if axis == "steps" and windows == "trials":
            curves, ends = ([trace.by_trials[part] for trace in traces] for part in (0, 1))
            return estimates.band(curves, width, rng, ends)
        return estimates.band([trace.curves[axis] for trace in traces], width, rng)

    def at_horizon(self, runs: Iterable[Record]) -> tuple[list[Record], Horizon | None]:
        """Runs with their values at the horizon that they have in common, and that horizon.

        Logs are read where it is no run's own.
        """
        every = list(runs)
        horizon = common(every)
        if horizon is None:
            return every, None
        return [self._at(run, horizon) for run in every], horizon

    def _at(self, run: Record, horizon: Horizon) -> Record:
        trace = None if run.error or is_measured(run, horizon) else self._trace(run)
        return with_values(run, horizon, trace and trace.up_to)

    def pictures(self, runs: Iterable[Record]) -> list[Pictures]:
        """Pictures of the value in the logs of runs, without those that cannot be read.

        They are read anew: of all runs together they are too large to be kept.
        """
        found = (self._made(run, lambda log: log.pictures) for run in runs)
        return [pictures for pictures in found if pictures is not None]

    def name_of(self, run: Record) -> str:
        """What a run is called where it is left out."""
        name = f"{run.variant}, seed {run.seed}"
        return (
            f"{self.folders[run.origin.folder]}: {name}"
            if run.origin.folder in self.folders
            else name
        )

    def _trace(self, run: Record) -> Trace | None:
        place = run.origin.folder, run.key
        if place not in self._traces:
            self._traces[place] = self._made(
                run, lambda log: _trace_of(run, log, self.widths, self.measure)
            )
            self.on_read(len(self._traces))
        return self._traces[place]

    def _made(self, run: Record, make: Callable[[Log], _T]) -> _T | None:
        """Something made of the log of a run; None, and a note, where it cannot be read."""
        try:
            return make(read_log(run))
        except ArchiveError as error:
            self.unreadable[self.name_of(run)] = str(error)
            return None
