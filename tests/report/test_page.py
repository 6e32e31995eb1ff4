"""The page of a report: its head, its contents, its links, its switches and its pictures."""

import csv
import json
import re
from pathlib import Path
from typing import Any
from urllib.parse import unquote
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from app.charts.read import schedules_of
from app.documents import presets
from app.experiments.store import REPORT_PAGE
from app.report.overview import seeds_in_words
from app.results.read import groups_of, read_folder
from tests.support.folders import add_run, new_folder, pictures
from tests.support.reports import page_of, table_of, text_of

SVG = "{http://www.w3.org/2000/svg}"


def root_of(page: str) -> ET.Element:
    return ET.fromstring(page.removeprefix("<!DOCTYPE html>"))


def one(root: ET.Element, tag: str, class_: str = "") -> ET.Element:
    """The first element of a kind."""
    found = root.iter(tag)
    return next(e for e in found if not class_ or class_ in e.get("class", "").split())


def words_of(element: ET.Element) -> str:
    return " ".join("".join(element.itertext()).split())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return new_folder(
        tmp_path / "results # with ü",
        name="my_experiment",
        description="How much it matters. And more.",
    )


def pair(folder: Path, n_seeds: int, higher: float) -> None:
    """A preset and a variant of it that ends so much higher, by the seed a little more or less."""
    for seed in range(n_seeds):
        add_run(folder, seed, final_reward=50.0 + seed, ended_at="2026-03-04T23:00:00+00:00")
        sets: dict[str, Any] = {"variant": "mine", "overrides": {"x": 1}}
        add_run(folder, seed, **sets, final_reward=50.0 + seed + higher + seed % 2)


def test_the_head_of_a_page_says_what_when_and_how_much(folder: Path) -> None:
    pair(folder, 12, 5.0)
    head = one(root_of(page_of(folder)), "header")
    assert words_of(one(head, "h1")) == "How much it matters"
    meta = words_of(one(head, "p", "meta"))
    assert "4 March 2026" in meta
    assert "24 runs over 12 seeds" in meta


def test_an_experiment_that_says_nothing_has_its_name_in_words(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "a", name="my_experiment")
    add_run(folder, 0)
    assert words_of(one(root_of(page_of(folder)), "h1")) == "My experiment"


@pytest.mark.parametrize(
    ("n_seeds", "higher", "said", "tally"),
    [
        (12, 5.0, "mine lies 5.5 [5.25, 5.75] above timed", ("1", "0", "0")),
        (12, -5.5, "mine lies 5 [4.75, 5.25] below timed", ("0", "1", "0")),
        (12, -0.5, "Undecided over 12 runs: mine differs from timed by", ("0", "0", "1")),
        (4, 5.0, "Undecided over 4 runs (4 are too few): mine differs", ("0", "0", "1")),
    ],
)
def test_the_headline_is_undecided_where_it_is(
    folder: Path, n_seeds: int, higher: float, said: str, tally: tuple[str, ...]
) -> None:
    pair(folder, n_seeds, higher)
    head = one(root_of(page_of(folder)), "header")
    headline = words_of(one(head, "p", "headline"))
    assert (
        re.sub(r"\d\.\d+", "", said)
        == re.sub(r"\d\.\d+", "", headline)[: len(re.sub(r"\d\.\d+", "", said))]
    )
    numbers = tuple(words_of(item).split()[0] for item in one(head, "ul", "tally"))
    assert numbers == tally


def test_contents_and_files_are_where_links_say(folder: Path) -> None:
    pair(folder, 3, 5.0)
    page = page_of(folder)
    root = root_of(page)
    ids = {element.get("id") for element in root.iter()}
    links = [link.get("href", "") for link in root.iter("a")]
    inside = [link for link in links if link.startswith("#")]
    assert len(inside) == len([*root.iter("section")])
    assert {link[1:] for link in inside} <= ids
    files = [unquote(link) for link in links if not link.startswith("#")]
    assert "results.sqlite" in files
    assert {"report_figures/curves.csv", "report_figures/runs.png"} <= {*files}
    assert all((folder / file).is_file() for file in files)


def test_links_lead_from_a_page_elsewhere_to_its_folders(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / "deep" / name) for name in ("a", "b ü")]
    for folder in folders:
        add_run(folder, 0)
    page_of(*folders)
    page = (folders[0] / REPORT_PAGE).read_text(encoding="utf-8")
    links = [unquote(link.get("href", "")) for link in root_of(page).iter("a")]
    assert "../b ü/results.sqlite" in links
    assert (folders[0] / "../b ü/results.sqlite").is_file()


@pytest.mark.pictures
def test_commands_stand_once_in_the_page_and_in_every_file(folder: Path) -> None:
    pair(folder, 3, 5.0)
    page = page_of(folder)
    assert page.count("Made by") == 0
    assert len(re.findall("<code>pounce experiment", page)) == 1
    files = [*(folder / "report_figures").glob("*.svg")]
    assert files
    assert all("Made by" in file.read_text(encoding="utf-8") for file in files)
    # What the small print says besides is a text of the page, and no part of its pictures.
    drawn = [words_of(svg) for svg in root_of(page).iter(f"{SVG}svg")]
    assert not any("bootstrap interval" in text for text in drawn)
    assert "95 % bootstrap interval over runs, point by point." in text_of(page)


