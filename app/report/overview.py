"""What a report begins and ends with: what was run, and how to make it again."""

import os
from collections.abc import Iterable, Sequence
from datetime import datetime
from pathlib import Path

import numpy as np

from app.analysis.axles import grouped
from app.experiments.record import Record
from app.report.document import Page, details, link, table, words
from app.report.parts import MOST_ROWS, left_out
from app.results import thesis
from app.results.horizon import Horizon
from app.results.read import Folder, Group, folder_names
from app.util.html import Markup, element, joined
from app.words.numbers import NONE, counted, in_short

_THESIS = {*thesis.FIGURES, "sentences"}
"""Experiments that are the thesis's own."""
_MOST_OPEN_ROWS = 16
_LONGEST_TITLE = 120
_FILES = {
    "results.sqlite": "the table of all runs",
    "experiment.yaml": "what was asked for",
}
"""Of a folder of results, by name: what they are."""


def title_of(read: Sequence[Folder], compare: bool) -> str:
    """What a page is about, in words."""
    if compare:
        first, second = (_title(folder) for folder in read)
        return first if first == second else f"{second}, beside: {first}"
    if len(read) > 1 and {folder.name for folder in read} <= _THESIS:
        return "The thesis's figures and findings"
    titles = [*dict.fromkeys(_title(folder) for folder in read)]
    text = "; ".join([titles[0], *(title[:1].lower() + title[1:] for title in titles[1:])])
    return text if len(text) <= _LONGEST_TITLE else f"Report on {len(titles)} experiments"


def _title(folder: Folder) -> str:
    """The beginning of what an experiment is said to be about; without that, its name in words."""
    text = " ".join(folder.description.split()).partition(". ")[0].partition(";")[0].rstrip(".")
    if not text or len(text) > _LONGEST_TITLE:
        text = (folder.name or folder.path.resolve().name).replace("_", " ")
    return text[:1].upper() + text[1:]


def opening_of(read: Sequence[Folder], rows: Sequence[Record], compare: bool) -> Sequence[Markup]:
    """When, how much and by what was run, below the title."""
    failed = sum(bool(row.error) for row in rows)
    also = f" ({failed} more failed)" if failed else ""
    seeds = {row.seed for row in rows}
    versions = ", ".join(sorted({row.version for row in rows if row.version})) or "unknown"
    names = [folder.path.resolve().name for folder in read]
    said = [
        f"{' and '.join(names)} compared" if compare else ", ".join(dict.fromkeys(names)),
        *_date(rows),
        f"{counted(len(rows) - failed, 'run')} over {counted(len(seeds), 'seed')}{also}",
        f"by version {versions} of the lab",
    ]
    return [element("p", " · ".join(said), class_="meta")]


def _date(rows: Iterable[Record]) -> list[str]:
    """The day on which the newest run ended, by UTC; none where that is not known."""
    newest = max((row.ended_at for row in rows), default="")
    try:
        day = datetime.fromisoformat(newest)
    except ValueError:
        return []
    return [f"{day.day} {day:%B %Y}"]


def write_what_was_run(
    page: Page,
    read: Sequence[Folder],
    groups: Sequence[Group],
    compare: bool,
    horizon: Horizon | None,
) -> None:
    """Write a section on what was run, on how many seeds, and where it is compared."""
    lines = [*_descriptions(read), *([] if horizon is None else [horizon.reason])]
    if compare:
        lines.append(f"A is {read[0].path}, B is {read[1].path}.")
    lines += [
        f"A stop condition or a number of steps may have ended the runs in {folder.path} early, so"
        " they do not count among the thesis's own."
        for folder in read
        if any(row.origin.limited for row in folder.rows)
    ]
    rows = [_row(group) for group in groups[:MOST_ROWS]]
    header = ("variant", "preset", "what is set in it", "runs", "seeds", "trials", "steps")
    found = joined([table(header, rows), left_out(len(groups))])
    if len(groups) > _MOST_OPEN_ROWS:
        found = details(f"The {len(groups)} variants", found)
    page.say("What was run", *(element("p", line) for line in lines), found)


def _row(group: Group) -> Sequence[object]:
    sets = ", ".join(f"{key} = {grouped(value)}" for key, value in group.overrides.items())
    trials = sorted({run.trials for run in group.runs})
    shown = f"{trials[0]:,}" if len(trials) == 1 else f"{trials[0]:,}–{trials[-1]:,}"
    steps = float(np.median([run.steps for run in group.runs]))
    preset = group.runs[0].preset_name
    return (
        group.label,
        preset if preset != group.label else NONE,
        words(sets) if sets else NONE,
        len(group.runs),
        seeds_in_words(run.seed for run in group.runs),
        shown,
        in_short(steps, m_from=1e5),
    )


def seeds_in_words(seeds: Iterable[int]) -> str:
    """Seeds as stretches of those that follow one another."""
    stretches: list[list[int]] = []
    for seed in sorted(set(seeds)):
        if stretches and seed == stretches[-1][-1] + 1:
            stretches[-1].append(seed)
        else:
            stretches.append([seed])
    shown = [str(one[0]) if len(one) == 1 else f"{one[0]}\N{EN DASH}{one[-1]}" for one in stretches]
    return ", ".join(shown if len(shown) <= 4 else [*shown[:3], "…", shown[-1]])


def _descriptions(read: Sequence[Folder]) -> list[str]:
    """What the experiments are about, each with the names of its folders if there are several."""
    names = folder_names(folder.path for folder in read)
    by_text: dict[str, list[str]] = {}
    for folder in read:
        if folder.description:
            by_text.setdefault(folder.description, []).append(names[folder.path])
    if len(names) == 1:
        return [*by_text]
    return [f"{', '.join(dict.fromkeys(which))}: {text}" for text, which in by_text.items()]


def write_again(page: Page, place: Path, read: Sequence[Folder]) -> None:
    """Write a section on how to make it all again, and where the numbers are.

    Args:
        page: to write on.
        place: where the page goes, from which its links lead.
        read: the folders it is on.
    """
    commands = [element("code", command) for command in page.commands]
    folders = [*dict.fromkeys(folder.path for folder in read)]
    names = folder_names(folders)
    files = [
        element("li", joined([_linked(place, path / name), f" ({what}, {names[path]})"], ""))
        for path in folders
        for name, what in _FILES.items()
        if (path / name).is_file()
    ]
    said = "The page and all of its pictures are made again, from nothing, by"
    page.say(
        "How to make it again",
        element("p", said),
        element("pre", joined(commands)),
        element("p", "What it is made of:"),
        element("ul", joined(files), class_="plain"),
        element("p", "Below each picture are links to its files: as SVG, as PNG, and its numbers."),
    )


def _linked(place: Path, file: Path) -> Markup:
    path = os.path.relpath(file.resolve(), place.resolve().parent)
    return link(path, file.name)
