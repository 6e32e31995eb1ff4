"""A report of results: one page that stands for itself, and its pictures as files.

What a page shows follows from what was run. Runs of the thesis's learners in its worlds give its
figures and a verdict on each of its findings; settings that were swept give maps and points; any
other variants give curves, and are set against the first of them.
"""

import contextlib
import html
import json
import math
import os
import re
import shlex
import sqlite3
import tempfile
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from app import experiments, presets, statistics
from app.figures import (
    THESIS_STYLES,
    Axle,
    Dot,
    Drawing,
    Line,
    Mark,
    Panel,
    Series,
    draw_curves,
    draw_dots,
    draw_plane,
    draw_points,
    shown_estimate,
    shown_value,
    style_of,
)
from app.statistics import Axis, Contrast, Estimate
from learners import measures
from sim.spec import WorldSpec

SCHEMA_VERSION = 1
PAGE_NAME = "report.html"
LEAST_SEEDS = 5
"""Runs below which no finding is decided."""
WIDE = 15.0
"""Reward per trial: a tenth of the range from flight to capture."""

_BOOTSTRAP_SEED = 20
_MOST_LINES = 8
_MOST_ROWS = 60
_MOST_OPEN_ROWS = 16
_LEAST_FOR_QUARTILES = 4
_WINDOW_STEPS = 500_000
_FINAL = "last 2,000 trials"
_CURVE_AXES: tuple[Axis, ...] = ("steps", "trials")
_TRIALS_WINDOW = 1_000


class ReportError(Exception):
    """There is nothing to report on, or nowhere to write to; the message says why."""


# --- Results as they lie on disk -----------------------------------------------------------------


class Metric(NamedTuple):
    """A number that the table of results holds for each run."""

    column: str
    title: str
    unit: str = ""

    @property
    def label(self) -> str:
        return f"{self.title} ({self.unit})" if self.unit else self.title


FINAL_REWARD = Metric("final_reward", "final reward", "mean per trial, last 2,000 trials")
AREA = Metric("area", "area under the curve", "mean reward per trial over all steps")
METRICS = (
    FINAL_REWARD,
    Metric("final_success", "final success as learned", "share of captures, last 2,000 trials"),
    Metric("greedy_success", "greedy success", "share of captures"),
    AREA,
    Metric("captures", "captures"),
    Metric("flights", "flights"),
    Metric("timeouts", "time-outs"),
    Metric("mean_hunt_length", "mean hunt", "steps"),
    Metric("switches_per_step", "option switches", "per step"),
)
_PERFORMANCE = {"final_reward", "final_success", "greedy_success", "area"}
_ENDINGS = {"captures", "flights", "timeouts"}
_BEHAVIOUR = {"mean_hunt_length", "switches_per_step"}
_MILESTONES = {"steps_to_50": "50 %", "steps_to_70": "70 %"}
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
    *_MILESTONES,
)


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
        return json.dumps([self.preset, settings, self.seed], sort_keys=True)


@dataclass(frozen=True)
class Folder:
    """A folder of results."""

    path: Path
    rows: Sequence[RunRow]
    command: str
    """That made the results."""


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
        return [run.scalars[column] for run in self.runs]


def read_folder(path: Path) -> Folder:
    """Read the table of results in a folder.

    Raises:
        ReportError: it is missing, of another version, or damaged.
    """
    shown = repr(str(path))
    if not path.is_dir():
        raise ReportError(f"{shown} is no folder; allowed: one that pounce experiment has written")
    file = path / "results.sqlite"
    if not file.is_file():
        raise ReportError(f"{shown} holds no results: there is no results.sqlite in it")
    try:
        with contextlib.closing(
            sqlite3.connect(f"{file.resolve().as_uri()}?mode=ro", uri=True)
        ) as db:
            db.row_factory = sqlite3.Row
            meta = _meta_of(db, shown)
            found = db.execute(f"SELECT {', '.join(_COLUMNS)} FROM runs ORDER BY rowid").fetchall()
        rows = _in_order(path, [_row(path, row) for row in found])
    except (sqlite3.Error, ValueError, TypeError) as error:
        raise ReportError(f"{shown} holds a damaged results.sqlite: {error}") from error
    return Folder(path, rows, _command_of(path, meta))


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
    if str(version) != str(SCHEMA_VERSION):
        raise ReportError(
            f"{shown} holds results of version {version}, and this program reads version"
            f" {SCHEMA_VERSION}; allowed: a report by the program that wrote them"
        )
    return meta


def _command_of(path: Path, meta: Mapping[str, Any]) -> str:
    """What made the results, as far as the table says."""
    seeds = json.loads(meta.get("seeds") or "[]")
    counted = ["--seeds", str(len(seeds))] if seeds == list(range(len(seeds))) and seeds else []
    name = str(meta.get("name") or path / "experiment.yaml")
    return shlex.join(["pounce", "experiment", name, *counted, "--out", str(path)])


def _row(folder: Path, row: sqlite3.Row) -> RunRow:
    failed = row["status"] != "done"
    return RunRow(
        folder=folder,
        key=str(row["key"]),
        variant=str(row["variant"] or ""),
        preset=Path(str(row["preset"])).stem,
        overrides=_mapping(row["overrides"]),
        settings=_mapping(row["settings"]),
        seed=int(row["seed"]),
        error=str(row["error"] or row["status"]) if failed else "",
        version=str(row["version"] or ""),
        digest=str(row["digest"] or ""),
        trials=int(row["trials"] or 0),
        steps=int(row["steps"] or 0),
        scalars={metric.column: _float(row[metric.column]) for metric in METRICS},
        milestones={name: None if row[name] is None else float(row[name]) for name in _MILESTONES},
    )


def _mapping(text: str) -> dict[str, Any]:
    found = json.loads(text)
    if not isinstance(found, dict):
        raise ValueError("settings are not a mapping")
    return found


def _float(value: Any) -> float:
    return math.nan if value is None else float(value)


# --- What a run's log says -----------------------------------------------------------------------


@dataclass(frozen=True)
class Widths:
    """Windows of the learning curves."""

    steps: int
    trials: int

    def of(self, axis: Axis) -> int:
        return self.steps if axis == "steps" else self.trials


@dataclass(frozen=True)
class Trace:
    """What is kept of a run's log, which is a thousand times as large."""

    seed: int
    curves: Mapping[Axis, np.ndarray]
    quantities: Mapping[str, float]
    introductions: Mapping[str, tuple[int, int]]
    """Trial and step of each skill that joined after the start."""


