"""Experiments from the page: run beside the lab, with the results of the command line."""

import contextlib
import sqlite3
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.analysis.estimates import bootstrap_rng, mean
from app.charts.read import line_of
from app.charts.styles import style_of
from app.documents import experiments
from app.documents.experiments import Experiment, parse
from app.experiments import store, task
from app.experiments.crews import Crew, Threads
from app.experiments.record import Record, origin_of
from app.experiments.runner import Progress, record_of, run_experiment
from app.experiments.store import Folder, FolderError, table_csv
from app.experiments.task import Finished
from app.results import read
from app.results.gather import Gatherer
from app.results.service import BusyError, Service, Standing, folder_for
from tests.support.endless import ENDLESS

TEXT = """
presets: [timed, standard_q]
set: {world.size: 30, world.step_limit: 80}
trials: 600
seeds: 3
"""
PATIENCE_S = 60.0


def small(n_seeds: int | None = None, text: str = TEXT) -> Experiment:
    return parse(text, "small.yaml", None, n_seeds)


def over(service: Service) -> Standing:
    """How an experiment stands once it is over."""
    service.wait(PATIENCE_S)
    assert service.standing is not None
    assert not service.standing.running
    return service.standing


@contextlib.contextmanager
def at_the_first_run(
    do: Callable[[], None], on_progress: Callable[[], object] = lambda: None
) -> Iterator[None]:
    """Do something when an experiment has its first run, and tell of its progress from then on.

    Both happen in the experiment's own thread, so it does nothing else meanwhile.
    """
    seen = False

    def run(
        experiment: Experiment,
        folder: Folder,
        crew: Crew,
        tell: Callable[[Progress], object],
        on_over: Callable[[Record, Finished], object],
    ) -> object:
        def take(record: Record, finished: Finished) -> None:
            nonlocal seen
            on_over(record, finished)
            if not seen:
                seen = True
                do()

        def note(progress: Progress) -> None:
            tell(progress)
            if seen:
                on_progress()

        return run_experiment(experiment, folder, crew, note, on_over=take)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("app.results.service.run_experiment", run)
        yield


def rows(folder: Path) -> dict[str, Any]:
    database = sqlite3.connect(folder / "results.sqlite")
    found = dict(database.execute("SELECT key, digest FROM runs"))
    database.close()
    return found


def test_the_page_makes_the_runs_of_the_command_line(tmp_path: Path) -> None:
    service = Service(tmp_path / "in the page ü")
    path = service.start(small(), workers=2)
    standing = over(service)
    assert standing.error == ""
    assert standing.progress is not None
    assert (standing.progress.done, standing.progress.failed) == (6, 0)
    with Folder(tmp_path / "b", small(), False, False) as folder:
        run_experiment(small(), folder, Threads(1))
    assert rows(path) == rows(tmp_path / "b")
    assert path == tmp_path / "in the page ü" / "small"


def test_runs_are_gathered_as_they_come(tmp_path: Path) -> None:
    service = Service(tmp_path)
    service.start(small(), workers=2)
    standing = over(service)
    runs = standing.gatherer.gathering().runs
    assert {run.key: run.digest for _, run in runs} == rows(standing.folder)
    assert {(place, run.seed) for place, run in runs} == {(v, s) for v in (0, 1) for s in (0, 1, 2)}
    for variant in (0, 1):
        values = [run.values["final_reward"] for place, run in runs if place == variant]
        estimate = standing.gatherer.estimate(variant)
        assert estimate.value == pytest.approx(np.mean(values))
        assert estimate.low <= estimate.value <= estimate.high
        curve = standing.gatherer.curve(variant, "trials")
        assert curve.n == 3
        assert curve.band.end[-1] <= 600


def test_one_at_a_time(tmp_path: Path) -> None:
    service = Service(tmp_path)
    service.start(small(text=ENDLESS), workers=1)
    with pytest.raises(BusyError, match="stop it first"):
        service.start(small(), workers=1)
    service.stop()
    assert over(service).gatherer.gathering().runs == ()
    service.start(small(), workers=2)
    assert over(service).error == ""


