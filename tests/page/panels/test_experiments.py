"""The Experiments tab: what it would run, what that costs, and how it stands, in words."""

import math
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import viser

from app.documents import presets
from app.documents.experiments import Experiment, parse
from app.experiments.cost import Plan
from app.experiments.runner import Progress
from app.experiments.store import FolderError
from app.live import snapshot
from app.live.session import Session, Status
from app.live.snapshot import Snapshot
from app.page.panels import experiments
from app.page.panels.experiments import (
    Experimenter,
    cost_html,
    not_repeated,
    progress_html,
    session_experiment,
)
from app.results.gather import Gatherer
from app.results.service import Quote, Standing
from app.schedule import carried
from app.server.server import close_server, open_server
from app.util import background
from app.util.background import Maker
from learners.commands import Explore, Introduce, SetParameter
from learners.run import Run


def moment(run: Run, preset: str) -> Snapshot:
    return snapshot.take(run, preset, 0, None, True)


def test_a_session_that_followed_its_preset_is_that_preset() -> None:
    spec = presets.load("timed")
    run = Run(spec, 5)
    run.advance(max_steps=3_000)
    (variant,) = session_experiment(moment(run, "timed"), 7).variants
    assert variant.spec == spec
    assert variant.label == "this session"


def test_what_was_done_by_hand_is_run_beside_the_preset_on_the_same_seeds() -> None:
    spec = presets.load("timed", ["world.size=40"])
    run = Run(spec, 5)
    run.advance(until_trial=50)
    run.apply(Introduce("circle_clockwise", 20))
    run.apply(Explore("circle_clockwise", 100, 0.5))
    run.advance(until_trial=80)
    experiment = session_experiment(moment(run, 'mein "Räuber" 🐈'), 30)
    mine, former = experiment.variants
    assert mine.spec == carried.preset_of(moment(run, "timed"))[0]
    assert mine.spec.schedule.introduced_at("circle_clockwise") == 50
    assert former.spec == spec
    assert (former.label, mine.label) == ('mein "Räuber" 🐈 as it was', "this session")
    assert experiment.n_runs == 60
    assert list(experiment.seeds_of(mine)) == list(experiment.seeds_of(former)) == [*range(30)]
    assert not_repeated(moment(run, "timed")) == ""


def test_what_a_session_cannot_repeat_is_said() -> None:
    run = Run(presets.load("timed", ["world.size=40"]), 5)
    run.advance(until_trial=50)
    run.apply(SetParameter("learner.epsilon", 0.9))
    found = moment(run, "timed")
    assert "learner.epsilon was set to 0.9 at trial 50" in not_repeated(found)
    text = session_experiment(found, 3).text.decode()
    assert f"# {not_repeated(found)}" in text


def test_the_text_of_a_session_is_the_whole_experiment() -> None:
    run = Run(presets.load("timed", ['description="Zeile: #1"', "world.size=40"]), 5)
    experiment = session_experiment(moment(run, "mine"), 3)
    again = parse(experiment.text, "session.yaml", None, 3)
    assert again.variants == experiment.variants
    assert again.seeds == experiment.seeds


def quote(done: int = 0, runs: int = 12) -> Quote:
    left = 1 - done / runs
    plan = Plan(min(4, runs), runs, done, int(74_000_000 * left), 8.0 * left, int(4_200_000 * left))
    return Quote(plan, Path("results/<b>"))


def test_the_cost_is_of_what_is_left() -> None:
    whole = cost_html(quote(), 3)
    assert "12 runs" in whole
    assert "74 M steps" in whole
    assert "8 s" in whole
    assert "&lt;b&gt;" in whole
    assert "6 are there already" in cost_html(quote(done=6), 3)
    assert "1 is there already" in cost_html(quote(done=1), 3)
    assert "The run is in" in cost_html(quote(done=1, runs=1), 1)
    assert "<b>1 run</b>: 1 variant, 1 seed each." in cost_html(quote(runs=1), 1)
    assert "All 12 runs are in" in cost_html(quote(done=12), 3)


def test_nothing_takes_no_time() -> None:
    short = Quote(Plan(1, 3, 0, 285_000, 0.1, 1_000), Path("results"))
    assert "About 285 k steps, <b>1 s</b>" in cost_html(short, 3)
    found = Progress(4, 1, 0, 2, 5_000, 2e4, 0.4, 0.1)
    assert "20 k steps/s, about 1 s left" in progress_html(standing(progress=found))


def standing(**changes: Any) -> Standing:
    experiment = parse("presets: [timed]\nseeds: 4", "a <b>.yaml")
    found = Progress(4, 1, 1, 2, 5_000_000, 2e6, 0.4, 9.0)
    state = {"progress": found, "running": True, "paused": False, "error": "", **changes}
    return Standing(experiment, Path("results"), Gatherer(experiment, 5_500_000), **state)


