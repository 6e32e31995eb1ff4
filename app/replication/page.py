"""Pages in Markdown, made of a template and of what came out.

A template is Markdown in which ``{{name}}`` stands for a number or a table.
"""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from importlib.resources import files
from typing import Any, Final, NamedTuple

TEMPLATES: Final = files("app.replication") / "templates"
HEADLINE_BEGINS: Final = "<!-- from the results -->"
HEADLINE_ENDS: Final = "<!-- end of what is from the results -->"

_PLACE: Final = re.compile(r"\{\{([^{}]+)\}\}")


class Table(NamedTuple):
    """A table whose first column names the rows."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]

    def markdown(self) -> str:
        """As Markdown has it; a cell holds no line breaks."""
        lines = [self.header, ["---"] * len(self.header), *self.rows]
        return "\n".join(f"| {' | '.join(map(_cell, line))} |" for line in lines)


@dataclass
class Found:
    """What came out, as the pages say it."""

    texts: dict[str, str] = field(default_factory=dict)
    """Numbers with their intervals, by name."""
    tables: dict[str, Table] = field(default_factory=dict)
    estimates: dict[str, Sequence[float]] = field(default_factory=dict)
    """By claim of a finding: value, ends of the interval, and number of runs."""
    spreads: dict[str, float] = field(default_factory=dict)
    """By claim of a finding: the standard deviation of its sum, of one run of each learner."""
    searches: dict[str, Any] = field(default_factory=dict)
    """By search, preset, and column that is to be high: the best variant, and what it sets."""

    def to_json(self) -> str:
        """As a file keeps it: read by people as well, so a row is a line."""
        return json.dumps(asdict(self), ensure_ascii=False, indent=1) + "\n"

    @classmethod
    def from_json(cls, text: str) -> "Found":
        """What a file holds."""
        found: dict[str, Any] = json.loads(text)
        found["tables"] = {name: Table(*table) for name, table in found["tables"].items()}
        return cls(**found)


def filled(template: str, found: Found) -> str:
    """A template with everything in its place.

    Raises:
        KeyError: nothing of that name came out.
    """
    tables = {name: table.markdown() for name, table in found.tables.items()}
    everything: Mapping[str, str] = {**found.texts, **tables}
    return _PLACE.sub(lambda place: everything[place[1].strip()], template)


def page(found: Found) -> str:
    """The page on the replication."""
    return filled((TEMPLATES / "replication.md").read_text("utf-8"), found)


def has_place(page: str) -> bool:
    """Whether a page has a place for what came out, between two marks."""
    return HEADLINE_ENDS in page.partition(HEADLINE_BEGINS)[2]


def with_place(page: str, template: str, found: Found) -> str:
    """A page in which a template, filled, stands between the two marks.

    Raises:
        ValueError: the marks are not there, in this order.
    """
    before, begins, rest = page.partition(HEADLINE_BEGINS)
    _, ends, after = rest.partition(HEADLINE_ENDS)
    if not has_place(page):
        raise ValueError(f"there is no {HEADLINE_BEGINS} with a {HEADLINE_ENDS} after it")
    text = filled((TEMPLATES / template).read_text("utf-8"), found)
    return f"{before}{begins}\n{text.strip()}\n{ends}{after}"


def with_headline(readme: str, found: Found) -> str:
    """A page with its headline from what came out; raises ValueError as :func:`with_place`."""
    return with_place(readme, "headline.md", found)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