def test_another_begins_as_soon_as_one_is_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, is_over, let_go = Service._run, threading.Event(), threading.Event()
    lingering: list[threading.Thread] = []

    def run_and_linger(service: Service, *about: Any) -> None:
        lingering.append(threading.current_thread())
        run(service, *about)
        is_over.set()
        let_go.wait(PATIENCE_S)

    service = Service(tmp_path)
    monkeypatch.setattr(Service, "_run", run_and_linger)
    service.start(small(1), workers=1)
    assert is_over.wait(PATIENCE_S)
    monkeypatch.undo()
    (first,) = lingering
    service.start(small(2), workers=1)
    assert len(over(service).gatherer.gathering().runs) == 4
    second = service.standing
    let_go.set()
    first.join(PATIENCE_S)
    assert service.standing is second


def test_paused_it_waits_and_goes_on(tmp_path: Path) -> None:
    service, told = Service(tmp_path), threading.Semaphore(0)
    with at_the_first_run(service.pause, told.release):
        service.start(small(40), workers=1)
        # Each time it could have taken in a run; one was under way, and one may have been over.
        for _ in range(8):
            assert told.acquire(timeout=PATIENCE_S)
    standing = service.standing
    assert standing is not None
    assert standing.paused
    assert standing.running
    assert len(standing.gatherer.gathering().runs) <= 3
    service.go_on()
    standing = over(service)
    assert not standing.paused
    assert len(standing.gatherer.gathering().runs) == 80


def test_stopped_it_goes_on_where_it_was(tmp_path: Path, counted: list[str]) -> None:
    service = Service(tmp_path)
    with at_the_first_run(service.stop):
        path = service.start(small(40), workers=1)
        before = over(service).gatherer.gathering().runs
    assert 0 < len(before) < 80
    assert rows(path).keys() == {run.key for _, run in before}

    counted.clear()
    assert service.start(small(40), workers=1) == path
    after = over(service).gatherer.gathering().runs
    assert len(after) == len(rows(path)) == 80
    assert not set(counted) & {run.key for _, run in before}


def test_fewer_seeds_of_what_is_there_are_shown_alone(tmp_path: Path) -> None:
    service = Service(tmp_path)
    service.start(small(4), workers=2)
    over(service)
    service.start(small(2), workers=2)
    assert {run.seed for _, run in over(service).gatherer.gathering().runs} == {0, 1}


def test_other_results_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "small").mkdir()
    (tmp_path / "small" / "thesis.txt").write_text("years of work")
    service = Service(tmp_path)
    assert service.start(small(), workers=1) == tmp_path / "small-2"
    over(service)
    other = small(text=TEXT.replace("600", "601"))
    assert service.start(other, workers=1) == tmp_path / "small-3"
    over(service)
    assert service.start(small(), workers=1) == tmp_path / "small-2"
    over(service)
    assert (tmp_path / "small" / "thesis.txt").read_text() == "years of work"


def test_a_place_that_cannot_be_written_to_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    service = Service(tmp_path / "file" / "below")
    service.start(small(), workers=1)
    assert "cannot be written to" in over(service).error


def test_results_of_another_version_are_left_alone(tmp_path: Path) -> None:
    service = Service(tmp_path)
    path = service.start(small(1), workers=1)
    over(service)
    with contextlib.closing(sqlite3.connect(path / "results.sqlite")) as database, database:
        database.execute("UPDATE meta SET value = '99' WHERE key = 'schema_version'")
    before = (path / "results.sqlite").read_bytes()
    assert service.start(small(1), workers=1) == tmp_path / "small-2"
    assert over(service).error == ""
    assert (path / "results.sqlite").read_bytes() == before


def test_a_damaged_table_is_left_alone(tmp_path: Path) -> None:
    service = Service(tmp_path)
    path = service.start(small(1), workers=1)
    over(service)
    (path / "results.sqlite").write_text("nothing of the kind" * 100)
    assert service.start(small(1), workers=1) == tmp_path / "small-2"
    assert over(service).error == ""


