"""The report: from folders of results to a page that stands for itself."""

import contextlib
import csv
import itertools
import json
import os
import re
import shlex
import sqlite3
import stat
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tyro

from app import metrics
from app.analysis.axles import Axle
from app.charts.paper import fonts
from app.charts.paper.drawing import Drawing
from app.cli import main
from app.cli.report import Report
from app.documents import presets
from app.experiments.record import Origin, Record
from app.experiments.store import REPORT_PAGE
from app.experiments.table import connect, note
from app.report import parts, write
from app.report.document import FIGURE_FILES
from app.report.sections.compare import pairs_of
from app.results.read import Group, ResultsError
from tests.support.folders import N_TRIALS, add_arrays, add_run, new_folder, pictures, seal
from tests.support.reports import page_of, pictures_of, table_of, text_of

CIRCLE = "schedule.skills.circle_clockwise.at"
FINAL = metrics.FINAL_REWARD.of_runs(N_TRIALS, N_TRIALS)
AREA = metrics.AREA
AVOID = "schedule.skills.avoid.at"
HOSTILE = '<script>alert("x")</script> & \x00 $\\frac$ http\ud800'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return new_folder(tmp_path / "results with blanks, ünicode # and ?")


def codes_of(page: str) -> list[str]:
    root = ET.fromstring(page.removeprefix("<!DOCTYPE html>"))
    return ["".join(code.itertext()) for code in root.iter("code")]


def tally_of(page: str) -> dict[str, tuple[str, str]]:
    """How many cells of the first plane differ, and which share they are, by how they do."""
    root = ET.fromstring(page.removeprefix("<!DOCTYPE html>"))
    table = next(t for t in root.iter("table") if "share of" in "".join(t.itertext()))
    rows = [["".join(cell.itertext()) for cell in row] for row in table.iter("tr")]
    return {what: (n, share) for what, n, share in rows}


def rows_of(folder: Path, name: str) -> list[dict[str, str]]:
    with (folder / "report_figures" / f"{name}.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


# --- The page ------------------------------------------------------------------------------------


@pytest.mark.pictures
def test_the_page_is_well_formed_stands_for_itself_and_names_its_command(folder: Path) -> None:
    for seed in range(3):
        add_run(folder, seed)
        add_run(folder, seed, preset="standard_q", share=0.2)
    page = page_of(folder)
    text = text_of(page)
    assert "pounce report" in text
    assert f"pounce experiment '{folder}/experiment.yaml' --seeds 3" in text
    outside = page.replace("http://www.w3.org/2000/svg", "")
    outside = outside.replace("http://www.w3.org/1999/xlink", "")
    for reference in ("http:", "https:", "src=", "<script", "@import", "<link"):
        assert reference not in outside
    root = ET.fromstring(page.removeprefix("<!DOCTYPE html>"))
    ids = [element.get("id") for element in root.iter() if element.get("id")]
    assert len(ids) == len(set(ids))


def test_the_same_results_give_the_same_page(folder: Path) -> None:
    for seed in range(3):
        add_run(folder, seed)
    assert page_of(folder) == page_of(folder)


def test_hostile_names_are_escaped(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "<b>&amp;$x$", name="<i>$y_$")
    hostile = HOSTILE.encode("utf-8", "replace").decode()
    for seed in range(2):
        add_run(folder, seed, variant=hostile, overrides={"<key>": "<value>"})
        add_run(folder, seed, variant="$x^{$", overrides={"<key>": "]]>"})
    add_run(folder, 5, status="failed", error="<b>broken</b>")
    page = page_of(folder)
    assert "<script" not in page
    assert "<b>" not in page
    assert "alert(" in text_of(page)
    assert "<b>broken</b>" in text_of(page)


def test_failed_runs_and_unreadable_logs_are_listed_and_do_not_count(folder: Path) -> None:
    for seed in range(4):
        add_run(folder, seed)
    add_run(folder, 7, status="failed", error="out of luck", final_reward=None, digest=None)
    (folder / "arrays" / "k1.npz").write_bytes(b"not an archive")
    (folder / "arrays" / "k2.npz").unlink()
    text = text_of(page_of(folder))
    assert "out of luck" in text
    assert "timed, seed 1" in text
    assert "timed, seed 2" in text
    assert {row["n"] for row in rows_of(folder, "curves") if row["low"]} == {"2"}


def test_copies_of_a_run_count_once(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / name) for name in "ab"]
    for folder in folders:
        for seed in range(2):
            add_run(folder, seed)
    page_of(*folders)
    assert {row["n"] for row in rows_of(folders[0], "curves") if row["low"]} == {"2"}


def test_variants_of_one_folder_with_the_same_settings_are_both_there(tmp_path: Path) -> None:
    settings = json.dumps(presets.load("timed").model_dump(mode="json"))
    folders = [new_folder(tmp_path / name) for name in "ab"]
    sets = {"schedule.skills.avoid.freeze": 300}
    for seed in range(2):
        run: dict[str, Any] = {"settings": settings, "digest": f"of {seed}"}
        add_run(folders[0], seed, **run)
        add_run(folders[0], seed, variant="freeze=300", overrides=sets, **run)
        add_run(folders[1], seed, variant="the same elsewhere", **run)
    text = text_of(page_of(folders[0]))
    assert "4 runs over 2 seeds" in text
    rows = [row for row in rows_of(folders[0], "curves") if row["low"]]
    assert {(row["line"], row["n"]) for row in rows} == {("timed", "2"), ("freeze=300", "2")}
    # Copies in another folder are, and a folder named twice is no other.
    text = text_of(page_of(*folders, folders[0]))
    assert "4 runs over 2 seeds" in text
    assert "the same elsewhere" not in text