def trace_of(run: RunRow, widths: Widths) -> Trace:
    """Read the log of a run.

    Raises:
        OSError, ValueError, KeyError, zipfile.BadZipFile: it is missing or damaged.
    """
    with np.load(run.folder / "arrays" / f"{run.key}.npz") as arrays:
        outcome, steps = arrays["outcome"], arrays["steps"].astype(np.int64)
        moments = arrays["introductions"].reshape(-1, 2).tolist()
        names = arrays["introduced"].tolist()
    if outcome.shape != steps.shape or not outcome.size:
        raise ValueError("its arrays do not fit together")
    reward = measures.rewards(WorldSpec.model_validate(run.settings["world"]), outcome)
    curves: dict[Axis, np.ndarray] = {
        axis: statistics.windowed(reward, steps, widths.of(axis), axis) for axis in _CURVE_AXES
    }
    joined = {
        name: (trial, step) for name, (trial, step) in zip(names, moments, strict=True) if trial > 0
    }
    return Trace(run.seed, curves, quantities_of(run, reward, steps), joined)


def quantities_of(run: RunRow, reward: np.ndarray, steps: np.ndarray) -> dict[str, float]:
    """Mean rewards that the findings speak of; those the run did not get to are not there."""
    ends = np.cumsum(steps, dtype=np.int64)
    found = {
        name: _mean(reward[(ends > first) & (ends <= last)])
        for name, (first, last) in _windows().items()
        if ends[-1] >= last
    }
    if reward.size == run.settings["trials"]:
        found[_FINAL] = _mean(reward[-measures.FINAL_TRIALS :])
    for name, (first, last) in _phases(run.settings).items():
        if reward.size >= last > first:
            found[name] = _mean(reward[first:last])
    return found


def _mean(values: np.ndarray) -> float:
    return float(values.mean()) if values.size else math.nan


@cache
def _windows() -> dict[str, tuple[int, int]]:
    """Windows by name, each with the steps before which and with which it ends."""
    half = {
        f"{k / 2:g}–{(k + 1) / 2:g} M": (k * _WINDOW_STEPS, (k + 1) * _WINDOW_STEPS)
        for k in (0, 1, 2, 3, 7)
    }
    return {**half, "0–1 M": (0, 1_000_000), "1–2 M": (1_000_000, 2_000_000)}


_TABLE_WINDOWS = ("0–0.5 M", "0.5–1 M", "1–1.5 M", "1.5–2 M", "3.5–4 M", _FINAL)


def _phases(settings: Mapping[str, Any]) -> dict[str, tuple[int, int]]:
    """Phases of the timed schedule by name, each with its first trial and the one after it."""
    schedule = settings.get("schedule", {})
    starts = {skill: timer["at"] for skill, timer in schedule.get("skills", {}).items()}
    length = {e["skill"]: e["duration"] for e in schedule.get("episodes", ())}
    circle, avoid = starts.get("circle_clockwise", 0), starts.get("avoid", 0)
    if not 0 < circle < avoid or not {"circle_clockwise", "avoid"} <= set(length):
        return {}
    circled, avoided = circle + length["circle_clockwise"], avoid + length["avoid"]
    return {
        "before circle": (max(circle - 2_000, 0), circle),
        "circle explored": (circle, circled),
        "circle mastered": (circled, avoid),
        "avoid explored": (avoid, avoided),
        "avoid mastered": (avoided, avoided + 3_500),
    }


# --- The thesis's experiments --------------------------------------------------------------------

WORLDS: Mapping[str, tuple[int, int, int]] = {
    "120": (120, 24, 18),
    "60": (60, 24, 18),
    "150": (150, 24, 18),
    "16×11": (120, 16, 11),
    "8×6": (120, 8, 6),
}
"""Size, directions and distances."""
_WORLD_TITLES = {
    "120": "grid 120 × 120, sensors 24 × 18",
    "60": "grid 60 × 60, sensors 24 × 18",
    "150": "grid 150 × 150, sensors 24 × 18",
    "16×11": "grid 120 × 120, sensors 16 × 11",
    "8×6": "grid 120 × 120, sensors 8 × 6",
}
_FIGURES: Mapping[str, tuple[str, Sequence[str]]] = {
    "figure_4_1": ("Figure 4.1: performance in the standard environment", ("120",)),
    "figure_4_2": ("Figure 4.2: scaling with environment size", ("60", "120", "150")),
    "figure_4_3": ("Figure 4.3: scaling with state resolution", ("120", "16×11", "8×6")),
}
_LEARNER_TITLES = {
    "timed": "timed hierarchical Q, 3 skills",
    "hierarchical_3": "hierarchical Q, 3 skills",
    "standard_q": "standard Q",
    "hierarchical_2": "hierarchical Q, 2 skills",
}

Place = tuple[str, str]
"""A world and a learner of the thesis."""


@cache
def _shipped(preset: str) -> dict[str, Any]:
    return presets.load(preset).model_dump(mode="json")


def place_of(run: RunRow) -> Place | None:
    """Where in the thesis's experiments a run belongs, if it is one of them."""
    if run.preset not in THESIS_STYLES:
        return None
    shipped = _shipped(run.preset)
    if any(run.settings.get(key) != shipped[key] for key in ("learner", "schedule", "trials")):
        return None
    world = dict(run.settings.get("world", {}))
    for name, (size, directions, distances) in WORLDS.items():
        changes = {"size": size, "n_directions": directions, "n_distances": distances}
        if world == {**shipped["world"], **changes}:
            return name, run.preset
    return None


class Term(NamedTuple):
    """A quantity with a weight."""

    weight: float
    world: str
    learner: str
    quantity: str = _FINAL


class Finding(NamedTuple):
    """A statement of the thesis as a sum of quantities and a bound."""

    topic: str
    claim: str
    terms: Sequence[Term]
    bound: float
    within: bool = False
    """Whether the sum is to lie between the bound and its negative, and not above it."""

    @property
    def condition(self) -> str:
        return f"between ±{self.bound:g}" if self.within else f"above {self.bound:g}"


def _ahead(
    topic: str, claim: str, larger: Term, smaller: Term, bound: float = 0, within: bool = False
) -> Finding:
    return Finding(topic, claim, (larger, smaller._replace(weight=-1)), bound, within)


def _at(world: str, learner: str, quantity: str = _FINAL) -> Term:
    return Term(1, world, learner, quantity)


def _lead(learner: str, wide: str, narrow: str) -> tuple[Term, ...]:
    """How much timed's lead over a learner grows from one world to another."""
    return (
        Term(1, wide, "timed"),
        Term(-1, wide, learner),
        Term(-1, narrow, "timed"),
        Term(1, narrow, learner),
    )


_STANDARD, _SIZE, _RESOLUTION = "Standard world (4.3.1)", "Size (4.3.2)", "Resolution (4.3.3)"
_OTHER_LEARNERS = {"standard_q": "standard Q", "hierarchical_3": "three skills from the start"}

