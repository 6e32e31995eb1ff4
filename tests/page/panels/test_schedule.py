"""The planner's panel and the files of presets, as far as they need no browser."""

import asyncio
import inspect
import os
import stat
import threading
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import viser
from hypothesis import given
from hypothesis import strategies as st

from app.documents import experiments, presets
from app.documents.experiments import ExperimentError
from app.live import snapshot
from app.live.session import Request, Session, StartAgain, Status, TrialOnce
from app.live.snapshot import Snapshot
from app.page.panels import schedule
from app.page.panels.schedule import Planner, PresetButtons
from app.schedule import blocks
from app.server.server import close_server, open_server
from learners.commands import Explore, FollowSchedule, FreezeSkills, Introduce, SetSchedule
from learners.run import Run
from learners.spec import RunSpec

SMALL = (
    "world.size=30",
    "world.n_directions=16",
    "world.n_distances=6",
    "world.step_limit=40",
    "trials=9000",
    "schedule.skills.circle_clockwise={at: 3000, freeze: 20}",
    "schedule.skills.avoid={at: 6000, freeze: 20}",
    "schedule.episodes=[{skill: circle_clockwise, duration: 500, probability: 0.95},"
    " {skill: circle_clockwise, at: 4000, duration: 100, probability: 0.5}]",
)


def small_spec(*settings: str) -> RunSpec:
    return presets.load("timed", [*SMALL, *settings])


# --- Names and files -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["a", "my_timed", "Run-2", "0", "x" * 64])
def test_plain_names_are_safe(name: str) -> None:
    assert schedule.is_safe_name(name)
    assert schedule.safe_name(name) == name


@pytest.mark.parametrize(
    "name",
    ["", ".", "..", "../x", "a/b", "a\\b", "/etc/x", ".hidden", "-x", "_x", "a b", "a.yaml", "é"],
)
def test_names_that_lead_elsewhere_are_not(name: str, tmp_path: Path) -> None:
    refuses(name, tmp_path)


@pytest.mark.parametrize("name", ["a\n", "a\0", "x" * 65, "C:x", "con:"])
def test_names_that_a_machine_may_not_take_are_not(name: str, tmp_path: Path) -> None:
    refuses(name, tmp_path)


def refuses(name: str, tmp_path: Path) -> None:
    assert not schedule.is_safe_name(name)
    with pytest.raises(ValueError, match="A name has"):
        schedule.save_file(tmp_path / "folder", name, "text")
    assert list(tmp_path.iterdir()) == []


@given(st.text(max_size=200))
def test_any_name_can_be_made_safe(name: str) -> None:
    assert schedule.is_safe_name(schedule.safe_name(name))
    assert schedule.is_safe_name(schedule.loaded_name(name))


def test_the_name_of_a_file_is_that_of_its_stem() -> None:
    assert schedule.safe_name("../up/My run.YAML") == "My_run"
    assert schedule.safe_name("C:\\files\\mine.yml") == "mine"
    assert schedule.loaded_name("mine.yaml") == "mine"
    assert schedule.loaded_name("timed.yaml") == "timed_loaded"


