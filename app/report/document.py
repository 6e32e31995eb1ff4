"""A page in the making: its sections, its tables, and the pictures that stand in it."""

import os
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple
from urllib.parse import quote

from app.charts.paper.drawing import Drawing
from app.report.style import STYLE
from app.util.html import Markup, element, escaped, joined

FIGURE_FILES: Final = ("svg", "png", "csv", "spreadsheet.csv")
"""What a figure is written as beside the page: how the names of its files end."""
_FILE_NAMES: Final = ("SVG", "PNG", "CSV", "CSV for spreadsheets")
_WIDE_RATIO: Final = 2.2
"""Width by height from which on a picture has several panels, which need room."""


class Count(NamedTuple):
    """How many of the things that a report tallies came out in one way."""

    number: int
    what: str
    look: str = "undecided"
    """A class of the style: ``holds``, ``fails`` or ``undecided``."""


class Section(NamedTuple):
    """A part of the page that the list of contents leads to."""

    id: str
    title: str
    content: Markup


class View(NamedTuple):
    """One of several ways to see the same."""

    name: str
    content: Markup


def table(header: Sequence[object], rows: Iterable[Sequence[object]]) -> Markup:
    """A table whose first column names the rows; it is moved in its own frame if it is wide."""
    head = element("tr", joined((element("th", cell, scope="col") for cell in header), ""))
    lines = [
        element(
            "tr",
            joined(
                [element("th", row[0], scope="row"), *(element("td", cell) for cell in row[1:])],
                "",
            ),
        )
        for row in rows
    ]
    content = element("table", joined([element("thead", head), element("tbody", joined(lines))]))
    first = Markup(escaped(header[0])).striptags() if header else ""
    return _frame(content, f"Table by {first}")


def grouped_table(
    header: Sequence[object], groups: Iterable[tuple[object, Sequence[Sequence[object]]]]
) -> Markup:
    """A table whose first column names several rows at once.

    Args:
        header: of all columns.
        groups: a name, and the other cells of each of its rows.
    """
    head = element("tr", joined((element("th", cell, scope="col") for cell in header), ""))
    bodies: list[Markup] = []
    for name, rows in groups:
        lines = [[element("td", cell) for cell in row] for row in rows]
        lines[0].insert(0, element("th", name, scope="rowgroup", rowspan=str(len(rows))))
        bodies.append(element("tbody", joined(element("tr", joined(cells, "")) for cells in lines)))
    content = element("table", joined([element("thead", head), *bodies]))
    return _frame(content, f"Table by {header[0]}")


def _frame(content: object, name: str) -> Markup:
    """A frame in which what is too wide can be moved, by keys as well."""
    told = {"aria-label": name, "tabindex": "0"}
    return element("div", content, class_="scroll", role="region", **told)


def details(summary: str, content: object) -> Markup:
    """Content that shows when its summary is opened."""
    return element("details", joined([element("summary", summary), content]))


def minor(text: str) -> Markup:
    """A text that steps back."""
    return element("span", text, class_="minor")


def words(text: object) -> Markup:
    """A cell of a table that is a sentence, and may break into lines."""
    return element("span", text, class_="words")


def link(path: str, text: str) -> Markup:
    """A link to a file by its path from the page, whatever bytes that has."""
    return element("a", text, href=quote(os.fsencode(path)))


def switch(name: str, what: str, views: Sequence[View]) -> Markup:
    """Views of which one shows, the first until another is chosen; without a script.

    Args:
        name: that no other switch of the page has.
        what: is seen, in words.
        views: at most three, of which a sheet of paper has the chosen one.
    """
    if len(views) == 1:
        return views[0].content
    parts: list[Markup] = []
    for place, view in enumerate(views):
        id = f"view-{name}-{place}"
        checked = ' checked="checked"' if not place else ""
        parts.append(Markup(f'<input type="radio" name="view-{name}" id="{id}"{checked}/>'))
        parts.append(element("label", view.name, **{"for": id}))
    others = "; ".join(view.name for view in views)
    note = f"One of {len(views)} views ({others}); the files have them all."
    told = element("p", note, class_="note on-paper")
    parts += [element("div", joined([view.content, told])) for view in views]
    named = {"aria-label": f"Ways to see: {what}"}
    return element("div", joined(parts), class_="views", role="group", **named)


