"""The command ``pounce export``: what it writes, and what it refuses."""

import io
from collections.abc import Iterator
from pathlib import Path

import pytest
from PIL import Image

from app.cli import main
from app.live.written import whole
from app.player import replay_page
from tests.support.replays import HEADER, branchy_records, fewer_moments
from tests.support.schedules import small_spec

pytestmark = pytest.mark.usefixtures("here", "few")


@pytest.fixture(scope="module")
def few() -> Iterator[None]:
    with fewer_moments():
        yield


def session(here: Path, name: str = "one.pounce") -> Path:
    """A small session with branches, in a file."""
    path = here / name
    path.write_bytes(whole(HEADER, branchy_records(small_spec(), 3_000)))
    return path


def preset(here: Path) -> Path:
    """A small preset, in a file."""
    from app.documents import presets

    path = here / "small.yaml"
    path.write_text(presets.dump(small_spec()), "utf-8")
    return path


def test_a_session_is_written_as_each_kind_of_file(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session(here)
    words = ["--html", "a.html", "--png", "a.png", "--svg", "a.svg", "--gif", "a.gif"]
    assert main.main(["export", "one.pounce", *words, "--at", "50"]) == 0
    assert capsys.readouterr().out.split() == ["a.html", "a.png", "a.svg", "a.gif"]
    html = (here / "a.html").read_text("utf-8")
    assert len(html.encode()) < replay_page.MOST_BYTES
    assert "timed, seed 5" in html
    assert "Trial 50, step" in (here / "a.svg").read_text("utf-8")
    assert Image.open(io.BytesIO((here / "a.png").read_bytes())).format == "PNG"
    assert getattr(Image.open(here / "a.gif"), "n_frames", 1) > 5
    # Nothing is left of what was being written.
    assert sorted(path.name for path in here.iterdir()) == [
        *("a.gif", "a.html", "a.png", "a.svg", "one.pounce"),
    ]


def test_a_preset_s_run_is_made_with_its_seed_and_trials(here: Path) -> None:
    preset(here)
    words = ["--seed", "7", "--trials", "120", "--dark", "--layer", "chosen", "--frame", "each"]
    assert main.main(["export", "small.yaml", "--svg", "b.svg", *words]) == 0
    text = (here / "b.svg").read_text("utf-8")
    assert "seed 7<" in text
    assert "Trial 120, step" in text
    assert "Chosen skill" in text


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["one.pounce"], "nothing is to be written; allowed: one or more of --html, --png"),
        (["--html", "a.html"], "SESSION is missing"),
        (["one.pounce", "--html", "a.txt"], "--html: 'a.txt' is not allowed; allowed: a file"),
        (["one.pounce", "--png", "no/a.png"], "--png: 'no/a.png' is in no folder"),
        (["one.pounce", "--png", "a.png", "--layer", "x"], "--layer: 'x' is not allowed"),
        (["one.pounce", "--png", "a.png", "--frame", "9"], "--frame: '9' is not allowed"),
        (["one.pounce", "--png", "a.png", "--at", "9999"], "--at: '9999' is not allowed"),
        (["one.pounce", "--png", "a.png", "--seed", "1"], "--seed is of a preset's run"),
        (["gone.pounce", "--html", "a.html"], "gone.pounce"),
        (["timed", "--html", "a.html", "--trials", "0"], "--trials: '0' is not allowed"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(
    here: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    session(here)
    assert main.main(["export", *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in " ".join(err.split())
    assert not list(here.glob("a.*"))


def test_a_session_for_which_there_is_no_room_is_refused(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    session(here)
    monkeypatch.setattr(replay_page, "MOST_BYTES", 300_000)
    assert main.main(["export", "one.pounce", "--html", "a.html"]) == 1
    assert "too long for one page" in capsys.readouterr().err
    assert not (here / "a.html").exists()