def test_a_run_that_may_have_ended_early_is_no_copy_of_one_that_may_not(tmp_path: Path) -> None:
    limited = new_folder(tmp_path / "limited", stop='{"success": 0.9}')
    whole = new_folder(tmp_path / "whole")
    settings = [presets.load(name) for name in ("timed", "standard_q")]
    for spec, preset in zip(settings, ("timed", "standard_q"), strict=True):
        for folder in (limited, whole):
            add_run(folder, 0, preset, settings=json.dumps(spec.model_dump(mode="json")))
    text = text_of(page_of(limited))
    assert "Figure 4.1" not in text
    assert "Findings" not in text
    assert f"may have ended the runs in {limited} early" in text
    text = text_of(page_of(limited, whole))
    assert "4 runs over 1 seed ·" in text
    assert "Figure 4.1" in text
    assert {row["n"] for row in rows_of(limited, "figure_4_1") if row["reward"]} == {"1"}


def test_the_command_of_a_page_makes_this_very_page(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / name) for name in "ab"]
    for folder in folders:
        add_run(folder, 0)
    out = tmp_path / "of mine.html"
    for compare in (False, True):
        page = write.write_report(folders, out, compare).page.read_text(encoding="utf-8")
        (line,) = (code for code in codes_of(page) if code.startswith("pounce report"))
        command = tyro.cli(Report, args=shlex.split(line)[2:])
        assert command == Report(tuple(map(str, folders)), compare, str(out))
    page = write.write_report(folders, None, False).page.read_text(encoding="utf-8")
    assert f"pounce report {folders[0]} {folders[1]}" in codes_of(page)


# --- Figures -------------------------------------------------------------------------------------


def test_the_csv_has_the_numbers_of_the_curve(folder: Path) -> None:
    for seed in range(3):
        add_run(folder, seed)
    page_of(folder)
    rows = rows_of(folder, "curves")
    means = [row for row in rows if "introduction" not in row["line"]]
    curves = []
    for seed in range(3):
        captured = np.random.default_rng(seed).random(N_TRIALS) < 0.5
        curves.append(np.where(captured, 100.0, -50.0).reshape(-1, 5).mean(axis=1))
    expected = np.mean(curves, axis=0)
    np.testing.assert_allclose([float(row["reward"]) for row in means], expected)
    assert means[1]["from_steps"] == "50"
    assert means[1]["to_steps"] == "100"
    marks = [row for row in rows if "introduction" in row["line"]]
    assert [(row["line"], row["from_steps"]) for row in marks] == [
        ("timed: introduction of avoid", "1000.0")
    ]


def test_every_figure_comes_as_svg_png_and_two_kinds_of_csv(folder: Path) -> None:
    for seed in range(2):
        add_run(folder, seed)
    page_of(folder)
    files = sorted(path.name for path in (folder / "report_figures").iterdir())
    curves = ("curves", "curves_by_trials", "curves_trials")
    stems = (*curves, "passages", "runs", "schedules")
    assert files == sorted(f"{stem}.{kind}" for stem in stems for kind in FIGURE_FILES)
    assert (folder / "report_figures" / "curves.png").read_bytes().startswith(b"\x89PNG")
    ET.parse(folder / "report_figures" / "curves.svg")


