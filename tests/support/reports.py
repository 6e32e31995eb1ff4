"""What a written report says."""

from pathlib import Path
from xml.etree import ElementTree as ET

from app.experiments.store import REPORT_PAGE
from app.report import write


def page_of(*folders: Path, compare: bool = False) -> str:
    """A page on folders, kept in the first of them with its pictures."""
    out = folders[0] / REPORT_PAGE if len(folders) > 1 else None
    return write.write_report(folders, out, compare).page.read_text(encoding="utf-8")


def text_of(page: str) -> str:
    return "\n".join(ET.fromstring(page.removeprefix("<!DOCTYPE html>")).itertext())


def table_of(page: str, word: str) -> list[dict[str, str]]:
    """Rows by their header of the first table that has a word in it; lines of cells by blanks."""
    root = ET.fromstring(page.removeprefix("<!DOCTYPE html>"))
    table = next(t for t in root.iter("table") if word in "".join(t.itertext()))
    head, *rows = ([" ".join(cell.itertext()) for cell in row] for row in table.iter("tr"))
    return [dict(zip(head, row, strict=True)) for row in rows]


def pictures_of(folder: Path) -> list[str]:
    return sorted(path.stem for path in (folder / "report_figures").glob("*.svg"))