def test_damaged_arrays_are_made_again(tmp_path: Path) -> None:
    service = Service(tmp_path)
    path = service.start(small(), workers=2)
    before = rows(over(service).folder)
    damaged = sorted((path / "arrays").glob("*.npz"))[2]
    sound = damaged.read_bytes()
    damaged.write_bytes(sound[: len(sound) // 2])
    service.start(small(), workers=2)
    assert {run.key: run.digest for _, run in over(service).gatherer.gathering().runs} == before
    assert damaged.read_bytes() == sound


def test_a_run_that_fails_is_listed_with_its_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured = task.measured

    def fail(course: Any, metrics: Any) -> Any:
        if course.run.seed == 1:
            raise RuntimeError("no luck")
        return measured(course, metrics)

    monkeypatch.setattr(task, "measured", fail)
    service = Service(tmp_path)
    service.start(small(), workers=2)
    runs = over(service).gatherer.gathering().runs
    assert {run.seed: run.gist for _, run in runs if run.error} == {1: "RuntimeError: no luck"}
    assert service.standing is not None
    assert service.standing.gatherer.estimate(0).n == 2


def test_the_cost_says_what_is_there_already(tmp_path: Path) -> None:
    service = Service(tmp_path)
    quote = service.quote(small(), workers=1)
    assert (quote.plan.runs, quote.plan.done, quote.folder) == (6, 0, tmp_path / "small")
    whole = quote.plan.steps
    service.start(small(2), workers=2)
    over(service)
    quote = service.quote(small(), workers=1)
    assert (quote.plan.runs, quote.plan.done) == (6, 4)
    assert quote.plan.steps == pytest.approx(whole / 3, rel=0.01)


def test_closing_ends_what_is_running(tmp_path: Path) -> None:
    before = set(threading.enumerate())
    service = Service(tmp_path)
    service.start(small(text=ENDLESS), workers=2)
    service.pause()
    service.close()
    assert not over(service).running
    # Those of a lab that other tests share come and go.
    begun = set(threading.enumerate()) - before
    assert not [thread for thread in begun if "run" in thread.name]


def test_there_is_an_end_to_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.results.service.MOST_FOLDERS", 2)
    for name in ("small", "small-2"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "other").write_text("")
    with pytest.raises(FolderError, match="too many results of small"):
        folder_for(tmp_path, small())


def test_the_table_as_csv_has_every_run(tmp_path: Path) -> None:
    service = Service(tmp_path)
    path = service.start(small(), workers=2)
    over(service)
    header, *lines = table_csv(path).splitlines()
    assert header.split(",") == list(store.COLUMNS)
    assert len(lines) == 6
    with pytest.raises(FolderError, match="cannot be read"):
        table_csv(tmp_path / "nowhere")


def test_curves_say_when_skills_joined_and_end_with_the_runs() -> None:
    text = (
        "presets: [timed]\nset: {world.size: 30, schedule.skills.circle_clockwise.at: 100,"
        " schedule.skills.avoid.at: 200}\ntrials: 1000\nseeds: 2\n"
    )
    experiment = experiments.parse(text, "a.yaml")
    gatherer = Gatherer(experiment, 30_000)
    for variant, one in task.tasks_of(experiment):
        done = task.perform(one)
        assert done is not None
        gatherer.add(record_of(variant, one, done, origin_of(experiment, Path())), done.arrays)
    curve = gatherer.curve(0, "trials")
    assert [(m.skill, m.trial) for m in curve.joined] == [
        ("circle_clockwise", 100),
        ("avoid", 200),
    ]
    assert gatherer.curve(0, "trials") is curve
    gathering = gatherer.gathering()
    assert (gathering.low, gathering.high) == (-50.0, 100.0)


def test_the_page_and_a_report_find_the_same_numbers_in_the_same_runs(tmp_path: Path) -> None:
    experiment, came = small(4), list[tuple[Record, Finished]]()
    with Folder(tmp_path / "results", experiment, resume=False, force=False) as folder:
        run_experiment(experiment, folder, Threads(1), on_over=lambda *run: came.append(run))
    groups = read.groups_of(read.read_folder(tmp_path / "results").rows)
    gatherer = Gatherer(experiment, 20_000)
    for record, finished in reversed(came):  # In whatever order they come.
        gatherer.add(record, finished.arrays)
    for place, group in enumerate(groups):
        assert gatherer.estimate(place) == mean(group.values("final_reward"), bootstrap_rng())
        for axis in read.AXES:
            found = gatherer.curve(place, axis).band
            width = int(found.end[0])
            reader = read.Reader(read.Widths(width, width), lambda *_: {})
            kept = line_of(reader, group.label, group.runs, axis, style_of(0)).band
            assert np.isfinite(found.low).all()
            for column, other in zip(found, kept, strict=True):
                np.testing.assert_array_equal(column, other, strict=True)