@dataclass
class Page:
    """What a report says, and the pictures it has so far."""

    commands: Sequence[str]
    figures: str
    """Name of the folder of pictures, as the page calls it."""
    sections: list[Section] = field(default_factory=list)
    drawings: dict[str, Drawing] = field(default_factory=dict)
    warnings: Sequence[str] = ()
    """What whoever sees any picture has to know."""
    tell: Callable[[str], object] = lambda _: None
    """Told what is being done."""
    headline: str = ""
    """What came out, in a sentence or two: what the first section that has something says."""
    tally: list[Count] = field(default_factory=list)
    """Of verdicts; empty where none are passed."""

    def say(self, title: str, *parts: object) -> None:
        """Add a section, which the list of contents leads to."""
        self.sections.append(self._section(title, parts))

    def lead(self, headline: str) -> None:
        """Put what came out at the head of the page, unless something stands there already."""
        self.headline = self.headline or headline

    def count(self, *counts: Count) -> None:
        """Put a tally at the head of the page, unless there is one already."""
        self.tally = self.tally or [*counts]

    def small_print(self, *notes: str) -> str:
        """Notes of a picture, what one has to know, and the commands that made it."""
        return "\n".join([*notes, *self._foot])

    def picture(self, name: str, caption: str, drawing: Drawing) -> Markup:
        """Keep a picture, and return it as it stands in the page, with links to its files.

        In its files the small print has warnings and commands, which the page has once.
        """
        self.drawings[name] = drawing
        files = [
            link(f"{self.figures}/{name}.{kind}", text)
            for kind, text in zip(FIGURE_FILES, _FILE_NAMES, strict=True)
        ]
        below = [
            element("strong", caption),
            *(element("div", note, class_="note") for note in self._notes(drawing)),
            element("div", joined(["Files:", *files], " "), class_="files"),
        ]
        look = ' class="wide"' if drawing.width > _WIDE_RATIO * drawing.height else ""
        start = f'<svg role="img" aria-label="{escaped(caption)}"{look} '
        svg = Markup(drawing.inline.replace("<svg ", start, 1))
        return element(
            "figure",
            joined([_frame(svg, f"Picture: {caption}"), element("figcaption", joined(below))]),
        )

    @property
    def _foot(self) -> Sequence[str]:
        return (*self.warnings, f"Made by: {' && '.join(self.commands)}")

    def _notes(self, drawing: Drawing) -> Sequence[str]:
        notes = drawing.small_print.removesuffix("\n".join(self._foot))
        return [note for note in notes.splitlines() if note]

    def _section(self, title: str, parts: Iterable[object]) -> Section:
        slug = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-") or "part"
        taken = {section.id for section in self.sections}
        # No part of a picture begins so, whatever it is called.
        id = f"section-{slug}"
        number = 1
        while id in taken:
            number += 1
            id = f"section-{slug}-{number}"
        content = element("section", joined([element("h2", title), *parts]), id=id)
        return Section(id, title, content)


def document(title: str, opening: Sequence[object], page: Page) -> str:
    """The whole page, to be written to a file.

    Args:
        title: of the page.
        opening: what stands below the title, before the headline and the tally.
        page: all else.
    """
    head = joined(
        [
            Markup('<meta charset="utf-8"/>'),
            Markup('<meta name="viewport" content="width=device-width, initial-scale=1"/>'),
            element("title", title),
            element("style", Markup(STYLE)),
        ]
    )
    warnings = [element("p", text, class_="warning") for text in page.warnings]
    headline = element("p", page.headline, class_="headline") if page.headline else Markup()
    top = element(
        "header", joined([element("h1", title), *opening, *warnings, headline, _tally(page.tally)])
    )
    main = element("main", joined(section.content for section in page.sections))
    paper = element("div", joined([top, _contents(page.sections), main]), class_="paper")
    content = joined([element("head", head), element("body", paper)])
    return f"<!DOCTYPE html>\n{element('html', content, lang='en')}\n"


def _tally(counts: Sequence[Count]) -> Markup:
    if not counts:
        return Markup()
    items = [
        element("li", joined([element("strong", f"{number:,}"), what], " "), class_=look)
        for number, what, look in counts
    ]
    return element("ul", joined(items), class_="tally")


def _contents(sections: Sequence[Section]) -> Markup:
    items = [
        element("li", element("a", section.title, href=f"#{section.id}")) for section in sections
    ]
    list_ = joined([element("h2", "Contents"), element("ol", joined(items))])
    return element("nav", list_, class_="contents", **{"aria-label": "Contents"})
