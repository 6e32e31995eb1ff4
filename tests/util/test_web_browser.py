"""The browser is opened without waiting, and never in the terminal."""

import os
import stat
import sys
import textwrap
import time
import webbrowser
from pathlib import Path

import pytest

from app.util.web_browser import chosen_browser, open_in_browser

PATIENCE_S = 60.0


@pytest.fixture
def programs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The one folder in which Python looks for browsers."""
    # It looks once in the life of a process.
    monkeypatch.setattr(webbrowser, "_browsers", {})
    monkeypatch.setattr(webbrowser, "_tryorder", None)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("BROWSER", raising=False)
    return tmp_path


def add_program(folder: Path, name: str, text: str = "") -> str:
    file = folder / name
    file.write_text(f"#!{sys.executable}\n{textwrap.dedent(text)}")
    file.chmod(file.stat().st_mode | stat.S_IXUSR)
    return str(file)


@pytest.mark.parametrize("name", ["w3m", "lynx", "links", "elinks", "www-browser"])
@pytest.mark.parametrize("form", ["{}", "{} %s", "{} -dump %s"])
def test_text_browsers_are_not_opened(
    programs: Path, monkeypatch: pytest.MonkeyPatch, name: str, form: str
) -> None:
    monkeypatch.setenv("BROWSER", form.format(add_program(programs, name)))
    assert chosen_browser() is None
    assert open_in_browser("http://127.0.0.1:9") is False


def test_of_several_browsers_the_first_with_windows_is_taken(
    programs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lynx, graphical = add_program(programs, "lynx"), add_program(programs, "graphical")
    monkeypatch.setenv("BROWSER", os.pathsep.join((lynx, "", graphical)))
    assert chosen_browser() == graphical


def test_where_there_is_no_browser_none_is_opened(
    programs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    add_program(programs, "w3m")
    assert chosen_browser() is None
    assert open_in_browser("http://127.0.0.1:9") is False


def test_a_browser_in_the_foreground_holds_up_nobody_and_has_no_terminal(
    programs: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """It goes on until a file says that it may end, as others do until somebody closes them."""
    opened, may_end = programs / "opened", programs / "may-end"
    slow = f"""
        import os, pathlib, sys, time
        print("in the way")
        terminals = [os.isatty(stream) for stream in range(3)]
        note = pathlib.Path({str(opened)!r})
        note.with_suffix(".new").write_text(f"{{sys.argv[1]}} {{any(terminals)}}")
        note.with_suffix(".new").rename(note)
        while not pathlib.Path({str(may_end)!r}).exists():
            time.sleep(0.02)
    """
    monkeypatch.setenv("BROWSER", add_program(programs, "slow", slow))
    try:
        assert open_in_browser("http://127.0.0.1:9/?a=b&c")
        deadline = time.monotonic() + PATIENCE_S
        while not opened.exists():
            assert time.monotonic() < deadline, "the browser was not started"
            time.sleep(0.02)
        assert opened.read_text() == "http://127.0.0.1:9/?a=b&c False"
    finally:
        may_end.touch()
    assert capfd.readouterr() == ("", "")
