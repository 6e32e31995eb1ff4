"""The panel of results: what it says and what it shows are of the same runs, and it fits."""

import codecs
import re
import secrets
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import viser

from app.charts.paper import fonts
from app.charts.view import Size
from app.documents.experiments import Experiment
from app.experiments.runner import Progress
from app.page.panels import results
from app.page.panels.results import ResultsPanel, room_of
from app.results.gather import Gatherer
from app.results.service import Standing
from app.server.calls import Calls
from app.server.server import close_server, open_server
from app.util.background import Maker
from tests.support.person import AtOnce, Person
from tests.support.runs import THESIS, experiment_of, fact, filled

PATIENCE_S = 60.0
EXPERIMENT = experiment_of(THESIS)
RUNS = [
    fact(place, seed, 10.0 * place, "broke" if seed == 2 and place == 3 else "")
    for seed in EXPERIMENT.seeds
    for place in range(len(EXPERIMENT.variants))
]


class Service:
    """How an experiment stands, as a test says."""

    def __init__(self) -> None:
        self.standing: Standing | None = None

    def begin(self, experiment: Experiment, n_runs: int, **changes: Any) -> None:
        """Another experiment, some of whose runs are over."""
        gatherer = filled(experiment, RUNS[:n_runs])
        progress = Progress(experiment.n_runs, n_runs, 0, 1, 5_000_000, 2e6, 0.4, 9.0)
        state = {"progress": progress, "running": True, "paused": False, "error": "", **changes}
        self.standing = Standing(experiment, Path("results"), gatherer, **state)

    def note(self, **changes: Any) -> None:
        """Something else is true of the same experiment."""
        assert self.standing is not None
        self.standing = replace(self.standing, **changes)

    def come(self, first: int, end: int) -> None:
        """More runs are over."""
        assert self.standing is not None
        add(self.standing.gatherer, first, end)
        assert self.standing.progress is not None
        self.note(progress=self.standing.progress._replace(done=end))


def add(gatherer: Gatherer, first: int, end: int) -> None:
    """Take some of the runs in."""
    other = filled(EXPERIMENT, RUNS[first:end])
    gatherer._runs += other._runs


class Desk:
    """A panel on a real server, and somebody before it; its frames come when a test says."""

    def __init__(self, server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch) -> None:
        self.service = Service()
        self.calls = Calls()
        self.made = threading.Event()
        self.wanted = False
        self.person = Person(server.gui)
        client: Any = self.person
        service: Any = self.service
        inbox: Any = AtOnce()
        desk = self

        class Watched(Maker[Any]):
            def want(self, of: Any, make: Any) -> None:
                desk.wanted = of != self.latest[0]
                super().want(of, make)

        monkeypatch.setattr(results, "Maker", Watched)
        monkeypatch.setattr(secrets, "token_urlsafe", lambda _: "secret")
        self.panel = ResultsPanel(
            client, self.calls, service, lambda *_: None, inbox, self.made.set
        )
        self.panel.open()

    def frame(self, now_s: float) -> None:
        """Draw, and draw again once what the first frame asked for is there, if it asked."""
        self.made.clear()
        self.wanted = False
        self.panel.update(now_s)
        if self.wanted:
            assert self.made.wait(PATIENCE_S)
        self.panel.update(now_s)

    @property
    def counts(self) -> tuple[int, int, int]:
        """Runs that are done and that failed, as it says, and the runs of its table."""
        said = re.search(r"(\d+) of \d+ runs done(?:, (\d+) failed)?", self.person.html)
        assert said is not None
        listed = re.search(r"of (\d+)</span>", self.person.html)
        return int(said[1]), int(said[2] or 0), 0 if listed is None else int(listed[1])


@pytest.fixture
def desk(monkeypatch: pytest.MonkeyPatch) -> Iterator[Desk]:
    server = open_server(port=0)
    yield Desk(server, monkeypatch)
    close_server(server)


def test_while_runs_come_the_headline_counts_those_that_are_shown(desk: Desk) -> None:
    desk.service.begin(EXPERIMENT, 0)
    desk.frame(0.0)
    assert desk.counts == (0, 0, 0)
    assert "No run is over yet." in desk.person.html
    desk.service.come(0, 3)
    desk.frame(0.1)
    assert desk.counts == (3, 0, 3)
    desk.service.come(3, 6)
    desk.frame(0.2)
    assert desk.counts == (3, 0, 3), "a link would be replaced beneath a click"
    desk.frame(5.0)
    assert desk.counts == (6, 0, 6)


def test_the_last_run_and_the_end_are_shown_at_once(desk: Desk) -> None:
    desk.service.begin(EXPERIMENT, 11)
    desk.frame(0.0)
    assert desk.counts == (11, 0, 11)
    desk.service.come(11, 12)
    desk.frame(0.1)
    assert desk.counts == (11, 1, 12)
    desk.service.note(running=False)
    desk.panel.update(0.2)
    assert "1 running" not in desk.person.html
    assert "Stopped" not in desk.person.html


