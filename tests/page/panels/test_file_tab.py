"""The File tab, as far as it needs no browser."""

import io
import os
import stat
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import viser
from hypothesis import given
from hypothesis import strategies as st

from app.documents import experiments, presets
from app.documents.experiments import Experiment
from app.live.requests import Request, StartAgain, TrialOnce
from app.live.session import Session
from app.live.status import Status
from app.page.panels import file_tab
from app.page.panels.file_tab import FileTab
from app.server.server import close_server, open_server
from learners.commands import FreezeSkills, Introduce
from learners.spec import RunSpec
from tests.support.person import AtOnce, Person


def small_spec(*settings: str) -> RunSpec:
    return presets.load("timed", ["world.size=30", "trials=9000", *settings])


# --- Names and files -----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["a", "my_timed", "Run-2", "0", "x" * 64])
def test_plain_names_are_safe(name: str) -> None:
    assert file_tab.is_safe_name(name)
    assert file_tab.safe_name(name) == name


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
    assert not file_tab.is_safe_name(name)
    with pytest.raises(ValueError, match="A name has"):
        file_tab.save_file(tmp_path / "folder", name, "text")
    assert list(tmp_path.iterdir()) == []


@given(st.text(max_size=200))
def test_any_name_can_be_made_safe(name: str) -> None:
    assert file_tab.is_safe_name(file_tab.safe_name(name))
    assert file_tab.is_safe_name(file_tab.loaded_name(name))


def test_the_name_of_a_file_is_that_of_its_stem() -> None:
    assert file_tab.safe_name("../up/My run.YAML") == "My_run"
    assert file_tab.safe_name("C:\\files\\mine.yml") == "mine"
    assert file_tab.loaded_name("mine.yaml") == "mine"
    assert file_tab.loaded_name("timed.yaml") == "timed_loaded"


