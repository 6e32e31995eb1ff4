"""The report: from folders of results to a page that stands for itself."""

import csv
import json
import sqlite3
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app import figures, presets, report, statistics
from app.laboratory import COLUMNS
from app.report_cli import Report
from app.report_cli import report as obey
from app.statistics import Estimate
from sim.world import CAPTURE, FLIGHT

N_TRIALS = 300
HOSTILE = '<script>alert("x")</script> & \x00 $\\frac$ http\ud800'


def add_run(
    folder: Path,
    seed: int,
    preset: str = "timed",
    variant: str = "",
    overrides: Mapping[str, Any] = {},
    share: float = 0.5,
    **columns: Any,
) -> None:
    """Add a run of 300 trials of ten steps; a share of the trials, drawn by seed, are captures."""
    settings = presets.load(preset if preset in presets.shipped() else "timed")
    draw = np.random.default_rng(seed)
    outcome = np.where(draw.random(N_TRIALS) < share, CAPTURE, FLIGHT).astype(np.int8)
    key = f"k{len(list((folder / 'arrays').iterdir()))}"
    reward = float(np.where(outcome == CAPTURE, 100, -50).mean())
    row: dict[str, Any] = {
        "key": key,
        "variant": variant or preset,
        "preset": preset,
        "overrides": json.dumps(overrides),
        "settings": json.dumps({**settings.model_dump(mode="json"), "overrides": dict(overrides)}),
        "seed": seed,
        "status": "done",
        "version": "1",
        "digest": f"{variant}{preset}{overrides}{seed}{share}",
        "trials": N_TRIALS,
        "steps": 10 * N_TRIALS,
        "final_reward": reward,
        "area": reward / 2,
        "steps_to_50": 100 * seed + 100,
        **columns,
    }
    np.savez(
        folder / "arrays" / f"{key}.npz",
        outcome=outcome,
        steps=np.full(N_TRIALS, 10, np.int32),
        introductions=np.array([[0, 0], [100, 1000]]),
        introduced=np.array(["approach", "avoid"]),
    )
    places = ", ".join("?" * len(row))
    with sqlite3.connect(folder / "results.sqlite") as database:
        database.execute(f"INSERT INTO runs ({', '.join(row)}) VALUES ({places})", [*row.values()])
    database.close()


def new_folder(path: Path, version: str = "1", name: str = "an experiment") -> Path:
    (path / "arrays").mkdir(parents=True)
    with sqlite3.connect(path / "results.sqlite") as database:
        database.execute("CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT)")
        database.execute(f"CREATE TABLE runs ({', '.join(f'{k} {v}' for k, v in COLUMNS.items())})")
        values = {"schema_version": version, "name": name, "seeds": "[0, 1, 2]"}
        database.executemany("INSERT INTO meta VALUES (?, ?)", [*values.items()])
    database.close()
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return new_folder(tmp_path / "results with blanks, ünicode # and ?")


def page_of(*folders: Path, compare: bool = False) -> str:
    return report.write_report(folders, None, compare).read_text(encoding="utf-8")


def text_of(page: str) -> str:
    return "\n".join(ET.fromstring(page.removeprefix("<!DOCTYPE html>")).itertext())


