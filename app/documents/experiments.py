"""Experiments: from a file to all the runs it asks for, with every error at once.

An experiment names presets and says what is varied in them. A *variant* is one preset with one
choice of values; each variant is run once for each seed. Values come from three kinds of axes, and
a variant takes one choice from each:

- ``grid``: keys of presets, each with its values, in every combination;
- ``linked``: groups of keys whose values move together, first with first, second with second;
- ``settings``: a list of choices, each with any keys, and perhaps a label.

A list of values may be a range, ``{start, stop, step}`` or ``{log_start, log_stop, count}``, both
ends included. Every value keeps the line it stands on, so that what a preset says of it can be
said of that line.
"""

import hashlib
import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from importlib.resources import files
from importlib.resources.abc import Traversable
from itertools import islice, product
from pathlib import Path
from sys import intern
from typing import Any, Final, NamedTuple

from app.documents import presets, ranges
from app.documents.faults import written_so
from app.documents.ranges import Number
from app.documents.sources import STDIN, Shipped, called
from app.documents.tree import (
    EXTENDS,
    MAX_DEPTH,
    Key,
    Node,
    PresetError,
    PresetProblem,
    Refused,
    UnusableError,
    children,
    document_of,
    dotted,
    in_order,
    n_values,
    plain,
    printable,
    quoted,
)
from app.metrics import METRICS, NAMES
from app.util.texts import as_text, folder_name
from learners.measures import RECENT_TRIALS
from learners.spec import MAX_TRIALS, RunSpec, did_you_mean
from sim.rng import MAX_SEED

MAX_RUNS: Final = 100_000
MAX_VARIANTS: Final = 10_000
MAX_VALUES: Final = 400_000
"""Of all variants together, each with those of its preset: they are what takes time and memory."""
MAX_STEPS: Final = 10**12
MAX_PROBLEMS: Final = 100
"""As many as anyone would read: where every variant is wrong, the rest is not looked at."""
MAX_WRONG_VALUES: Final = MAX_VALUES // 4
"""Of variants that are wrong. What is wrong with all of them is one problem, and many values."""

_SHIPPED: Final = Shipped(
    "experiment",
    "presets/experiments",
    files("presets") / "experiments",
    ("figure_4_1", "figure_4_2", "figure_4_3"),
)

_AXES: Final = ("set", "grid", "linked", "settings")
_KEYS: Final = (
    "description",
    "presets",
    *_AXES,
    "seeds",
    "common_starts",
    "trials",
    "steps",
    "metrics",
    "stop",
)
_PRESET_KEYS: Final = ("preset", "label", *_AXES)
_LABEL: Final = "label"
MAX_LABEL: Final = 200
_MAX_WHOLE_LABEL: Final = 2_000
"""Of a variant, with the values that it is made of."""
_MAX_SHOWN_COUNT: Final = 10**18
_RANGES: Final = (("start", "stop", "step"), ("log_start", "log_stop", "count"))
_ALLOWED_PRESETS: Final = "a shipped preset, a path, or a whole preset with a label"
_ALLOWED_VALUES: Final = "a list of values, {start, stop, step}, or {log_start, log_stop, count}"


class ExperimentError(PresetError):
    """An experiment that cannot be run; carries everything that is wrong with it."""


@dataclass(frozen=True)
class Stop:
    """When a run has learned enough: looked at every ``every`` trials."""

    success: float
    """Share of captures."""
    trials: int = RECENT_TRIALS
    """So many of the most recent trials count; before there are as many, a run goes on."""
    every: int = 100


@dataclass(frozen=True)
class Variant:
    """One preset with one choice of values."""

    label: str
    """Unlike that of any other variant."""
    preset: str
    """As the experiment names it; the label of one that is written there as a whole."""
    spec: RunSpec
    overrides: Mapping[str, Any]
    """What the experiment sets in the preset, by dotted key."""


