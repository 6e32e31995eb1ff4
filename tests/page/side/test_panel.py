"""Runs side by side in one browser: what its frame is sent, and what comes of a hand there."""

import json
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest
import viser

from app.live.race import Race
from app.live.requests import Play, Request, SetSpeed
from app.live.session import Session
from app.live.worker import FULL_SPEED
from app.page.side import messages, panel
from app.page.side.panel import SidePanel
from app.page.side.show import Hall
from app.picture.layers import LAYERS
from app.picture.look import ALL, Look
from tests.support.person import AtOnce, Person
from tests.support.races import PATIENCE_S, SEED, answered, small

PRESETS = ("standard_q", "hierarchical_3", "timed", "hierarchical_2")
STEPS = 600
_HARMLESS = SetSpeed(FULL_SPEED)


class Frames:
    """Frames that keep what they are sent."""

    def __init__(self) -> None:
        self.sent: list[tuple[str, dict[str, Any]]] = []
        self.is_slow = False
        self.has_left = False
        self.opened: Callable[[], object] = lambda: None
        self.take: Callable[[Any], object] = lambda message: None

    def enter(self, kind: Any, take: Any, opened: Callable[[], object], page: str) -> "Frames":
        assert page == "side"
        self.opened, self.take = opened, take
        return self

    def frame_html(self, title: str) -> str:
        return f'<iframe title="{title}"></iframe>'

    def send(self, kind: str, content: dict[str, Any]) -> None:
        self.sent.append((kind, json.loads(msgspec.json.encode(content))))

    def waits(self, kind: str) -> bool:
        return self.is_slow

    def leave(self) -> None:
        self.has_left = True

    def last(self, kind: str) -> dict[str, Any]:
        return [content for sort, content in self.sent if sort == kind][-1]

    def count(self, kind: str) -> int:
        return sum(sort == kind for sort, _ in self.sent)


class Desk:
    """The side panel of one browser, of a session in a small world; drawn when a test says so."""

    def __init__(self, gui: viser.GuiApi) -> None:
        spec = small("timed", "trials=4000")
        self.session = Session(spec, "timed", SEED, FULL_SPEED, playing=False)
        self.session.start()
        self.frames, self.viewers = Frames(), set[object]()
        show: Any = SimpleNamespace(
            enter=self.viewers.add, leave=self.viewers.discard, wake=lambda: None
        )
        client: Any = SimpleNamespace(gui=gui)
        inbox: Any = AtOnce()
        frames: Any = self.frames
        presets = {name: small(name, "trials=4000") for name in PRESETS}
        self.panel = SidePanel(client, self.session, show, frames, inbox, lambda: presets)
        self.hall: Hall | None = None
        self.now_s = 0.0

    @property
    def race(self) -> Race:
        assert self.session.race is not None
        return self.session.race

    def draw(self) -> None:
        self.now_s += 1.0
        race = self.session.race
        if race is not None and (self.hall is None or self.hall.race is not race):
            self.leave_hall()
            self.hall = Hall(race)
        if self.hall is not None:
            self.hall.look_again(self.now_s)
        self.panel.draw(self.hall, self.now_s)

    def take(self, *many: Any) -> None:
        for message in many:
            self.frames.take(message)
        self.draw()

    def start(self, *many: messages.Start | messages.StartFour) -> None:
        """Have runs begun, and stand still after some steps."""
        self.take(*(many or (messages.StartFour(),)))
        self.ask()
        answered(self.race, self.race.run_to(STEPS))
        self.race.wait_for(lambda status: status.step == STEPS and not status.playing, PATIENCE_S)
        self.draw()
        self.draw()

    def ask(self, request: Request = _HARMLESS) -> None:
        """Wait until the session has answered something, and all before it."""
        ticket = self.session.submit(request)
        self.session.wait_for(lambda status: status.answered >= ticket, PATIENCE_S)

    def leave_hall(self) -> None:
        if self.hall is not None:
            self.hall.stop()

    @property
    def refused(self) -> str:
        said = self.frames.last("said")
        assert said["refused"]
        return str(said["text"])


@pytest.fixture
def desk(gui: viser.GuiApi, person: Person, monkeypatch: pytest.MonkeyPatch) -> Iterator[Desk]:
    # They come to where a test wants them when it says so.
    monkeypatch.setattr(panel, "FIRST_SPEED", 1.0)
    desk = Desk(gui)
    yield desk
    desk.leave_hall()
    desk.session.stop()


# --- What is sent