def test_how_it_stands_is_said_in_words() -> None:
    running = progress_html(standing())
    assert "a &lt;b&gt;" in running
    assert "1 of 4 runs done, 1 failed, 2 running" in running
    assert "2 M steps/s, about 9 s left" in running
    assert "paused" in progress_html(standing(paused=True))
    assert "Make the others goes on there" in progress_html(standing(running=False))
    over = Progress(4, 3, 1, 0, 5_000_000, 2e6, 1.0, 0.0)
    assert "goes on" not in progress_html(standing(running=False, progress=over))
    assert "No &lt;space&gt;" in progress_html(standing(running=False, error="No <space>"))
    assert "getting ready" in progress_html(standing(progress=None))
    assert progress_html(standing(progress=None, running=False)).endswith("stopped.")


# The tab, on a real server that nobody looks at


class Bench:
    """A workbench on which experiments take no time."""

    def __init__(self) -> None:
        self.standing: Standing | None = None
        self.quoted = 0
        self.trials = 0
        """Of the experiment whose cost was asked for last."""
        self.locked = False

    def quote(self, experiment: Experiment, workers: int) -> Quote:
        self.quoted += 1
        self.trials = experiment.variants[0].spec.trials
        if self.locked:
            raise FolderError("is in use by another pounce")
        return quote(done=0 if self.standing is None else 12)


class Tab:
    """The tab with a bench of that kind."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self.bench = Bench()
        self.session = Session(presets.load("timed"), "timed", 1, speed=1.0, playing=False)
        bench: Any = self.bench
        self.experimenter = Experimenter(
            gui, self.session, bench, lambda event, request: 0, lambda client: None
        )
        self._made = threading.Event()
        self.experimenter._offer = Maker(self._made.set)

    def shown_cost(self, status: Status | None = None) -> str:
        """What the tab says once it has found out what an experiment takes."""
        self._made.clear()
        self.experimenter.update(status or self.session.status)
        assert self._made.wait(30)
        self.experimenter.update(status or self.session.status)
        return self.experimenter._cost.content


@pytest.fixture
def tab() -> Iterator[Tab]:
    server = open_server(port=0)
    yield Tab(server.gui)
    close_server(server)


def test_an_experiment_that_no_frame_saw_running_changes_what_is_offered(tab: Tab) -> None:
    assert "12 runs" in tab.shown_cost()
    assert tab.experimenter._start.label == "Start"
    tab.bench.standing = standing(running=False)
    assert "All 12 runs are in" in tab.shown_cost()
    assert tab.experimenter._start.label == "Show these runs"


def test_what_is_known_is_not_found_out_again(tab: Tab) -> None:
    tab.shown_cost()
    for _ in range(5):
        tab.experimenter.update(tab.session.status)
    assert tab.bench.quoted == 1


def test_a_cost_is_measured_again_now_and_then_and_shown_meanwhile(
    tab: Tab, monkeypatch: pytest.MonkeyPatch
) -> None:
    tab.shown_cost()
    for quoted in (2, 3):
        tab._made.clear()
        with monkeypatch.context() as later:
            later.setattr(experiments, "_FRESH_S", -math.inf)
            tab.experimenter.update(tab.session.status)
        assert "12 runs" in tab.experimenter._cost.content
        assert tab._made.wait(30)
        for _ in range(3):
            tab.experimenter.update(tab.session.status)
            assert "12 runs" in tab.experimenter._cost.content
        assert tab.bench.quoted == quoted


def test_a_session_that_becomes_longer_keeps_its_cost_in_sight_and_is_asked_for_now_and_then(
    tab: Tab, monkeypatch: pytest.MonkeyPatch
) -> None:
    status = tab.session.status
    beyond = [
        replace(status, snapshot=replace(status.snapshot, trial=status.snapshot.spec.trials + more))
        for more in (500, 1_500, 2_500, 3_500)
    ]
    tab.shown_cost(beyond[0])
    for later in beyond:
        tab.experimenter.update(later)
        assert "12 runs" in tab.experimenter._cost.content
    assert tab.bench.quoted == 1
    monkeypatch.setattr(experiments, "_FRESH_S", -math.inf)
    assert "12 runs" in tab.shown_cost(beyond[-1])
    assert tab.bench.trials == beyond[-1].snapshot.trial


def test_a_cost_is_not_measured_while_an_experiment_runs(
    tab: Tab, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(experiments, "_FRESH_S", -math.inf)
    tab.bench.standing = standing()
    tab.shown_cost()
    for _ in range(5):
        tab.experimenter.update(tab.session.status)
    assert tab.bench.quoted == 1


def test_whose_schedule_would_be_run_is_said_while_an_opened_run_is_on_the_board(tab: Tab) -> None:
    tab.shown_cost()
    assert "on the board" not in tab.experimenter._about.content
    status = tab.session.status
    opened = replace(status.snapshot, preset="figure_4_1: <b>", seed=7, generation=1)
    tab.shown_cost(replace(status, snapshot=opened, aside="timed, trial 12"))
    said = "This is the schedule of figure_4_1: &lt;b&gt;, seed 7, which is on the board, not timed"
    assert said in tab.experimenter._about.content


def test_a_folder_that_is_free_again_is_found_to_be(
    tab: Tab, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(background, "_RETRY_S", math.inf)
    tab.bench.locked = True
    assert "Cannot be run: is in use" in tab.shown_cost()
    tab.bench.locked = False
    monkeypatch.setattr(background, "_RETRY_S", 0.0)
    assert "12 runs" in tab.shown_cost()