@pytest.mark.pictures
def test_labels_in_any_script_are_text_and_what_no_font_has_is_said(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(fonts, "system_fonts", lambda: ())
    for seed in range(2):
        add_run(folder, seed, variant="先学接近")
        add_run(folder, seed, variant="=1+1 Räuber")
    assert main.main(["report", str(folder)]) == 0
    said = [line for line in capsys.readouterr().err.splitlines() if "font" in line]
    note = "No font of this machine has 先, 学, 接, 近: boxes in PNG files; SVG files and pages"
    assert len(said) == 1
    assert said[0].startswith(note)
    page = (folder / REPORT_PAGE).read_text(encoding="utf-8")
    assert page.count(note) == 1
    for path in (folder / "report_figures" / "curves.svg", folder / REPORT_PAGE):
        assert re.search("<text[^>]*>先学接近 ", path.read_text(encoding="utf-8"))
    assert "report_figures/curves.spreadsheet.csv" in page
    sheet = (folder / "report_figures" / "curves.spreadsheet.csv").read_bytes()
    assert sheet.startswith("\ufeffpanel,line,".encode())
    assert ",'=1+1 Räuber,".encode() in sheet
    assert ",=1+1 Räuber,".encode() in (folder / "report_figures" / "curves.csv").read_bytes()


def test_with_a_font_for_every_character_nothing_is_said(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for seed in range(2):
        add_run(folder, seed, variant="先学接近")
    monkeypatch.setattr(fonts, "_known", lambda: frozenset(range(0x10000)))
    assert main.main(["report", str(folder)]) == 0
    assert "font" not in capsys.readouterr().err
    assert "No font" not in (folder / REPORT_PAGE).read_text(encoding="utf-8")


@pytest.mark.pictures
def test_a_plane_has_each_cell_with_its_interval_under_the_pointer(folder: Path) -> None:
    for at in (1, 2):
        for p in (0.1, 0.3):
            if (at, p) != (2, 0.3):
                for seed in range(2):
                    add_run(
                        folder,
                        seed,
                        variant=f"{at} {p}",
                        overrides={"at": at, "p": p},
                        final_reward=at + 10 * p + seed,
                    )
    page = page_of(folder)
    rows = rows_of(folder, "plane_1_final_reward")
    assert [(row["at"], row["p"], row["n"]) for row in rows] == [
        ("1", "0.1", "2"),
        ("1", "0.3", "2"),
        ("2", "0.1", "2"),
    ]
    label = FINAL.label
    assert [float(row[label]) for row in rows] == [2.5, 4.5, 3.5]
    assert "<title>at = 2, p = 0.1: 3.5 [3, 4], n = 2</title>" in page


def test_settings_that_move_together_are_one_axis(folder: Path) -> None:
    for freeze in (0, 30, 300):
        overrides = {"approach.freeze": freeze, "avoid.freeze": freeze, "trials": 100}
        for seed in range(2):
            add_run(folder, seed, variant=str(freeze), overrides=overrides)
    page_of(folder)
    rows = rows_of(folder, "sweep_1_final_reward")
    assert [row["{approach, avoid}.freeze"] for row in rows] == ["0", "30", "300"]


def timing_runs(folder: Path, circles: Sequence[int], n_seeds: int = 5, **columns: Any) -> None:
    """A plane of introduction times: later ones of circle are better, by the seed as well."""
    for circle in circles:
        for avoid in (0, 14_500):
            sets = {CIRCLE: circle, AVOID: avoid}
            words = [f"{key}={value}" for key, value in sets.items()]
            settings = presets.load("timed", words).model_dump(mode="json")
            for seed in range(n_seeds):
                add_run(
                    folder,
                    seed,
                    variant=f"{circle} {avoid}",
                    overrides=sets,
                    settings=json.dumps(settings),
                    **{"final_reward": circle / 1000 + 10 * seed, **columns},
                )


def test_cells_are_set_against_the_presets_own_setting(folder: Path) -> None:
    timing_runs(folder, (0, 8_000, 12_000, 16_000))
    page = page_of(folder)
    rows = rows_of(folder, "difference_1_final_reward")
    what = "final reward: difference to the preset's own setting (12,000 and 14,500)"
    assert {(row[CIRCLE], row[AVOID], row[what]) for row in rows} == {
        *(("0", avoid, "-12.0") for avoid in ("0", "14500")),
        *(("8000", avoid, "-4.0") for avoid in ("0", "14500")),
        ("12000", "0", "0.0"),
        *(("16000", avoid, "4.0") for avoid in ("0", "14500")),
    }
    assert {row["n"] for row in rows} == {"5"}
    counts = tally_of(page)
    assert counts["higher by less than 5"] == ("2", "29 %")
    assert counts["lower by less than 5"] == ("2", "29 %")
    assert counts["lower by 5 to 15"] == ("2", "29 %")
    assert counts["cannot be told apart: the interval includes 0"] == ("1", "14 %")
    assert counts["lower by more than 15"] == ("0", "0 %")
    text = text_of(page)
    assert "trial at which circle clockwise joins" in text
    assert "5 (71 %) lie less than 5 from the preset's own setting" in text
    assert "chosen for having come out highest" not in text


def test_without_the_presets_own_setting_cells_are_set_against_the_highest(folder: Path) -> None:
    timing_runs(folder, (0, 8_000, 16_000))
    page = page_of(folder)
    assert "difference to the highest cell (16,000 and 0)" in text_of(page)
    assert "chosen for having come out highest" in text_of(page)
    assert tally_of(page)["lower by more than 15"] == ("2", "40 %")


def test_single_runs_make_a_plane_of_which_nothing_can_be_told(folder: Path) -> None:
    timing_runs(folder, (0, 12_000), n_seeds=1)
    page = page_of(folder)
    assert "Single runs give no interval." in text_of(page)
    assert "whole interval" not in text_of(page)
    assert tally_of(page)["cannot be told apart: the interval includes 0"] == ("0", "0 %")
    assert tally_of(page)["no interval: single runs"] == ("3", "100 %")


def test_the_metric_that_is_asked_for_first_is_shown_first(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "plane", metrics=["steps_to_50", "flights", "area"])
    timing_runs(folder, (0, 12_000), final_reward=None, flights=7)
    page = page_of(folder)
    assert [name for name in pictures_of(folder) if "plane" in name or "difference" in name] == [
        "difference_1_area",
        "difference_1_flights",
        "plane_1_area",
        "plane_1_flights",
    ]
    assert page.index('id="plane_1_flights') < page.index('id="plane_1_area')
    assert "final reward" not in text_of(page)


def test_variants_are_set_against_the_first_in_the_metric_asked_for(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "variants", metrics=["greedy_success"])
    for seed in range(5):
        nothing: dict[str, Any] = {"final_reward": None, "area": None}
        add_run(folder, seed, **nothing, greedy_success=0.5)
        add_run(folder, seed, variant="b", overrides={"x": 0}, **nothing, greedy_success=0.75)
    page = page_of(folder)
    found = [row for row in rows_of(folder, "variants") if row["row"] == "b"]
    assert [float(row["value"]) for row in found] == [0.75, 0.25]
    assert {row["quantity"] for row in rows_of(folder, "variants")} == {
        "greedy success (share of captures)",
        "greedy success: difference to timed",
    }
    assert "final reward" not in text_of(page)


def test_folders_that_differ_are_compared_in_the_metric_of_the_first(tmp_path: Path) -> None:
    first = new_folder(tmp_path / "a", metrics=["captures", "final_reward"])
    second = new_folder(tmp_path / "b")
    for seed in range(5):
        add_run(first, seed, captures=10, final_reward=1.0)
        add_run(second, seed, captures=12, final_reward=2.0)
    page_of(first, second, compare=True)
    (row,) = rows_of(first, "difference")
    assert (row["quantity"], row["value"]) == ("B \N{MINUS SIGN} A: captures", "2.0")


def spread_runs(folder: Path, arrays: Mapping[str, np.ndarray]) -> None:
    for seed in range(2):
        add_run(folder, seed, arrays=arrays)
        add_run(folder, seed, preset="standard_q", share=0.2)


@pytest.mark.pictures
def test_the_spread_of_value_is_drawn_and_its_findings_are_listed(folder: Path) -> None:
    share = np.zeros((2, 18, 24))
    share[:, :12, 8:17] = 0.5
    steps = np.where(share > 0, 12.0, np.nan)
    spread_runs(folder, pictures([12_000, 14_500], share, steps))
    page = page_of(folder)
    text = text_of(page)
    assert "above 0.9 of the states" in text
    assert "1.00 [1.00, 1.00]" in text
    rows = rows_of(folder, "value_spread")
    assert len(rows) == 2 * 18 * 24
    (row,) = (
        row
        for row in rows
        if row["moment"].startswith("circling")
        and row["from_cells"] == "0.0"
        and row["degrees_from_ahead"] == "180.0"
    )
    assert (row["share"], row["steps"], row["n"]) == ("0.5", "12.0", "2")
    assert (folder / "report_figures" / "value_spread.svg").stat().st_size < 300_000
    assert "<image" in page


@pytest.mark.parametrize(("n_seeds", "said"), [(9, True), (10, False)])
def test_findings_that_too_few_seeds_leave_undecided_say_first_how_many_it_takes(
    folder: Path, n_seeds: int, said: bool
) -> None:
    share = np.full((2, 18, 24), 0.5)
    for seed in range(n_seeds):
        add_run(folder, seed, arrays=pictures([12_000, 14_500], share, 10 * share))
        add_run(folder, seed, preset="standard_q", share=0.2)
    text = text_of(page_of(folder))
    assert ("So few seeds decide nothing" in text) is said
    if said:
        assert text.index("--seeds 30") < text.index("Each finding is a quantity")


def test_without_a_moment_of_the_thesis_no_spread_is_drawn(folder: Path) -> None:
    spread_runs(folder, {})
    page_of(folder)
    assert not (folder / "report_figures" / "value_spread.svg").exists()


def test_variants_with_settings_of_their_own_are_set_against_the_first(folder: Path) -> None:
    for seed in range(5):
        add_run(folder, seed, final_reward=80.0 + seed)
        add_run(folder, seed, variant="without", overrides={"x": 0}, final_reward=70.0 + seed)
    page = page_of(folder)
    found = [row for row in rows_of(folder, "variants") if row["row"] == "without"]
    assert [float(row["value"]) for row in found] == [72.0, -10.0]
    assert (found[1]["low"], found[1]["high"]) == ("-10.0", "-10.0")
    assert "0.00" in text_of(page)


def test_the_interquartile_means_of_variants_and_of_their_differences(folder: Path) -> None:
    for seed, wild in enumerate((-1000.0, *[0.0] * 8, 1000.0)):
        add_run(folder, seed, flights=10 * seed)
        add_run(folder, seed, final_reward=10.0 * seed, variant="base", overrides={"x": 1})
        add_run(folder, seed, final_reward=10.0 * seed + wild, variant="wild", overrides={"x": 0})
    for seed in range(9):
        add_run(folder, seed, final_reward=1.0, variant="few", overrides={"x": 2})
    rows = {row["variant"]: row for row in table_of(page_of(folder), "P(variant higher)")}
    assert not any("P(variant better)" in row for row in rows.values())
    label = f"{FINAL.label} [95 %]"
    assert "IQM 45" in rows["base"][label]
    assert "IQM 45" in rows["wild"][label]
    assert "IQM" not in rows["few"][label]
    difference = "final reward: difference to timed [95 %]"
    assert "IQM" in rows["wild"][difference]
    assert rows["timed"][difference] == "–"
    assert "IQM" not in rows["few"][difference]


def test_values_on_a_scale_of_ratios() -> None:
    assert Axle("x", (10, 30, 100, 300)).is_logarithmic
    assert not Axle("x", (10, 20, 30, 40)).is_logarithmic
    assert not Axle("x", (0, 20, 40)).is_logarithmic
    assert not Axle("x", ("a", "b", "c")).is_logarithmic
    assert Axle("x", (0, 30, 100, 1000)).is_crowded
    assert not Axle("x", (0.1, 0.3, 0.95)).is_crowded


# --- Many variants -------------------------------------------------------------------------------

KEYS = ("learner.epsilon", "learner.alpha", "learner.gamma", "schedule.skills.avoid.freeze")


def many_runs(folder: Path, n_seeds: int = 3, named: bool = False) -> None:
    """18 variants of four settings, of which the last two move together."""
    for epsilon, alpha, gamma in itertools.product((0.05, 0.1, 0.2), (1, 2, 3), (0.9, 0.99)):
        sets: dict[str, Any] = dict(
            zip(KEYS, (epsilon, alpha, gamma, 300 if gamma == 0.9 else 3_000), strict=True)
        )
        label = ", ".join(["timed", *(f"{key}={value}" for key, value in sets.items())])
        for seed in range(n_seeds):
            add_run(
                folder,
                seed,
                variant=label.replace("=", " ") if named else label,
                overrides=sets,
                final_reward=100 * epsilon + alpha + 10 * seed,
            )


def test_variants_of_many_settings_have_short_names_and_it_is_said_what_they_are(
    folder: Path,
) -> None:
    many_runs(folder)
    page = page_of(folder)
    names = [row["row"] for row in rows_of(folder, "variants")]
    assert names[0] == "0.05 / 1 / 0.9, 300"
    assert len({*names}) == 18
    what = " / ".join((*KEYS[:2], f"{KEYS[2]}, {KEYS[3]}"))
    # With the differences, all views of the curves, the passages and the scalars.
    assert text_of(page).count(f"named by their values of {what}, in this order.") == 6
    assert "final reward: difference to 0.05 / 1 / 0.9, 300 [95 %]" in text_of(page)


def test_variants_that_somebody_has_named_keep_their_names(folder: Path) -> None:
    many_runs(folder, n_seeds=1, named=True)
    page = page_of(folder)
    assert "named by their values" not in text_of(page)
    assert rows_of(folder, "variants")[0]["row"].startswith("timed, learner.epsilon 0.05")


def test_each_of_many_settings_has_its_mean_over_all_others(folder: Path) -> None:
    many_runs(folder)
    page = page_of(folder)
    rows = rows_of(folder, "settings_1_final_reward")
    both = f"{KEYS[2]}, {KEYS[3]}"
    means = [5 * times + 12 for times in (1, 2, 4)]
    expected = [
        *((KEYS[0], str(e), mean) for e, mean in zip((0.05, 0.1, 0.2), means, strict=True)),
        *((KEYS[1], str(a), 35 / 3 + a + 10) for a in (1, 2, 3)),
        *((both, pair, 35 / 3 + 12) for pair in ("0.9, 300", "0.99, 3000")),
    ]
    label = FINAL.label
    assert [(row["setting"], row["value"]) for row in rows] == [(k, v) for k, v, _ in expected]
    np.testing.assert_allclose([float(row[label]) for row in rows], [m for *_, m in expected])
    # Below five seeds the interval is the range of the seeds, each averaged over the others first.
    np.testing.assert_allclose([float(row["high"]) for row in rows], [m + 10 for *_, m in expected])
    assert {row["n"] for row in rows} == {"3"}
    assert "over n = 3 seeds, each averaged" in text_of(page)
    assert "Not all combinations" not in text_of(page)


def test_variants_with_seeds_of_their_own_have_means_over_settings_too(folder: Path) -> None:
    for number, (x, y, z) in enumerate(itertools.product((1, 2), (1, 2), (1, 2))):
        for seed in range(2):
            sets = {"x": x, "y": y, "z": z}
            add_run(folder, 2 * number + seed, variant=str(sets), overrides=sets, final_reward=x)
    page = page_of(folder)
    rows = rows_of(folder, "settings_1_final_reward")
    assert [float(row[FINAL.label]) for row in rows] == [1, 2, 1.5, 1.5, 1.5, 1.5]
    assert "over n = 2 runs of each variant" in text_of(page)
    assert "share seeds" not in text_of(page)


def test_the_curves_of_many_variants_go_from_the_lowest_to_the_highest(folder: Path) -> None:
    many_runs(folder, n_seeds=2)
    page = page_of(folder)
    lines = [*dict.fromkeys(row["line"] for row in rows_of(folder, "curves") if row["reward"])]
    assert len(lines) == 8
    # All are set against the first, which is the lowest as well; the next one and the last are the
    # ends of the others.
    assert lines[:2] == ["0.05 / 1 / 0.9, 300", "0.05 / 1 / 0.99, 3000"]
    assert lines[-1] == "0.2 / 3 / 0.99, 3000"
    said = "Shown: 0.05 / 1 / 0.9, 300, and others from the lowest to the highest final reward"
    assert said in text_of(page)


def test_of_curves_of_all_variants_it_is_not_said_which_they_are(folder: Path) -> None:
    for seed in range(2):
        add_run(folder, seed)
    assert "to the highest" not in text_of(page_of(folder))


def test_marks_are_spoken_of_only_where_there_are_any(folder: Path, tmp_path: Path) -> None:
    drawn: list[str] = []
    draw = parts.drawn

    def kept(name: str, chart: Any, small: str) -> Drawing:
        drawn.append(small)
        return draw(name, chart, small)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parts, "drawn", kept)
        add_run(folder, 0)
        page_of(folder)
        assert all("Dashed marks" in small for small in drawn)
        without = new_folder(tmp_path / "without")
        add_run(without, 0)
        arrays = dict(np.load(without / "arrays" / "k0.npz"))
        arrays |= {"introductions": np.array([[0, 0]]), "introduced": np.array(["approach"])}
        add_arrays(without, "k0", **arrays)
        seal(without)
        drawn.clear()
        page_of(without)
        assert len(drawn) == 3
        assert not any("Dashed marks" in small for small in drawn)


# --- The overview --------------------------------------------------------------------------------


def test_the_overview_says_what_the_experiment_is_about(tmp_path: Path) -> None:
    first = new_folder(tmp_path / "a", description="How <much> freezing matters.")
    second = new_folder(tmp_path / "b", description="Another matter.")
    for folder in (first, second):
        add_run(folder, 0)
    assert "\nHow <much> freezing matters.\n" in text_of(page_of(first))
    text = text_of(page_of(first, second))
    assert "a: How <much> freezing matters." in text
    assert "b: Another matter." in text


def test_failures_are_spoken_of_only_where_there_are_any(folder: Path) -> None:
    add_run(folder, 0)
    assert "failed" not in text_of(page_of(folder))
    add_run(folder, 1, status="failed", error="out of luck")
    assert "1 run over 2 seeds (1 more failed)" in text_of(page_of(folder))


@pytest.mark.parametrize("compare", [False, True])
def test_runs_that_are_in_two_folders_are_counted_once(tmp_path: Path, compare: bool) -> None:
    folders = [new_folder(tmp_path / name) for name in "ab"]
    for folder in folders:
        for seed in range(3):
            add_run(folder, seed)
    add_run(folders[1], 3)
    assert "4 runs over 4 seeds" in text_of(page_of(*folders, compare=compare))


def test_a_page_on_an_unfinished_experiment_says_so_wherever_it_is_looked_at(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small_print: list[str] = []
    draw = parts.drawn

    def kept(name: str, chart: Any, small: str) -> Drawing:
        small_print.append(small)
        return draw(name, chart, small)

    monkeypatch.setattr(parts, "drawn", kept)
    with contextlib.closing(connect(folder)) as database:
        note(database, variants=json.dumps(["timed", "standard_q"]))
    for seed in range(2):
        add_run(folder, seed)
    add_run(folder, 2, status="failed", error="out of luck")
    written = write.write_report([folder], None, False)
    said = "Unfinished: 3 of 6 runs."
    assert written.warnings == [said]
    assert said in text_of(written.page.read_text(encoding="utf-8"))
    assert small_print
    assert all(said in small.splitlines() for small in small_print)
    for seed in range(3):
        add_run(folder, seed, preset="standard_q")
    assert "Unfinished" not in page_of(folder)


def test_of_several_experiments_it_is_said_which_is_unfinished(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / name) for name in "ab"]
    for seed in range(3):
        add_run(folders[0], seed)
    add_run(folders[1], 0)
    assert "Unfinished: 1 of 3 runs in b." in text_of(page_of(*folders))
    assert "Unfinished: 1 of 3 runs in b." in text_of(page_of(*folders, compare=True))


def test_what_is_of_all_trials_of_short_runs_is_not_said_to_be_of_the_last(folder: Path) -> None:
    add_run(folder, 0)
    text = text_of(page_of(folder))
    assert "all 300 trials" in text
    assert "last 2,000 trials" not in text


def test_it_is_told_what_is_being_done(folder: Path) -> None:
    for seed in range(3):
        add_run(folder, seed)
    add_run(folder, 3, status="failed", error="out of luck")
    told: list[str] = []
    write.write_report([folder], None, False, told.append)
    assert told[0] == "reading tables of results"
    assert [text for text in told if text.startswith("reading logs")] == [
        "reading logs: 1 run",
        "reading logs: 2 runs",
        "reading logs: 3 runs",
    ]
    assert told[-1] == "writing the page"


# --- What was not measured -----------------------------------------------------------------------


def test_a_value_that_fewer_runs_have_says_how_many_do(folder: Path) -> None:
    for seed in range(3):
        found: dict[str, Any] = {} if not seed else {"final_reward": None, "area": None}
        add_run(folder, seed, **found)
        add_run(folder, seed, preset="standard_q", variant="all", overrides={"x": 1})
    rows = {row["variant"]: row for row in table_of(page_of(folder), AREA.label)}
    assert rows["timed"][AREA.label].endswith("of 1 run")
    assert "run" not in rows["all"][AREA.label]


def test_runs_that_finished_no_trial_are_not_taken_for_damaged(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "short", steps="3")
    none: dict[str, Any] = dict.fromkeys(("final_reward", "area"))
    empty = {"outcome": np.zeros(0, np.int8), "steps": np.zeros(0, np.int32)}
    for seed in range(2):
        add_run(folder, seed)
        add_run(folder, seed, preset="standard_q", trials=0, steps=3, **none)
        key = f"k{2 * seed + 1}"
        arrays = dict(np.load(folder / "arrays" / f"{key}.npz"))
        add_arrays(folder, key, **{**arrays, **empty})
    seal(folder)
    page = page_of(folder)
    assert "left out" not in text_of(page)
    # That a run has trials and its log none is damage as before.
    with sqlite3.connect(folder / "results.sqlite") as database:
        database.execute("UPDATE runs SET trials = 7 WHERE key = 'k1'")
    database.close()
    seal(folder)
    assert [row["run"] for row in table_of(page_of(folder), "do not fit together")] == [
        "standard_q, seed 0"
    ]


def test_only_what_was_measured_has_a_table(tmp_path: Path) -> None:
    folder = new_folder(tmp_path / "narrow", metrics=["steps_to_50", "mean_hunt_length"])
    for seed in range(3):
        nothing: dict[str, Any] = {"final_reward": None, "area": None, "mean_hunt_length": 9.0}
        add_run(folder, seed, **nothing)
    page = page_of(folder)
    root = ET.fromstring(page.removeprefix("<!DOCTYPE html>"))
    heads = [["".join(c.itertext()) for c in table.iter("th")] for table in root.iter("table")]
    assert all(len(head) > 3 for head in heads)
    (row,) = table_of(page, "mean hunt (steps)")
    assert row["steps to a reward of 50"] == "200 [100, \N{INFINITY}] by 3 of 3 runs"
    assert "steps to a reward of 70" not in text_of(page)


# --- Two folders ---------------------------------------------------------------------------------


def test_two_folders_are_compared_by_settings_and_seed(tmp_path: Path) -> None:
    first, second = (new_folder(tmp_path / name) for name in "ab")
    for seed in range(5):
        add_run(first, seed, overrides={"x": 1}, final_reward=10.0 * seed)
        add_run(second, seed, overrides={"x": 1}, final_reward=10.0 * seed + 3)
    add_run(first, 0, variant="only here", overrides={"x": 2})
    page = page_of(first, second, compare=True)
    (row,) = rows_of(first, "difference")
    assert [row[name] for name in ("value", "low", "high", "n")] == ["3.0", "3.0", "3.0", "5"]
    text = text_of(page)
    assert "only here" in text
    assert "5 seeds are in both" in text


def test_a_comparison_has_the_interquartile_means(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / name) for name in "ab"]
    gains = (-1000.0, 3.0, 3.0, 4.0, 4.0, 4.0, 4.0, 5.0, 5.0, 1000.0)
    for seed, wild in enumerate(gains):
        add_run(folders[0], seed, final_reward=10.0 * seed)
        add_run(folders[1], seed, final_reward=10.0 * seed + wild)
    rows = {row["quantity"]: row for row in table_of(page_of(*folders, compare=True), "P(B > A)")}
    row = rows[FINAL.label]
    assert "IQM 45 " in row["A"]
    assert "IQM 49 " in row["B"]
    difference = row["B \N{MINUS SIGN} A [95 %]"]
    assert difference.startswith("3.2 ")
    assert "IQM 4 " in difference


