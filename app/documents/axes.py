"""Axes: what an experiment varies, each a row of choices of which a variant takes one.

How many choices and values there are is known before any of them is made.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from app.documents.ranges import Linear, Logarithmic, range_of
from app.documents.samples import Item, SameAs, Sample, label_of
from app.documents.tree import Key, Node, children, key_of, n_values, plain, without


class Choice(NamedTuple):
    """Values that are taken together."""

    values: Sequence[Node]
    """Each knows its key in the preset, and the place of the experiment it is from."""
    label: str | None = None
    whole: Node | None = None
    """Where all of it stands: its label if it has one; None if it has only its values."""
    is_draw: bool = False


@dataclass(frozen=True)
class Range:
    """Values of a range, made as they are taken."""

    node: Node
    """As it is written, with the key that its values are for."""
    numbers: Linear | Logarithmic

    def __len__(self) -> int:
        return self.numbers.size

    def __iter__(self) -> Iterator[Node]:
        return (self.node._replace(value=number) for number in self.numbers.numbers())


Column = Sequence[Node] | Range
"""The values of a key."""


@dataclass(frozen=True)
class Linked:
    """Choices of values that move together, made as they are taken."""

    columns: tuple[Column, ...]

    def __len__(self) -> int:
        return len(self.columns[0])

    def __iter__(self) -> Iterator[Choice]:
        return map(Choice, zip(*self.columns, strict=True))


@dataclass(frozen=True)
class Draws:
    """Choices of values that are drawn at random, made as they are taken."""

    node: Node
    sample: Sample
    columns: tuple[Node, ...]
    """Of each key its values if they are a list; what is drawn from a range has none yet."""

    def __len__(self) -> int:
        return self.sample.count

    def __iter__(self) -> Iterator[Choice]:
        for number, drawn in enumerate(self.sample.draws(), 1):
            values = [
                column.value[value.place]
                if isinstance(value, Item)
                else column._replace(value=value)
                for column, value in zip(self.columns, drawn, strict=True)
            ]
            yield Choice(values, label_of(number), self.node, is_draw=True)


class Axis(NamedTuple):
    """Choices of which a variant takes one."""

    keys: tuple[Key, ...]
    choices: Sequence[Choice] | Linked | Draws
    n_values: int
    """In all choices together."""


def with_key(node: Node, key: Key) -> Node:
    """The same value, and all within it, under another key."""
    match node.value:
        case dict():
            value = {name: with_key(inner, (*key, name)) for name, inner in children(node)}
        case list():
            value = [with_key(inner, (*key, index)) for index, inner in children(node)]
        case _:
            value = node.value
    return node._replace(key=key, value=value)


def column_of(name: str, node: Node) -> Column:
    """The values of a key, out of what states them."""
    key = key_of(name)
    if isinstance(node.value, list):
        return [with_key(value, key) for _, value in children(node)]
    return Range(node._replace(key=key), range_of(plain(node)))


def drawn_axis(node: Node) -> Axis:
    """The axis of what is drawn at random."""
    sample = Sample.model_validate(plain(node))
    entries = {key_of(name): of for name, of in node.value["keys"].value.items()}
    columns: list[Node] = []
    for key, own in entries.items():
        values = sample.keys[key]
        of = entries[key_of(values.same_as)] if isinstance(values, SameAs) else own
        items = [with_key(item, key) for _, item in children(of)]
        columns.append(Node(key, items if isinstance(of.value, list) else None, own.place))
    largest = (max(map(n_values, c.value)) if c.value else 1 for c in columns)
    return Axis(
        tuple(sample.keys), Draws(node, sample, tuple(columns)), sample.count * sum(largest)
    )


def choice_of(item: Node) -> Choice:
    """A choice out of the mapping that states it, with its label if it has one."""
    written = item.value.get("label")
    values = values_of(without(item, [("label",)]))
    if written is None or not written.value:
        return Choice(values, None, item)
    return Choice(values, written.value, written)


def values_of(node: Node) -> list[Node]:
    """One value for each key, out of the mapping that states them."""
    return [with_key(value, key_of(name)) for name, value in node.value.items()]