def test_curves_have_a_switch_that_takes_no_script(folder: Path) -> None:
    pair(folder, 3, 5.0)
    root = root_of(page_of(folder))
    views = one(root, "div", "views")
    inputs = [*views.iter("input")]
    assert [i.get("checked") for i in inputs] == ["checked", None, None]
    assert len({i.get("name") for i in inputs}) == 1
    labels = {label.get("for"): words_of(label) for label in views.iter("label")}
    named = [labels[i.get("id")] for i in inputs]
    assert re.fullmatch(r"windows of [\d,]+ consecutive trials", named[0])
    assert re.fullmatch(r"windows of [\d,]+ steps", named[1])
    assert named[2].endswith("against trials")
    assert len([*views.iter("figure")]) == 3


def test_what_too_few_seeds_leave_undecided_is_one_line(folder: Path) -> None:
    share = np.full((2, 18, 24), 0.5)
    for seed in range(3):
        add_run(folder, seed, arrays=pictures([12_000, 14_500], share, 10 * share))
        add_run(folder, seed, preset="standard_q", share=0.2)
    root = root_of(page_of(folder))
    items = [words_of(item) for item in one(root, "ul", "tally")]
    (n,) = (item.split()[0] for item in items if item.endswith("undecided"))
    assert int(n) > 5
    (summary,) = (e for e in root.iter("details") if "is tested" in words_of(e))
    line = f"{n} findings are undecided for having fewer than 10 seeds"
    assert words_of(one(summary, "summary")) == line
    assert words_of(root).count("what is tested") == words_of(summary).count("what is tested")


def session(folder: Path, n_seeds: int = 12) -> None:
    """Runs as a session's schedule leaves them: its preset written out, and what was done."""
    former = presets.load("timed")
    at = ["schedule.skills.circle_clockwise.at=50", "schedule.episodes.0.duration=20"]
    mine = presets.load("timed", at)
    # The session comes first, as in folders of older versions.
    for label, spec, reward in (("this session", mine, 40.0), ("timed as it was", former, 60.0)):
        for seed in range(n_seeds):
            settings = json.dumps(spec.model_dump(mode="json"))
            add_run(folder, seed, label, settings=settings, final_reward=reward + seed)


def test_a_session_is_set_against_its_preset_and_shows_its_schedule(folder: Path) -> None:
    session(folder)
    page = page_of(folder)
    headline = words_of(one(root_of(page), "p", "headline"))
    assert headline.startswith("this session lies 20 [20, 20] below timed as it was")
    rows = {row["variant"]: row for row in table_of(page, "P(variant higher)")}
    difference = "final reward: difference to timed as it was [95 %]"
    assert rows["this session"][difference].startswith("\N{MINUS SIGN}20 ")
    with (folder / "report_figures" / "schedules.csv").open(encoding="utf-8") as file:
        planned = [row for row in csv.DictReader(file) if row["skill"] == "circle_clockwise"]
    explored = {row["variant"]: row for row in planned if row["what"] == "explored"}
    assert [
        (row["from_trial"], row["to_trial"], row["probability"])
        for row in (explored["this session"], explored["timed as it was"])
    ] == [("50", "70", "0.95"), ("12000", "14000", "0.95")]


def test_variants_that_share_a_schedule_share_its_lanes(folder: Path) -> None:
    for label, sets in (("timed", {}), ("other", {"learner.alpha": 0.3})):
        settings = presets.load("timed").model_dump(mode="json")
        add_run(folder, 0, variant=label, overrides=sets, settings=json.dumps(settings))
    lanes = schedules_of(groups_of(read_folder(folder).rows)).lanes
    assert [lane.skill for lane in lanes] == ["approach", "circle_clockwise", "avoid"]
    assert {lane.variant for lane in lanes} == {"timed, other"}
    assert lanes[1].words == "at 12,000, frozen 300, explored 2,000 at 95%"


def test_a_schedule_says_which_skills_join_by_a_rule(folder: Path) -> None:
    settings = presets.load("timed_auto").model_dump(mode="json")
    add_run(folder, 0, variant="mine", settings=json.dumps(settings))
    chart = schedules_of(groups_of(read_folder(folder).rows))
    words = "once reach of 500 trials is below 0.01, frozen 300, explored 2,000 at 95%"
    assert [lane.words for lane in chart.lanes][:2] == ["from the start, frozen 300", words]
    assert ["mine", "circle_clockwise", words, "", "", ""] in chart.numbers
    assert "When skills join" in text_of(page_of(folder))


def test_learners_whose_skills_are_all_there_have_no_schedule(folder: Path) -> None:
    add_run(folder, 0, preset="hierarchical_3")
    assert not schedules_of(groups_of(read_folder(folder).rows)).lanes
    assert "When skills join" not in text_of(page_of(folder))


def test_what_was_run_names_presets_settings_and_seeds(folder: Path) -> None:
    pair(folder, 3, 5.0)
    rows = {row["variant"]: row for row in table_of(page_of(folder), "what is set in it")}
    assert (rows["mine"]["preset"], rows["mine"]["what is set in it"]) == ("timed", "x = 1")
    assert (rows["mine"]["runs"], rows["mine"]["seeds"]) == ("3", "0–2")


def test_seeds_are_told_by_stretches() -> None:
    assert seeds_in_words([3, 1, 2, 7]) == "1–3, 7"
    assert seeds_in_words(range(0, 20, 2)) == "0, 2, 4, …, 18"