def test_below_ten_runs_a_comparison_has_no_interquartile_mean(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / name) for name in "ab"]
    for folder in folders:
        for seed in range(9):
            add_run(folder, seed)
    rows = table_of(page_of(*folders, compare=True), "P(B > A)")
    assert rows
    assert not any("IQM" in cell for row in rows for cell in row.values())


def group(variant: str, preset: str, sets: Mapping[str, Any], trials: int) -> Group:
    """A variant with one run, as far as it matters for what it belongs to."""
    run = Record(
        key="",
        variant=variant,
        preset=preset,
        overrides=sets,
        settings={"trials": trials},
        seed=0,
        error="",
        version="",
        digest="",
        seconds=1.0,
        ended_at="",
        values={"trials": trials, "steps": trials},
        arrays="",
        origin=Origin(Path(), (), False, None),
    )
    return Group(variant, preset, sets, [run])


def slow_pairs(first: Sequence[Group], second: Sequence[Group]) -> tuple[list[Any], list[str]]:
    """Labels of what belongs together and of what is alone, found by looking at all of them."""
    pairs: list[Any] = []
    left, right = list(first), list(second)
    keys: list[Callable[[Group], Any]] = [
        lambda group: (group.preset, group.overrides),
        lambda group: group.runs[0].settings,
        lambda group: group.overrides,
        lambda group: group.label,
    ]
    for key in keys:
        for one in list(left):
            mine = [other for other in left if key(other) == key(one)]
            theirs = [other for other in right if key(other) == key(one)]
            if len(mine) == len(theirs) == 1:
                pairs.append((one.label, theirs[0].label))
                left.remove(one)
                right.remove(theirs[0])
    return pairs, [group.label for group in (*left, *right)]


