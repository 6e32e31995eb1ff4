"""Experiments in a real browser: choose, see the cost, start, watch, open runs, keep files."""

import codecs
import csv
import io
import math
import re
import sqlite3
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from playwright.sync_api import Locator, expect

from app.charts.view import Size
from app.documents import experiments
from app.documents.experiments import Experiment
from app.experiments import task
from app.experiments.store import COLUMNS
from app.live.held import Opened
from app.live.requests import Pause, Play, SetSpeed
from app.page.panels.experiments import THIS_SESSION
from learners.commands import Introduce
from tests.support.live import SMALL, LiveLab, preset_of, small_experiment
from tests.support.screen import Begin, BeginTwo, Screen, picture

ROWS_PER_PAGE = Size().rows
_PUT_AWAY = """name => {
    window.isPutAway = false;
    const watch = new MutationObserver(() => {
        const notices = [...document.querySelectorAll(".mantine-Notification-root")];
        const notice = notices.find(node => node.textContent.includes(`Received ${name}`));
        const close = notice?.querySelector(".mantine-Notification-closeButton");
        if (!close) return;
        watch.disconnect();
        close.click();
        window.isPutAway = true;
    });
    watch.observe(document.body, {
        attributes: true, childList: true, characterData: true, subtree: true,
    });
}"""
"""Has a notice be put away as it comes; left alone, it goes by itself after some seconds."""
"""Of the table, in a window of the usual size."""

HOSTILE = "<img src=x onerror=alert(1)>"

LONG = """
presets: [timed]
set: {learner.epsilon: 1.0}
settings:
  - {trials: 20}
  - {trials: 2000000, world.step_limit: 5000}
"""
"""One run that is over at once, and one of minutes."""


class Row(NamedTuple):
    """A run as the results have it."""

    key: str
    variant: str
    seed: int
    digest: str


# What is asked of a lab, and of a page ------------------------------------------------------


def rows_in(folder: Path) -> list[Row]:
    """All runs in a folder of results, first all variants with the first seed."""
    database = sqlite3.connect(folder / "results.sqlite")
    found = database.execute("SELECT key, variant, seed, digest FROM runs ORDER BY seed, variant")
    rows = [Row(*row) for row in found]
    database.close()
    return rows


def offered(screen: Screen) -> list[str]:
    """Experiments to choose from."""
    screen.field("Experiment").click()
    options = screen.page.get_by_role("option")
    expect(options.first).to_be_visible()
    names = options.all_inner_texts()
    screen.page.keyboard.press("Escape")
    expect(options).to_have_count(0)
    return names


def listed(screen: Screen) -> Locator:
    """Rows of the table of runs."""
    return screen.results.locator("table.runs tbody tr")


def column(screen: Screen, title: str) -> Locator:
    """Cells of a column of the table of runs."""
    place = ["variant", "seed", "value", "greedy", "success", "steps to 70", "steps", "digest"]
    return listed(screen).locator(f"td:nth-child({place.index(title) + 1})")


def link(screen: Screen, name: str) -> Locator:
    """A link of the panel, by what is written on it."""
    return screen.results.get_by_role("link", name=name, exact=True)


def dots(screen: Screen) -> Locator:
    """Runs in the chart of all runs."""
    return screen.results.locator("svg a circle")


def expect_opened(live: LiveLab, screen: Screen, experiment: Experiment, row: Row) -> None:
    """Wait until a run is in the lab as it ended, and the page says so in its place."""

    name = f"{experiment.title}: {row.variant}, seed {row.seed}"

    def is_over(opened: Opened | None) -> bool:
        return opened is not None and opened.name == name and opened.same is not None

    status = live.wait_for(lambda status: is_over(status.opened))
    opened, snapshot = status.opened, status.snapshot
    assert opened == Opened(name, snapshot.step, row.digest, same=True, found=row.digest)
    (spec,) = [v.spec for v in experiment.variants if v.label == row.variant]
    assert (snapshot.spec, snapshot.seed, snapshot.trial) == (spec, row.seed, spec.trials)
    assert not status.playing
    expect(screen.headline).to_contain_text(f"This is {name}, as it ended: digest ")
    expect(screen.headline).to_contain_text(f"{row.digest[:8]}")
    expect(screen.headline).to_contain_text(", as in the results.")
    expect(screen.results).to_be_hidden()
    screen.expect_cell_colours(live.colours())


