"""Results as they lie on disk, read back: a table of runs, and the log of each."""

import contextlib
import json
import math
import shlex
import sqlite3
import zipfile
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from app import experiments, presets, results, statistics
from app.figures import shown_value
from app.metrics import METRICS, MILESTONES, NAMES
from app.replicate import log_in
from app.statistics import Axis
from app.sweep import BETWEEN, short_names
from learners import measures
from sim.spec import WorldSpec

AXES: tuple[Axis, ...] = ("steps", "trials")
"""What learning curves are drawn against."""

_WIDEST_TRIALS = 1_000
_COLUMNS = (
    "key",
    "variant",
    "preset",
    "overrides",
    "settings",
    "seed",
    "status",
    "error",
    "version",
    "digest",
    "trials",
    "steps",
    *(metric.column for metric in METRICS),
    *MILESTONES,
)


class ResultsError(Exception):
    """Results cannot be read or reported on; the message says why, and what can be."""


# --- The table of results ------------------------------------------------------------------------


@dataclass(frozen=True)
class RunRow:
    """One run as the table of results has it."""

    folder: Path
    key: str
    variant: str
    preset: str
    """Its name, without the folder and the ending of a file."""
    overrides: Mapping[str, Any]
    settings: Mapping[str, Any]
    limited: bool
    """Whether a stop condition or a number of steps may have ended it before its trials did."""
    seed: int
    error: str
    """Why it failed; empty if it did not."""
    version: str
    digest: str
    trials: int
    steps: int
    scalars: Mapping[str, float]
    milestones: Mapping[str, float | None]

    @property
    def identity(self) -> str:
        """What a run is a function of, as a text."""
        settings = {key: self.settings[key] for key in self.settings if key != "description"}
        return json.dumps([self.preset, settings, self.limited, self.seed], sort_keys=True)


@dataclass(frozen=True)
class Folder:
    """A folder of results."""

    path: Path
    rows: Sequence[RunRow]
    command: str
    """That made the results."""
    metrics: Sequence[str] = NAMES
    """Columns that were measured, first the one that is charted if it is a mean."""
    description: str = ""
    """What the experiment is about, in its own words."""


@dataclass
class Group:
    """Runs that differ in nothing but their seeds."""

    label: str
    preset: str
    overrides: Mapping[str, Any]
    runs: list[RunRow] = field(default_factory=list)

    def by_seed(self, column: str) -> dict[int, float]:
        """A scalar of each run."""
        return {run.seed: run.scalars[column] for run in self.runs}

    def values(self, column: str) -> list[float]:
        """A scalar of each run, in the order of the runs."""
        return [run.scalars[column] for run in self.runs]


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
        with contextlib.closing(results.reader(path)) as db:
            db.row_factory = sqlite3.Row
            meta = _meta_of(db, shown)
            found = db.execute(f"SELECT {', '.join(_COLUMNS)} FROM runs ORDER BY rowid").fetchall()
        limited = _is_limited(meta)
        rows = _in_order(path, [_row(path, row, limited) for row in found])
        metrics, command = _metrics_of(meta), _command_of(path, meta)
        description = str(meta.get("description") or "")
    except (sqlite3.Error, ValueError, TypeError) as error:
        raise ResultsError(f"{shown} holds a damaged results.sqlite: {error}") from error
    return Folder(path, rows, command, metrics, description)


def _in_order(path: Path, rows: Iterable[RunRow]) -> list[RunRow]:
    """Runs by variant and seed; in the table they stand in the order in which they ended.

    Variants are in the order of the experiment, if it can still be read, else by name.
    """
    labels: list[str] = []
    with contextlib.suppress(OSError, presets.PresetError):
        text = (path / "experiment.yaml").read_bytes()
        labels = [variant.label for variant in experiments.parse(text, "", path).variants]
    places = {label: place for place, label in enumerate(labels)}

    def place(run: RunRow) -> tuple[int, int, str, str, int]:
        known = places.get(run.variant, len(places))
        return known, len(run.overrides), run.variant, run.key if run.error else "", run.seed

    return sorted(rows, key=place)


