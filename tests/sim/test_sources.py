"""The version of the code is that of the code which runs, whatever lies on disk, and however."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

ELSEWHERE = ("NUMBA_CACHE_DIR", "PYTHONDONTWRITEBYTECODE", "PYTHONPYCACHEPREFIX")
"""What the tests may be run with, and would look for what is written elsewhere."""

MACHINERY = ("__init__", "sources", "compiled", "compile_cache")

PIECE = """
from sim.compiled import piece

FACTOR = 2

@piece
def scaled(number):
    return number * FACTOR
"""
LOOP = """
from sim.compiled import loop
from sim.numbers import scaled

@loop
def ten_times(number):
    return scaled(number) * 5
"""
PLAIN = WITHIN = 'ANSWER = "old"\n'

VERSION = "from sim.sources import SOURCE_DIGEST; print(SOURCE_DIGEST)"
ANSWER = f"{VERSION}; from learners import plain; print(plain.ANSWER)"
ANSWER_WITHIN = f"{VERSION}; from learners import kernel; print(kernel.ANSWER)"
ANSWERS = pytest.mark.parametrize(
    ("file", "program"),
    [("learners/plain.py", ANSWER), ("learners/kernel/__init__.py", ANSWER_WITHIN)],
    ids=["module", "package within"],
)
COMPILED = (
    f"{VERSION}; from learners.kernel.loop import ten_times;"
    " print(ten_times(1), sum(ten_times.stats.cache_hits.values()))"
)


class Checkout:
    """A few small modules in place of those that learn, with what reads and compiles them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.environment = {
            **{k: v for k, v in os.environ.items() if k not in ELSEWHERE},
            "PYTHONPATH": str(folder),
            "XDG_CACHE_HOME": str(folder / "home"),
        }
        for package in ("sim", "learners", "learners/kernel"):
            (folder / package).mkdir(parents=True)
        for module in MACHINERY:
            shutil.copy(ROOT / "sim" / f"{module}.py", folder / "sim")
        for name, text in (
            ("sim/numbers.py", PIECE),
            ("learners/__init__.py", ""),
            ("learners/kernel/__init__.py", WITHIN),
            ("learners/kernel/loop.py", LOOP),
            ("learners/plain.py", PLAIN),
        ):
            (folder / name).write_text(text)

    def replace(self, name: str, old: str, new: str) -> None:
        """Edit a file so that neither its size nor its time tells."""
        file = self.folder / name
        before = file.stat()
        text = file.read_text().replace(old, new)
        assert len(text) == before.st_size
        file.write_text(text)
        os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))

    def run(self, program: str) -> list[str]:
        done = subprocess.run(
            [sys.executable, "-c", program],
            env=self.environment,
            cwd=self.folder,
            capture_output=True,
            text=True,
            check=False,
        )
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout.split()


@pytest.fixture
def checkout(tmp_path: Path) -> Checkout:
    return Checkout(tmp_path / "checkout")


@pytest.mark.parametrize("place", ["of the package", "of the user", "of the environment"])
def test_compiled_code_of_old_sources_is_never_run(
    checkout: Checkout, tmp_path: Path, place: str
) -> None:
    if place == "of the user":
        (checkout.folder / "sim" / "__pycache__").write_text("Nothing can be written below.")
    if place == "of the environment":
        checkout.environment["NUMBA_CACHE_DIR"] = str(tmp_path / "cache")
    old, *answer = checkout.run(COMPILED)
    assert answer == ["10", "0"]
    checkout.replace("sim/numbers.py", "FACTOR = 2", "FACTOR = 3")
    new, *answer = checkout.run(COMPILED)
    assert new != old
    assert answer == ["15", "0"]
    places = {
        "of the package": checkout.folder / "sim" / "__pycache__",
        "of the user": checkout.folder / "home" / "pounce",
        "of the environment": tmp_path / "cache" / "pounce",
    }
    assert len([*places[place].glob(f"compiled-{old[:16]}*")]) == 1


def test_checkouts_that_share_a_folder_share_what_is_equal(tmp_path: Path) -> None:
    one, two = Checkout(tmp_path / "one"), Checkout(tmp_path / "two")
    for checkout in (one, two):
        checkout.environment["NUMBA_CACHE_DIR"] = str(tmp_path / "cache")
    assert one.run(COMPILED)[1:] == ["10", "0"]
    assert two.run(COMPILED)[1:] == ["10", "1"]
    two.replace("sim/numbers.py", "FACTOR = 2", "FACTOR = 4")
    assert two.run(COMPILED)[1:] == ["20", "0"]
    assert one.run(COMPILED)[1:] == ["10", "1"]


@ANSWERS
def test_a_stale_file_of_bytecode_is_not_run(checkout: Checkout, file: str, program: str) -> None:
    old, answer = checkout.run(program)
    assert answer == "old"
    checkout.replace(file, "old", "new")
    new, answer = checkout.run(program)
    assert (new != old, answer) == (True, "new")


def test_bytecode_is_kept_between_two_starts(checkout: Checkout) -> None:
    checkout.run(ANSWER)
    (kept,) = (checkout.folder / "learners" / "__pycache__").glob("plain.*.pyc")
    before = kept.stat().st_mtime_ns
    assert checkout.run(ANSWER)[1] == "old"
    assert kept.stat().st_mtime_ns == before


@ANSWERS
def test_an_edit_after_the_start_neither_runs_nor_counts(
    checkout: Checkout, file: str, program: str
) -> None:
    before, _ = checkout.run(program)
    edit = f"import pathlib; pathlib.Path('{file}').write_text('ANSWER = 3')"
    assert checkout.run(f"import sim; {edit}; {program}") == [before, "old"]
    now, answer = checkout.run(program)
    assert (now != before, answer) == (True, "3")


def test_line_endings_and_byte_order_marks_make_no_difference(checkout: Checkout) -> None:
    before = checkout.run(ANSWER)
    for file in checkout.folder.rglob("*.py"):
        text = file.read_bytes().replace(b"\n", b"\r\n")
        file.write_bytes(b"\xef\xbb\xbf" + text)
    assert checkout.run(ANSWER) == before


def test_every_word_counts_and_where_it_stands(checkout: Checkout) -> None:
    found = {checkout.run(VERSION)[0]}
    loop, plain = (checkout.folder / "learners" / f"{name}.py" for name in ("kernel/loop", "plain"))
    loop.write_text(f"{LOOP}{PLAIN}")
    plain.write_text("")
    found.add(checkout.run(VERSION)[0])
    loop.rename(checkout.folder / "learners" / "loop.py")
    found.add(checkout.run(VERSION)[0])
    assert len(found) == 3


def test_a_package_comes_before_a_module_of_its_name(checkout: Checkout) -> None:
    (checkout.folder / "learners" / "kernel.py").write_text('ANSWER = "module"')
    assert checkout.run(ANSWER_WITHIN)[1] == "old"


def test_what_editors_and_file_systems_leave_is_no_source(checkout: Checkout) -> None:
    before = checkout.run(ANSWER)
    folder = checkout.folder / "learners"
    (folder / ".#plain.py").symlink_to("somebody@somewhere")
    (folder / "._plain.py").write_bytes(b"\x00\x05\x16\x07\xff")
    (folder / "plain-copy.py").write_text("ANSWER = 4\n")
    assert checkout.run(ANSWER) == before