def saved(screen: Screen, button: str, name: str) -> bytes:
    """What a button of the panel gives to keep, under this name."""
    screen.page.evaluate(_PUT_AWAY, name)
    with screen.page.expect_download() as download:
        screen.click(button)
    assert download.value.suggested_filename == name
    # It lies over what is clicked next, for as long as a pointer rests on it.
    notice = screen.page.locator(".mantine-Notification-root", has_text=f"Received {name}")
    screen.page.wait_for_function("() => window.isPutAway")
    expect(notice).to_have_count(0)
    return download.value.path().read_bytes()


# Running ------------------------------------------------------------------------------------


def test_a_schedule_is_run_over_seeds_beside_the_live_session(begin_two: BeginTwo) -> None:
    live, one, other = begin_two("timed", "trials=2000", trial=50)
    live.ask(Introduce("circle_clockwise", 20))
    one.turn_to("Experiments")
    expect(one.field("Experiment")).to_have_value(THIS_SESSION)
    one.fill("Seeds", "3")
    cost = one.text("6 runs: 2 variants, 3 seeds each.")
    expect(cost).to_be_visible()
    expect(cost).to_contain_text(f"in {live.results / 'session'}.")
    assert not live.results.exists()

    before = live.ask(SetSpeed(200.0), Play()).snapshot
    one.click("Start")
    expect(one.results).to_be_visible()
    expect(other.results).to_be_hidden()
    other.turn_to("Experiments")
    expect(other.field("Seeds")).to_have_value("3")
    for screen in (one, other):
        expect(
            screen.text("Session: 6 of 6 runs done.").locator("visible=true").first
        ).to_be_visible()
    status = live.session.status
    assert status.playing
    assert (status.snapshot.generation, status.snapshot.preset) == (before.generation, "timed")
    assert status.snapshot.step > before.step
    live.ask(Pause())

    standing = live.at_end()
    former, mine = standing.experiment.variants
    assert mine.spec.schedule.introduced_at("circle_clockwise") == 50
    assert former.spec == preset_of("timed", "trials=2000")
    assert (mine.label, former.label) == ("this session", "timed as it was")
    assert standing.folder == live.results / "session"
    rows = rows_in(standing.folder)
    assert len(rows) == 6
    expect(other.results).to_be_hidden()
    other.results_button.click()
    for screen in (one, other):
        expect(column(screen, "variant")).to_have_text(
            ["timed as it was"] * 3 + ["this session"] * 3
        )
        expect(column(screen, "seed")).to_have_text(["0", "1", "2"] * 2)
        expect(column(screen, "digest")).to_have_text(
            [
                r.digest[:8]
                for v in ("timed as it was", "this session")
                for r in rows
                if r.variant == v
            ]
        )
    other.close_results()
    expect(one.results).to_be_visible()

    # What is shown already needs no button to show it; fewer of these runs are shown alone.
    assert one.reads("All 6 runs are in ")
    for label in ("Start", "Show these runs"):
        expect(one.button(label)).to_have_count(0)
    one.fill("Seeds", "2")
    one.click("Show these runs")
    expect(column(one, "seed")).to_have_text(["0", "1"] * 2)
    assert len(rows_in(standing.folder)) == 6