def test_a_file_is_saved_as_a_whole(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    path = schedule.save_file(folder, "mine", "text: é\n")
    assert path == folder / "mine.yaml"
    assert path.read_bytes() == "text: é\n".encode()
    assert list(folder.iterdir()) == [path]
    umask = os.umask(0)
    os.umask(umask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~umask


def test_nothing_is_overwritten_unless_that_is_wanted(tmp_path: Path) -> None:
    path = schedule.save_file(tmp_path, "mine", "first")
    with pytest.raises(FileExistsError):
        schedule.save_file(tmp_path, "mine", "second")
    assert path.read_text() == "first"
    schedule.save_file(tmp_path, "mine", "second", overwrite=True)
    assert path.read_text() == "second"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_is_a_file_that_is_there_and_what_it_points_to_stays(tmp_path: Path) -> None:
    outside, folder = tmp_path / "outside", tmp_path / "folder"
    folder.mkdir()
    (folder / "mine.yaml").symlink_to(outside)
    with pytest.raises(FileExistsError):
        schedule.save_file(folder, "mine", "text")
    schedule.save_file(folder, "mine", "text", overwrite=True)
    assert not outside.exists()
    assert (folder / "mine.yaml").read_text() == "text"


def test_a_failure_leaves_the_old_file_and_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = schedule.save_file(tmp_path, "mine", "first")

    def fail(_: int) -> None:
        raise OSError("the disk is full")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OSError, match="disk is full"):
        schedule.save_file(tmp_path, "mine", "second", overwrite=True)
    assert path.read_text() == "first"
    assert list(tmp_path.iterdir()) == [path]


def test_of_many_who_save_under_one_name_one_does(tmp_path: Path) -> None:
    saved: list[int] = []

    def save(number: int) -> None:
        try:
            schedule.save_file(tmp_path, "mine", str(number))
        except FileExistsError:
            return
        saved.append(number)

    threads = [threading.Thread(target=save, args=(number,)) for number in range(16)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(saved) == 1
    assert (tmp_path / "mine.yaml").read_text() == str(saved[0])


def test_a_saved_preset_says_what_it_does_not_repeat_and_can_be_read() -> None:
    spec = small_spec()
    text = schedule.preset_text(spec, ["It was frozen: for a while."])
    assert "# It was frozen: for a while.\n" in text
    assert presets.parse(text, "mine") == spec
    assert schedule.preset_text(spec, []) == presets.dump(spec)


# --- What the widgets are to show ----------------------------------------------------------------


def moment(trial: int, act: Callable[[Run], None] = lambda _: None) -> Snapshot:
    run = Run(small_spec(), 3)
    run.advance(until_trial=trial)
    act(run)
    return snapshot.take(run, "timed", 0)


def choices(shot: Snapshot) -> dict[str, str]:
    return schedule.choices_of(blocks.blocks_of(shot), shot)


def form(chosen: str, shot: Snapshot) -> schedule.Form:
    return schedule.form_of(chosen, blocks.blocks_of(shot), shot)


CIRCLE = "introduction:circle_clockwise"


def test_only_what_lies_ahead_can_be_chosen_and_new_explorations() -> None:
    new = {
        "approach: new exploration": "new:approach",
        "circle clockwise: new exploration": "new:circle_clockwise",
        "avoid: new exploration": "new:avoid",
    }
    assert choices(moment(0)) == {
        "– nothing –": "",
        "circle clockwise: joins": CIRCLE,
        "circle clockwise: exploration 1": "episode:0:circle_clockwise",
        "circle clockwise: exploration 2": "episode:1:circle_clockwise",
        "avoid: joins": "introduction:avoid",
        **new,
    }
    assert choices(moment(3_100)) == {
        "– nothing –": "",
        "circle clockwise: exploration": "episode:1:circle_clockwise",
        "avoid: joins": "introduction:avoid",
        **new,
    }


def test_an_introduction_can_be_moved_and_not_deleted() -> None:
    shown = form(CIRCLE, moment(0))
    assert (shown.at, shown.trials, shown.trials_label) == (3_000, 20, "Freeze")
    assert (shown.movable, shown.editable) == (True, True)
    assert (shown.deletable, shown.explores) == (False, False)
    assert "not deleted" in shown.caption


def test_an_exploration_can_be_changed_and_deleted() -> None:
    shown = form("episode:1:circle_clockwise", moment(0))
    assert (shown.at, shown.trials, shown.probability) == (4_000, 100, 0.5)
    assert (shown.movable, shown.deletable, shown.explores) == (True, True, True)


def test_what_has_begun_can_not_be_chosen_any_more() -> None:
    shown = form(CIRCLE, moment(3_000))
    assert shown.chosen == ""
    assert {shown.movable, shown.editable, shown.deletable} == {False}
    assert "has begun" in shown.caption


def test_a_new_exploration_is_proposed_for_when_the_skill_is_there() -> None:
    assert form("new:approach", moment(0)).at == 1_000
    assert form("new:approach", moment(1_234)).at == 2_300
    avoid = form("new:avoid", moment(0))
    assert (avoid.at, avoid.is_new, avoid.editable, avoid.movable) == (6_000, True, True, False)


def test_a_skill_that_will_not_join_cannot_be_explored() -> None:
    shown = form("new:avoid", moment(0, lambda run: run.apply(FollowSchedule(False))))
    assert not shown.editable
    assert "not going to join" in shown.caption


def test_every_case_says_what_to_do_or_why_nothing_can_be_done() -> None:
    assert "Choose" in form("", moment(0)).caption
    assert "past" in form("", moment(6_001)).caption
    off = moment(0, lambda run: run.apply(FollowSchedule(False)))
    assert "not followed" in form("", off).caption
    moves = snapshot.take(Run(presets.load("standard_q", ["world.size=30"]), 1), "q", 0)
    assert "nothing to schedule" in form("", moves).caption
    assert choices(moves) == {"– nothing –": ""}


# --- The panel, on a real server that nobody looks at --------------------------------------------


async def finished(done: Awaitable[object]) -> None:
    await done


class Person:
    """Stands for a browser: uses widgets, and keeps what it is told."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self.gui = gui
        self.told: list[str] = []
        self.downloads: dict[str, bytes] = {}

    def add_notification(self, title: str, body: str, **_: Any) -> None:
        self.told.append(body)

    def send_file_download(self, filename: str, content: bytes, **_: Any) -> None:
        self.downloads[filename] = content

    def use(self, handle: Any, value: Any = True) -> None:
        """What happens when a person clicks on a widget, or enters a value."""
        assert not handle._impl.props.disabled
        assert handle.visible
        handle._impl.value = value
        for callback in handle._impl.update_cb:
            done = callback(viser.GuiEvent(client=self, client_id=0, target=handle))  # type: ignore
            if inspect.isawaitable(done):
                asyncio.run(finished(done))


class Desk:
    """A paused session with the planner and the preset buttons of one browser."""

    def __init__(self, server: viser.ViserServer, save_dir: Path | None) -> None:
        self.requests: list[Request] = []
        self.session = Session(small_spec(), "timed", 3, speed=1.0, playing=False)
        self.session.start()
        self.person = Person(server.gui)
        self.planner = Planner(server.gui, self.ask, self.session)
        client: Any = self.person
        self.buttons = PresetButtons(client, self.session, self.ask, save_dir)

    def ask(self, event: viser.GuiEvent, request: Request) -> int:
        self.requests.append(request)
        return self.session.submit(request, self.person.told.append)

    def settle(self) -> Status:
        """Wait until all has been answered, and show it."""
        ticket = self.session.submit(FreezeSkills(False))
        status = self.session.wait_for(lambda status: status.answered >= ticket, 30)
        self.planner.update(status)
        return status

    def choose(self, label: str) -> None:
        self.person.use(self.planner._choice, label)
        self.settle()

    @property
    def at(self) -> int:
        """Trial in which circling is to join."""
        return self.settle().snapshot.spec.schedule.introduced_at("circle_clockwise")


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    server = open_server(port=0)
    yield server
    close_server(server)


@pytest.fixture
def desk(server: viser.ViserServer, tmp_path: Path) -> Iterator[Desk]:
    desk = Desk(server, tmp_path / "presets")
    yield desk
    desk.session.stop()


def test_two_clicks_move_a_block(desk: Desk) -> None:
    desk.choose("circle clockwise: joins")
    desk.person.use(desk.planner._nudges, "\N{MINUS SIGN}500")
    assert desk.at == 2_500
    assert desk.planner._at.read() == 2_500
    assert desk.person.told == []


def test_the_render_loop_does_not_undo_a_choice(desk: Desk) -> None:
    status = desk.settle()
    desk.person.use(desk.planner._choice, "avoid: joins")
    desk.planner.update(status)
    assert desk.planner._choice.value == "avoid: joins"
    assert desk.planner._at.read() == 6_000


def test_a_click_right_after_a_choice_is_about_what_was_chosen(desk: Desk) -> None:
    desk.choose("avoid: joins")
    desk.person.use(desk.planner._choice, "circle clockwise: joins")
    desk.person.use(desk.planner._nudges, "+100")
    assert desk.at == 3_100


def test_clicks_in_quick_succession_add_up(desk: Desk) -> None:
    desk.choose("circle clockwise: joins")
    for _ in range(3):
        desk.person.use(desk.planner._nudges, "\N{MINUS SIGN}100")
    assert desk.at == 2_700


def test_nothing_is_shown_before_the_own_request_is_answered(desk: Desk) -> None:
    before = desk.settle()
    desk.choose("circle clockwise: joins")
    desk.person.use(desk.planner._nudges, "+500")
    desk.planner.update(before)
    assert desk.planner._at.read() == 3_000
    assert desk.planner._choice.value == "circle clockwise: joins"
    desk.settle()
    assert desk.planner._at.read() == 3_500


def test_a_refused_edit_is_told_and_changes_nothing(desk: Desk) -> None:
    desk.choose("circle clockwise: exploration 2")
    desk.person.use(desk.planner._at.handle, "3100")
    desk.settle()
    desk.person.use(desk.planner._apply)
    assert "overlap" in desk.person.told[0]
    assert desk.requests == []
    # What was typed stays, so that it can be mended.
    desk.settle()
    assert desk.planner._at.read() == 3_100


def test_fields_are_applied_together(desk: Desk) -> None:
    desk.choose("circle clockwise: exploration 2")
    desk.settle()
    assert desk.planner._apply.disabled
    desk.person.use(desk.planner._at.handle, "5000")
    desk.person.use(desk.planner._trials.handle, "250")
    desk.person.use(desk.planner._chance.handle, "0.75")
    desk.settle()
    desk.person.use(desk.planner._apply)
    episode = desk.settle().snapshot.spec.schedule.episodes[1]
    assert (episode.at, episode.duration, episode.probability) == (5_000, 250, 0.75)
    assert desk.planner._apply.disabled


def test_an_exploration_is_added_chosen_and_deleted(desk: Desk) -> None:
    desk.choose("approach: new exploration")
    assert desk.planner._apply.label == "Add"
    desk.person.use(desk.planner._at.handle, "7000")
    desk.person.use(desk.planner._apply)
    status = desk.settle()
    assert status.snapshot.spec.schedule.episodes[-1].at == 7_000
    assert desk.planner._choice.value == "approach: exploration"
    desk.person.use(desk.planner._delete)
    status = desk.settle()
    assert len(status.snapshot.spec.schedule.episodes) == 2
    assert desk.planner._choice.value == "– nothing –"
    assert all(isinstance(request, SetSchedule) for request in desk.requests)


def test_what_cannot_be_done_is_disabled(desk: Desk) -> None:
    shown = desk.planner
    desk.settle()
    assert (shown._nudges.visible, shown._no_nudges.visible) == (False, True)
    assert shown._no_nudges.hint
    fields = [field.handle for field in (shown._at, shown._trials, shown._chance)]
    for handle in (*fields, shown._apply, shown._delete):
        assert handle.disabled
    desk.choose("avoid: joins")
    assert (shown._nudges.visible, shown._no_nudges.visible) == (True, False)
    assert shown._chance.handle.disabled
    assert shown._delete.disabled
    assert not shown._at.handle.disabled


def test_a_block_that_begins_is_let_go(desk: Desk) -> None:
    desk.choose("circle clockwise: joins")
    desk.person.use(desk.planner._at.handle, "1")
    desk.settle()
    desk.person.use(desk.planner._apply)
    desk.session.submit(TrialOnce())
    desk.settle()
    assert desk.planner._choice.value == "– nothing –"
    assert "has begun" in desk.planner._picture.content


def test_the_picture_is_sent_again_only_when_it_changes(desk: Desk) -> None:
    status = desk.settle()
    desk.planner.update(status)
    desk.planner._picture.content = "as it was"
    desk.planner.update(status)
    desk.settle()
    assert desk.planner._picture.content == "as it was"
    desk.session.submit(Explore("approach", 10, 0.5))
    desk.settle()
    assert "explored in 50% of the steps" in desk.planner._picture.content


def test_another_run_starts_with_nothing_chosen(desk: Desk) -> None:
    desk.choose("avoid: joins")
    desk.session.submit(StartAgain(small_spec(), "timed", 4))
    desk.settle()
    assert desk.planner._choice.value == "– nothing –"


def test_a_preset_is_downloaded_and_saved(desk: Desk, tmp_path: Path) -> None:
    desk.session.submit(TrialOnce())
    desk.session.submit(Introduce("avoid", 5))
    desk.settle()
    desk.person.use(desk.buttons._save)
    content = desk.person.downloads["my_timed.yaml"]
    assert (tmp_path / "presets" / "my_timed.yaml").read_bytes() == content
    spec = presets.parse(content, "my_timed.yaml")
    assert spec.schedule.introduced_at("avoid") == 1
    assert "Saved as my_timed.yaml" in desk.buttons._said.content


def test_overwriting_takes_a_second_click(desk: Desk, tmp_path: Path) -> None:
    path = tmp_path / "presets" / "my_timed.yaml"
    desk.person.use(desk.buttons._save)
    path.write_text("precious")
    desk.person.downloads.clear()
    desk.person.use(desk.buttons._save)
    assert path.read_text() == "precious"
    assert desk.person.downloads == {}
    assert "Overwrite it?" in desk.buttons._said.content
    # The question is about one name.
    desk.person.use(desk.buttons._name, "other")
    assert not desk.buttons._overwrite.visible
    desk.person.use(desk.buttons._name, "my_timed")
    desk.person.use(desk.buttons._save)
    desk.person.use(desk.buttons._overwrite)
    assert presets.parse(path.read_bytes(), "my_timed.yaml") == small_spec()
    assert not desk.buttons._overwrite.visible


def test_an_unsafe_name_cannot_be_saved(desk: Desk, tmp_path: Path) -> None:
    desk.person.use(desk.buttons._name, "../<b>")
    assert desk.buttons._save.disabled
    assert "A name has" in desk.buttons._said.content
    desk.buttons._store(overwrite=True)
    assert desk.person.downloads == {}
    assert not (tmp_path / "presets").exists()


def test_a_folder_that_cannot_be_written_is_said_and_the_download_comes(
    desk: Desk, tmp_path: Path
) -> None:
    (tmp_path / "presets").write_text("a file in the place of the folder")
    desk.person.use(desk.buttons._save)
    assert "not written" in desk.buttons._said.content
    assert list(desk.person.downloads) == ["my_timed.yaml"]


def upload(desk: Desk, name: str, content: str) -> None:
    desk.person.use(desk.buttons._load, SimpleNamespace(name=name, content=content.encode()))


def test_a_loaded_preset_starts_again(desk: Desk) -> None:
    upload(desk, "mine.yaml", presets.dump(small_spec("trials=77")))
    status = desk.settle()
    assert status.snapshot.spec.trials == 77
    assert (status.snapshot.preset, status.snapshot.seed) == ("mine", 3)
    assert desk.requests == [StartAgain(small_spec("trials=77"), "mine", 3)]


@pytest.fixture
def shown(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is put on the page from now on."""
    contents: list[str] = []
    add_html = desk.person.gui.add_html

    def remember(content: str, **options: Any) -> Any:
        contents.append(content)
        return add_html(content, **options)

    monkeypatch.setattr(desk.person.gui, "add_html", remember)
    return contents


def test_all_errors_of_a_wrong_preset_are_shown_and_the_session_is_untouched(
    desk: Desk, shown: list[str]
) -> None:
    upload(desk, "b<b>.yaml", "learner: {options: moves, alpha: 7}\n<i>: 1\ntrials: no\n")
    (content,) = shown
    for words in ("learner.alpha", "trials", "&lt;i&gt;", "b&lt;b&gt;.yaml:1"):
        assert words in content
    assert "<i>" not in content
    assert desk.requests == []
    assert desk.settle().snapshot.generation == 0


@pytest.mark.parametrize("name", experiments.shipped())
def test_an_experiment_in_the_place_of_a_preset_is_told_to_be_one(
    name: str, desk: Desk, shown: list[str]
) -> None:
    upload(desk, f"{name}<b>.yaml", experiments.shipped()[name].read_text())
    (content,) = shown
    assert f"{name}&lt;b&gt;.yaml is an experiment, not a preset" in content
    assert "is not a known key" not in content
    assert desk.requests == []


@pytest.mark.parametrize("name", presets.shipped())
def test_a_preset_in_the_place_of_an_experiment_is_told_to_be_one(
    name: str, desk: Desk, shown: list[str]
) -> None:
    file = viser.UploadedFile(f"{name}.yaml", presets.shipped()[name].read_bytes())
    with pytest.raises(ExperimentError) as wrong:
        experiments.parse(file.content, file.name, None)
    client: Any = desk.person
    schedule.show_problems(client, "It cannot be run", wrong.value, file)
    (content,) = shown
    assert f"{name}.yaml is a preset, not an experiment" in content
    assert "is not a known key" not in content


def test_a_file_of_the_right_kind_is_told_what_is_wrong_with_it(
    desk: Desk, shown: list[str]
) -> None:
    file = viser.UploadedFile("mine.yaml", b"presets: [timed]\nlearner: 5\n")
    with pytest.raises(ExperimentError) as wrong:
        experiments.parse(file.content, file.name, None)
    client: Any = desk.person
    schedule.show_problems(client, "It cannot be run", wrong.value, file)
    upload(desk, "mine.yaml", "learner: {options: moves}\nseeds: 5\n")
    assert "learner" in shown[0]
    assert "seeds" in shown[1]
    assert not any("takes it" in content for content in shown)