def rows_of(folder: Path, name: str) -> list[dict[str, str]]:
    with (folder / "report_figures" / f"{name}.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


# --- The page ------------------------------------------------------------------------------------


def test_the_page_is_well_formed_stands_for_itself_and_names_its_command(folder: Path) -> None:
    for seed in range(3):
        add_run(folder, seed)
        add_run(folder, seed, preset="standard_q", share=0.2)
    page = page_of(folder)
    text = text_of(page)
    assert "pounce report" in text
    assert "pounce experiment 'an experiment' --seeds 3" in text
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


def test_variants_are_in_the_order_of_the_experiment_whichever_ended_first(folder: Path) -> None:
    text = "presets: [timed, standard_q, {preset: timed, label: another}]\nseeds: 2\n"
    (folder / "experiment.yaml").write_text(text)
    for preset, variant in (("timed", "another"), ("standard_q", ""), ("timed", "")):
        for seed in (1, 0):
            add_run(folder, seed, preset=preset, variant=variant)
    found = [(run.variant, run.seed) for run in report.read_folder(folder).rows]
    assert found == [(v, s) for v in ("timed", "standard_q", "another") for s in (0, 1)]


def test_copies_of_a_run_count_once(tmp_path: Path) -> None:
    folders = [new_folder(tmp_path / name) for name in "ab"]
    for folder in folders:
        for seed in range(2):
            add_run(folder, seed)
    page_of(*folders)
    assert {row["n"] for row in rows_of(folders[0], "curves") if row["low"]} == {"2"}


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


def test_every_figure_comes_as_svg_png_and_csv(folder: Path) -> None:
    for seed in range(2):
        add_run(folder, seed)
    page_of(folder)
    files = sorted(path.name for path in (folder / "report_figures").iterdir())
    stems = ("curves", "curves_trials")
    assert files == sorted(f"{stem}.{kind}" for stem in stems for kind in ("csv", "png", "svg"))
    assert (folder / "report_figures" / "curves.png").read_bytes().startswith(b"\x89PNG")
    ET.parse(folder / "report_figures" / "curves.svg")


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
    label = report.FINAL_REWARD.label
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


def test_variants_with_settings_of_their_own_are_set_against_the_first(folder: Path) -> None:
    for seed in range(5):
        add_run(folder, seed, final_reward=80.0 + seed)
        add_run(folder, seed, variant="without", overrides={"x": 0}, final_reward=70.0 + seed)
    page = page_of(folder)
    found = [row for row in rows_of(folder, "variants") if row["row"] == "without"]
    assert [float(row["value"]) for row in found] == [72.0, -10.0]
    assert (found[1]["low"], found[1]["high"]) == ("-10.0", "-10.0")
    assert "0.00" in text_of(page)


def test_values_on_a_scale_of_ratios() -> None:
    assert figures.Axle("x", (10, 30, 100, 300)).is_logarithmic
    assert not figures.Axle("x", (10, 20, 30, 40)).is_logarithmic
    assert not figures.Axle("x", (0, 20, 40)).is_logarithmic
    assert not figures.Axle("x", ("a", "b", "c")).is_logarithmic
    assert figures.Axle("x", (0, 30, 100, 1000)).is_crowded
    assert not figures.Axle("x", (0.1, 0.3, 0.95)).is_crowded


# --- Findings ------------------------------------------------------------------------------------

ABOVE = report.Finding("", "", (), 15)
CLOSE = report.Finding("", "", (), 15, within=True)


@pytest.mark.parametrize(
    ("finding", "low", "high", "n", "expected"),
    [
        (ABOVE, 16, 30, 5, report.HOLDS),
        (ABOVE, 0, 14, 5, report.FAILS),
        (ABOVE, 14, 16, 30, report.UNDECIDED),
        (ABOVE, 16, 30, 4, report.UNDECIDED),
        (CLOSE, -14, 14, 5, report.HOLDS),
        (CLOSE, 16, 30, 5, report.FAILS),
        (CLOSE, -30, -16, 5, report.FAILS),
        (CLOSE, -16, 0, 5, report.UNDECIDED),
    ],
)
def test_the_rule(finding: report.Finding, low: float, high: float, n: int, expected: str) -> None:
    assert report.verdict(finding, Estimate((low + high) / 2, low, high, n)) == expected


def placed_runs(folder: Path, seeds: Sequence[int]) -> tuple[report.Reader, report.Placed]:
    """Full runs of two learners, one of which captures always and one never."""
    found: dict[report.Place, list[report.RunRow]] = {}
    for preset, share in (("timed", 1.0), ("standard_q", 0.0)):
        spec = presets.load(preset)
        for seed in seeds:
            add_run(folder, seed, preset=preset, share=share)
            key = f"k{len(list((folder / 'arrays').iterdir())) - 1}"
            np.savez(
                folder / "arrays" / f"{key}.npz",
                outcome=np.full(spec.trials, CAPTURE if share else FLIGHT, np.int8),
                steps=np.full(spec.trials, 50, np.int32),
                introductions=np.zeros((0, 2), np.int64),
                introduced=np.zeros(0, "U32"),
            )
    database = folder / "results.sqlite"
    assert database.is_file()
    for row in report.read_folder(folder).rows:
        settings = {k: v for k, v in row.settings.items() if k != "overrides"}
        run = report.RunRow(**{**row.__dict__, "settings": settings})
        place = report.place_of(run)
        assert place is not None
        found.setdefault(place, []).append(run)
    return report.Reader(report.Widths(100_000, 1_000)), found


def test_a_finding_is_measured_by_seed(folder: Path) -> None:
    reader, placed = placed_runs(folder, range(5))
    effect = report.effect_of(report.FINDINGS[0], reader, placed)
    assert effect is not None
    assert effect == statistics.Contrast(Estimate(150.0, 150.0, 150.0, 5), paired=True)
    assert report.verdict(report.FINDINGS[0], effect.estimate) == report.HOLDS


def test_with_few_seeds_nothing_is_decided(folder: Path) -> None:
    reader, placed = placed_runs(folder, range(3))
    effect = report.effect_of(report.FINDINGS[0], reader, placed)
    assert effect is not None
    assert report.verdict(report.FINDINGS[0], effect.estimate) == report.UNDECIDED


def test_a_finding_whose_learners_were_not_run_is_not_measured(folder: Path) -> None:
    reader, placed = placed_runs(folder, range(2))
    assert report.effect_of(report.FINDINGS[1], reader, placed) is None


def test_windows_that_a_run_did_not_get_through_are_not_there(folder: Path) -> None:
    reader, placed = placed_runs(folder, range(1))
    (trace,) = reader.traces(placed["120", "standard_q"])
    # 24,000 trials of 50 steps are 1.2 million steps.
    assert {"0–0.5 M", "0.5–1 M", "0–1 M", "last 2,000 trials"} <= set(trace.quantities)
    assert "1–1.5 M" not in trace.quantities


def test_a_changed_learner_is_not_the_thesiss(folder: Path) -> None:
    _, placed = placed_runs(folder, range(1))
    run = placed["120", "timed"][0]
    settings = json.loads(json.dumps(run.settings))
    settings["learner"]["alpha"] = 0.2
    assert report.place_of(report.RunRow(**{**run.__dict__, "settings": settings})) is None
    settings = json.loads(json.dumps(run.settings))
    settings["world"]["size"] = 60
    moved = report.RunRow(**{**run.__dict__, "settings": settings})
    assert report.place_of(moved) == ("60", "timed")


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


def test_folders_without_a_variant_in_common_are_refused(tmp_path: Path) -> None:
    first, second = (new_folder(tmp_path / name) for name in "ab")
    add_run(first, 0, overrides={"x": 1})
    add_run(second, 0, overrides={"x": 2})
    with pytest.raises(report.ReportError, match="no variant in common"):
        report.write_report([first, second], None, True)


# --- What cannot be reported ---------------------------------------------------------------------


def test_unusable_folders_are_refused_in_clear_words(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "results.sqlite").write_text("nothing of the kind" * 100)
    new_folder(tmp_path / "later", version="2")
    new_folder(tmp_path / "nothing yet")
    for name, message in (
        ("missing", "is no folder"),
        ("empty", "no results.sqlite"),
        ("damaged", "damaged"),
        ("later", "version 2"),
        ("nothing yet", "no run is over"),
    ):
        with pytest.raises(report.ReportError, match=message):
            report.write_report([tmp_path / name], None, False)


def test_settings_that_are_no_json_are_refused(folder: Path) -> None:
    add_run(folder, 0, settings="{")
    with pytest.raises(report.ReportError, match="damaged"):
        report.write_report([folder], None, False)


def test_a_failed_write_leaves_the_old_page_and_nothing_else(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add_run(folder, 0)
    old = page_of(folder)
    before = sorted(path.name for path in folder.iterdir())

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(report.ReportError, match="No space left"):
        report.write_report([folder], None, False)
    assert (folder / "report.html").read_text(encoding="utf-8") == old
    assert sorted(path.name for path in folder.iterdir()) == before
    assert not list((folder / "report_figures").glob(".pounce-*"))


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (Report(), "DIR is missing"),
        (Report(("a",), compare=True), "1 folders were given"),
        (Report(("a",), out="experiment.yaml"), "ends in .html"),
        (Report(("a\0",)), "NUL"),
    ],
)
def test_wrong_words_are_refused(
    command: Report, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert obey(command) == 2
    assert message in capsys.readouterr().err


def test_the_command_says_where_the_page_is(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    add_run(folder, 0)
    out = tmp_path / "pages" / "of mine.html"
    assert obey(Report((str(folder),), out=str(out))) == 0
    assert capsys.readouterr().out == f"{out}\n"
    assert out.is_file()
    assert (tmp_path / "pages" / "of mine_figures" / "curves.svg").is_file()
    assert obey(Report((str(tmp_path / "missing"),))) == 1
    assert "is no folder" in capsys.readouterr().err
