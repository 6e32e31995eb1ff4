"""The wheel, installed for itself and used from elsewhere, where nothing but the current folder is
the user's: no home, a plain locale, and files about that have names of our packages.
"""

import contextlib
import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import urllib.request
import venv
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.pages import PAGES, ROOT, links_of

EXPERIMENT = "presets: [timed]\nset: {world.size: 40}\ntrials: 60\nseeds: 1\nmetrics: [captures]\n"
PATIENCE_S = 300


class Installed:
    """Pounce in an environment of its own, with what it needs from the one that runs the tests."""

    def __init__(self, folder: Path) -> None:
        self.bin = folder / "environment" / "bin"
        self.elsewhere = folder / "elsewhere"
        self.elsewhere.mkdir()
        for name in ("app", "sim", "learners", "presets", "benchmarks", "numba"):
            (self.elsewhere / f"{name}.py").write_text("raise SystemExit('not to be imported')\n")
        wheels = folder / "wheels"
        checked("-m", "hatchling", "build", "--target", "wheel", "--directory", str(wheels))
        (wheel,) = wheels.glob("*.whl")
        venv.create(folder / "environment")
        python = str(self.bin / "python")
        paths = {"base": str(folder / "environment"), "platbase": str(folder / "environment")}
        self.packages = Path(sysconfig.get_path("purelib", "venv", vars=paths))
        needed = [
            path for path in sys.path if Path(path).name in ("site-packages", "dist-packages")
        ]
        (self.packages / "needed.pth").write_text("\n".join(needed))
        install = ("install", "--quiet", "--no-deps", "--no-index", "--no-compile")
        checked("-m", "pip", "--python", python, *install, str(wheel))
        # What other tests have compiled of the same code, as an image comes with it.
        for compiled in (ROOT / "sim" / "__pycache__").glob("compiled-*"):
            # Without what somebody is just writing, and will have renamed before it is read.
            shutil.copytree(
                compiled,
                self.packages / "sim" / "__pycache__" / compiled.name,
                ignore=shutil.ignore_patterns("*.tmp.*"),
            )

    def start(self, *words: str, program: tuple[str, ...] = ("pounce",)) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [str(self.bin / program[0]), *program[1:], *words],
            env={
                "PATH": "/usr/bin:/bin",
                "LC_ALL": "C",
                "HOME": os.devnull,
                # Where sessions are kept.
                "XDG_STATE_HOME": str(self.bin.parents[1] / "state"),
            },
            cwd=self.elsewhere,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )

    def answer(self, *words: str, program: tuple[str, ...] = ("pounce",)) -> str:
        """What a command says that succeeds and complains of nothing."""
        running = self.start(*words, program=program)
        said, complaint = running.communicate(timeout=PATIENCE_S)
        assert (running.returncode, complaint) == (0, "")
        return said


def checked(*words: str) -> None:
    done = subprocess.run(
        [sys.executable, *words], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    for module in ("hatchling", "pip"):
        if importlib.util.find_spec(module) is None:
            pytest.skip(f"{module} is not installed: pip install 'pounce-lab[test]'")
    return Installed(tmp_path_factory.mktemp("installed"))


def test_what_is_run_is_what_was_installed(installed: Installed) -> None:
    program = ("python", "-c")
    where = "import sys; sys.path.remove(''); import app, sim; print(app.__file__, sim.__file__)"
    found = installed.answer(where, program=program).split()
    assert [Path(file).parent.parent for file in found] == [installed.packages] * 2


def test_commands_work_from_elsewhere(installed: Installed) -> None:
    listed = installed.answer("presets")
    assert str(installed.packages / "presets" / "timed.yaml") in listed
    quick = ("--trials", "60", "--set", "world.size=40")
    assert "timed: reward" in installed.answer("run", "timed", *quick, "--out", "runs")
    (installed.elsewhere / "mine.yaml").write_text(EXPERIMENT)
    assert "1 of 1 runs done" in installed.answer("experiment", "mine.yaml")
    assert installed.answer("report") == "results/mine/report.html\n"
    assert "</html>" in (installed.elsewhere / "results/mine/report.html").read_text("utf-8")
    made = {path.name for path in installed.elsewhere.iterdir() if path.suffix != ".py"}
    assert made == {"runs", "results", "mine.yaml"}


def test_the_module_is_the_command(installed: Installed) -> None:
    (installed.elsewhere / "app.py").rename(installed.elsewhere / "other.py")
    try:
        listed = installed.answer("presets", program=("python", "-m", "app"))
    finally:
        (installed.elsewhere / "other.py").rename(installed.elsewhere / "app.py")
    assert str(installed.packages / "presets" / "timed.yaml") in listed


def test_the_documentation_comes_with_it_and_its_links_hold(installed: Installed) -> None:
    found = json.loads(installed.answer("doctor", "--json"))
    assert found["works"] is True
    (guide,) = (Path(one["found"]) for one in found["findings"] if one["name"] == "guide")
    assert guide == installed.bin.parent / "share" / "doc" / "pounce-lab" / "README.md"
    for page in PAGES:
        nowhere = [one for one in links_of(guide.parent / page) if not one.leads_somewhere]
        # These lead into the code, which lies elsewhere.
        if page.startswith("docs/beyond/"):
            nowhere = [one for one in nowhere if one.target.suffix != ".py"]
        assert page == "ARCHITECTURE.md" or nowhere == []


@contextlib.contextmanager
def lab(installed: Installed) -> Iterator[tuple[subprocess.Popen[str], str]]:
    running = installed.start("lab", "--no-browser", "--port", "0")
    try:
        assert running.stdout is not None
        said = running.stdout.readline()
        address = re.search(r"http://\S+", said)
        assert address is not None, (said, running.communicate(timeout=PATIENCE_S))
        yield running, address[0]
    finally:
        running.kill()
        running.communicate()


def test_the_page_opens_and_ctrl_c_ends_the_lab(installed: Installed) -> None:
    with lab(installed) as (running, address):
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        with opener.open(address, timeout=PATIENCE_S) as page:
            assert (page.status, b"<html" in page.read()) == (200, True)
        running.send_signal(signal.SIGINT)
        _, complaint = running.communicate(timeout=PATIENCE_S)
    assert (running.returncode in (os.EX_OK, 130), complaint) == (True, "")


def test_where_nothing_can_be_written_it_is_said_once(installed: Installed) -> None:
    kept = installed.packages / "sim" / "__pycache__"
    kept.rename(kept.with_name("kept"))
    kept.write_text("Not even root can write below this.")
    try:
        running = installed.start("run", "timed", "--trials", "5", "--set", "world.size=40")
        said, complaint = running.communicate(timeout=PATIENCE_S)
    finally:
        kept.unlink()
        kept.with_name("kept").rename(kept)
    assert (running.returncode, "timed: reward" in said) == (0, True)
    assert complaint.count("\n") == 1
    assert "cannot be kept" in complaint
