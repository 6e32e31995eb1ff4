"""A page in the making: its sections, its tables, and the pictures that stand in it."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Final

from app.charts.paper.drawing import Drawing
from app.util.html import Markup, element, escaped, joined

FIGURE_FILES: Final = ("svg", "png", "csv", "spreadsheet.csv")
"""What a figure is written as beside the page: how the names of its files end."""
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
.warning { color: #9c2b00; font-weight: 600; }
code { font-size: .9em; overflow-wrap: anywhere; } summary { cursor: pointer; margin: .6rem 0; }
@page { size: A4 portrait; margin: 14mm 12mm; }
@media print {
  body { margin: 0; padding: 0; max-width: none; font-size: 10pt; } p { max-width: none; }
  .scroll { overflow: visible; } table { font-size: 8pt; line-height: 1.35; }
  th, td, tbody th { white-space: normal; min-width: 0; padding-right: .4rem; }
  th:first-child { overflow-wrap: anywhere; min-width: 5rem; }
  tr, figure { break-inside: avoid; } h2, h3, summary { break-after: avoid; }
  details::details-content { content-visibility: visible; block-size: auto; }
  summary { list-style: none; font-weight: 600; }
}
"""


def table(header: Sequence[object], rows: Iterable[Sequence[object]]) -> Markup:
    """A table whose first column names the rows."""
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
    return element("div", content, class_="scroll")


def details(summary: str, content: object) -> Markup:
    """Content that shows when its summary is opened."""
    return element("details", joined([element("summary", summary), content]))


def minor(text: str) -> Markup:
    """A text that steps back."""
    return element("span", text, class_="minor")


@dataclass
class Page:
    """What a report says, and the pictures it has so far."""

    commands: Sequence[str]
    figures: str
    """Name of the folder of pictures, as the page calls it."""
    sections: list[Markup] = field(default_factory=list)
    drawings: dict[str, Drawing] = field(default_factory=dict)
    warnings: Sequence[str] = ()
    """What whoever sees any picture has to know."""
    tell: Callable[[str], object] = lambda _: None
    """Told what is being done."""

    def say(self, title: str, *parts: object) -> None:
        """Add a section."""
        self.sections.append(element("section", joined([element("h2", title), *parts])))

    def small_print(self, *notes: str) -> str:
        """Notes of a picture, what one has to know, and the commands that made it."""
        return "\n".join([*notes, *self.warnings, f"Made by: {' && '.join(self.commands)}"])

    def picture(self, name: str, caption: str, drawing: Drawing) -> Markup:
        """Keep a picture, and return it as it stands in the page."""
        self.drawings[name] = drawing
        files = ", ".join(f"{self.figures}/{name}.{kind}" for kind in FIGURE_FILES)
        text = joined([caption, element("span", f"Files: {files}", class_="files")], " ")
        svg = drawing.svg.replace("<svg ", f'<svg role="img" aria-label="{escaped(caption)}" ', 1)
        return element("figure", joined([Markup(svg), element("figcaption", text)]))


def document(title: str, page: Page) -> str:
    """The whole page, to be written to a file."""
    head = joined(
        [
            Markup('<meta charset="utf-8"/>'),
            Markup('<meta name="viewport" content="width=device-width, initial-scale=1"/>'),
            element("title", title),
            element("style", Markup(_STYLE)),
        ]
    )
    body = joined([element("h1", title), *page.sections])
    content = joined([element("head", head), element("body", element("main", body))])
    return f"<!DOCTYPE html>\n{element('html', content, lang='en')}\n"