@dataclass(frozen=True, eq=False)
class Experiment:
    """Everything that is to be run, and until when. Equal to itself alone."""

    name: str
    text: bytes
    """The file as it was given."""
    description: str
    variants: tuple[Variant, ...]
    seeds: Sequence[int]
    common_starts: bool = True
    """Whether all variants run with the same seeds, and so with the same starts of trials."""
    trials: int | None = None
    """Trials of each run; None where the presets say how many."""
    steps: int | None = None
    """Steps of each run; where ``trials`` is None they alone count."""
    metrics: tuple[str, ...] = NAMES
    """Columns of :mod:`app.metrics` that are measured; charts show the first of them."""
    stop: Stop | None = None
    source: str = ""
    """How it was named where it can be named again; empty if it was given as a text."""
    _seeds_of: Mapping[str, Sequence[int]] = field(default_factory=dict, repr=False)

    @property
    def n_runs(self) -> int:
        """Runs in all."""
        return len(self.variants) * len(self.seeds)

    def seeds_of(self, variant: Variant) -> Sequence[int]:
        """The seeds of a variant: its own ones unless starts are shared."""
        return self.seeds if self.common_starts else self._seeds_of[variant.label]

    def trials_of(self, variant: Variant) -> int:
        """Trials after which a run of a variant ends, whatever else may end it."""
        return _n_trials(variant.spec, self.trials, self.steps)

    def runs(self) -> "Iterator[tuple[Variant, int]]":
        """Every run as its variant and seed: first all variants with the first seed."""
        for index in range(len(self.seeds)):
            for variant in self.variants:
                yield variant, self.seeds_of(variant)[index]


def _n_trials(spec: RunSpec, trials: int | None, steps: int | None) -> int:
    """Trials after which a run ends in an experiment that states these trials and steps."""
    return MAX_TRIALS if steps is not None and trials is None else spec.trials


def own_seed(label: str, seed: int) -> int:
    """Seed of a variant's own: a function of its label and of the seed it stands for."""
    found = hashlib.sha256(f"{label}\0{seed}".encode()).digest()
    return int.from_bytes(found[:8], "big") >> 1


# --- Files ---------------------------------------------------------------------------------------


def shipped() -> dict[str, Traversable]:
    """The experiments that come with the lab, by name: first the thesis's own."""
    return _SHIPPED.files()


def load(name_or_path: str, n_seeds: int | None = None) -> Experiment:
    """Read a shipped experiment, a file or standard input.

    Args:
        name_or_path: ``-`` for standard input.
        n_seeds: takes the place of the file's seeds.

    Raises:
        ExperimentError: it cannot be run; with all that is wrong with it.
    """
    try:
        found = _SHIPPED.asked_for(name_or_path)
    except UnusableError as error:
        problem = PresetProblem(called(name_or_path), None, "", None, error.message)
        raise ExperimentError([problem]) from None
    experiment = parse(found.data, found.label, found.folder, n_seeds)
    name = as_text(name_or_path)
    can_be_named_again = name_or_path != STDIN and "\N{REPLACEMENT CHARACTER}" not in name
    return replace(experiment, source=name if can_be_named_again else "")


def parse(
    data: bytes | str, source: str, folder: Path | None = Path(), n_seeds: int | None = None
) -> Experiment:
    """Read an experiment from a text.

    Args:
        data: the text.
        source: what its problems call it; the experiment's name is the stem of it, or near to it
            where no folder could be called so.
        folder: where paths of presets start; None if only shipped presets may be named.
        n_seeds: seeds 0 to so many less one, in the place of those that it names.

    Raises:
        ExperimentError: it cannot be run; with all that is wrong with it.
    """
    problems: list[PresetProblem] = []
    root = document_of(data, source, problems)
    if root is None:
        raise ExperimentError(problems)
    text = data.encode() if isinstance(data, str) else data
    reader = _Reader(root, folder, problems)
    experiment = reader.experiment(folder_name(Path(source).stem), text, n_seeds)
    if problems or experiment is None:
        raise ExperimentError(in_order(dict.fromkeys(problems)))
    return experiment


# --- Axes: what is varied ------------------------------------------------------------------------