def test_a_file_is_saved_as_a_whole(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    path = file_tab.save_file(folder, "mine", "text: é\n")
    assert path == folder / "mine.yaml"
    assert path.read_bytes() == "text: é\n".encode()
    assert list(folder.iterdir()) == [path]
    umask = os.umask(0)
    os.umask(umask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~umask


def test_nothing_is_overwritten_unless_that_is_wanted(tmp_path: Path) -> None:
    path = file_tab.save_file(tmp_path, "mine", "first")
    with pytest.raises(FileExistsError):
        file_tab.save_file(tmp_path, "mine", "second")
    assert path.read_text() == "first"
    file_tab.save_file(tmp_path, "mine", "second", overwrite=True)
    assert path.read_text() == "second"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_is_a_file_that_is_there_and_what_it_points_to_stays(tmp_path: Path) -> None:
    outside, folder = tmp_path / "outside", tmp_path / "folder"
    folder.mkdir()
    (folder / "mine.yaml").symlink_to(outside)
    with pytest.raises(FileExistsError):
        file_tab.save_file(folder, "mine", "text")
    file_tab.save_file(folder, "mine", "text", overwrite=True)
    assert not outside.exists()
    assert (folder / "mine.yaml").read_text() == "text"


def test_a_failure_leaves_the_old_file_and_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = file_tab.save_file(tmp_path, "mine", "first")

    def fail(_: int) -> None:
        raise OSError("the disk is full")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OSError, match="disk is full"):
        file_tab.save_file(tmp_path, "mine", "second", overwrite=True)
    assert path.read_text() == "first"
    assert list(tmp_path.iterdir()) == [path]


def test_of_many_who_save_under_one_name_one_does(tmp_path: Path) -> None:
    saved: list[int] = []

    def save(number: int) -> None:
        try:
            file_tab.save_file(tmp_path, "mine", str(number))
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
    text = file_tab.preset_text(spec, ["It was frozen: for a while."])
    assert "# It was frozen: for a while.\n" in text
    assert presets.parse(text, "mine") == spec
    assert file_tab.preset_text(spec, []) == presets.dump(spec)


# --- The tab, on a real server that nobody looks at ----------------------------------------------


class Desk:
    """A paused session with the tab of one browser."""

    def __init__(self, server: viser.ViserServer, save_dir: Path | None) -> None:
        self.requests: list[Request] = []
        self.loaded: list[tuple[Experiment, bytes, str]] = []
        self.offered: dict[str, RunSpec] = {}
        self.session = Session(small_spec(), "timed", 3, speed=1.0, playing=False)
        self.session.start()
        self.person = Person(server.gui)
        client: Any = self.person
        FileTab(client, self.session, self.ask, AtOnce().work, self.take, self.offer, save_dir)

    def ask(self, client: object, request: Request) -> None:
        assert client is self.person
        self.requests.append(request)
        self.session.submit(request, self.person.told.append)

    def take(self, found: Experiment, data: bytes, name: str) -> str:
        self.loaded.append((found, data, name))
        return "a name"

    def offer(self, name: str, spec: RunSpec) -> None:
        self.offered[name] = spec

    def settle(self) -> Status:
        """Wait until all has been answered."""
        ticket = self.session.submit(FreezeSkills(False))
        return self.session.wait_for(lambda status: status.answered >= ticket, 60)


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    server = open_server(port=0)
    desk = Desk(server, tmp_path / "presets")
    yield desk
    desk.session.stop()
    close_server(server)


def rename(desk: Desk, name: str) -> None:
    desk.person.send(desk.person.widget("Name"), name)


def test_a_preset_is_downloaded_and_saved(desk: Desk, tmp_path: Path) -> None:
    desk.session.submit(TrialOnce())
    desk.session.submit(Introduce("avoid", 5))
    desk.settle()
    desk.person.click("Save as preset")
    content = desk.person.downloads["my_timed.yaml"]
    assert (tmp_path / "presets" / "my_timed.yaml").read_bytes() == content
    spec = presets.parse(content, "my_timed.yaml")
    assert spec.schedule.introduced_at("avoid") == 1
    assert desk.person.reads("Saved as my_timed.yaml")
    assert desk.offered == {"my_timed": spec}


def test_blanks_in_a_name_become_underscores_and_no_shipped_preset_is_hidden(desk: Desk) -> None:
    rename(desk, " my first  lesson")
    desk.person.click("Save as preset")
    assert desk.person.reads("Saved as my_first_lesson.yaml")
    rename(desk, "timed")
    desk.person.click("Save as preset")
    assert list(desk.offered) == ["my_first_lesson", "timed_loaded"]


def test_overwriting_takes_a_second_click(desk: Desk, tmp_path: Path) -> None:
    path = tmp_path / "presets" / "my_timed.yaml"
    desk.person.click("Save as preset")
    path.write_text("precious")
    desk.person.downloads.clear()
    desk.person.click("Save as preset")
    assert path.read_text() == "precious"
    assert desk.person.downloads == {}
    assert desk.person.reads("Overwrite it?")
    # The question is about one name.
    rename(desk, "other")
    assert not desk.person.sees("Overwrite")
    rename(desk, "my_timed")
    desk.person.click("Save as preset")
    desk.person.click("Overwrite")
    assert presets.parse(path.read_bytes(), "my_timed.yaml") == small_spec()
    assert not desk.person.sees("Overwrite")


def test_an_unsafe_name_cannot_be_saved(desk: Desk, tmp_path: Path) -> None:
    rename(desk, "../<b>")
    assert not desk.person.can_use("Save as preset")
    assert desk.person.reads("A name has")
    desk.person.widget("Save as preset").disabled = False
    desk.person.click("Save as preset")
    assert desk.person.downloads == {}
    assert not (tmp_path / "presets").exists()


def test_a_folder_that_cannot_be_written_is_said_and_the_download_comes(
    desk: Desk, tmp_path: Path
) -> None:
    (tmp_path / "presets").write_text("a file in the place of the folder")
    desk.person.click("Save as preset")
    assert desk.person.reads("not written")
    assert list(desk.person.downloads) == ["my_timed.yaml"]


def test_a_loaded_preset_starts_again(desk: Desk) -> None:
    desk.person.upload("Load preset", "mine.yaml", presets.dump(small_spec("trials=77")))
    status = desk.settle()
    assert status.snapshot.spec.trials == 77
    assert (status.snapshot.preset, status.snapshot.seed) == ("mine", 3)
    assert desk.requests == [StartAgain(small_spec("trials=77"), "mine", 3, paused=True)]
    assert desk.offered == {"mine": small_spec("trials=77")}


def test_all_errors_of_a_wrong_preset_are_shown_and_the_session_is_untouched(desk: Desk) -> None:
    wrong = "learner: {options: moves, alpha: 7}\n<i>: 1\ntrials: no\n"
    desk.person.upload("Load preset", "b<b>.yaml", wrong)
    for words in ("learner.alpha", "trials", "&lt;i&gt;", "b&lt;b&gt;.yaml:1"):
        assert words in desk.person.html
    assert "<i>" not in desk.person.html
    assert desk.requests == []
    assert desk.settle().snapshot.generation == 0


@pytest.mark.parametrize("name", experiments.shipped())
def test_an_experiment_in_the_place_of_a_preset_is_told_to_be_one(name: str, desk: Desk) -> None:
    text = experiments.shipped()[name].read_text()
    desk.person.upload("Load preset", f"{name}<b>.yaml", text)
    assert f"{name}&lt;b&gt;.yaml is an experiment, not a preset" in desk.person.html
    assert "is not a known key" not in desk.person.html
    assert desk.requests == []


@pytest.mark.parametrize("name", presets.shipped())
def test_a_preset_in_the_place_of_an_experiment_is_told_to_be_one(name: str, desk: Desk) -> None:
    desk.person.upload("Load experiment", f"{name}.yaml", presets.shipped()[name].read_text())
    assert f"{name}.yaml is a preset, not an experiment" in desk.person.html
    assert "is not a known key" not in desk.person.html
    assert desk.loaded == []


def test_a_file_of_the_right_kind_is_told_what_is_wrong_with_it(desk: Desk) -> None:
    desk.person.upload("Load experiment", "mine.yaml", "presets: [timed]\nlearner: 5\n")
    assert "learner" in desk.person.html
    assert "takes it" not in desk.person.html
    desk.person.upload("Load preset", "mine.yaml", "learner: {options: moves}\nseeds: 5\n")
    assert "seeds" in desk.person.html
    assert "takes it" not in desk.person.html


def test_a_loaded_experiment_is_offered(desk: Desk) -> None:
    text = "presets: [timed]\nseeds: 5\n"
    desk.person.upload("Load experiment", "mine.yaml", text)
    ((found, data, name),) = desk.loaded
    assert (found.name, found.n_runs) == ("mine", 5)
    assert (data, name) == (text.encode(), "mine.yaml")
    assert desk.person.told == ["a name is chosen under Experiments."]


def test_tables_are_kept_as_arrays(desk: Desk) -> None:
    desk.session.submit(TrialOnce())
    snapshot = desk.settle().snapshot
    desk.person.click("Save tables")
    tables = np.load(io.BytesIO(desk.person.downloads["timed-seed3-trial1.npz"]))
    assert (int(tables["trial"]), int(tables["step"])) == (1, snapshot.step)
    np.testing.assert_array_equal(tables["visits"], snapshot.visits)