FINDINGS: Sequence[Finding] = (
    *(
        _ahead(
            _STANDARD,
            f"timed ends above {name} by a wide margin",
            _at("120", "timed"),
            _at("120", other),
            WIDE,
        )
        for other, name in _OTHER_LEARNERS.items()
    ),
    *(
        _ahead(
            _STANDARD,
            f"timed learns a good deal faster than {name}: from 1.5 to 2 M steps",
            _at("120", "timed", "1.5–2 M"),
            _at("120", other, "1.5–2 M"),
            WIDE,
        )
        for other, name in _OTHER_LEARNERS.items()
    ),
    *(
        _ahead(
            _STANDARD,
            f"two skills are fast: ahead of {name} from 0.5 to 1 M steps",
            _at("120", "hierarchical_2", "0.5–1 M"),
            _at("120", other, "0.5–1 M"),
            WIDE,
        )
        for other, name in _OTHER_LEARNERS.items()
    ),
    _ahead(
        _STANDARD,
        "two skills stop: they end close to where they are from 0.5 to 1 M steps",
        _at("120", "hierarchical_2"),
        _at("120", "hierarchical_2", "0.5–1 M"),
        WIDE,
        within=True,
    ),
    _ahead(
        _STANDARD,
        "two skills stop low: they end below timed",
        _at("120", "timed"),
        _at("120", "hierarchical_2"),
        WIDE,
    ),
    *(
        _ahead(_STANDARD, claim, _at("120", "timed", larger), _at("120", "timed", smaller))
        for claim, larger, smaller in (
            ("timed dips when circle comes in", "before circle", "circle explored"),
            ("timed recovers from circle", "circle mastered", "before circle"),
            ("timed dips when avoid comes in", "circle mastered", "avoid explored"),
            ("timed recovers from avoid", "avoid mastered", "avoid explored"),
        )
    ),
    *(
        _ahead(
            _SIZE,
            f"at 60 the full learners end close together: {claim}",
            _at("60", larger),
            _at("60", smaller),
            WIDE,
            within=True,
        )
        for claim, larger, smaller in (
            ("standard Q and timed", "standard_q", "timed"),
            ("timed and three skills from the start", "timed", "hierarchical_3"),
            ("standard Q and three skills from the start", "standard_q", "hierarchical_3"),
        )
    ),
    *(
        _ahead(
            _SIZE,
            f"at 60 standard Q is ahead of timed early: from {window.replace('–', ' to ')} steps",
            _at("60", "standard_q", window),
            _at("60", "timed", window),
        )
        for window in ("0–1 M", "1–2 M")
    ),
    *(
        Finding(
            _SIZE,
            f"timed's lead over {name} grows from {narrow} to {wide}",
            _lead(other, wide, narrow),
            0,
        )
        for narrow, wide in (("60", "120"), ("120", "150"))
        for other, name in _OTHER_LEARNERS.items()
    ),
    *(
        _ahead(
            _RESOLUTION,
            f"lower resolution breaks standard Q: it ends lower by a wide margin at {world}",
            _at("120", "standard_q"),
            _at(world, "standard_q"),
            WIDE,
        )
        for world in ("16×11", "8×6")
    ),
    *(
        _ahead(
            _RESOLUTION,
            f"lower resolution hurts three skills from the start: they end lower at {world}",
            _at("120", "hierarchical_3"),
            _at(world, "hierarchical_3"),
        )
        for world in ("16×11", "8×6")
    ),
    *(
        _ahead(
            _RESOLUTION,
            f"lower resolution leaves timed working: it ends close to 24×18 at {world}",
            _at("120", "timed"),
            _at(world, "timed"),
            WIDE,
            within=True,
        )
        for world in ("16×11", "8×6")
    ),
    *(
        _ahead(
            _RESOLUTION,
            f"timed ends above {name} by a wide margin at {world}",
            _at(world, "timed"),
            _at(world, other),
            WIDE,
        )
        for world in ("16×11", "8×6")
        for other, name in _OTHER_LEARNERS.items()
    ),
)

HOLDS, FAILS, UNDECIDED = "holds", "does not hold", "undecided"


def verdict(finding: Finding, effect: Estimate) -> str:
    """Whether an effect bears a finding out: only where the whole interval says the same."""
    if effect.n < LEAST_SEEDS:
        return UNDECIDED
    low, high, bound = effect.low, effect.high, finding.bound
    if finding.within:
        if -bound < low and high < bound:
            return HOLDS
        return FAILS if low > bound or high < -bound else UNDECIDED
    if low > bound:
        return HOLDS
    return FAILS if high < bound else UNDECIDED


# --- A page in the making ------------------------------------------------------------------------


class Markup(str):
    """A text that is markup already, and is not to be escaped again."""


def _escaped(text: object) -> Markup:
    if isinstance(text, Markup):
        return text
    # Control characters and halves of characters have no place in a page, however written.
    plain = re.sub("[^\t\n\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "\ufffd", str(text))
    return Markup(html.escape(plain))


def _element(tag: str, content: object, **attributes: str) -> Markup:
    shown = "".join(f' {key.rstrip("_")}="{_escaped(v)}"' for key, v in attributes.items())
    return Markup(f"<{tag}{shown}>{_escaped(content)}</{tag}>")


def _joined(parts: Iterable[object], between: str = "\n") -> Markup:
    return Markup(between.join(_escaped(part) for part in parts))


def _table(header: Sequence[object], rows: Iterable[Sequence[object]]) -> Markup:
    """A table whose first column names the rows."""
    head = _element("tr", _joined((_element("th", cell, scope="col") for cell in header), ""))
    lines = [
        _element(
            "tr",
            _joined(
                [_element("th", row[0], scope="row"), *(_element("td", cell) for cell in row[1:])],
                "",
            ),
        )
        for row in rows
    ]
    table = _element("table", _joined([_element("thead", head), _element("tbody", _joined(lines))]))
    return _element("div", table, class_="scroll")


def _details(summary: str, content: object) -> Markup:
    return _element("details", _joined([_element("summary", summary), content]))


@dataclass
class Page:
    """What a report says, and the pictures it has so far."""

    commands: Sequence[str]
    figures: str
    """Name of the folder of pictures, as the page calls it."""
    sections: list[Markup] = field(default_factory=list)
    drawings: dict[str, Drawing] = field(default_factory=dict)

    def say(self, title: str, *parts: object) -> None:
        """Add a section."""
        self.sections.append(_element("section", _joined([_element("h2", title), *parts])))

    def small_print(self, *notes: str) -> str:
        return "\n".join([*notes, f"Made by: {' && '.join(self.commands)}"])

    def picture(self, name: str, caption: str, drawing: Drawing) -> Markup:
        """Keep a picture, and return it as it stands in the page."""
        self.drawings[name] = drawing
        files = ", ".join(f"{self.figures}/{name}.{kind}" for kind in ("svg", "png", "csv"))
        text = _joined([caption, _element("span", f"Files: {files}", class_="files")], " ")
        svg = drawing.svg.replace("<svg ", f'<svg role="img" aria-label="{_escaped(caption)}" ', 1)
        return _element("figure", _joined([Markup(svg), _element("figcaption", text)]))


_STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #1b1b1b; background: #fff;
  max-width: 76rem; margin: 2rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin-bottom: .3rem; }