@pytest.mark.parametrize("seed", range(20))
def test_pairs_are_those_that_looking_at_all_of_them_finds(seed: int) -> None:
    draw = np.random.default_rng(seed)

    def folder_of(side: str) -> list[Group]:
        return [
            group(
                str(draw.choice([f"{side}{number}", "alpha", "beta"])),
                str(draw.choice(["timed", "standard_q", "mine"])),
                {"x": int(draw.integers(4))},
                int(draw.integers(5)),
            )
            for number in range(draw.integers(1, 12))
        ]

    first, second = folder_of("a"), folder_of("b")
    pairs, alone = pairs_of(first, second)
    found = [(one.label, other.label) for one, other in pairs], [one.label for one in alone]
    assert found == slow_pairs(first, second)


def test_the_keys_of_a_variant_are_written_once_in_each_round(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    n_written = 0
    dumps = json.dumps

    def counted(*args: Any, **kwargs: Any) -> str:
        nonlocal n_written
        n_written += 1
        return dumps(*args, **kwargs)

    sides = [[group(f"{side}{k}", side, {side: k}, k) for k in range(50)] for side in "ab"]
    monkeypatch.setattr("app.report.sections.compare.json.dumps", counted)
    pairs, alone = pairs_of(*sides)
    assert (len(pairs), alone) == (50, [])
    assert n_written <= 3 * 100


def test_folders_without_a_variant_in_common_are_refused(tmp_path: Path) -> None:
    first, second = (new_folder(tmp_path / name) for name in "ab")
    add_run(first, 0, variant="x=1", overrides={"x": 1})
    add_run(second, 0, variant="x=2", overrides={"x": 2})
    with pytest.raises(ResultsError, match="no variant in common"):
        write.write_report([first, second], None, True)


def test_variants_that_only_share_a_label_are_compared_and_their_settings_told(
    tmp_path: Path,
) -> None:
    first, second = (new_folder(tmp_path / name) for name in "ab")
    for folder, epsilon in ((first, 0.1), (second, 0.2)):
        for preset in ("timed", "standard_q"):
            settings = presets.load(preset, [f"learner.epsilon={epsilon}"]).model_dump(mode="json")
            for seed in range(3):
                add_run(
                    folder,
                    seed,
                    preset,
                    overrides={"learner.epsilon": epsilon},
                    settings=json.dumps(settings),
                )
    page = page_of(first, second, compare=True)
    assert [row["row"] for row in rows_of(first, "difference")] == ["standard_q", "timed"]
    told = "A and B differ in their settings: learner.epsilon (A: 0.1, B: 0.2)."
    assert text_of(page).count(told) == 2


def test_of_many_settings_that_differ_some_are_told(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / name) for name in "ab"]
    world = presets.load("timed").model_dump(mode="json")["world"]
    for folder, value in zip(folders, (1, 2), strict=True):
        more = {f"key{number}": value for number in range(13)}
        add_run(folder, 0, settings=json.dumps({"world": world, "trials": 300, **more}))
    text = text_of(page_of(*folders, compare=True))
    assert "key9 (A: 1, B: 2); and 3 more." in text
    assert "key10" not in text