def _meta_of(db: sqlite3.Connection, shown: str) -> dict[str, Any]:
    """Names and values of the meta table, whether it has them as rows or as columns."""
    found = db.execute("SELECT * FROM meta").fetchall()
    if found and set(found[0].keys()) == {"key", "value"}:
        meta = {row["key"]: row["value"] for row in found}
    else:
        meta = dict(found[0]) if found else {}
    version = meta.get("schema_version")
    if str(version) != str(results.SCHEMA_VERSION):
        raise ResultsError(
            f"{shown} holds results of version {version}, and this program reads version"
            f" {results.SCHEMA_VERSION}; allowed: a report by the program that wrote them"
        )
    return meta


def _metrics_of(meta: Mapping[str, Any]) -> Sequence[str]:
    """Columns that were asked for; all of them in results that do not say."""
    found = json.loads(meta.get("metrics") or "[]")
    if not isinstance(found, list) or not all(isinstance(name, str) for name in found):
        raise ValueError("metrics are not a list of names")
    return found or NAMES


def _is_limited(meta: Mapping[str, Any]) -> bool:
    """Whether anything but its trials may have ended a run."""
    return any(json.loads(meta.get(name) or "null") is not None for name in ("stop", "steps"))


def _command_of(path: Path, meta: Mapping[str, Any]) -> str:
    """What made the results, as far as the table says."""
    seeds = json.loads(meta.get("seeds") or "[]")
    counted = ["--seeds", str(len(seeds))] if seeds == list(range(len(seeds))) and seeds else []
    source = str(meta.get("source") or "")
    if not source:
        # An experiment of the page has no file, and a name alone does not say where its file is.
        name = str(meta.get("name") or "")
        source = name if name in experiments.shipped() else str(path / "experiment.yaml")
    return shlex.join(["pounce", "experiment", source, *counted, "--out", str(path)])


def _row(folder: Path, row: sqlite3.Row, limited: bool) -> RunRow:
    failed = row["status"] != "done"
    return RunRow(
        folder=folder,
        key=str(row["key"]),
        variant=str(row["variant"] or ""),
        preset=Path(str(row["preset"])).stem,
        overrides=_mapping(row["overrides"]),
        settings=_mapping(row["settings"]),
        limited=limited,
        seed=int(row["seed"]),
        error=str(row["error"] or row["status"]) if failed else "",
        version=str(row["version"] or ""),
        digest=str(row["digest"] or ""),
        trials=int(row["trials"] or 0),
        steps=int(row["steps"] or 0),
        scalars={metric.column: _float(row[metric.column]) for metric in METRICS},
        milestones={name: None if row[name] is None else float(row[name]) for name in MILESTONES},
    )


def _mapping(text: str) -> dict[str, Any]:
    found = json.loads(text)
    if not isinstance(found, dict):
        raise ValueError("settings are not a mapping")
    return found


def _float(value: Any) -> float:
    return math.nan if value is None else float(value)


def groups_of(rows: Iterable[RunRow]) -> list[Group]:
    """Runs that are over, together with those of the same variant and settings.

    Where some may have ended early, they are no runs of the same as those that may not. Variants
    of several folders that only share a label are told apart by their folders.
    """
    found: dict[str, Group] = {}
    for run in rows:
        if not run.error:
            settings = {**run.settings, "description": ""}
            parts = [run.variant, run.preset, run.overrides, settings, run.limited]
            key = json.dumps(parts, sort_keys=True)
            label = run.variant or _label(run.preset, run.overrides)
            found.setdefault(key, Group(label, run.preset, run.overrides)).runs.append(run)
    groups = list(found.values())
    _tell_apart(groups)
    return groups


def _tell_apart(groups: Iterable[Group]) -> None:
    """Put the names of their folders before labels that variants of several folders share."""
    by_label: dict[str, list[Group]] = {}
    for group in groups:
        by_label.setdefault(group.label, []).append(group)
    for label, alike in by_label.items():
        folders = [tuple(dict.fromkeys(run.folder for run in group.runs)) for group in alike]
        if len(set(folders)) > 1:
            names = folder_names(folder for several in folders for folder in several)
            for group, several in zip(alike, folders, strict=True):
                group.label = f"{', '.join(names[folder] for folder in several)}: {label}"


def folder_names(folders: Iterable[Path]) -> dict[Path, str]:
    """Names of folders; the whole path of those whose names are alike."""
    names = {folder: folder.resolve().name for folder in folders}
    counts = Counter(names.values())
    return {path: name if counts[name] == 1 else str(path) for path, name in names.items()}


