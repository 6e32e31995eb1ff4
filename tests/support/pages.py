"""Pages of documentation, taken apart: their tables, and where their links lead."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

ROOT: Final = Path(__file__).resolve().parents[2]
PAGES: Final = (
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "docs/audience.md",
    "docs/beyond.md",
    "docs/beyond/coherence.md",
    "docs/beyond/context.md",
    "docs/beyond/feudal.md",
    "docs/beyond/held.md",
    "docs/beyond/introduction.md",
    "docs/beyond/lin.md",
    "docs/beyond/not_built.md",
    "docs/beyond/q_lambda.md",
    "docs/beyond/static.md",
    "docs/beyond/templates.md",
    "docs/commands.md",
    "docs/lessons.md",
    "docs/page.md",
    "docs/references.md",
    "docs/replication.md",
    "docs/serving.md",
    "docs/sessions.md",
    "docs/sharing.md",
    "docs/speed.md",
    "docs/time.md",
    "docs/side_by_side.md",
    "docs/sharing.md",
    "docs/replay_page.md",
    "docs/audience.md",
    "presets/README.md",
    "presets/lessons/README.md",
    "presets/experiments/README.md",
)


class Link(NamedTuple):
    """A link from one page to a place."""

    target: Path
    anchor: str

    @property
    def leads_somewhere(self) -> bool:
        """Whether the file is there, and the heading in it."""
        if not self.target.exists():
            return False
        return not self.anchor or self.anchor in anchors_of(self.target)


def links_of(page: Path) -> Iterator[Link]:
    """Links from a page to other files, and to headings."""
    for address in re.findall(r"\]\(([^)\s]+)\)", page.read_text("utf-8")):
        if "://" not in address:
            file, _, anchor = address.partition("#")
            yield Link(page.parent / file if file else page, anchor)


def anchors_of(page: Path) -> set[str]:
    """What the headings of a page are called in links."""
    headings = re.findall(r"^#+ (.+)$", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def rows_of(page: str, heading: str = "") -> list[list[str]]:
    """Cells of all rows of the tables of a page, or of those below one of its headings.

    Args:
        page: path from the root.
        heading: with its signs, as ``## Keys``; up to the next one of at least its rank.
    """
    text = (ROOT / page).read_text("utf-8")
    if heading:
        rank = len(heading.partition(" ")[0])
        text = re.split(rf"^{re.escape(heading)}$", text, maxsplit=1, flags=re.MULTILINE)[1]
        text = re.split(rf"^#{{1,{rank}}} ", text, maxsplit=1, flags=re.MULTILINE)[0]
    lines = [line for line in text.splitlines() if line.startswith("|")]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return [row for row in rows if set("".join(row)) - set("-:")]