def test_pairs_with_the_same_settings_are_not_said_to_differ(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / name) for name in "ab"]
    for folder in folders:
        add_run(folder, 0)
    assert "differ in their settings" not in text_of(page_of(*folders, compare=True))


def test_folders_that_did_not_measure_the_same_stand_beside_one_another(tmp_path: Path) -> None:
    all_, some = new_folder(tmp_path / "all"), new_folder(tmp_path / "some", metrics=["area"])
    for seed in range(3):
        add_run(all_, seed, variant="mine", overrides={"learner.alpha": 0.3})
        add_run(all_, seed, variant="yours", overrides={"learner.gamma": 0.8})
        add_run(some, seed, variant="theirs", overrides={"learner.epsilon": 0.2})
    rows = text_of(page_of(all_, some)).partition("difference to mine [95 %]")[2]
    assert "yours" in rows
    assert "theirs" in rows


def test_a_and_b_are_over_the_seeds_of_their_paired_difference(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / name) for name in "ab"]
    for folder, n_seeds in zip(folders, (3, 6), strict=True):
        for seed in range(n_seeds):
            add_run(folder, seed, final_reward=10.0 * seed)
    rows = {row["quantity"]: row for row in table_of(page_of(*folders, compare=True), "P(B > A)")}
    row = rows[FINAL.label]
    assert (row["A"], row["B"], row["n"]) == ("10 [0, 20]", "10 [0, 20]", "3")