def test_each_browser_has_its_own_view_of_the_results(begin_two: BeginTwo) -> None:
    live, screen, other = begin_two()
    # So many that they take a second page.
    n_runs = 2 * (ROWS_PER_PAGE // 2 + 1)
    seeds = [str(seed) for seed in range(n_runs // 2)]
    standing = live.run_to_end(small_experiment(n_seeds=len(seeds)))
    digests = sorted(row.digest[:8] for row in rows_in(standing.folder))
    for each in (screen, other):
        each.show_results()
        expect(column(each, "seed")).to_have_text((2 * seeds)[:ROWS_PER_PAGE])
    content = other.results.inner_text()
    panel = screen.results

    expect(link(screen, "Curves")).to_have_count(0)
    expect(panel).to_contain_text("simulation steps (millions)")
    link(screen, "trials").click()
    expect(panel).to_contain_text("trials (thousands)")
    link(screen, f"standard_q ({len(seeds)} runs)").click()
    expect(panel).to_contain_text("chosen: standard_q")
    expect(column(screen, "variant")).to_have_text(["standard_q"] * len(seeds))
    link(screen, "Runs").click()
    expect(dots(screen)).to_have_count(n_runs)
    expect(panel).to_contain_text("final reward (mean per trial, all 600 trials)")
    link(screen, "choose none").click()
    expect(panel).not_to_contain_text("chosen:")
    expect(listed(screen)).to_have_count(ROWS_PER_PAGE)

    by_seed = [seed for seed in seeds for _ in range(2)]
    link(screen, "seed").click()
    expect(column(screen, "seed")).to_have_text(by_seed[:ROWS_PER_PAGE])
    link(screen, "seed ▲").click()
    expect(column(screen, "seed")).to_have_text(by_seed[::-1][:ROWS_PER_PAGE])
    link(screen, "digest").click()
    expect(column(screen, "digest")).to_have_text(digests[:ROWS_PER_PAGE])
    expect(panel).to_contain_text(f"1–{ROWS_PER_PAGE} of {n_runs}")
    link(screen, "next page").click()
    expect(column(screen, "digest")).to_have_text(digests[ROWS_PER_PAGE:])
    expect(panel).to_contain_text(f"{n_runs} of {n_runs}")

    assert other.results.inner_text() == content
    # Whoever learns an address of one browser learns none of another.
    secrets = [
        set(re.findall(r'href="(call/[^/"]+)/', each.results.inner_html()))
        for each in (screen, other)
    ]
    assert [len(found) for found in secrets] == [1, 1]
    assert secrets[0] != secrets[1]


def test_an_experiment_pauses_goes_on_stops_and_is_gone_on_with(begin: Begin) -> None:
    live, screen = begin()
    screen.turn_to("File")
    with screen.told("long is chosen under Experiments."):
        screen.upload("Load experiment", "long.yaml", LONG)
    screen.turn_to("Experiments")
    expect(screen.field("Experiment")).to_have_value("long")
    assert screen.reads("2 runs: 2 variants, 1 seed each.")
    screen.fill("At a time", "1")

    def said(words: str) -> Locator:
        """What the tab says of the experiment; the panel says the same."""
        return screen.text(words).locator("visible=true").first

    screen.click("Start")
    expect(said("Long: 1 of 2 runs done, 1 running.")).to_be_visible()
    expect(screen.button("Start")).to_have_count(0)
    expect(screen.page.get_by_role("progressbar")).to_be_visible()
    screen.click("Pause")
    expect(said("Long: paused, 1 of 2 runs done.")).to_be_visible()
    expect(screen.button("Pause")).to_have_count(0)
    paused = live.lab.service.standing
    assert paused is not None
    assert paused.paused
    screen.click("Go on")
    expect(said("Long: 1 of 2 runs done, 1 running.")).to_be_visible()
    screen.click("Stop")
    stopped = said(
        "Long: 1 of 2 runs done. Stopped; with it chosen, Make the others goes on there."
    )
    expect(stopped).to_be_visible()
    for name in ("Pause", "Go on", "Stop"):
        expect(screen.button(name)).to_have_count(0)
    assert [row.variant for row in rows_in(live.results / "long")] == ["timed, trials=20"]

    assert screen.reads("1 seed each; 1 is there already.")
    screen.click("Make the others")
    expect(said("Long: 1 of 2 runs done, 1 running.")).to_be_visible()
    expect(listed(screen)).to_have_count(1)
    screen.click("Stop")
    expect(stopped).to_be_visible()


def test_a_run_that_fails_is_listed_with_its_error_and_cannot_be_opened(
    begin: Begin, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured = task.measured

    def fail(course: Any, metrics: Any) -> Any:
        if course.run.seed == 1:
            raise RuntimeError(f"no {HOSTILE} luck")
        return measured(course, metrics)

    monkeypatch.setattr(task, "measured", fail)
    live, screen = begin()
    live.run_to_end(small_experiment(SMALL.replace(", standard_q", ""), n_seeds=3))
    screen.show_results()
    expect(listed(screen)).to_have_count(3)
    row = listed(screen).nth(1)
    expect(row).to_contain_text(f"failed: RuntimeError: no {HOSTILE} luck")
    expect(row.get_by_role("link")).to_have_count(0)
    for other in (0, 2):
        opens = listed(screen).nth(other).get_by_role("link", name="open ▸")
        expect(opens).to_have_count(1)
    expect(screen.text("Small: 2 of 3 runs done, 1 failed.").first).to_be_visible()
    link(screen, "Runs").click()
    expect(dots(screen)).to_have_count(2)
    expect(screen.results).to_contain_text("1 run failed.")
    expect(screen.page.locator("img[src='x']")).to_have_count(0)


# Opening a run ------------------------------------------------------------------------------


def test_a_run_of_the_table_and_a_dot_of_the_chart_open_that_very_run(begin: Begin) -> None:
    live, screen = begin(trial=20)
    experiment = small_experiment(n_seeds=3)
    standing = live.run_to_end(experiment)
    found = {(row.variant, row.seed): row for row in rows_in(standing.folder)}
    screen.show_results()
    row = listed(screen).nth(4)
    expect(row.locator("td").first).to_have_text("standard_q")
    # Anywhere in the row.
    row.locator("td").nth(5).click(position={"x": 3, "y": 3})
    expect_opened(live, screen, experiment, found["standard_q", 1])

    screen.results_button.click()
    link(screen, "Runs").click()
    expect(dots(screen)).to_have_count(6)
    # The dot that is drawn last lies on top of the others.
    dots(screen).last.click()
    expect_opened(live, screen, experiment, found["standard_q", 2])
    screen.results_button.click()
    expect(dots(screen)).to_have_count(6)
    listed(screen).nth(2).get_by_role("link", name="timed").click()
    expect_opened(live, screen, experiment, found["timed", 2])

    # What was going on before was set aside, and comes back.
    screen.click("Back to timed, trial 20")
    status = live.wait_for(lambda status: status.aside is None)
    assert (status.snapshot.trial, status.snapshot.preset, status.opened) == (20, "timed", None)
    expect(screen.headline).not_to_contain_text("as in the results")
    expect(screen.reading("Trial")).to_have_text("20")

    screen.results_button.click()
    listed(screen).nth(2).get_by_role("link", name="timed").click()
    expect_opened(live, screen, experiment, found["timed", 2])

    # It is a run like any other.
    screen.turn_to("Run")
    screen.click("Go on for 600 trials more")
    live.wait_for(lambda status: status.opened is None)
    expect(screen.headline).not_to_contain_text("as in the results")


# Looking ------------------------------------------------------------------------------------


def test_results_lie_beside_the_board_or_over_it_and_never_over_the_controls(begin: Begin) -> None:
    live, screen = begin()
    live.run_to_end(small_experiment(n_seeds=8))
    screen.page.set_viewport_size({"width": 1920, "height": 1080})
    screen.show_results()
    # So many rows there are only once it is painted for the room that it has there.
    expect(listed(screen).nth(ROWS_PER_PAGE)).to_be_visible()
    board = screen.page.locator("#pounce-stage .board")

    def box(thing: Locator) -> tuple[float, float]:
        """Where it begins and ends, from left to right."""
        # What is drawn anew is nowhere for a moment.
        while (found := thing.bounding_box()) is None:
            expect(thing).to_be_visible()
        return found["x"], found["x"] + found["width"]

    expect(board).to_be_visible()
    assert box(screen.results)[1] <= box(board)[0]
    link(screen, "Runs").click()
    expect(dots(screen)).to_have_count(16)
    # What a dot is can be read at once, under the pointer and by keyboard.
    tip = screen.page.locator("#pounce-tip")
    dots(screen).last.hover()
    expect(tip).to_contain_text(re.compile("^standard_q, seed 7: "))
    screen.page.keyboard.press("Escape")
    expect(tip).to_be_hidden()
    screen.results.locator("svg a:has(circle)").first.focus()
    expect(tip).to_contain_text(re.compile("^timed, seed 0: "))
    # Seeds are shared.
    expect(screen.results.locator(".differences")).to_contain_text("paired over 8 seeds")

    screen.page.set_viewport_size({"width": 1024, "height": 768})
    for thing in (screen.results_button, screen.field("Seeds"), screen.results_close):
        # A click would meet it, and nothing that lies over it.
        thing.click(trial=True)
    # What was open is open again after the page was loaded anew.
    screen.page.reload()
    expect(screen.results).to_be_visible()
    screen.close_results()


def test_runs_and_charts_can_be_kept_as_files(begin: Begin) -> None:
    live, screen = begin()
    standing = live.run_to_end(small_experiment(n_seeds=2))
    screen.show_results()
    table = csv.DictReader(io.StringIO(saved(screen, "Runs as CSV", "small_runs.csv").decode()))
    assert list(table.fieldnames or ()) == list(COLUMNS)
    found = {(row["variant"], int(row["seed"])): row["digest"] for row in table}
    assert found == {(r.variant, r.seed): r.digest for r in rows_in(standing.folder)}
    assert len(found) == 4
    sheet = saved(screen, "Runs for spreadsheets", "small_runs.spreadsheet.csv")
    assert sheet.startswith(codecs.BOM_UTF8)
    assert len(sheet.splitlines()) == 1 + 4

    expect(link(screen, "standard_q (2 runs)")).to_be_visible()
    curves = saved(screen, "Chart as CSV", "small_chart_curves.csv").decode()
    lines = [*csv.DictReader(io.StringIO(curves))]
    assert {name for line in lines for name in line.values()} >= {"timed", "standard_q"}
    numbers = [number for line in lines for number in map(number_in, line.values()) if number]
    assert len(numbers) > 2 * len(lines) > 20
    sheet = saved(screen, "Chart for spreadsheets", "small_chart_curves.spreadsheet.csv")
    assert sheet.decode("utf-8-sig").splitlines() == curves.splitlines()
    image = saved(screen, "Chart as PNG", "small_chart_curves.png")
    expect_picture(image)

    link(screen, "Runs").click()
    expect(dots(screen)).to_have_count(4)
    means = [
        *csv.DictReader(io.StringIO(saved(screen, "Chart as CSV", "small_chart_runs.csv").decode()))
    ]
    estimates = [standing.gatherer.estimate(place).value for place in (0, 1)]
    for line, value in zip(means, estimates, strict=True):
        assert any(math.isclose(found, value) for found in map(number_in, line.values()) if found)
    dotted = saved(screen, "Chart as PNG", "small_chart_runs.png")
    expect_picture(dotted)
    assert dotted != image


def number_in(text: str) -> float | None:
    """The number that a text says, if it says one."""
    try:
        return float(text)
    except ValueError:
        return None


def expect_picture(png: bytes) -> None:
    """A picture that could be printed, with something on it."""
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    pixels = picture(png)
    height, width, _ = pixels.shape
    assert 300 < height < 4_000
    assert 600 < width < 4_000
    assert len({tuple(pixel) for pixel in pixels[::7, ::7].reshape(-1, 3).tolist()}) > 10


# Loading ------------------------------------------------------------------------------------


def test_a_wrong_experiment_is_refused_with_all_its_problems(begin: Begin, tmp_path: Path) -> None:
    private = tmp_path / "private.yaml"
    private.write_text("password: 4711\n")
    wrong = f"presets: [timed]\ngrid: {{learner.epsilon: [4]}}\nseeds: 0\n'{HOSTILE}': 1\n"
    problems = (
        "learner.epsilon: value 4",
        "seeds: value 0",
        f"'{HOSTILE}': value 1: is not a known",
    )
    nosy = f"presets: [{private}, {{label: mine, preset: {{extends: {private}}}}}]\n"
    _, screen = begin()
    screen.turn_to("Experiments")
    screen.choose("Experiment", THIS_SESSION)
    before = offered(screen)
    screen.turn_to("File")
    for text, found in ((wrong, problems), (nosy, ("is not a shipped preset",))):
        screen.upload("Load experiment", f"{HOSTILE}.yaml", text)
        dialog = screen.page.get_by_role("dialog")
        expect(dialog).to_contain_text("This experiment cannot be run; nothing has changed")
        for problem in found:
            expect(dialog).to_contain_text(problem)
        expect(dialog).not_to_contain_text("4711")
        expect(screen.page.locator("img[src='x']")).to_have_count(0)
        dialog.get_by_role("button", name="Close", exact=True).click()
        expect(dialog).to_have_count(0)
    screen.turn_to("Experiments")
    expect(screen.field("Experiment")).to_have_value(THIS_SESSION)
    assert offered(screen) == before


def test_a_loaded_experiment_is_chosen_named_and_shown_as_text(begin: Begin) -> None:
    text = (
        f"description: '{HOSTILE} about'\npresets:\n  - {{label: '{HOSTILE} label', preset: timed}}"
        "\nset: {world.size: 30}\ntrials: 60\nseeds: [11, 12]\n"
    )
    live, screen = begin()
    screen.turn_to("File")
    name = "img_src_x_onerror_alert_1_"
    with screen.told(f"{name} is chosen under Experiments."):
        screen.upload("Load experiment", f"{HOSTILE}.yaml", text)
    screen.turn_to("Experiments")
    expect(screen.field("Experiment")).to_have_value(name)
    screen.choose("Experiment", "Figure 4.1")
    expect(screen.field("Seeds")).to_have_value("30")
    assert screen.reads("210 runs: 4 variants, 30 to 120 seeds each.")
    screen.choose("Experiment", name)
    expect(screen.field("Seeds")).to_have_value("2")
    assert screen.reads(f"{HOSTILE} about")
    assert screen.reads("2 runs: 1 variant, 2 seeds each.")
    screen.click("Start")
    # Too long for its column, where it is cut.
    expect(column(screen, "variant")).to_have_text([re.compile("^<img src.*label$")] * 2)
    expect(screen.results.get_by_title(f"{HOSTILE} label: open")).to_have_count(2)
    expect(column(screen, "seed")).to_have_text(["11", "12"])
    link(screen, "Runs").click()
    expect(dots(screen)).to_have_count(2)
    dots(screen).last.click()
    row = Row("", f"{HOSTILE} label", 12, rows_in(live.results / name)[1].digest)
    expect_opened(live, screen, live.at_end().experiment, row)
    expect(screen.page.locator("img[src='x']")).to_have_count(0)


def test_no_name_of_a_file_leads_out_of_the_results_or_hides_another_experiment(
    begin: Begin,
) -> None:
    live, screen = begin()
    names = {
        f"{THIS_SESSION}.yaml": "This_session_s_schedule",
        "figure_4_1.yaml": "figure_4_1_loaded",
        # What is left of it without its ending is the folder above.
        "...yaml": "preset",
    }
    screen.turn_to("Experiments")
    before = offered(screen)
    titles = [experiments.titled(name) for name in experiments.shipped()]
    assert before[: 1 + len(titles)] == [THIS_SESSION, *titles]
    for file, name in names.items():
        screen.turn_to("File")
        screen.upload("Load experiment", file, SMALL)
        screen.turn_to("Experiments")
        expect(screen.field("Experiment")).to_have_value(name)
        assert screen.reads(f"in {live.results / name}.")
    assert offered(screen) == [*before, *names.values()]