def test_before_there_are_runs_there_is_something_to_choose_from(desk: Desk) -> None:
    desk.draw()
    assert desk.frames.last("race") == {"runs": []}
    choice = desk.frames.last("choice")
    assert choice["presets"] == list(PRESETS)
    assert [line["name"] for line in choice["lines"]] == ["live run"]
    assert (choice["preset"], choice["seed"]) == ("timed", SEED)
    desk.draw()
    assert [kind for kind, _ in desk.frames.sent] == ["choice", "race"]


def test_the_thesiss_four_are_sent_with_all_that_is_to_be_seen(desk: Desk) -> None:
    desk.start()
    runs = desk.frames.last("race")["runs"]
    assert [run["name"] for run in runs] == list(PRESETS)
    assert len({json.dumps(run["look"]) for run in runs}) == 4
    assert len(desk.frames.last("worlds")["worlds"]) == 1
    for kind in ("boards", "overs"):
        assert len(desk.frames.last(kind)["boards"]) == 4
    assert all(board["colours"] for board in desk.frames.last("boards")["boards"])
    moment = desk.frames.last("moment")
    assert (moment["step"], moment["end"], moment["live"]) == (STEPS, STEPS, True)
    readings = desk.frames.last("readings")
    assert "Four runs, step for step, from the same starts" in readings["standing"]
    assert [run["digest"] for run in readings["runs"]] == list(desk.race.status.digests)
    assert len(desk.frames.last("legend")["captions"]) == 4
    assert desk.frames.last("cell")["rows"] is None


def test_what_is_as_it_was_is_sent_once_and_all_again_to_a_frame_that_is_new(desk: Desk) -> None:
    desk.start()
    n_sent = len(desk.frames.sent)
    # What is measured beside them may be new.
    beside = ("readings", "compare")
    desk.draw()
    assert {kind for kind, _ in desk.frames.sent[n_sent:]} <= set(beside)
    n_sent = len(desk.frames.sent)
    desk.frames.opened()
    desk.draw()
    kinds = {kind for kind, _ in desk.frames.sent[n_sent:]}
    assert {"race", "worlds", "curves", "moment", "boards", "overs", "choice"} <= kinds


def test_a_page_that_is_slow_gets_fewer_boards_and_none_is_made_for_nothing(desk: Desk) -> None:
    desk.start()
    n_boards = desk.frames.count("boards")
    desk.frames.is_slow = True
    desk.take(messages.StepOnce())
    desk.race.wait_for(lambda status: status.step == STEPS + 1, PATIENCE_S)
    desk.draw()
    assert desk.frames.last("moment")["step"] == STEPS + 1
    assert desk.frames.count("boards") == n_boards
    desk.frames.is_slow = False
    desk.draw()
    assert desk.frames.count("boards") == n_boards + 1


# --- Which runs


def test_lines_and_presets_may_be_chosen(desk: Desk) -> None:
    line = desk.session.status.snapshot.generation
    desk.start(
        messages.Start(
            (
                messages.Chosen(line=line),
                messages.Chosen(preset="timed", seed=1),
                messages.Chosen(preset="timed", seed=2),
            )
        )
    )
    names = [run["name"] for run in desk.frames.last("race")["runs"]]
    assert names == ["live run", "timed, seed 1", "timed, seed 2"]
    # The live run has made no step, and is known no further.
    assert desk.frames.last("readings")["runs"][0]["stand"] == "Step 0: no more is known"


@pytest.mark.parametrize(
    "chosen",
    [
        messages.Chosen(),
        messages.Chosen(preset="nobody_knows", seed=1),
        messages.Chosen(preset="timed"),
        messages.Chosen(line=99),
    ],
)
def test_what_is_not_there_cannot_be_chosen(desk: Desk, chosen: messages.Chosen) -> None:
    desk.take(messages.Start((chosen, messages.Chosen(preset="timed", seed=1))))
    assert desk.refused
    assert desk.session.race is None


# --- Time


def test_all_boards_show_the_same_step_of_the_past(desk: Desk) -> None:
    desk.start()
    live = desk.frames.last("boards")
    desk.take(messages.Seek(200))
    while desk.race.moments.found(desk.panel) is None:
        desk.race.moments.made(0)
    desk.draw()
    moment = desk.frames.last("moment")
    assert (moment["step"], moment["end"], moment["live"]) == (200, STEPS, False)
    assert desk.frames.last("boards") != live
    # A digest is that of where the runs are.
    assert {run["digest"] for run in desk.frames.last("readings")["runs"]} == {""}
    desk.take(messages.Live())
    assert desk.frames.last("moment")["live"]
    assert desk.frames.last("boards") == live


def test_the_past_plays_and_the_runs_are_left_alone(desk: Desk) -> None:
    desk.start()
    desk.take(messages.Seek(100), messages.SetRate(2.0), messages.Play(1))
    assert desk.frames.last("moment")["playing"]
    assert not desk.race.status.playing
    desk.take(messages.Pause())
    assert not desk.frames.last("moment")["playing"]
    desk.take(messages.GoBy("steps", -1))
    assert not desk.frames.last("moment")["live"]


