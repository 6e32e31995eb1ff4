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
from app.live.requests import GoBack, Request
from app.live.session import Session
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.panels import experiments
from app.page.panels.experiments import (
    ExperimentsPanel,
    about_html,
    beside_in_words,
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
from tests.support.person import AtOnce, Person


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
    former, mine = experiment.variants
    assert mine.spec == carried.preset_of(moment(run, "timed"))[0]
    assert mine.spec.schedule.introduced_at("circle_clockwise") == 50
    assert former.spec == spec
    assert (former.label, mine.label) == ('mein "Räuber" 🐈 as it was', "this session")
    assert experiment.n_runs == 60
    assert list(experiment.seeds_of(mine)) == list(experiment.seeds_of(former)) == [*range(30)]
    assert not_repeated(moment(run, "timed")) == ()


def test_a_line_is_called_by_its_name_if_that_promises_no_more_than_is_run() -> None:
    def labels(line: str) -> list[str]:
        variants = session_experiment(moment(run, "timed"), 3, line).variants
        return [variant.label for variant in variants]

    run = Run(presets.load("timed", ["world.size=40"]), 5)
    run.advance(until_trial=50)
    run.apply(Introduce("circle_clockwise", 20))
    name = 'circle: "early" # ü\t- x'
    assert labels(name) == ["timed as it was", name]
    assert labels("x" * 300)[1] == "x" * 200
    assert labels("timed as it was")[1] == "this session"
    run.apply(SetParameter("learner.epsilon", 0.9))
    assert labels("ε 0.9")[1] == "this session"


def test_what_a_session_cannot_repeat_is_said() -> None:
    run = Run(presets.load("timed", ["world.size=40"]), 5)
    run.advance(until_trial=50)
    run.apply(SetParameter("learner.epsilon", 0.9))
    found = moment(run, "timed")
    (lost,) = not_repeated(found)
    assert lost.startswith("Exploration ε was set to 0.9 at trial 50")
    experiment = session_experiment(found, 3)
    assert f"# {lost}" in experiment.text.decode()
    said = about_html(experiment, (lost, "<b>"))
    assert "Will not be repeated:</div>\n<ul" in said
    assert f"<li>{lost}</li>" in said
    assert "<li>&lt;b&gt;</li>" in said
    assert "Will not" not in about_html(experiment)


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
    whole = cost_html(quote(), "3 seeds")
    assert "12 runs" in whole
    assert "74 M steps" in whole
    assert "8 s" in whole
    assert "&lt;b&gt;" in whole
    assert "6 are there already" in cost_html(quote(done=6), "3 seeds")
    assert "1 is there already" in cost_html(quote(done=1), "3 seeds")
    assert "The run is in" in cost_html(quote(done=1, runs=1), "1 seed")
    assert "<b>1 run</b>: 1 variant, 1 seed each." in cost_html(quote(runs=1), "1 seed")
    assert "All 12 runs are in" in cost_html(quote(done=12), "3 seeds")


def test_the_cost_says_how_many_variants_are_drawn_at_random() -> None:
    found = quote()
    searched = found._replace(plan=found.plan._replace(drawn=3))
    assert "4 variants (3 drawn at random), 3 seeds each." in cost_html(searched, "3 seeds")
    assert "drawn" not in cost_html(found, "3 seeds")


def test_the_cost_says_beside_what_it_holds() -> None:
    alone, paused, learning = (beside_in_words(*at) for at in ((0, True), (1, False), (3, True)))
    assert "About <b>8 s</b>:" in cost_html(quote(), "3 seeds", alone)
    assert "About <b>8 s</b> with this page open:" in cost_html(quote(), "3 seeds", paused)
    assert "<b>8 s</b> with 3 pages open and the lab" in cost_html(quote(), "3 seeds", learning)


def test_what_is_not_what_was_run_under_its_name_before_is_said_to_be_so() -> None:
    assert "whose results stay" not in cost_html(quote(), "3 seeds")
    assert "whose results stay" in cost_html(quote()._replace(is_beside_others=True), "3 seeds")


def test_nothing_takes_no_time() -> None:
    short = Quote(Plan(1, 3, 0, 285_000, 0.1, 1_000), Path("results"))
    assert "About <b>1 s</b>: 285 k steps" in cost_html(short, "3 seeds")
    found = Progress(4, 1, 0, 2, 5_000, 2e4, 0.4, 0.1)
    assert "20 k steps/s, about 1 s left" in progress_html(standing(progress=found))


def standing(**changes: Any) -> Standing:
    experiment = parse("presets: [timed]\nseeds: 4", "a <b>.yaml")
    found = Progress(4, 1, 1, 2, 5_000_000, 2e6, 0.4, 9.0)
    state = {"progress": found, "running": True, "paused": False, "error": "", **changes}
    return Standing(experiment, Path("results"), Gatherer(experiment, 5_500_000), **state)


def test_how_it_stands_is_said_in_words() -> None:
    running = progress_html(standing())
    assert "A &lt;b&gt;" in running
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


class Service:
    """What runs experiments, which take no time."""

    def __init__(self) -> None:
        self.standing: Standing | None = None
        self.quoted = 0
        self.trials = 0
        """Of the experiment whose cost was asked for last."""
        self.locked = False
        self.started: list[tuple[str, int, int]] = []
        """Name, seeds and workers."""

    def quote(self, experiment: Experiment, workers: int, beside: object) -> Quote:
        self.quoted += 1
        self.trials = experiment.variants[-1].spec.trials
        if self.locked:
            raise FolderError("is in use by another pounce")
        return quote(done=0 if self.standing is None else 12)

    def start(self, experiment: Experiment, workers: int) -> None:
        if self.locked:
            raise FolderError("is in use by another pounce")
        self.started.append((experiment.name, len(experiment.seeds), workers))


class Tab:
    """The tab, and somebody before it."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self.service = Service()
        self.session = Session(presets.load("timed"), "timed", 1, speed=1.0, playing=False)
        service: Any = self.service
        self.n_pages = 1
        self.shown: list[object] = []
        """Browsers in which the results were opened."""
        self.requests: list[Request] = []
        self._made = threading.Event()
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(experiments, "Maker", lambda: Maker(self._made.set))
            self.panel = ExperimentsPanel(
                gui, self.session, service, self.ask, AtOnce().work, self.shown.append
            )
        self.person = Person(gui)

    def ask(self, client: object, request: Request) -> None:
        self.requests.append(request)

    def update(self, status: Status | None = None) -> None:
        """Draw once, which may ask for the cost; without waiting for it."""
        self._made.clear()
        self.panel.update(status or self.session.status, self.n_pages)

    def find_out(self) -> None:
        """Wait until the cost that was asked for is known."""
        assert self._made.wait(60)

    def settle(self, status: Status | None = None) -> None:
        """Draw until what an experiment takes is found out and shown."""
        self.update(status)
        self.find_out()
        self.panel.update(status or self.session.status, self.n_pages)


@pytest.fixture
def tab() -> Iterator[Tab]:
    server = open_server(port=0)
    yield Tab(server.gui)
    close_server(server)


def test_an_experiment_that_no_frame_saw_running_changes_what_is_offered(tab: Tab) -> None:
    tab.settle()
    assert tab.person.reads("12 runs")
    assert tab.person.sees("Start")
    tab.service.standing = standing(running=False)
    tab.settle()
    assert tab.person.reads("All 12 runs are in")
    assert tab.person.sees("Show these runs")


def test_what_is_known_is_not_found_out_again(tab: Tab) -> None:
    tab.settle()
    for _ in range(5):
        tab.update()
    assert tab.service.quoted == 1


def test_a_cost_is_measured_again_now_and_then_and_shown_meanwhile(
    tab: Tab, monkeypatch: pytest.MonkeyPatch
) -> None:
    tab.settle()
    for quoted in (2, 3):
        with monkeypatch.context() as later:
            later.setattr(experiments, "_FRESH_S", -math.inf)
            tab.update()
        assert tab.person.reads("12 runs")
        tab.find_out()
        for _ in range(3):
            tab.update()
            assert tab.person.reads("12 runs")
        assert tab.service.quoted == quoted


def test_a_cost_is_found_out_again_when_something_else_goes_on_beside_it(tab: Tab) -> None:
    tab.settle()
    assert tab.person.reads("with this page open:")
    tab.n_pages = 2
    tab.settle()
    assert tab.service.quoted == 2
    assert tab.person.reads("with 2 pages open:")
    tab.settle(replace(tab.session.status, playing=True))
    assert tab.service.quoted == 3
    assert tab.person.reads("with 2 pages open and the lab learning:")


def test_a_session_that_becomes_longer_keeps_its_cost_in_sight_and_is_asked_for_now_and_then(
    tab: Tab, monkeypatch: pytest.MonkeyPatch
) -> None:
    status = tab.session.status
    beyond = [
        replace(status, snapshot=replace(status.snapshot, trial=status.snapshot.spec.trials + more))
        for more in (500, 1_500, 2_500, 3_500)
    ]
    tab.settle(beyond[0])
    for later in beyond:
        tab.update(later)
        assert tab.person.reads("12 runs")
    assert tab.service.quoted == 1
    monkeypatch.setattr(experiments, "_FRESH_S", -math.inf)
    tab.settle(beyond[-1])
    assert tab.person.reads("12 runs")
    assert tab.service.trials == beyond[-1].snapshot.trial


def test_a_cost_is_not_measured_while_an_experiment_runs(
    tab: Tab, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(experiments, "_FRESH_S", -math.inf)
    tab.service.standing = standing()
    tab.settle()
    for _ in range(5):
        tab.update()
    assert tab.service.quoted == 1


def test_whose_schedule_would_be_run_is_said_while_an_opened_run_is_on_the_board(tab: Tab) -> None:
    tab.settle()
    assert not tab.person.reads("on the board")
    status = tab.session.status
    opened = replace(status.snapshot, preset="Figure 4.1: <b>", seed=7, generation=1)
    tab.settle(replace(status, snapshot=opened, is_own=False, aside="timed, trial 12"))
    said = (
        "schedule of Figure 4.1: <b>, seed 7, which is on the board, and not of your run"
        " (timed, trial 12), which is set aside."
    )
    assert tab.person.reads(said)
    assert "<b>, seed" not in tab.person.html
    tab.person.click("Back to timed, trial 12")
    assert tab.requests == [GoBack()]


def test_a_folder_that_is_free_again_is_found_to_be(
    tab: Tab, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(background, "_RETRY_S", math.inf)
    tab.service.locked = True
    tab.settle()
    assert tab.person.reads("Cannot be run: is in use")
    tab.service.locked = False
    monkeypatch.setattr(background, "_RETRY_S", 0.0)
    tab.settle()
    assert tab.person.reads("12 runs")


def test_what_is_chosen_is_started_and_shown_to_whoever_started_it(tab: Tab) -> None:
    tab.person.choose("Experiment", "Figure 4.1")
    tab.person.fill("Seeds", 3)
    tab.person.fill("At a time", 2)
    tab.person.click("Start")
    assert tab.service.started == [("figure_4_1", 3, 2)]
    assert tab.shown == [tab.person]


def test_what_a_line_of_the_session_does_is_tried_over_thirty_seeds(tab: Tab) -> None:
    client: Any = tab.person
    run = Run(presets.load("timed", ["world.size=40"]), 5)
    run.advance(until_trial=50)
    run.apply(Introduce("circle_clockwise", 20))
    tab.panel.test(client, moment(run, "timed"), "mine")
    workers = int(tab.person.value("At a time"))
    assert tab.service.started == [("session", 30, workers)]
    assert tab.shown == [client]
    assert tab.person.told == []
    run.apply(SetParameter("learner.epsilon", 0.2))
    tab.panel.test(client, moment(run, "timed"), "mine")
    # The name of such a branch would promise what its schedule does not hold.
    (told,) = tab.person.told
    assert told.startswith("Exploration ε was set to 0.2 at trial 50")


def test_what_cannot_be_started_is_told_and_shown_to_nobody(tab: Tab) -> None:
    tab.person.type("Seeds", "some")
    tab.person.click("Start")
    tab.person.fill("Seeds", 3)
    tab.service.locked = True
    tab.person.click("Start")
    assert tab.person.told[0].startswith("Seeds: 'some' is not taken")
    assert tab.person.told[1] == "is in use by another pounce"
    assert tab.shown == []