def in_short(groups: Sequence[Group]) -> tuple[Sequence[Group], str]:
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


def _label(preset: str, overrides: Mapping[str, Any]) -> str:
    return ", ".join([preset, *(f"{key}={shown_value(v)}" for key, v in overrides.items())])


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

    reward: np.ndarray
    """(trial,) float64."""
    steps: np.ndarray
    """(trial,) int64: that each trial took."""
    pictures: Pictures | None
    """None in results that keep none."""


Measure = Callable[[RunRow, Log], Mapping[str, float]]
"""Names and values of the quantities that are kept of a log."""


@dataclass(frozen=True)
class Widths:
    """Windows of the learning curves."""

    steps: int
    trials: int

    def of(self, axis: Axis) -> int:
        """The width of a window on an axis."""
        return self.steps if axis == "steps" else self.trials


def widths_of(rows: Iterable[RunRow]) -> Widths:
    """Round widths of windows that suit the longest of the runs that are over."""
    runs = [run for run in rows if not run.error]
    steps = max((run.steps for run in runs), default=1)
    trials = max((run.trials for run in runs), default=1)
    return Widths(
        statistics.window_width(steps, measures.CURVE_WINDOW_STEPS),
        statistics.window_width(trials, _WIDEST_TRIALS),
    )


@dataclass(frozen=True)
class Trace:
    """What is kept of a run's log, which is a thousand times as large."""

    seed: int
    curves: Mapping[Axis, np.ndarray]
    """(window,) float64 each: mean reward per trial, NaN where no trial ended."""
    quantities: Mapping[str, float]
    introductions: Mapping[str, tuple[int, int]]
    """Trial and step of each skill that joined after the start."""
    pictures: Pictures | None
    """None in results that keep none."""


def trace_of(run: RunRow, widths: Widths, measure: Measure) -> Trace:
    """Read the log of a run.

    Raises:
        OSError, ValueError, KeyError, zipfile.BadZipFile: it is missing or damaged.
    """
    with np.load(run.folder / "arrays" / f"{run.key}.npz") as arrays:
        outcome, steps, joined = log_in(arrays)
        pictures = None
        if "moments" in arrays:
            pictures = Pictures(arrays["moments"], arrays["value_share"], arrays["value_distance"])
    world = WorldSpec.model_validate(run.settings["world"])
    if outcome.shape != steps.shape or not outcome.size:
        raise ValueError("its arrays do not fit together")
    if pictures is not None:
        shape = (*pictures.moments.shape, world.n_distances, world.n_directions)
        if {pictures.share.shape, pictures.distance.shape} != {shape}:
            raise ValueError("its pictures of the value do not fit its world")
    reward = measures.rewards(world, outcome)
    curves: dict[Axis, np.ndarray] = {
        axis: statistics.windowed(reward, steps, widths.of(axis), axis) for axis in AXES
    }
    quantities = measure(run, Log(reward, steps, pictures))
    return Trace(run.seed, curves, quantities, joined, pictures)


@dataclass
class Reader:
    """Reads logs, each once, and notes those that cannot be read."""

    widths: Widths
    measure: Measure
    folders: Mapping[Path, str] = field(default_factory=dict)
    """Names of folders, to tell their runs apart; empty where there is but one."""
    unreadable: dict[str, str] = field(default_factory=dict)
    """By name of the run: why its log cannot be read."""
    _traces: dict[tuple[Path, str], Trace | None] = field(default_factory=dict)

    def traces(self, runs: Iterable[RunRow]) -> list[Trace]:
        """What is kept of the logs of runs, without those that cannot be read."""
        found = (self._trace(run) for run in runs)
        return [trace for trace in found if trace is not None]

    def name_of(self, run: RunRow) -> str:
        """What a run is called where it is left out."""
        name = f"{run.variant or run.preset}, seed {run.seed}"
        return f"{self.folders[run.folder]}: {name}" if run.folder in self.folders else name

    def _trace(self, run: RunRow) -> Trace | None:
        place = run.folder, run.key
        if place not in self._traces:
            try:
                self._traces[place] = trace_of(run, self.widths, self.measure)
            except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
                self._traces[place] = None
                self.unreadable[self.name_of(run)] = f"its log cannot be read: {error}"
        return self._traces[place]
