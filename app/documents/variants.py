"""Variants: all combinations of what an experiment varies, counted before any of them is made.

Values come from four kinds of axes (:mod:`app.documents.axes`), and a variant takes one choice from
each:

- ``grid``: keys of presets, each with its values, in every combination;
- ``linked``: groups of keys whose values move together, first with first, second with second;
- ``settings``: a list of choices, each with any keys, and perhaps a label;
- ``sample``: choices that are drawn at random (:mod:`app.documents.samples`).

Every value keeps the line it stands on, so that what a preset says of it can be said of that line.
"""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice, product
from pathlib import Path
from sys import intern
from typing import Any, Final, NamedTuple, cast

from app.documents import presets
from app.documents.axes import (
    Axis,
    Choice,
    Linked,
    Range,
    choice_of,
    column_of,
    drawn_axis,
    values_of,
    with_key,
)
from app.documents.experiment_spec import MAX_RUNS, ExperimentSpec
from app.documents.tree import (
    Key,
    Node,
    PresetError,
    PresetProblem,
    Refused,
    UnusableError,
    children,
    dotted,
    key_of,
    n_values,
    plain,
    printable,
    quoted,
)
from learners.spec import RunSpec

MAX_VARIANTS: Final = 10_000
MAX_VALUES: Final = 400_000
"""Of all variants together, each with those of its preset: they are what takes time and memory."""
MAX_PROBLEMS: Final = 100
"""As many as anyone would read: where every variant is wrong, the rest is not looked at."""
MAX_WRONG_VALUES: Final = MAX_VALUES // 4
"""Of variants that are wrong. What is wrong with all of them is one problem, and many values."""

_PRESETS: Final = "a shipped preset, a path, or a whole preset with a label"
_MAX_WHOLE_LABEL: Final = 2_000
"""Of a variant, with the values that it is made of."""
_MAX_SHOWN_COUNT: Final = 10**18


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
    seeds: Sequence[int] | None = None
    """That its preset has of its own in the experiment; None where it has those of all."""
    is_draw: bool = False
    """Whether some of its values were drawn at random."""


# --- Plans: a preset and what is varied in it ----------------------------------------------------


class Plan(NamedTuple):
    """One preset and everything that is varied in it."""

    name: str
    label: str
    named_by: Node
    """Its label if it has one, else the preset as it is named."""
    base: presets.Base
    fixed: Sequence[Node]
    axes: Sequence[Axis]
    seeds: Sequence[int] | None
    """Of its own."""

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


# --- From what is asked for to variants ----------------------------------------------------------