def test_an_experiment_that_is_over_is_not_called_stopped_before_its_last_run_is_shown(
    desk: Desk,
) -> None:
    desk.service.begin(EXPERIMENT, 11)
    desk.frame(0.0)
    desk.service.come(11, 12)
    desk.service.note(running=False)
    desk.panel.update(0.1)
    assert "Stopped" not in desk.person.html
    desk.frame(0.2)
    assert desk.counts == (11, 1, 12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [({"paused": True}, "paused, "), ({"running": False}, "Stopped; ")],
)
def test_a_pause_and_a_stop_are_said_with_all_runs_at_once(
    changes: dict[str, bool], words: str, desk: Desk
) -> None:
    desk.service.begin(EXPERIMENT, 3)
    desk.frame(0.0)
    desk.service.come(3, 6)
    desk.service.note(**changes)
    desk.frame(0.1)
    assert words in desk.person.html
    assert desk.counts == (6, 0, 6)


def test_another_experiment_with_as_many_runs_is_shown_in_its_place(desk: Desk) -> None:
    desk.service.begin(EXPERIMENT, 4)
    desk.frame(0.0)
    other = experiment_of("presets: [hierarchical_3, timed]\nseeds: 6")
    desk.service.begin(other, 0)
    second = desk.service.standing
    assert second is not None
    add(second.gatherer, 0, 2)
    add(second.gatherer, 4, 6)
    desk.panel.update(0.1)
    assert "standard_q" not in desk.person.html
    desk.frame(0.2)
    assert "standard_q" not in desk.person.html
    assert "hierarchical_3" in desk.person.html


def test_a_file_is_of_the_experiment_that_is_shown_though_another_has_begun(desk: Desk) -> None:
    desk.service.begin(EXPERIMENT, 4)
    desk.frame(0.0)
    desk.person.click("Chart as CSV")
    first = desk.person.downloads.copy()
    assert first
    desk.person.downloads.clear()
    desk.service.begin(experiment_of("presets: [timed]\nseeds: 6"), 0)
    desk.person.click("Chart as CSV")
    assert desk.person.downloads == first


def test_before_a_run_is_over_there_is_no_file(desk: Desk) -> None:
    desk.service.begin(EXPERIMENT, 0)
    desk.frame(0.0)
    desk.person.click("Chart as PNG")
    desk.person.click("Runs as CSV")
    assert desk.person.told == ["no run is over yet"] * 2
    assert desk.person.downloads == {}


def test_a_spreadsheet_is_sent_and_boxes_in_a_picture_are_said(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fonts, "system_fonts", lambda: ())
    text = "presets:\n- {preset: timed, label: =先}\n- standard_q\n"
    desk.service.begin(experiment_of(text), 2)
    desk.frame(0.0)
    for words in ("Chart as CSV", "Chart for spreadsheets", "Chart as PNG"):
        desk.person.click(words)
    endings = ("csv", "spreadsheet.csv", "png")
    assert [*desk.person.downloads] == [f"results_chart_curves.{ending}" for ending in endings]
    plain, sheet, _ = desk.person.downloads.values()
    assert ",=先,".encode() in plain
    assert sheet.startswith(codecs.BOM_UTF8)
    assert ",'=先,".encode() in sheet
    (note,) = desk.person.told
    assert note.startswith("No font of this machine has 先: ")


# --- Its place -----------------------------------------------------------------------------------


def test_what_is_drawn_fits_the_room_that_a_page_tells(desk: Desk) -> None:
    desk.service.begin(EXPERIMENT, 4)
    desk.frame(0.0)
    assert f"max-width:{684 - 34}px" in desk.person.html
    assert desk.calls.take("secret/size/900x700")
    desk.frame(0.1)
    assert f"max-width:{900 - 34}px" in desk.person.html


@pytest.mark.parametrize(
    "text", ["", "9x", "-1x5", "\u0661\u0663x700", "1366.0x700", f"{'9' * 5_000}x1"]
)
def test_a_room_of_no_size_changes_nothing(text: str) -> None:
    assert room_of(text, Size(684, 752)) == Size(684, 752)


def test_no_room_is_too_small_or_too_large_to_be_drawn_for() -> None:
    small, large = room_of("0x0", Size()), room_of("99999x99999", Size())
    assert 300 <= min(small) < max(large) < 5_000


def test_a_page_opens_and_closes_its_results_by_links(desk: Desk) -> None:
    assert desk.calls.take("secret/show")
    desk.service.begin(EXPERIMENT, 4)
    desk.frame(0.0)
    assert desk.calls.take("secret/close")
    desk.frame(0.1)
    assert not desk.panel._panel.visible
    assert desk.calls.take("secret/show")
    assert desk.panel._panel.visible


def test_wherever_one_looks_it_is_said_that_an_experiment_runs(desk: Desk) -> None:
    def sign() -> str:
        return desk.panel._sign.content

    desk.panel.update(0.0)
    assert "Experiment" not in sign()
    desk.service.begin(EXPERIMENT, 4)
    assert desk.calls.take("secret/close")
    desk.panel.update(0.1)
    assert "Experiment Some: 4 of 12 runs. <a " in sign()
    desk.service.note(paused=True)
    desk.panel.update(0.2)
    assert "4 of 12 runs, paused." in sign()
    desk.service.note(running=False)
    desk.panel.update(0.3)
    assert "Experiment" not in sign()
