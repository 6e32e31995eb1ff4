"""Ctrl-C, at moments that are met exactly: as a module begins to be imported, or code compiled."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

# Nothing is imported here that the program would not have before its first line.
TRIPWIRE = """
import os, sys
word, *sys.argv[1:] = sys.argv[1:]

def interrupt(*_):
    os.kill(os.getpid(), 2)

class Tripwire:
    def find_spec(self, name, path=None, target=None):
        if name == word:
            interrupt()

sys.meta_path.insert(0, Tripwire())
if word == "a compilation":
    from sim.compile_cache import CompileCache
    CompileCache.load_overload = interrupt
if word == "the end":
    import atexit
    atexit.register(interrupt)
from app.__main__ import main
sys.exit(main())
"""
EXECUTED = """
import sys
from app.util import interrupts
from app.cli.answers import complain

interrupts.end_the_program()
try:
    with interrupts.undoing():
        exec("import signal; signal.raise_signal(signal.SIGINT)")
except KeyboardInterrupt:
    complain("interrupted")
sys.exit(interrupts.EXIT_INTERRUPTED)
"""
LOST = """
import signal, sys, time
from app.util import interrupts

class Finalized:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)

interrupts.end_the_program()
try:
    with interrupts.undoing():
        Finalized()
        until = time.monotonic() + 60
        while time.monotonic() < until:
            time.sleep(0.001)
except KeyboardInterrupt:
    print("undone")
"""


def done(
    folder: Path, program: str, *words: str, ignoring: bool = False, option: str = "-c"
) -> tuple[int, str, str]:
    """Exit code, answer and complaint of a program: a text, or with ``-m`` a module."""
    # Whoever runs the tests in the background has them ignore interrupts, and children inherit it.
    handling = signal.SIG_IGN if ignoring else signal.SIG_DFL
    ended = subprocess.run(
        [sys.executable, option, program, *words],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
        preexec_fn=lambda: signal.signal(signal.SIGINT, handling),
    )
    return ended.returncode, ended.stdout, ended.stderr


@pytest.mark.parametrize(
    ("moment", "words"),
    [
        ("signal", "presets"),
        ("app.util.interrupts", "presets"),
        ("app.cli.main", "presets"),
        ("tyro", "presets"),
        ("yaml", "presets"),
        ("numba", "run timed"),
        ("app.experiments.seeds", "run timed"),
        ("a compilation", "run timed --out runs"),
        ("a compilation", "experiment ablation"),
        ("app.report.write", "report ."),
        ("benchmarks", "bench"),
        ("app.page.lab", "lab --no-browser"),
        ("a compilation", "lab --no-browser"),
    ],
)
def test_an_interrupt_ends_the_program_with_one_word(
    tmp_path: Path, moment: str, words: str
) -> None:
    assert done(tmp_path, TRIPWIRE, moment, *words.split()) == (130, "", "interrupted\n")
    assert [*tmp_path.iterdir()] == []


def test_an_interrupt_at_the_very_end_shows_nothing_else(tmp_path: Path) -> None:
    code, answer, complaint = done(tmp_path, TRIPWIRE, "the end", "--version")
    assert (code, answer[:7], complaint) == (130, "pounce ", "interrupted\n")


def test_who_ignores_interrupts_is_not_interrupted(tmp_path: Path) -> None:
    code, answer, complaint = done(tmp_path, TRIPWIRE, "tyro", "--version", ignoring=True)
    assert (code, answer[:7], complaint) == (0, "pounce ", "")


def test_an_interrupt_that_a_finalizer_would_lose_is_not_lost(tmp_path: Path) -> None:
    assert done(tmp_path, LOST) == (130, "undone\n", "")


def test_an_interrupt_within_executed_text_has_the_same_code(tmp_path: Path) -> None:
    # Only of modules that are run does Python notice.
    (tmp_path / "executed.py").write_text(EXECUTED)
    assert done(tmp_path, "executed", option="-m") == (130, "", "interrupted\n")