class _Choice(NamedTuple):
    """Values that are taken together."""

    values: tuple[Node, ...]
    """Each knows its key in the preset, and the place of the experiment it is from."""
    label: str | None = None
    whole: Node | None = None
    """Where all of it stands: its label if it has one; None if it has only its values."""


@dataclass(frozen=True)
class _Range:
    """Values of a range. How many there are is known long before any of them is made."""

    node: Node
    """As it is written, with the key that its values are for."""
    count: int
    numbers: Callable[[], Iterable[Number]]

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[Node]:
        return (self.node._replace(value=number) for number in self.numbers())


_Values = Sequence[Node] | _Range


@dataclass(frozen=True)
class _Linked:
    """Choices of values that move together, made as they are taken."""

    columns: tuple[_Values, ...]

    def __len__(self) -> int:
        return len(self.columns[0])

    def __iter__(self) -> Iterator[_Choice]:
        return map(_Choice, zip(*self.columns, strict=True))


class _Axis(NamedTuple):
    """Choices of which a variant takes one."""

    keys: tuple[Key, ...]
    choices: Sequence[_Choice] | _Linked
    n_values: int
    """In all choices together."""


class _Plan(NamedTuple):
    """One preset and everything that is varied in it."""

    name: str
    label: str
    named_by: Node
    """Its label if it has one, else the preset as it is named."""
    base: presets.Base
    fixed: tuple[Node, ...]
    axes: tuple[_Axis, ...]

    @property
    def n_variants(self) -> int:
        return math.prod(len(axis.choices) for axis in self.axes)

    @property
    def n_values(self) -> int:
        """In all variants together."""
        n_variants = self.n_variants
        given = sum(map(n_values, (self.base.tree, *self.fixed)))
        # Each choice is in as many variants as any other of its axis.
        varied = (axis.n_values * n_variants // len(axis.choices) for axis in self.axes)
        return given * n_variants + sum(varied)


def _with_key(node: Node, key: Key) -> Node:
    """The same value, and all within it, under another key."""
    match node.value:
        case dict():
            value = {name: _with_key(inner, (*key, name)) for name, inner in node.value.items()}
        case list():
            value = [_with_key(inner, (*key, index)) for index, inner in enumerate(node.value)]
        case _:
            value = node.value
    return node._replace(key=key, value=value)


# --- From a tree to an experiment ----------------------------------------------------------------


class _Reader:
    """Reads one experiment and notes what is wrong with it."""

    def __init__(self, root: Node, folder: Path | None, problems: list[PresetProblem]) -> None:
        self._root = root
        self._shelf = presets.Shelf(folder)
        self._problems = problems

    def experiment(self, name: str, text: bytes, n_seeds: int | None) -> Experiment | None:
        entries = self._mapping(self._root, _KEYS)
        description = self._text(entries.get("description"), 400)
        seeds = self._seeds(entries.get("seeds"))
        if n_seeds is not None:
            seeds = range(n_seeds)
        common_starts = self._flag(entries.get("common_starts"), True)
        trials = self._whole(entries.get("trials"), 1, MAX_TRIALS)
        steps = self._whole(entries.get("steps"), 1, MAX_STEPS)
        metrics = self._metrics(entries.get("metrics"))
        stop = self._stop(entries.get("stop"))
        plans = self._plans(entries, trials is not None)
        if not self._few_enough(plans, len(seeds)):
            return None
        variants = self._variants(plans, trials, steps)
        own = {} if common_starts else self._own_seeds(variants, seeds)
        return Experiment(
            name=name,
            text=text,
            description=description,
            variants=variants,
            seeds=seeds,
            common_starts=common_starts,
            trials=trials,
            steps=steps,
            metrics=metrics,
            stop=stop,
            _seeds_of=own,
        )

    def _fault(self, node: Node, message: str) -> None:
        if not isinstance(node.value, Refused):
            value = None if isinstance(node.value, dict) and not node.key else quoted(plain(node))
            self._problems.append(node.problem(message, value))

    def _mapping(self, node: Node, names: Sequence[str] = ()) -> dict[str, Node]:
        """Entries of a mapping that may have keys of these names; of any where none are named."""
        if not isinstance(node.value, dict):
            allowed = f"the keys {', '.join(names)}" if names else "keys of presets"
            self._fault(node, f"must be a mapping; allowed: {allowed}")
            return {}
        for name, child in node.value.items():
            if names and name not in names:
                hint = did_you_mean(name, names)
                self._fault(child, f"is not a known key{hint}; allowed: {', '.join(names)}")
        return {name: child for name, child in node.value.items() if not names or name in names}

    def _items(self, node: Node | None, what: str) -> list[Node]:
        if node is None or node.value is None or isinstance(node.value, Refused):
            return []
        if not isinstance(node.value, list) or not node.value:
            self._fault(node, f"must be a list; allowed: {what}")
            return []
        return node.value

    def _text(self, node: Node | None, longest: int) -> str:
        if node is None or node.value is None or isinstance(node.value, Refused):
            return ""
        if not isinstance(node.value, str) or len(node.value) > longest:
            self._fault(node, f"must be a text; allowed: up to {longest} characters")
            return ""
        return node.value

    def _flag(self, node: Node | None, default: bool) -> bool:
        if node is None or node.value is None or isinstance(node.value, bool):
            return default if node is None or node.value is None else node.value
        self._fault(node, "must be true or false; allowed: true, false")
        return default

    def _whole(self, node: Node | None, low: int, high: int) -> int | None:
        if node is None or node.value is None:
            return None
        value = node.value
        if isinstance(value, int) and not isinstance(value, bool):
            if low <= value <= high:
                return value
            wrong = f"must be at least {low}" if value < low else f"must be at most {high}"
        else:
            wrong = "must be a whole number"
        hint = written_so(value, decimals=False)
        self._fault(node, f"{wrong}; allowed: {low} to {high}{hint}")
        return None

    def _seeds(self, node: Node | None) -> Sequence[int]:
        if node is None or not isinstance(node.value, list):
            n_seeds = self._whole(node, 1, MAX_RUNS)
            return range(1 if n_seeds is None else n_seeds)
        seeds: dict[int, None] = {}
        for item in self._items(node, f"seeds from 0 to {MAX_SEED}"):
            seed = self._whole(item, 0, MAX_SEED)
            if seed in seeds:
                self._fault(item, "is there twice; allowed: each seed once")
            elif seed is not None:
                seeds[seed] = None
        return tuple(seeds)

    def _metrics(self, node: Node | None) -> tuple[str, ...]:
        found: dict[str, None] = {}
        for item in self._items(node, f"names from {', '.join(NAMES)}"):
            if not isinstance(item.value, str) or item.value not in NAMES:
                hint = did_you_mean(plain(item), NAMES)
                self._fault(item, f"is not measured{hint}; allowed: {', '.join(NAMES)}")
            elif item.value in found:
                self._fault(item, "is there twice; allowed: each once")
            else:
                found[item.value] = None
        means = [metric.column for metric in METRICS]
        if found and not found.keys() & set(means) and node is not None:
            self._fault(node, f"has nothing to chart; allowed: also one of {', '.join(means)}")
        return tuple(found) or NAMES

    def _stop(self, node: Node | None) -> Stop | None:
        if node is None or node.value is None:
            return None
        entries = self._mapping(node, ("success", "trials", "every"))
        success = entries.get("success")
        if success is None and isinstance(node.value, dict):
            self._fault(node, "has no success; allowed: a share of captures, 0 to 1")
        if success is None:
            return None
        value = success.value
        if not isinstance(value, int | float) or isinstance(value, bool) or not 0 <= value <= 1:
            hint = written_so(value, decimals=True)
            self._fault(success, f"must be a share of captures; allowed: 0 to 1{hint}")
            return None
        trials = self._whole(entries.get("trials"), 1, MAX_TRIALS)
        every = self._whole(entries.get("every"), 1, MAX_TRIALS)
        return Stop(float(value), trials or Stop.trials, every or Stop.every)

    def _plans(self, entries: Mapping[str, Node], has_trials: bool) -> list[_Plan]:
        node = entries.get("presets")
        if node is None:
            self._fault(self._root, "has no presets; allowed: a list of presets")
            return []
        fixed, axes = self._varied(entries)
        self._refuse_twice(axes, ())
        if has_trials:
            fixed = (*fixed, entries["trials"])
        plans = []
        for item in self._items(node, "presets, each a name, a path, or {preset, label, ...}"):
            plan = self._plan(item, fixed, axes)
            if plan is not None:
                plans.append(plan)
        return plans

    def _plan(self, item: Node, fixed: tuple[Node, ...], axes: tuple[_Axis, ...]) -> _Plan | None:
        name, label = item, ""
        entries: dict[str, Node] = {}
        own_axes: tuple[_Axis, ...] = ()
        if isinstance(item.value, dict):
            entries = self._mapping(item, _PRESET_KEYS)
            label = self._text(entries.get(_LABEL), MAX_LABEL)
            own_fixed, own_axes = self._varied(entries)
            fixed = (*fixed, *own_fixed)
            if "preset" not in entries:
                self._fault(item, "names no preset; allowed: preset: NAME")
                return None
            name = entries["preset"]
        named_by = entries[_LABEL] if label else name
        is_written_here = isinstance(name.value, dict)
        if is_written_here and not label:
            self._fault(item, "has no label; allowed: a label for a preset that has no name")
            return None
        if not is_written_here and not isinstance(name.value, str):
            self._fault(name, f"must be a text; allowed: {_ALLOWED_PRESETS}")
            return None
        self._refuse_twice(own_axes, axes)
        axes = (*axes, *own_axes)
        try:
            if is_written_here:
                base = self._shelf.base_within(_with_key(name, ()))
                return _Plan(label, label, named_by, base, fixed, axes)
            base = self._shelf.base_of(name.value)
        except UnusableError as error:
            self._fault(name, error.message)
            return None
        return _Plan(name.value, label or Path(name.value).stem, named_by, base, fixed, axes)

    def _varied(self, entries: Mapping[str, Node]) -> tuple[tuple[Node, ...], tuple[_Axis, ...]]:
        """What is set once, and the axes."""
        fixed = self._settings(entries["set"]) if "set" in entries else ()
        axes: list[_Axis] = []
        if "grid" in entries:
            for name, child in self._mapping(entries["grid"]).items():
                axes += self._axis({name: child}, child)
        for group in self._items(entries.get("linked"), "groups of keys that move together"):
            axes += self._axis(self._mapping(group), group)
        if "settings" in entries:
            items = self._items(entries["settings"], "mappings of keys of presets to values")
            choices = [self._choice(item) for item in items]
            keys = dict.fromkeys(value.key for choice in choices for value in choice.values)
            if choices:
                nodes = [value for choice in choices for value in choice.values]
                axes.append(_Axis(tuple(keys), choices, sum(map(n_values, nodes))))
        return fixed, tuple(axes)

    def _choice(self, item: Node) -> _Choice:
        entries = dict(self._mapping(item))
        written = entries.pop(_LABEL, None)
        label = self._text(written, MAX_LABEL) or None
        values = self._settings(item._replace(value=entries))
        return _Choice(values, label, item if label is None else written)

    def _settings(self, node: Node) -> tuple[Node, ...]:
        found = []
        for name, child in self._mapping(node).items():
            key = self._key(name, child)
            if key is not None:
                found.append(_with_key(child, key))
        return tuple(found)

    def _axis(self, entries: Mapping[str, Node], group: Node) -> list[_Axis]:
        """The axis of keys that move together, if they can."""
        columns: list[_Values] = []
        keys: list[Key] = []
        for name, child in entries.items():
            key, values = self._key(name, child), self._values(child)
            if key is not None and values:
                columns.append(_for_key(values, key))
                keys.append(key)
        if len(columns) < len(entries) or not columns:
            return []
        if len(set(map(len, columns))) > 1:
            counts = zip(entries, map(len, columns), strict=True)
            listed = ", ".join(f"{printable(name)}: {count}" for name, count in counts)
            message = f"has values that cannot move together ({listed}); allowed: as many for each"
            self._problems.append(group.problem(message))
            return []
        return [_Axis(tuple(keys), _Linked(tuple(columns)), sum(map(_n_values, columns)))]

    def _key(self, name: str, node: Node) -> Key | None:
        key: Key = tuple(name.split("."))
        if not all(key) or len(key) > MAX_DEPTH:
            self._fault(node, "is not a key; allowed: a dotted key of a preset")
            return None
        if key[0] == EXTENDS:
            self._fault(node, "cannot be varied; allowed: in a preset's file")
            return None
        return key

    def _values(self, node: Node) -> _Values:
        """Values of a key; none, with the problem noted, if they are not to be had."""
        if isinstance(node.value, dict):
            for names in _RANGES:
                if set(node.value) == set(names):
                    return self._range(node, [node.value[name] for name in names], names)
        if not isinstance(node.value, list) or not node.value:
            self._fault(node, f"has no values; allowed: {_ALLOWED_VALUES}")
            return []
        return node.value

    def _range(self, node: Node, parts: Sequence[Node], names: tuple[str, ...]) -> _Values:
        wrong = [part for part in parts if not _is_finite(part.value)]
        for part in wrong:
            hint = written_so(part.value, decimals=True)
            self._fault(part, f"must be a finite number; allowed: a number{hint}")
        if wrong:
            return []
        first, last, step = (part.value for part in parts)
        is_log = names is _RANGES[1]
        if is_log and not (0 < first < last and isinstance(step, int) and step >= 2):
            self._fault(node, "is no range; allowed: 0 < log_start < log_stop, count 2 or more")
            return []
        if not is_log and not (first <= last and step > 0):
            self._fault(node, "is no range; allowed: start up to stop, and a step above 0")
            return []
        if (step if is_log else (last - first) / step) >= MAX_VARIANTS:
            self._fault(node, f"has too many values; allowed: fewer than {MAX_VARIANTS}")
            return []
        if is_log:
            # Rounded to whole numbers, some may be the same: to be counted they must be made.
            are_whole = isinstance(first, int) and isinstance(last, int)
            count = len(ranges.logarithmic(first, last, step)) if are_whole else step
            return _Range(node, count, partial(ranges.logarithmic, first, last, step))
        return _Range(
            node, ranges.n_steps(first, last, step), partial(ranges.linear, first, last, step)
        )

    def _refuse_twice(self, axes: Iterable[_Axis], others: Iterable[_Axis]) -> None:
        """No key of an axis may be one of another, or of those that were looked at before."""
        seen = {key for axis in others for key in axis.keys}
        for axis in axes:
            for key in axis.keys:
                if key in seen:
                    message = f"{dotted(key)} is varied twice; allowed: once in each preset"
                    self._problems.append(self._root.problem(message))
            seen.update(axis.keys)

    def _few_enough(self, plans: Sequence[_Plan], n_seeds: int) -> bool:
        n_variants = sum(plan.n_variants for plan in plans)
        n_values = sum(plan.n_values for plan in plans)
        if n_variants > MAX_VARIANTS or n_variants * n_seeds > MAX_RUNS:
            message = (
                f"asks for {_counted(n_variants)} variants with {n_seeds} seeds each,"
                f" {_counted(n_variants * n_seeds)} runs;"
                f" allowed: up to {MAX_VARIANTS} variants and {MAX_RUNS} runs"
            )
        elif n_values > MAX_VALUES:
            message = (
                f"asks for {n_variants} variants with {_counted(n_values)} values in all;"
                f" allowed: up to {MAX_VALUES} values, each variant with those of its preset"
            )
        else:
            return True
        self._problems.append(self._root.problem(message))
        return False

    def _variants(
        self, plans: Iterable[_Plan], trials: int | None, steps: int | None
    ) -> tuple[Variant, ...]:
        found: dict[str, Variant] = {}
        made: dict[str, _Made] = {}
        effects: dict[tuple[object, ...], _Made] = {}
        late: dict[PresetProblem, PresetProblem] = {}  # One for all values of a line that are late.
        wrong: dict[PresetProblem, None] = {}
        n_wrong_values = 0
        for plan, base, choices in _combinations(plans):
            if len(wrong) >= MAX_PROBLEMS or n_wrong_values >= MAX_WRONG_VALUES:
                break
            try:
                variant = _variant(plan, base, choices)
            except PresetError as error:
                wrong.update(dict.fromkeys(error.problems))
                n_wrong_values += plan.n_values // plan.n_variants
                continue
            this, n_trials = _Made(plan, choices), _n_trials(variant.spec, trials, steps)
            # Plans are there to the end, choices until the next plan: each has an id of its own.
            alike = made.setdefault(variant.label, this)
            same = effects.setdefault((id(plan), *_effects(choices, n_trials)), this)
            problem = None
            if len(variant.label) > _MAX_WHOLE_LABEL:
                problem = self._root.problem(
                    f"has a variant whose label is {len(variant.label)} characters long;"
                    f" allowed: up to {_MAX_WHOLE_LABEL}, or settings with a label"
                )
            elif alike is not this:
                problem = _named_alike(this, alike)
            elif same is not this:
                found_late = _too_late(this, same, n_trials)
                problem = late.setdefault(found_late._replace(value=None), found_late)
            if problem is None:
                found[variant.label] = variant
            else:
                wrong[problem] = None
                n_wrong_values += plan.n_values // plan.n_variants
        self._problems += islice(wrong, MAX_PROBLEMS)
        return tuple(found.values())

    def _own_seeds(
        self, variants: Iterable[Variant], seeds: Sequence[int]
    ) -> dict[str, tuple[int, ...]]:
        own = {v.label: tuple(own_seed(v.label, seed) for seed in seeds) for v in variants}
        distinct = {seed for those in own.values() for seed in those}
        if len(distinct) < sum(map(len, own.values())):
            message = "leads to one seed for two runs; allowed: another label, or other seeds"
            self._problems.append(self._root.problem(message))
        return own


def _combinations(
    plans: Iterable[_Plan],
) -> Iterator[tuple[_Plan, presets.Base, Sequence[_Choice]]]:
    """Every variant as its plan, what is the same in all variants of that, and its choices."""
    for plan in plans:
        base = presets.with_settings(plan.base, plan.fixed)
        for choices in product(*(axis.choices for axis in plan.axes)):
            yield plan, base, choices


class _Made(NamedTuple):
    """What a variant is made of."""

    plan: _Plan
    choices: Sequence[_Choice]

    def first_unlike(self, other: "_Made") -> tuple[_Choice, _Choice]:
        """The first choice in which two variants of one plan differ: its own, and the other's."""
        pairs = zip(self.choices, other.choices, strict=True)
        return next((own, its) for own, its in pairs if own is not its)


def _named_alike(this: _Made, other: _Made) -> PresetProblem | None:
    """What is wrong with a variant that is named like an earlier one, where they part ways."""
    if this.plan is not other.plan:
        node = this.plan.named_by
        message = "makes a variant named like one of another preset; allowed: a label each"
        return node.problem(message, quoted(plain(node)))
    choice, earlier = this.first_unlike(other)
    if any(isinstance(leaf.value, Refused) for value in choice.values for leaf in _leaves(value)):
        return None  # What it would have been is not known, and that has been said.
    node = choice.values[0] if choice.whole is None else choice.whole
    if choice.label is not None and choice.label == earlier.label:
        message = "is there twice; allowed: a label each"
    elif list(map(plain, choice.values)) == list(map(plain, earlier.values)):
        moves = choice.whole is None and len(choice.values) > 1
        with_all = ", with all that moves with it" if moves else ""
        message = f"is there twice{with_all}; allowed: each once"
    else:
        message = "makes a variant named like another; allowed: settings with a label each"
    return node.problem(message, quoted(plain(node)))


def _leaves(node: Node) -> Iterator[Node]:
    """The values within a value that hold no others."""
    within = [leaf for _, child in children(node) for leaf in _leaves(child)]
    yield from within or [node]


def _is_late(leaf: Node, n_trials: int) -> bool:
    """Whether it is when a skill joins or an episode starts, after the last trial of a run."""
    match leaf.key:
        case ("schedule", "skills" | "episodes", _, "at"):
            return isinstance(leaf.value, int) and leaf.value >= n_trials
        case _:
            return False


def _effects(choices: Iterable[_Choice], n_trials: int) -> Iterator[object]:
    """What choices of one plan lead to, alike where they differ only in what is late."""
    for choice in choices:
        leaves = [leaf for value in choice.values for leaf in _leaves(value)]
        late = [_is_late(leaf, n_trials) for leaf in leaves]
        if any(late):
            yield frozenset(
                (leaf.key, None if is_late else repr(leaf.value))
                for leaf, is_late in zip(leaves, late, strict=True)
            )
        else:
            yield id(choice)


def _too_late(this: _Made, other: _Made, n_trials: int) -> PresetProblem:
    """What is wrong with a variant that differs from an earlier one only in what is late."""
    choice, _ = this.first_unlike(other)
    leaves = (leaf for value in choice.values for leaf in _leaves(value))
    late = next(leaf for leaf in leaves if _is_late(leaf, n_trials))
    message = (
        f"comes after the last of {n_trials} trials, as another value does, so that both make the"
        f" same runs; allowed: 0 to {n_trials - 1}, and one later"
    )
    return late.problem(message, quoted(late.value))


def _is_finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _counted(count: int) -> str:
    """A count as a problem states it, which may be the product of hundreds of axes."""
    return str(count) if count <= _MAX_SHOWN_COUNT else f"more than {_MAX_SHOWN_COUNT}"


def _for_key(values: _Values, key: Key) -> _Values:
    """The same values under another key."""
    if isinstance(values, _Range):
        return replace(values, node=values.node._replace(key=key))
    return [_with_key(value, key) for value in values]


def _n_values(values: _Values) -> int:
    return len(values) if isinstance(values, _Range) else sum(map(n_values, values))


def _variant(plan: _Plan, base: presets.Base, choices: Sequence[_Choice]) -> Variant:
    """A variant of a plan, of whose base all that is fixed is a part."""
    chosen = [value for choice in choices for value in choice.values]
    spec = presets.completed(base, chosen)
    # Variants have the same keys: each text is kept once.
    overrides = {
        intern(".".join(map(str, node.key))): plain(node) for node in (*plan.fixed, *chosen)
    }
    return Variant(_label(plan, choices), plan.name, spec, overrides)


def _label(plan: _Plan, choices: Sequence[_Choice]) -> str:
    parts = [plan.label]
    names = iter(_short(tuple(value.key for choice in choices for value in choice.values)))
    for choice in choices:
        own = list(islice(names, len(choice.values)))
        if choice.label is not None:
            parts.append(choice.label)
            continue
        parts += [f"{n}={_written(plain(v))}" for n, v in zip(own, choice.values, strict=True)]
    return ", ".join(parts)


@lru_cache(maxsize=16)  # Most variants of a preset have the same keys.
def _short(keys: tuple[Key, ...]) -> tuple[str, ...]:
    """The end of each key, as long as it must be to be told from the others."""
    n_with = Counter(key[-length:] for key in keys for length in range(1, len(key) + 1))
    return tuple(".".join(map(str, _end(key, n_with))) for key in keys)


def _end(key: Key, n_with: Mapping[Key, int]) -> Key:
    for length in range(min(2, len(key)), len(key)):
        end = key[-length:]
        is_place_in_a_list = str(end[0]).isdigit()
        if not is_place_in_a_list and n_with[end] == 1:
            return end
    return key


def _written(value: object) -> str:
    match value:
        case str():
            return value
        case list():
            return f"[{', '.join(map(_written, value))}]"
        case _:
            return quoted(value)