def test_without_shared_seeds_a_and_b_are_over_all_of_their_runs(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / name) for name in "ab"]
    for folder, seeds in zip(folders, (range(2), range(2, 5)), strict=True):
        for seed in seeds:
            add_run(folder, seed, final_reward=10.0 * seed)
    rows = {row["quantity"]: row for row in table_of(page_of(*folders, compare=True), "P(B > A)")}
    row = rows[FINAL.label]
    assert (row["A"], row["B"]) == ("5 [0, 10]", "30 [20, 40]")
    assert (row["n"], row["paired"]) == ("2 and 3", "no")


def test_variants_of_folders_that_only_share_a_label_are_told_apart(tmp_path: Path) -> None:
    short, long = (new_folder(tmp_path / name) for name in ("zehn", "dreissig"))
    for folder, trials in ((short, 10), (long, 30)):
        settings = {**presets.load("timed").model_dump(mode="json"), "trials": trials}
        for seed in range(2):
            add_run(folder, seed, settings=json.dumps(settings))
        add_run(folder, 9, status="failed", error="out of luck", settings=json.dumps(settings))
    page = page_of(short, long)
    names = [row["row"] for row in rows_of(short, "variants")]
    assert names[:2] == ["zehn: timed", "dreissig: timed"]
    assert {row["line"] for row in rows_of(short, "curves") if row["reward"]} >= {
        "zehn: timed",
        "dreissig: timed",
    }
    assert [row["run"] for row in table_of(page, "out of luck")] == [
        "zehn: timed, seed 9",
        "dreissig: timed, seed 9",
    ]


