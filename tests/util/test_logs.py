"""What is logged on the terminal, and what is not."""

import io
import logging
import sys
import threading
import warnings
from collections.abc import Iterator

import pytest

from app.util import logs
from app.util.logs import LEVELS, MAX_CHARACTERS, MAX_KINDS, Plain, Sparing, sparing_log

log = logging.getLogger("tests.stranger")


@pytest.fixture
def written(monkeypatch: pytest.MonkeyPatch) -> Iterator[io.StringIO]:
    """What is written to the terminal while the log is sparing."""
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "stderr", terminal)
    with sparing_log():
        yield terminal


HOSTILE = "\x1b]0;mine\x07\x1b[2J\r\nYour lab has expired\u202e\x9b31m"


def test_nothing_reaches_the_terminal_raw(written: io.StringIO) -> None:
    log.warning("a page called %s", HOSTILE)
    try:
        raise ValueError(HOSTILE)
    except ValueError:
        log.exception("failed")
    text = written.getvalue()
    assert text.startswith(
        "a page called \\x1b]0;mine\\x07\\x1b[2J\\r\\nYour lab has expired\\u202e"
    )
    assert "ValueError: \\x1b]0;mine" in text
    assert all(character.isprintable() or character == "\n" for character in text)


def test_half_a_character_is_no_obstacle() -> None:
    # Not logged for real: others who listen, as a test runner does, may not be able to take it.
    record = logging.LogRecord("a", logging.WARNING, "b.py", 1, "a file %s", ("\ud800",), None)
    assert Plain().format(record) == "a file \ufffd"


def test_what_is_said_stays_readable(written: io.StringIO) -> None:
    log.warning("Größe → 20 µm, “quoted” 猫\tin one line")
    assert written.getvalue() == "Größe → 20 µm, “quoted” 猫\\tin one line\n"


def test_a_line_is_short_however_long_the_text(written: io.StringIO) -> None:
    log.warning("a page sent %s", "A" * 3_000_000)
    assert len(written.getvalue()) < MAX_CHARACTERS + 100
    assert "(2,998,012 characters more)" in written.getvalue()


def test_of_one_kind_one_line_is_said_and_then_how_many(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "stderr", terminal)
    with sparing_log():
        for number in range(1_235):
            log.warning("dropped message %d", number)
            if number == 0:
                log.warning("another kind")
        assert terminal.getvalue() == "dropped message 0\nanother kind\n"
    assert terminal.getvalue().endswith("… and 1,234 more, the last: dropped message 1234\n")


def test_the_rest_is_said_though_nothing_follows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(logs, "QUIET_S", 0.05)
    said = threading.Event()

    class Terminal(io.StringIO):
        def write(self, text: str) -> int:
            if "more" in text:
                said.set()
            return super().write(text)

    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with sparing_log():
        for _ in range(3):
            log.warning("again")
        assert said.wait(60)
    lines = terminal.getvalue().splitlines()
    counts = [int(line.split()[2]) for line in lines if line.startswith("… and ")]
    # On a slow machine the second may be due for a line of its own.
    assert lines[0] == "again"
    assert lines.count("again") + sum(counts) == 3


def test_after_a_while_a_line_is_said_again(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = [100.0]
    monkeypatch.setattr(logs.time, "monotonic", lambda: now_s[0])
    terminal = io.StringIO()
    handler = Sparing(terminal)
    record = logging.LogRecord("a", logging.WARNING, "file.py", 7, "again", None, None)
    for now_s[0] in (100.0, 101.0, 102.0, 120.0, 140.0):
        handler.handle(record)
    handler.close()
    assert terminal.getvalue() == "again\n… and 2 more, the last: again\nagain\nagain\n"


def test_kinds_are_bounded() -> None:
    terminal = io.StringIO()
    handler = Sparing(terminal)
    for line in range(10 * MAX_KINDS):
        handler.handle(logging.LogRecord("a", 30, "file.py", line, "text %d", (line,), None))
    assert len(handler._kinds) == MAX_KINDS
    handler.close()


def test_warnings_are_logged_and_not_remembered(written: io.StringIO) -> None:
    registry: dict[object, object] = {}
    for number in range(100):
        warnings.warn_explicit(
            f"{HOSTILE} {number}", UserWarning, "viser.py", 64, registry=registry
        )
    assert written.getvalue().count("\n") == 1
    assert written.getvalue().startswith("viser.py:64: UserWarning: \\x1b]0;mine")
    assert [key for key in registry if key != "version"] == []


def test_all_is_as_before_once_it_ends() -> None:
    handlers, show = list(logging.getLogger().handlers), warnings.showwarning
    level = logging.getLogger("app").level
    with sparing_log(logging.DEBUG):
        assert warnings.showwarning is not show
    assert logging.getLogger().handlers == handlers
    assert logging.getLogger("app").level == level
    assert warnings.showwarning is show


@pytest.mark.parametrize(("name", "n_said"), [("debug", 4), ("info", 3), ("warning", 2)])
def test_so_much_is_said_as_was_asked_for(
    monkeypatch: pytest.MonkeyPatch, name: str, n_said: int
) -> None:
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "stderr", terminal)
    own = logging.getLogger("app.page.lab")
    with sparing_log(LEVELS[name]):
        own.debug("where it comes from")
        own.info("a page has come")
        own.warning("refused a page")
        own.error("a frame could not be drawn")
    said = ["where it comes from", "a page has come", "refused a page"]
    said = [*said, "a frame could not be drawn"][4 - n_said :]
    assert terminal.getvalue().splitlines() == said


def test_errors_alone_are_said_where_that_was_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "stderr", terminal)
    with sparing_log(LEVELS["error"]):
        log.warning("a library's")
        logging.getLogger("app.server").warning("our own")
        warnings.warn("and Python's", UserWarning, stacklevel=1)
        log.error("an error")
    assert terminal.getvalue() == "an error\n"


def test_of_libraries_nothing_less_than_a_warning_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "stderr", terminal)
    with sparing_log(LEVELS["debug"]):
        log.debug("GET /?token=secret")
        log.info("connection open")
    assert terminal.getvalue() == ""