def test_space_lets_the_runs_go_on_where_they_are(desk: Desk) -> None:
    desk.start()
    desk.take(messages.Play(1))
    desk.race.wait_for(lambda status: status.step > STEPS, PATIENCE_S)
    desk.take(messages.Pause())
    desk.race.wait_for(lambda status: not status.playing, PATIENCE_S)


def test_speed_is_that_of_all(desk: Desk) -> None:
    desk.start()
    desk.take(messages.SetSpeed(2_000.0))
    desk.race.wait_for(lambda status: status.speed == 2_000.0, PATIENCE_S)
    desk.take(messages.Faster(10))
    desk.race.wait_for(lambda status: status.speed == 20_000.0, PATIENCE_S)
    desk.take(messages.SetSpeed(0.0))
    desk.race.wait_for(lambda status: status.speed == FULL_SPEED, PATIENCE_S)


# --- Comparing


def test_two_are_compared_in_words_and_on_a_map(desk: Desk) -> None:
    desk.start()
    desk.take(messages.Compare(0, 2, shown=True))
    while desk.frames.last("compare")["step"] is None:
        desk.draw()
    compare = desk.frames.last("compare")
    assert (compare["one"], compare["other"], compare["shown"]) == (0, 2, True)
    assert compare["text"].startswith("Different from the start: standard_q chooses among the nine")
    assert compare["caption"].startswith("standard_q and timed, at step")
    assert compare["legend"]
    assert len(desk.frames.last("boards")["boards"]) == 5
    desk.take(messages.Compare(0, 2, shown=False))
    assert len(desk.frames.last("boards")["boards"]) == 4


def test_a_run_cannot_be_compared_with_itself_or_with_none(desk: Desk) -> None:
    desk.start()
    pair = desk.frames.last("compare")
    desk.take(messages.Compare(1, 1, shown=True))
    line = desk.session.status.snapshot.generation
    assert desk.frames.last("compare")["one"] == pair["one"]
    desk.start(
        messages.Start((messages.Chosen(line=line), messages.Chosen(preset="timed", seed=1)))
    )
    desk.take(messages.Compare(0, 3, shown=True))
    assert desk.frames.last("compare")["other"] == 1


def test_the_same_cell_is_read_in_all(desk: Desk) -> None:
    desk.start()
    desk.take(messages.Point(-3, 0))
    cell = desk.frames.last("cell")
    assert (cell["east"], cell["north"]) == (-3, 0)
    assert [len(row["values"]) for row in cell["rows"]] == [4] * 5
    desk.take(messages.Point(9_000, 0))
    values = {value for row in desk.frames.last("cell")["rows"] for value in row["values"]}
    assert values == {"not on this board"}
    desk.take(messages.Unpoint())
    assert desk.frames.last("cell")["rows"] is None


def test_every_layer_can_be_looked_at(desk: Desk) -> None:
    desk.start()
    for layer in LAYERS.values():
        for frame in (-1, ALL):
            desk.panel.update(Look(layer=layer.key, frame=frame, option=1))
            desk.draw()
            # The first that is shown is of moves.
            of_moves = layer.title_of(small("standard_q").learner)
            assert desk.frames.last("legend")["layer"] == of_moves
    assert len(desk.frames.last("boards")["boards"]) == 4


# --- Looking, or not


def test_a_browser_looks_and_looks_away(desk: Desk) -> None:
    assert not desk.panel.is_open
    desk.panel.toggle()
    assert desk.panel.is_open
    assert desk.viewers == {desk.panel}
    desk.start()
    desk.take(messages.Close())
    assert not desk.panel.is_open
    assert desk.viewers == set()
    assert desk.session.race is not None
    desk.panel.open(four=True)
    assert desk.panel.is_open
    desk.panel.leave()
    assert desk.frames.has_left
    assert desk.viewers == set()


def test_runs_can_be_put_away(desk: Desk) -> None:
    desk.start()
    desk.take(messages.End())
    desk.ask()
    assert desk.session.race is None


def test_it_is_said_that_the_live_run_stands_still(desk: Desk) -> None:
    desk.ask(SetSpeed(1_000.0))
    desk.ask(Play())
    desk.session.wait_for(lambda status: status.snapshot.step > 0, PATIENCE_S)
    desk.start()
    trial = desk.session.status.snapshot.trial
    said = desk.frames.last("said")
    assert said == {
        "text": f"Your run stands still at trial {trial:,} meanwhile.",
        "refused": False,
    }