def test_steps_to_a_share_of_captures_are_compared_as_medians(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / name) for name in "ab"]
    for seed in range(3):
        add_run(folders[0], seed, steps_to_50=100 * seed + 100, steps_to_70=None)
        later = None if seed == 2 else 100 * seed + 150
        add_run(folders[1], seed, steps_to_50=later, steps_to_70=None)
    rows = {row["quantity"]: row for row in table_of(page_of(*folders, compare=True), "P(B > A)")}
    row = rows["steps to a reward of 50"]
    assert row["A"] == "200 [100, \N{INFINITY}] by 3 of 3 runs"
    assert row["B"] == "250 [150, \N{INFINITY}] by 2 of 3 runs"
    assert row["B \N{MINUS SIGN} A [95 %]"] == "50"
    # The run that did not get there had more steps than its partner took.
    assert row["P(B > A) [95 %]"] == "1.00 [0.29, 1.00]"
    assert (row["n"], row["paired"]) == ("3", "by seed")
    row = rows["steps to a reward of 70"]
    assert row["A"] == "more than 3,000 by 0 of 3 runs"
    assert row["B \N{MINUS SIGN} A [95 %]"] == "–"
    # Of runs that all ended before, it cannot be told which would be later.
    assert row["P(B > A) [95 %]"] == "–"


def test_variants_differ_in_all_that_was_measured(folder: Path) -> None:
    for seed in range(5):
        add_run(folder, seed, captures=10)
        sets: dict[str, Any] = {"variant": "b", "overrides": {"x": 0}}
        add_run(folder, seed, **sets, captures=12, steps_to_50=None)
    rows = {row["quantity"]: row for row in table_of(page_of(folder), "quantity")}
    assert FINAL.label not in rows
    row = rows["captures"]
    assert row["variant"] == "b"
    assert row["difference to timed [95 %]"] == "2 [2, 2]"
    assert row["P(variant higher) [95 %]"] == "1.00 [0.48, 1.00]"
    row = rows["steps to a reward of 50"]
    assert row["difference to timed [95 %]"] == "–"
    assert row["P(variant higher) [95 %]"] == "1.00 [0.48, 1.00]"
    assert "greedy success (share of captures)" not in rows


# --- Where a page goes ---------------------------------------------------------------------------


def test_a_page_on_several_folders_takes_the_place_of_none_of_their_own(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / "results" / name) for name in "ab"]
    for folder in folders:
        for seed in range(3):
            add_run(folder, seed)
    own = [write.write_report([folder], None, False).page for folder in folders]
    assert own == [folder / "report.html" for folder in folders]
    before = [page.read_bytes() for page in own]
    for compare, name in ((True, "compare_a_b"), (False, "report_a_b")):
        page = write.write_report(folders, None, compare).page
        assert page == tmp_path / "results" / name / "report.html"
        assert (page.parent / "report_figures").is_dir()
    assert [page.read_bytes() for page in own] == before


@pytest.mark.parametrize(
    ("folders", "expected"),
    [
        (["a"], "a/report.html"),
        (["a", "../here/a"], "a/report.html"),
        (["a", "b/c"], "report_a_c/report.html"),
        (["x/a", "y/a"], "x/report_x-a_y-a/report.html"),
        ([".", "b"], "TMP/report_here_b/report.html"),
    ],
)
def test_the_place_of_a_page_that_was_not_told(
    folders: Sequence[str], expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    found = write.default_place([Path(folder) for folder in folders], False)
    assert found == Path(expected.replace("TMP", str(tmp_path)))


def test_the_name_of_a_page_on_many_folders_is_one_that_file_systems_take(tmp_path: Path) -> None:
    folders = [tmp_path / f"{number}{'a' * 50}" for number in range(20)]
    name = write.default_place(folders, False).parent.name
    assert name == f"report_0{'a' * 50}_and_19_more"


# --- What cannot be reported ---------------------------------------------------------------------


def test_results_without_a_run_that_is_over_are_refused(folder: Path) -> None:
    add_run(folder, 0, status="failed", error="out of luck")
    with pytest.raises(ResultsError, match="no run is over"):
        write.write_report([folder], None, False)


def test_a_failed_write_leaves_the_old_page_and_nothing_else(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add_run(folder, 0)
    old = page_of(folder)
    before = sorted(path.name for path in folder.iterdir())

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(ResultsError, match="No space left"):
        write.write_report([folder], None, False)
    assert (folder / "report.html").read_text(encoding="utf-8") == old
    assert sorted(path.name for path in folder.iterdir()) == before
    assert not list((folder / "report_figures").glob(".*"))


def test_a_page_is_for_those_whom_new_files_are_for(folder: Path) -> None:
    add_run(folder, 0)
    before = os.umask(0o077)
    try:
        page_of(folder)
    finally:
        os.umask(before)
    written = [folder / "report.html", *(folder / "report_figures").iterdir()]
    assert {stat.S_IMODE(path.stat().st_mode) for path in written} == {0o600}
