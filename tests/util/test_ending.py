"""How the lab's program ends: on a signal, or with a word on why."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PATIENCE_S = 180.0

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals are POSIX's")

SERVES = """
import sys, threading
from app.util.ending import watched
with watched() as ending:
    print("begun", flush=True)
    if "early" in sys.argv:
        threading.Event().wait()
    over = threading.Event()
    ending.by(over.set)
    print("ready", flush=True)
    over.wait()
    print("over", flush=True)
    if "slow" in sys.argv:
        threading.Event().wait()
sys.exit(ending.exit_code)
"""
"""What the lab does about its end, without the lab."""

LAB = """
import sys, threading
from app.cli.main import main
from app.page import serving
opened = serving._announce
def fail(*_):
    raise {kind}("the last straw")
def announce(the_lab, port):
    opened(the_lab, port)
    {fault}
serving._announce = announce
sys.exit(main(["lab", "--no-browser", "--port", "0"]))
"""
"""The lab, with something that happens as soon as it is open."""


@contextlib.contextmanager
def program(
    code: str, *words: str, ignored: tuple[signal.Signals, ...] = ()
) -> Iterator[subprocess.Popen[str]]:
    """A Python program that is ended whatever happens."""

    def set_signals() -> None:
        # What a shell starts in the background ignores Ctrl-C; a test may be run like that.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        for number in ignored:
            signal.signal(number, signal.SIG_IGN)

    process = subprocess.Popen(
        [sys.executable, "-c", code, *words],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=set_signals,
    )
    watchdog = threading.Timer(PATIENCE_S, process.kill)
    watchdog.start()
    try:
        yield process
    finally:
        watchdog.cancel()
        process.kill()
        process.communicate()


def read_until(process: subprocess.Popen[str], words: str) -> str:
    assert process.stdout is not None
    for line in process.stdout:
        if words in line:
            return line
    pytest.fail(f"it never said {words!r}: {process.communicate()[1]}")


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 0), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_a_signal_ends_what_serves_in_order(number: signal.Signals, code: int) -> None:
    with program(SERVES) as process:
        read_until(process, "ready")
        process.send_signal(number)
        out, err = process.communicate()
    assert (process.returncode, out, err) == (code, "over\n", "")


@pytest.mark.parametrize(
    ("number", "code", "said"),
    [(signal.SIGINT, 130, "interrupted\n"), (signal.SIGTERM, 143, ""), (signal.SIGHUP, 129, "")],
)
def test_a_signal_that_comes_early_ends_it_at_once(
    number: signal.Signals, code: int, said: str
) -> None:
    with program(SERVES, "early") as process:
        read_until(process, "begun")
        process.send_signal(number)
        assert process.communicate() == ("", said)
    assert process.returncode == code


@pytest.mark.parametrize("second", [signal.SIGINT, signal.SIGTERM])
def test_a_second_signal_does_not_wait(second: signal.Signals) -> None:
    with program(SERVES, "slow") as process:
        read_until(process, "ready")
        process.send_signal(signal.SIGINT)
        read_until(process, "over")
        process.send_signal(second)
        assert process.wait() == -second


def test_a_terminal_that_goes_away_ends_nothing_under_nohup() -> None:
    with program(SERVES, ignored=(signal.SIGHUP,)) as process:
        read_until(process, "ready")
        process.send_signal(signal.SIGHUP)
        process.send_signal(signal.SIGTERM)
        assert process.communicate() == ("over\n", "")
    assert process.returncode == 143


def test_sigterm_ends_the_lab_as_ctrl_c_does() -> None:
    with program(LAB.format(kind="OSError", fault="pass")) as process:
        read_until(process, "pounce is at http://127.0.0.1:")
        process.send_signal(signal.SIGTERM)
        assert process.communicate() == ("\nEnded.\n", "")
    assert process.returncode == 143


@pytest.mark.parametrize(
    ("kind", "fault", "reason"),
    [
        (
            "SystemExit",
            "the_lab.server._websock_server._background_event_loop.call_soon_threadsafe(fail)",
            "the page's server has ended",
        ),
        ("SystemExit", "the_lab.session._answer_requests = fail", "the learner has ended"),
        ("KeyError", "the_lab.experiments.update = fail", "drawing failed"),
    ],
    ids=["server", "learner", "drawing"],
)
def test_a_lab_that_ends_by_itself_says_why(kind: str, fault: str, reason: str) -> None:
    with program(LAB.format(kind=kind, fault=fault)) as process:
        out, err = process.communicate()
    assert process.returncode == 1
    assert "Ended." not in out
    (said,) = (line for line in err.splitlines() if line.startswith("The lab has ended by itself"))
    assert reason in said
    assert "the last straw" in said