class Expansion:
    """All that one experiment asks for; notes what is wrong with it as it goes."""

    def __init__(
        self,
        asked: ExperimentSpec,
        root: Node,
        folder: Path | None,
        problems: list[PresetProblem],
    ) -> None:
        """What is asked for is what the tree states; paths of presets start at the folder."""
        self._asked = asked
        self._root = root
        self._shelf = presets.Shelf(folder)
        self._problems = problems

    def plans(self) -> list[Plan]:
        """The presets that can be had, each with what is varied in it."""
        entries = self._root.value
        fixed, axes = self._varied(entries)
        self._refuse_twice(axes, ())
        if "trials" in entries:
            fixed.append(entries["trials"])
        items: list[Node] = entries["presets"].value if "presets" in entries else []
        pairs = zip(items, self._asked.presets, strict=True)
        plans = (self._plan(item, asked.seeds, fixed, axes) for item, asked in pairs)
        return [plan for plan in plans if plan is not None]

    def _plan(
        self, item: Node, seeds: Sequence[int] | None, fixed: list[Node], axes: list[Axis]
    ) -> Plan | None:
        is_mapping = isinstance(item.value, dict)
        entries: dict[Any, Node] = dict(children(item)) if is_mapping else {"preset": item}
        own_fixed, own_axes = self._varied(entries)
        self._refuse_twice(own_axes, axes)
        preset, written = entries.get("preset"), entries.get("label")
        label = written.value if written else ""
        at = preset or item
        try:
            match None if preset is None else preset.value:
                case None:
                    raise UnusableError("names no preset; allowed: preset: NAME")
                case str(name):
                    base = self._shelf.base_of(name)
                case dict() if label:
                    name, base = label, self._shelf.base_within(with_key(at, ()))
                case dict():
                    at = item
                    raise UnusableError(
                        "has no label; allowed: a label for a preset that has no name"
                    )
                case Refused():
                    return None
                case _:
                    raise UnusableError(f"must be a text; allowed: {_PRESETS}")
        except UnusableError as error:
            self._problems.append(at.problem(error.message, quoted(plain(at))))
            return None
        named_by = written if written and label else at
        label = label or Path(name).stem
        return Plan(name, label, named_by, base, [*fixed, *own_fixed], [*axes, *own_axes], seeds)

    def _varied(self, entries: Mapping[str, Node]) -> tuple[list[Node], list[Axis]]:
        """What is set once, and the axes."""
        fixed = values_of(entries["set"]) if "set" in entries else []
        groups: list[Node] = []
        if "grid" in entries:
            columns = entries["grid"].value.items()
            groups += (node._replace(value={name: node}) for name, node in columns)
        if "linked" in entries:
            groups += entries["linked"].value
        axes = [axis for group in groups if (axis := self._linked(group)) is not None]
        if "settings" in entries:
            choices = list(map(choice_of, entries["settings"].value))
            values = [value for choice in choices for value in choice.values]
            keys = dict.fromkeys(value.key for value in values)
            axes.append(Axis(tuple(keys), choices, sum(map(n_values, values))))
        if "sample" in entries:
            axes.append(drawn_axis(entries["sample"]))
        return fixed, axes

    def _linked(self, group: Node) -> Axis | None:
        """The axis of keys that move together, if they can."""
        columns = {name: column_of(name, node) for name, node in group.value.items()}
        if len(set(map(len, columns.values()))) == 1:
            n_in_all = sum(
                len(column) if isinstance(column, Range) else sum(map(n_values, column))
                for column in columns.values()
            )
            return Axis(tuple(map(key_of, columns)), Linked(tuple(columns.values())), n_in_all)
        if columns:
            listed = ", ".join(f"{printable(name)}: {len(of)}" for name, of in columns.items())
            message = f"has values that cannot move together ({listed}); allowed: as many for each"
            self._problems.append(group.problem(message))
        return None

    def _refuse_twice(self, axes: Iterable[Axis], others: Iterable[Axis]) -> None:
        """No key of an axis may be one of another, or of those that were looked at before."""
        seen = {key for axis in others for key in axis.keys}
        for axis in axes:
            for key in axis.keys:
                if key in seen:
                    message = f"{dotted(key)} is varied twice; allowed: once in each preset"
                    self._problems.append(self._root.problem(message))
            seen.update(axis.keys)

    def few_enough(self, plans: Sequence[Plan]) -> bool:
        """Whether so many variants and runs may be made."""
        n_variants = sum(plan.n_variants for plan in plans)
        n_values = sum(plan.n_values for plan in plans)
        n_seeds = [len(self._asked.seeds if plan.seeds is None else plan.seeds) for plan in plans]
        n_runs = sum(plan.n_variants * n for plan, n in zip(plans, n_seeds, strict=True))
        if n_variants > MAX_VARIANTS or n_runs > MAX_RUNS:
            each = f" with {n_seeds[0]} seeds each" if len({*n_seeds}) == 1 else ""
            message = (
                f"asks for {_counted(n_variants)} variants{each}, {_counted(n_runs)} runs;"
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

    def variants(self, plans: Iterable[Plan]) -> tuple[Variant, ...]:
        """The variants that are sound, each with a label of its own."""
        found: dict[str, Variant] = {}
        made: dict[str, _Made] = {}
        effects: dict[tuple[object, ...], _Made] = {}
        # One for all values of a line that are late, and for all that are drawn from one range.
        late: dict[PresetProblem, PresetProblem] = {}
        wrong: dict[PresetProblem, None] = {}
        n_wrong_values = 0
        for plan, base, choices in _combinations(plans):
            if len(wrong) >= MAX_PROBLEMS or n_wrong_values >= MAX_WRONG_VALUES:
                break
            try:
                variant = _variant(plan, base, choices)
            except PresetError as error:
                if any(choice.is_draw for choice in choices):
                    alike = (late.setdefault(p._replace(value=None), p) for p in error.problems)
                    wrong.update(dict.fromkeys(alike))
                else:
                    wrong.update(dict.fromkeys(error.problems))
                n_wrong_values += plan.n_values // plan.n_variants
                continue
            this, n_trials = _Made(plan, choices), self._asked.last_trial(variant.spec)
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


def _combinations(
    plans: Iterable[Plan],
) -> Iterator[tuple[Plan, presets.Base, Sequence[Choice]]]:
    """Every variant as its plan, what is the same in all variants of that, and its choices."""
    for plan in plans:
        base = presets.with_settings(plan.base, plan.fixed)
        for choices in product(*(axis.choices for axis in plan.axes)):
            yield plan, base, choices


class _Made(NamedTuple):
    """What a variant is made of."""

    plan: Plan
    choices: Sequence[Choice]

    def first_unlike(self, other: "_Made") -> tuple[Choice, Choice]:
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


def _effects(choices: Iterable[Choice], n_trials: int) -> Iterator[object]:
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


def _counted(count: int) -> str:
    """A count as a problem states it, which may be the product of hundreds of axes."""
    return str(count) if count <= _MAX_SHOWN_COUNT else f"more than {_MAX_SHOWN_COUNT}"


def _variant(plan: Plan, base: presets.Base, choices: Sequence[Choice]) -> Variant:
    """A variant of a plan, of whose base all that is fixed is a part."""
    chosen = [value for choice in choices for value in choice.values]
    spec = presets.completed(base, chosen)
    # Variants have the same keys: each text is kept once.
    overrides = {
        intern(".".join(map(str, node.key))): plain(node) for node in (*plan.fixed, *chosen)
    }
    is_draw = any(choice.is_draw for choice in choices)
    return Variant(_label(plan, choices), plan.name, spec, overrides, plan.seeds, is_draw)


def _label(plan: Plan, choices: Sequence[Choice]) -> str:
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
            return f"[{', '.join(map(_written, cast('list[object]', value)))}]"
        case _:
            return quoted(value)