h2 { font-size: 1.2rem; margin: 2.4rem 0 .6rem; border-bottom: 1px solid #ccc; }
p { max-width: 50rem; }
figure { margin: 1.2rem 0; } figure svg { max-width: 100%; height: auto; }
figcaption { color: #333; max-width: 50rem; } .files { color: #666; font-size: .8em; }
.scroll { overflow-x: auto; margin: .8rem 0; }
table { border-collapse: collapse; font-size: .86rem; font-variant-numeric: tabular-nums; }
th, td { padding: .28rem .6rem .28rem 0; border-bottom: 1px solid #e2e2e2; text-align: left;
  vertical-align: top; }
thead th { border-bottom: 1px solid #555; } th { font-weight: 600; }
tbody th { font-weight: 400; min-width: 11rem; } td { white-space: nowrap; }
.holds { color: #00603f; font-weight: 600; } .fails { color: #9c2b00; font-weight: 600; }
.undecided { color: #555; font-style: italic; } .minor { color: #666; }
code { font-size: .9em; overflow-wrap: anywhere; } summary { cursor: pointer; margin: .6rem 0; }
@media print { body { margin: 0; max-width: none; } section { break-inside: auto; } }
"""


def _document(title: str, page: Page) -> str:
    head = _joined(
        [
            Markup('<meta charset="utf-8"/>'),
            Markup('<meta name="viewport" content="width=device-width, initial-scale=1"/>'),
            _element("title", title),
            _element("style", Markup(_STYLE)),
        ]
    )
    body = _joined([_element("h1", title), *page.sections])
    content = _joined([_element("head", head), _element("body", _element("main", body))])
    return f"<!DOCTYPE html>\n{_element('html', content, lang='en')}\n"


# --- Groups and their curves ---------------------------------------------------------------------


def _rng() -> np.random.Generator:
    """A generator for one interval, so that no interval depends on which came before it."""
    return np.random.default_rng(_BOOTSTRAP_SEED)


def groups_of(rows: Iterable[RunRow]) -> list[Group]:
    """Runs that are over, together with those of the same variant and settings."""
    found: dict[str, Group] = {}
    for run in rows:
        if not run.error:
            key = json.dumps([run.variant, run.preset, run.overrides], sort_keys=True)
            label = run.variant or _label(run.preset, run.overrides)
            found.setdefault(key, Group(label, run.preset, run.overrides)).runs.append(run)
    return list(found.values())


def _label(preset: str, overrides: Mapping[str, Any]) -> str:
    return ", ".join([preset, *(f"{key}={shown_value(v)}" for key, v in overrides.items())])


@dataclass
class Reader:
    """Reads logs, each once, and notes those that cannot be read."""

    widths: Widths
    unreadable: dict[str, str] = field(default_factory=dict)
    _traces: dict[tuple[Path, str], Trace | None] = field(default_factory=dict)

    def traces(self, runs: Iterable[RunRow]) -> list[Trace]:
        found = (self._trace(run) for run in runs)
        return [trace for trace in found if trace is not None]

    def _trace(self, run: RunRow) -> Trace | None:
        place = run.folder, run.key
        if place not in self._traces:
            try:
                self._traces[place] = trace_of(run, self.widths)
            except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
                self._traces[place] = None
                name = f"{run.variant or run.preset}, seed {run.seed}"
                self.unreadable[name] = f"its log cannot be read: {error}"
        return self._traces[place]

    def line(self, label: str, runs: Iterable[RunRow], axis: Axis, style: Any) -> Line:
        traces = self.traces(runs)
        curves = [trace.curves[axis] for trace in traces]
        found = statistics.band(curves, self.widths.of(axis), _rng())
        return Line(label, found, style, len(traces), _marks(traces, axis))


def _widths(rows: Iterable[RunRow]) -> Widths:
    runs = [run for run in rows if not run.error]
    steps = max((run.steps for run in runs), default=1)
    trials = max((run.trials for run in runs), default=1)
    return Widths(
        statistics.window_width(steps, measures.CURVE_WINDOW_STEPS),
        statistics.window_width(trials, _TRIALS_WINDOW),
    )


def _marks(traces: Sequence[Trace], axis: Axis) -> list[Mark]:
    """Introductions that all runs have come to, at the median over the runs."""
    column = 1 if axis == "steps" else 0
    names = dict.fromkeys(name for trace in traces for name in trace.introductions)
    marks = []
    for name in names:
        moments = [t.introductions[name][column] for t in traces if name in t.introductions]
        if len(moments) == len(traces):
            marks.append(Mark(float(np.median(moments)), name.replace("_", " ")))
    return marks


def _curve_notes(widths: Widths, axis: Axis) -> str:
    share = f"{statistics.LEAST_SHARE:.0%}".replace("%", " %")
    return (
        f"Mean reward per trial in windows of {widths.of(axis):,} {axis}; n runs (seeds) each;"
        " shaded: 95 % bootstrap interval over runs, point by point. Dashed marks:"
        " introductions of skills (median over runs). Faint: some runs have ended, and the mean is"
        " over those that go on, which may not be typical; where fewer than"
        f" {share} do, the curve ends."
    )


def _curve_pictures(
    page: Page, reader: Reader, name: str, caption: str, panels: Callable[[Axis], Sequence[Panel]]
) -> Markup:
    """A picture against steps, and the same against trials to be opened."""
    by_steps, by_trials = (
        page.picture(
            name if axis == "steps" else f"{name}_trials",
            caption if axis == "steps" else f"{caption}, against trials",
            draw_curves(
                name if axis == "steps" else f"{name}_trials",
                panels(axis),
                axis,
                page.small_print(_curve_notes(reader.widths, axis)),
            ),
        )
        for axis in _CURVE_AXES
    )
    return _joined([by_steps, _details("The same against trials", by_trials)])


# --- Sections: the thesis ------------------------------------------------------------------------

Placed = Mapping[Place, Sequence[RunRow]]


def _placed(groups: Iterable[Group]) -> dict[Place, list[RunRow]]:
    found: dict[Place, list[RunRow]] = {}
    seen: set[tuple[Place, int]] = set()
    for group in groups:
        for run in group.runs:
            place = place_of(run)
            # The standard world is in all three experiments, with the same seeds.
            if place is not None and (place, run.seed) not in seen:
                seen.add((place, run.seed))
                found.setdefault(place, []).append(run)
    return found


def _thesis_figures(page: Page, reader: Reader, placed: Placed) -> None:
    for name, (title, worlds) in _FIGURES.items():
        here = [world for world in worlds if any(place[0] == world for place in placed)]
        if not here or (len(worlds) > 1 and len(here) < 2):
            continue

        def panels(axis: Axis, here: Sequence[str] = here) -> list[Panel]:
            return [_thesis_panel(reader, placed, world, axis) for world in here]

        page.say(title, _curve_pictures(page, reader, name, title, panels))


def _thesis_panel(reader: Reader, placed: Placed, world: str, axis: Axis) -> Panel:
    lines = [
        reader.line(_LEARNER_TITLES[learner], placed[world, learner], axis, style)
        for learner, style in THESIS_STYLES.items()
        if (world, learner) in placed
    ]
    return Panel(_WORLD_TITLES[world], lines)


def effect_of(finding: Finding, reader: Reader, placed: Placed) -> Contrast | None:
    """The sum that a finding speaks of; None where a part of it was not run."""
    terms = []
    for weight, world, learner, quantity in finding.terms:
        traces = reader.traces(placed.get((world, learner), ()))
        values = {t.seed: t.quantities[quantity] for t in traces if quantity in t.quantities}
        if not values:
            return None
        terms.append((weight, values))
    return statistics.contrast(terms, _rng())


_CLASSES = {HOLDS: "holds", FAILS: "fails", UNDECIDED: "undecided"}


def _finding_row(finding: Finding, effect: Contrast) -> Sequence[object]:
    found = verdict(finding, effect.estimate)
    words = f"{found} at {effect.estimate.n} seed{'s' if effect.estimate.n != 1 else ''}"
    return (
        finding.claim,
        finding.topic,
        finding.condition,
        shown_estimate(effect.estimate, ".1f"),
        "by seed" if effect.paired else "no",
        _element("span", words, class_=_CLASSES[found]),
    )


def _minor(text: str) -> Markup:
    return _element("span", text, class_="minor")


def _findings(page: Page, reader: Reader, placed: Placed) -> None:
    effects = [(finding, effect_of(finding, reader, placed)) for finding in FINDINGS]
    rows = [_finding_row(finding, effect) for finding, effect in effects if effect is not None]
    absent = [(f.topic, f.claim) for f, effect in effects if effect is None]
    rule = (
        "Each finding is a difference of mean rewards per trial and a condition on it. A wide"
        f" margin is {WIDE:g}, a tenth of the range from a flight (\N{MINUS SIGN}50) to a capture"
        " (100); two learners are close if they differ by less than that. A finding holds if the"
        " whole 95 % interval of the difference meets the condition, does not hold if none of it"
        f" does, and is undecided otherwise, and whenever there are fewer than {LEAST_SEEDS} seeds,"
        " where no bootstrap interval is wide enough. Differences are of runs of the same seed,"
        f" where seeds are shared. The intervals are not corrected for there being {len(rows)}."
    )
    values = (
        "How value spreads, the thesis's last finding in the standard world, shows in the tables of"
        " a run, which results do not keep. python -m tests.test_findings measures it: first a cone"
        " behind the prey, then counter-clockwise a ring, then inwards into the visual field."
    )
    header = ("finding", "part", "condition", "difference [95 %]", "paired", "verdict")
    parts = [_element("p", rule), _table(header, rows)] if rows else []
    if absent:
        table = _table(("part", "finding"), absent)
        parts.append(
            _details(f"{len(absent)} findings whose worlds or learners were not run", table)
        )
    page.say("Findings", *parts, _element("p", values, class_="minor"))


def _window_means(page: Page, reader: Reader, placed: Placed) -> None:
    rows = []
    for world in WORLDS:
        for learner in THESIS_STYLES:
            traces = reader.traces(placed.get((world, learner), ()))
            if traces:
                cells = [_window_cell(traces, window) for window in _TABLE_WINDOWS]
                rows.append((f"{world}: {learner}", len(traces), *cells))
    text = (
        "Mean reward per trial over the trials that ended in a window of simulation steps, with"
        " 95 % intervals over runs. A run counts in the windows that it went through wholly; where"
        " not all did, the number that did follows. Worlds go by what is not standard in them: the"
        " size of the grid, or directions × distances of the sensors."
    )
    page.say(
        "Means over windows of steps",
        _element("p", text),
        _table(("world and learner", "n", *_TABLE_WINDOWS), rows),
    )


def _window_cell(traces: Sequence[Trace], window: str) -> str:
    values = [trace.quantities.get(window, math.nan) for trace in traces]
    found = statistics.mean(values, _rng())
    fewer = f" ({found.n})" if 0 < found.n < len(traces) else ""
    return shown_estimate(found, ".1f") + fewer


# --- Sections: any experiment --------------------------------------------------------------------


def _curves(page: Page, reader: Reader, groups: Sequence[Group]) -> None:
    def panels(axis: Axis) -> list[Panel]:
        lines = [
            reader.line(group.label, group.runs, axis, style_of(index))
            for index, group in enumerate(groups)
        ]
        return [Panel("", _with_clear_marks(lines))]

    caption = "Reward of each variant"
    page.say("Learning curves", _curve_pictures(page, reader, "curves", caption, panels))


def _with_clear_marks(lines: Sequence[Line]) -> Sequence[Line]:
    """Lines without marks where theirs differ: it could not be seen which are whose."""
    if len({tuple(line.marks) for line in lines if line.marks}) <= 1:
        return lines
    return [line._replace(marks=()) for line in lines]


def _scalars(page: Page, groups: Sequence[Group]) -> None:
    there = {m.column for m in METRICS if any(map(math.isfinite, _all_values(groups, m)))}
    text = (
        "Mean over runs with its 95 % bootstrap interval; below it, from four runs on, the"
        " interquartile mean (IQM), which a few wild runs hardly move. Steps are medians, with a"
        " run that never got there counted as longer than any that did."
    )
    how_well, how, endings = (
        [metric for metric in METRICS if metric.column in names & there]
        for names in (_PERFORMANCE, _BEHAVIOUR, _ENDINGS)
    )
    shown = groups[:_MOST_ROWS]
    tables = _joined(
        [
            _scalar_table(shown, how_well, _scalar_cell, ()),
            _scalar_table(shown, how, _mean_cell, tuple(_MILESTONES)),
            _scalar_table(shown, endings, _mean_cell, ()),
            _left_out(len(groups)),
        ]
    )
    if len(groups) > _MOST_OPEN_ROWS:
        tables = _details(f"The scalars of {len(shown)} variants", tables)
    page.say("Scalars", _element("p", text), tables)


def _scalar_table(
    groups: Sequence[Group],
    metrics: Sequence[Metric],
    cell: Callable[[Sequence[float]], str],
    milestones: Sequence[str],
) -> Markup:
    titles = [f"steps to {_MILESTONES[column]} success" for column in milestones]
    header = ("variant", "n", *titles, *(metric.label for metric in metrics))
    rows = [
        (
            group.label,
            len(group.runs),
            *(_reached_cell(group, column) for column in milestones),
            *(cell(group.values(metric.column)) for metric in metrics),
        )
        for group in groups
    ]
    return _table(header, rows)


def _all_values(groups: Iterable[Group], metric: Metric) -> Iterable[float]:
    return (value for group in groups for value in group.values(metric.column))


def _left_out(n_groups: int) -> str | Markup:
    if n_groups <= _MOST_ROWS:
        return Markup()
    text = f"The first {_MOST_ROWS} of {n_groups} variants; results.sqlite has all of them."
    return _element("p", text, class_="minor")


def _mean_cell(values: Sequence[float]) -> str:
    return shown_estimate(statistics.mean(values, _rng()))


def _scalar_cell(values: Sequence[float]) -> Markup:
    middle = statistics.interquartile_mean(values, _rng())
    if middle.n < _LEAST_FOR_QUARTILES:
        return _escaped(_mean_cell(values))
    below = _minor(f"IQM {shown_estimate(middle)}")
    return _joined([_mean_cell(values), Markup("<br/>"), below], "")


def _reached_cell(group: Group, column: str) -> Markup:
    found = statistics.reached([run.milestones[column] for run in group.runs], _rng())
    median = found.median
    value, low, high = (_steps(value) for value in (median.value, median.low, median.high))
    interval = "" if math.isnan(median.low) or low == high else f" [{low}, {high}]"
    share = _minor(f"by {found.reached} of {median.n} runs")
    return _joined([f"{value}{interval}", Markup("<br/>"), share], "")


def _steps(value: float) -> str:
    if math.isinf(value):
        return "never"
    return f"{value / 1e6:.3g} M" if value >= 1e5 else f"{value:,.0f}"


class Sweep(NamedTuple):
    """Variants of one preset that differ in one or two settings."""

    axles: tuple[Axle, ...]
    groups: Mapping[tuple[int, ...], Group]
    """By the index of its value along each axle."""


def sweep_of(groups: Sequence[Group]) -> Sweep | None:
    """What was swept in the variants of a preset; None where it is nothing, or too much.

    Settings that move together count as one.
    """
    keys = set(groups[0].overrides)
    if len(groups) < 3 or any(set(group.overrides) != keys for group in groups):
        return None
    bundles = _bundles(groups)
    axles = tuple(_axle(bundle, groups) for bundle in bundles)
    if not 1 <= len(axles) <= 2:
        return None
    places = {
        tuple(
            axle.values.index(_bundle_value(bundle, group))
            for axle, bundle in zip(axles, bundles, strict=True)
        ): group
        for group in groups
    }
    return Sweep(axles, places) if len(places) == len(groups) else None


def _bundles(groups: Sequence[Group]) -> list[list[str]]:
    """Keys that vary, those together that always move together."""
    columns: dict[tuple[int, ...], list[str]] = {}
    for key in groups[0].overrides:
        values = [json.dumps(group.overrides[key], sort_keys=True) for group in groups]
        first = {value: index for index, value in reversed(list(enumerate(values)))}
        if len(first) > 1:
            columns.setdefault(tuple(first[value] for value in values), []).append(key)
    return list(columns.values())


def _bundle_name(bundle: Sequence[str], settings: Mapping[str, Any]) -> str:
    """Keys that move together, what they share said once; an episode with its skill."""
    if len(bundle) > 1:
        parts = [key.split(".") for key in bundle]
        differing = [k for k, column in enumerate(zip(*parts, strict=False)) if len({*column}) > 1]
        if len({len(part) for part in parts}) == 1 and len(differing) == 1:
            (place,) = differing
            inner = ", ".join(part[place] for part in parts)
            return ".".join([*parts[0][:place], f"{{{inner}}}", *parts[0][place + 1 :]])
        return ", ".join(bundle)
    episode = re.match(r"schedule\.episodes\.(\d+)\.", bundle[0])
    episodes = settings.get("schedule", {}).get("episodes", ())
    if episode and int(episode[1]) < len(episodes):
        return f"{bundle[0]} ({episodes[int(episode[1])]['skill']})"
    return bundle[0]


def _bundle_value(bundle: Sequence[str], group: Group) -> Any:
    values = [group.overrides[key] for key in bundle]
    if all(value == values[0] for value in values) and isinstance(values[0], int | float):
        return values[0]
    return ", ".join(shown_value(value) for value in values)


def _axle(bundle: Sequence[str], groups: Sequence[Group]) -> Axle:
    values = list(dict.fromkeys(_bundle_value(bundle, group) for group in groups))
    axle = Axle(_bundle_name(bundle, groups[0].runs[0].settings), values)
    return axle._replace(values=sorted(values)) if axle.is_numeric else axle


def _sweeps(page: Page, groups: Sequence[Group]) -> set[str]:
    """Sections of what was swept; returns the presets that were."""
    by_preset: dict[str, list[Group]] = {}
    for group in groups:
        by_preset.setdefault(group.preset, []).append(group)
    sweeps = {preset: sweep_of(found) for preset, found in by_preset.items()}
    there = {preset: sweep for preset, sweep in sweeps.items() if sweep is not None}
    planes = {preset: sweep for preset, sweep in there.items() if len(sweep.axles) == 2}
    rows: dict[tuple[str, tuple[Any, ...]], dict[str, Sweep]] = {}
    for preset, sweep in there.items():
        if len(sweep.axles) == 1:
            axle = sweep.axles[0]
            rows.setdefault((axle.key, tuple(axle.values)), {})[preset] = sweep
    for number, (preset, sweep) in enumerate(planes.items(), 1):
        _plane_section(page, number, preset, sweep)
    for number, of_presets in enumerate(rows.values(), 1):
        _points_section(page, number, of_presets)
    return set(there)


def _sweep_metrics(groups: Iterable[Group]) -> list[Metric]:
    groups = list(groups)
    return [m for m in (FINAL_REWARD, AREA) if any(map(math.isfinite, _all_values(groups, m)))]


def _plane_section(page: Page, number: int, preset: str, sweep: Sweep) -> None:
    parts = []
    across, up = sweep.axles
    for metric in _sweep_metrics(sweep.groups.values()):
        cells = {
            (place[0], place[1]): statistics.mean(group.values(metric.column), _rng())
            for place, group in sweep.groups.items()
        }
        n = sorted({cell.n for cell in cells.values()})
        counted = str(n[0]) if len(n) == 1 else f"{n[0]} to {n[-1]}"
        name = f"plane_{number}_{metric.column}"
        small = page.small_print(
            f"{preset}. Mean over n = {counted} runs (seeds) in each cell; the 95 % bootstrap"
            " intervals are in the page and in the CSV. Cells have equal sizes whatever the values"
            " of the settings. Hatched: not run."
        )
        drawing = draw_plane(name, (across, up), cells, metric.label, small)
        caption = f"{metric.label} of {preset} in the plane of {across.key} and {up.key}"
        rows = [
            (shown_value(across.values[i]), shown_value(up.values[j]), shown_estimate(cell), cell.n)
            for (i, j), cell in sorted(cells.items())
        ]
        table = _table((across.key, up.key, f"{metric.label} [95 %]", "n"), rows)
        parts += [page.picture(name, caption, drawing), _details("The intervals", table)]
    page.say(f"Sweep of {preset}", *parts)


def _points_section(page: Page, number: int, sweeps: Mapping[str, Sweep]) -> None:
    parts = []
    axle = next(iter(sweeps.values())).axles[0]
    everything = [group for sweep in sweeps.values() for group in sweep.groups.values()]
    for metric in _sweep_metrics(everything):
        series = [
            Series(
                preset,
                [
                    statistics.mean(sweep.groups[index,].values(metric.column), _rng())
                    for index in range(len(axle.values))
                ],
            )
            for preset, sweep in sweeps.items()
        ]
        name = f"sweep_{number}_{metric.column}"
        small = page.small_print(
            "Mean over n runs (seeds) at each point; bars: 95 % bootstrap interval."
        )
        drawing = draw_points(name, axle, series, metric.label, small)
        parts.append(page.picture(name, f"{metric.label} against {axle.key}", drawing))
    page.say(f"Sweep over {axle.key}", *parts)


def _ablation(page: Page, groups: Sequence[Group]) -> None:
    """Variants beside the first one."""
    base, *others = groups[:_MOST_ROWS]
    column = FINAL_REWARD.column
    found = [
        statistics.compare(group.by_seed(column), base.by_seed(column), _rng()) for group in others
    ]
    nothing = Estimate(math.nan, math.nan, math.nan, 0)
    difference = f"difference to {base.label} (reward per trial)"
    columns = {
        FINAL_REWARD.label: [
            Dot(group.label, statistics.mean(group.values(column), _rng()))
            for group in (base, *others)
        ],
        difference: [
            Dot(base.label, nothing),
            *(Dot(g.label, c.difference) for g, c in zip(others, found, strict=True)),
        ],
    }
    small = page.small_print(
        "Mean over n runs (seeds); bars: 95 % bootstrap interval. Differences are paired by seed"
        " where seeds are shared."
    )
    drawing = draw_dots("variants", columns, small, zero=(difference,))
    rows = [
        (
            group.label,
            shown_estimate(c.difference),
            f"{c.improvement:.2f}",
            c.difference.n,
            "by seed" if c.paired else "no",
        )
        for group, c in zip(others, found, strict=True)
    ]
    header = (
        "variant",
        f"{FINAL_REWARD.title}: {difference} [95 %]",
        "P(variant better)",
        "n",
        "paired",
    )
    caption = f"{FINAL_REWARD.label} of each variant"
    page.say(
        "Variants beside one another",
        page.picture("variants", caption, drawing),
        _table(header, rows),
        _left_out(len(groups)),
    )


# --- Sections: two folders -----------------------------------------------------------------------

Pair = tuple[Group, Group]


def pairs_of(first: Sequence[Group], second: Sequence[Group]) -> tuple[list[Pair], list[Group]]:
    """Variants of two folders that belong together, and those left alone.

    They do if preset and overrides agree; else if all settings do, however they came about; else
    if the overrides do. Each time only where no other variant has the same.
    """
    pairs: list[Pair] = []
    left, right = list(first), list(second)
    for alike in (_full_key, _spec_key, _overrides_key):
        for group in list(left):
            mine = [other for other in left if alike(other) == alike(group)]
            theirs = [other for other in right if alike(other) == alike(group)]
            if len(mine) == len(theirs) == 1:
                pairs.append((group, theirs[0]))
                left.remove(group)
                right.remove(theirs[0])
    return pairs, [*left, *right]


def _full_key(group: Group) -> str:
    return json.dumps([group.preset, group.overrides], sort_keys=True)


def _spec_key(group: Group) -> str:
    settings = group.runs[0].settings
    return json.dumps({**settings, "description": ""}, sort_keys=True)


def _overrides_key(group: Group) -> str:
    return json.dumps(group.overrides, sort_keys=True)


def _comparison(page: Page, reader: Reader, first: Folder, second: Folder) -> None:
    pairs, alone = pairs_of(groups_of(first.rows), groups_of(second.rows))
    if not pairs:
        raise ReportError(
            f"{str(first.path)!r} and {str(second.path)!r} have no variant in common;"
            " allowed: folders whose variants set the same keys to the same values"
        )
    picture = _comparison_picture(page, pairs)
    page.say("Difference B \N{MINUS SIGN} A", picture, *_comparison_tables(pairs))
    for number, pair in enumerate(pairs[:_MOST_LINES], 1):
        _pair_curves(page, reader, number, pair)
    if alone:
        names = _element("ul", _joined(_element("li", group.label) for group in alone))
        page.say("In one folder only", names)


def _pair_name(pair: Pair) -> str:
    first, second = pair
    return first.label if first.label == second.label else f"{first.label} / {second.label}"


def _compared(pair: Pair, metric: Metric) -> statistics.Comparison:
    before, after = (group.by_seed(metric.column) for group in pair)
    return statistics.compare(after, before, _rng())


def _comparison_picture(page: Page, pairs: Sequence[Pair]) -> Markup:
    dots = [
        Dot(_pair_name(pair), _compared(pair, FINAL_REWARD).difference)
        for pair in pairs[:_MOST_ROWS]
    ]
    what = f"B \N{MINUS SIGN} A: {FINAL_REWARD.label}"
    small = page.small_print(
        "Difference of means over n pairs of runs of the same seed, or over all runs where no"
        " seeds are shared; bars: 95 % bootstrap interval."
    )
    drawing = draw_dots("difference", {what: dots}, small, zero=(what,))
    return page.picture("difference", what, drawing)


def _comparison_tables(pairs: Sequence[Pair]) -> list[Markup]:
    header = (
        "quantity",
        "A",
        "B",
        "B \N{MINUS SIGN} A [95 %]",
        "P(B > A)",
        "n of B \N{MINUS SIGN} A",
        "paired",
    )
    tables = []
    for pair in pairs[:_MOST_ROWS]:
        rows = []
        for metric in METRICS:
            before, after = (statistics.mean(g.values(metric.column), _rng()) for g in pair)
            found = _compared(pair, metric)
            if found.difference.n:
                rows.append(
                    (
                        metric.label,
                        shown_estimate(before),
                        shown_estimate(after),
                        shown_estimate(found.difference),
                        f"{found.improvement:.2f}",
                        found.difference.n,
                        "by seed" if found.paired else "no",
                    )
                )
        text = _element("p", _identical(pair), class_="minor")
        tables.append(_joined([_element("h3", _pair_name(pair)), _table(header, rows), text]))
    return tables


def _identical(pair: Pair) -> str:
    digests = [{run.seed: run.digest for run in group.runs if run.digest} for group in pair]
    shared = [seed for seed in digests[0] if seed in digests[1]]
    same = sum(digests[0][seed] == digests[1][seed] for seed in shared)
    return f"{len(shared)} seeds are in both; {same} of these runs are alike digest for digest."


def _pair_curves(page: Page, reader: Reader, number: int, pair: Pair) -> None:
    def panels(axis: Axis) -> list[Panel]:
        lines = [
            reader.line(f"{side}: {group.label}", group.runs, axis, style_of(index))
            for index, (side, group) in enumerate(zip("AB", pair, strict=True))
        ]
        return [Panel(_pair_name(pair), _with_clear_marks(lines))]

    name = f"pair_{number}"
    caption = f"Reward in A and B: {_pair_name(pair)}"
    page.say(_pair_name(pair), _curve_pictures(page, reader, name, caption, panels))


# --- The whole -----------------------------------------------------------------------------------


def write_report(folders: Sequence[Path], out: Path | None, compare: bool) -> Path:
    """Write a page on folders of results, and its pictures into a folder beside it.

    Args:
        folders: of results; without ``compare`` they are taken together.
        out: the page; ``report.html`` in the first folder unless given.
        compare: set the second folder against the first.

    Returns:
        The page.

    Raises:
        ReportError: nothing can be reported, or nothing be written.
    """
    if compare and len(folders) != 2:
        raise ReportError(f"a comparison needs two folders, and there are {len(folders)}")
    read = [read_folder(folder) for folder in folders]
    place = folders[0] / PAGE_NAME if out is None else out
    commands = [*(folder.command for folder in read), _command(folders, compare)]
    page = Page(commands, f"{place.stem}_figures")
    rows = [row for folder in read for row in folder.rows]
    if not compare:
        rows = _without_copies(rows)
    if all(row.error for row in rows):
        shown = ", ".join(repr(str(folder)) for folder in folders)
        raise ReportError(f"no run is over in {shown}: there is nothing to report yet")
    reader = Reader(_widths(rows))
    title = _overview(page, read, rows, compare)
    if compare:
        _comparison(page, reader, *read)
    else:
        _everything(page, reader, groups_of(rows))
    _missing_runs(page, reader, rows)
    _write_all(page, place, _document(title, page))
    return place


def _everything(page: Page, reader: Reader, groups: Sequence[Group]) -> None:
    placed = _placed(groups)
    # One learner alone in a world replicates nothing; it is a variant like any other.
    if len({learner for _, learner in placed}) < 2:
        placed = {}
    if placed:
        _thesis_figures(page, reader, placed)
        _findings(page, reader, placed)
        _window_means(page, reader, placed)
    others = [g for g in groups if not placed or place_of(g.runs[0]) not in placed]
    swept = _sweeps(page, groups)
    rest = [group for group in others if group.preset not in swept]
    if len(rest) > 1:
        _ablation(page, rest)
    if 0 < len(others) <= _MOST_LINES:
        _curves(page, reader, others)
    _scalars(page, groups)


def _without_copies(rows: Iterable[RunRow]) -> list[RunRow]:
    """Runs, each once in a folder's own table, however many folders hold the very same one."""
    found: dict[tuple[str, str], RunRow] = {}
    for row in rows:
        found.setdefault((row.identity, row.digest or row.key), row)
    return list(found.values())


def _command(folders: Sequence[Path], compare: bool) -> str:
    words = ["pounce", "report", *(["--compare"] if compare else []), *map(str, folders)]
    return shlex.join(words)


def _overview(page: Page, read: Sequence[Folder], rows: Sequence[RunRow], compare: bool) -> str:
    names = [folder.path.resolve().name for folder in read]
    failed = sum(bool(row.error) for row in rows)
    versions = ", ".join(sorted({row.version for row in rows if row.version})) or "unknown"
    seeds = {row.seed for row in rows}
    lines = [
        f"{len(rows) - failed} runs over {len(seeds)} seeds"
        f" ({failed} more failed), by version {versions} of the lab.",
    ]
    if compare:
        lines.append(f"A is {read[0].path}, B is {read[1].path}.")
    commands = [_element("code", command) for command in page.commands]
    content = [_element("p", line) for line in lines]
    content.append(_element("p", _joined(["Made by", *commands], Markup("<br/>"))))
    page.sections.append(_joined(content))
    return " and ".join(names) if compare else ", ".join(names)


def _missing_runs(page: Page, reader: Reader, rows: Iterable[RunRow]) -> None:
    failed = {f"{r.variant or r.preset}, seed {r.seed}": r.error for r in rows if r.error}
    missing = {**failed, **reader.unreadable}
    if missing:
        cells = [(name, _element("span", why)) for name, why in missing.items()]
        page.say("Runs that are left out", _table(("run", "why"), cells))


def _write_all(page: Page, place: Path, document: str) -> None:
    folder = place.with_name(page.figures)
    header = '<?xml version="1.0" encoding="utf-8"?>\n'
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, drawing in page.drawings.items():
            _write(folder / f"{name}.svg", (header + drawing.svg).encode())
            _write(folder / f"{name}.png", drawing.png)
            _write(folder / f"{name}.csv", drawing.csv.encode("utf-8", "replace"))
        # The page comes last: where it is, its pictures are.
        _write(place, document.encode())
    except OSError as error:
        raise ReportError(
            f"{str(place)!r} cannot be written: {error.strerror or error};"
            " allowed: a place that can"
        ) from error


def _write(file: Path, data: bytes) -> None:
    """Write a file so that it is there whole or as it was before."""
    handle, name = tempfile.mkstemp(prefix=".pounce-", dir=file.parent)
    try:
        with os.fdopen(handle, "wb") as out:
            out.write(data)
        # A temporary file is its owner's alone; a report is like any other file.
        os.chmod(name, 0o644)
        os.replace(name, file)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(name)
        raise
