"""Compiled code is kept between two starts where that is safe; where not, all works without."""

import logging
import os
import pickle
import shutil
import stat
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from numba.core import config

from sim import compile_cache, sources
from sim.compiled import loop

LONG_AGO = 5_000


def twice(number: int) -> int:
    return number + number


def thrice(number: int) -> int:
    return 3 * number


class Program:
    """What a start of the program sees of the cache."""

    def __init__(self, folder: Path, caplog: pytest.LogCaptureFixture) -> None:
        self.folder = folder
        self._caplog = caplog

    def start(self) -> None:
        config.reload_config()
        compile_cache._folders_for.cache_clear()
        compile_cache._has_spoken = False
        self._caplog.clear()

    def of(self, function: Callable[[int], int] = twice) -> tuple[int, bool]:
        """Start, and call a function with 3; what it returned, and whether it had been kept."""
        self.start()
        compiled: Any = loop(function)
        return compiled(3), bool(compiled.stats.cache_hits)

    @property
    def said(self) -> list[str]:
        return [record.getMessage() for record in self._caplog.records]

    def file(self, ending: str, name: str = "twice") -> Path:
        (found,) = self.folder.rglob(f"*.{name}*{ending}")
        return found


@pytest.fixture
def program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> Iterator[Program]:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    # As if the tests were of the code that is compiled.
    monkeypatch.setattr(sources, "digest_with", lambda package: "0" * 64)
    caplog.set_level(logging.WARNING, "sim.compile_cache")
    yield Program(tmp_path / "cache", caplog)
    monkeypatch.undo()
    config.reload_config()
    compile_cache._folders_for.cache_clear()


def test_what_was_compiled_is_kept(program: Program) -> None:
    assert program.of() == (6, False)
    assert program.of() == (6, True)
    assert program.said == []


class Bomb:
    """Does something as it is unpickled."""

    def __init__(self, trace: Path) -> None:
        self._trace = trace

    def __reduce__(self) -> Any:
        return (Path.touch, (self._trace,))


def flipped(data: bytes) -> bytes:
    middle = len(data) // 2
    return data[:middle] + bytes([data[middle] ^ 4]) + data[middle + 1 :]


@pytest.mark.parametrize("ending", [".nbi", ".nbc"])
@pytest.mark.parametrize(
    "damaged",
    [
        pytest.param(lambda data: b"", id="empty"),
        pytest.param(lambda data: data[:40], id="short"),
        pytest.param(lambda data: data[:-1], id="cut"),
        pytest.param(flipped, id="flipped"),
        pytest.param(lambda data: bytes(len(data)), id="zeros"),
        pytest.param(lambda data: b"\x80\x05garbage" + data, id="garbage"),
    ],
)
def test_a_damaged_file_is_said_and_mended(
    program: Program, ending: str, damaged: Callable[[bytes], bytes]
) -> None:
    program.of()
    file = program.file(ending)
    file.write_bytes(damaged(file.read_bytes()))
    assert program.of() == (6, False)
    assert program.said == [f"compiled code: {file} is damaged: it is compiled anew"]
    assert program.of() == (6, True)
    assert program.said == []


@pytest.mark.parametrize("ending", [".nbi", ".nbc"])
def test_nothing_is_unpickled_that_was_not_written_here(
    program: Program, tmp_path: Path, ending: str
) -> None:
    program.of()
    file, trace = program.file(ending), tmp_path / "trace"
    bomb = pickle.dumps(Bomb(trace))
    for data in (bomb, pickle.dumps("0.1") + bomb, file.read_bytes()[:32] + bomb):
        file.write_bytes(data)
        assert program.of() == (6, False)
        assert len(program.said) == 1
    assert not trace.exists()


@pytest.mark.parametrize("ending", [".nbi", ".nbc"])
def test_a_file_of_another_function_is_not_taken(program: Program, ending: str) -> None:
    program.of()
    program.of(thrice)
    file = program.file(ending)
    shutil.copy(program.file(ending, "thrice"), file)
    assert program.of() == (6, False)
    assert program.said == [f"compiled code: {file} is damaged: it is compiled anew"]


def test_several_damages_are_said_in_one_line(program: Program) -> None:
    for function in (twice, thrice):
        program.of(function)
    for file in program.folder.rglob("*.nb?"):
        file.write_bytes(b"")
    program.start()
    for function in (twice, thrice):
        loop(function)(3)
    assert len(program.said) == 1


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="permissions are others here")
def test_a_file_that_others_can_write_is_not_taken(program: Program) -> None:
    program.of()
    file = program.file(".nbi")
    assert not file.stat().st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    file.chmod(0o666)
    assert program.of() == (6, False)
    said = f"{file} could have been written by others"
    assert program.said == [f"compiled code: {said}: it is compiled anew"]
    assert program.of() == (6, True)


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="permissions are others here")
def test_files_that_others_cannot_write_are_made_whatever_the_mask(program: Program) -> None:
    former = os.umask(0)
    try:
        program.of()
    finally:
        os.umask(former)
    assert program.of() == (6, True)


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can give files away"
)
def test_a_file_of_a_stranger_is_not_taken(program: Program) -> None:
    program.of()
    os.chown(program.file(".nbc"), 12_345, 12_345)
    assert program.of() == (6, False)
    assert "could have been written by others" in program.said[0]


def test_where_nothing_can_be_written_it_is_compiled_in_memory(program: Program) -> None:
    program.folder.write_text("This is no folder.")
    for _ in range(2):
        assert program.of() == (6, False)
        (said,) = program.said
        assert said.startswith(f"compiled code: cannot be kept in {program.folder}")
        assert said.endswith(f"{os.strerror(20)}; it is compiled at each start")


def test_where_the_disk_is_full_it_is_compiled_in_memory(
    program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    full = OSError(28, os.strerror(28))

    def refuse(*_: Any) -> None:
        raise full

    with monkeypatch.context() as context:
        context.setattr(compile_cache.os, "chmod", refuse)
        program.start()
        for function in (twice, thrice):
            loop(function)(3)
    (said,) = program.said
    assert said.startswith(f"compiled code: cannot be kept in {program.folder}")
    assert [file for file in program.folder.rglob("*") if file.is_file()] == []
    assert program.of() == (6, False)
    assert program.of() == (6, True)


def test_a_folder_that_cannot_be_written_to_has_another_behind_it(
    program: Program, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    places = [tmp_path / "file", tmp_path / "home"]
    monkeypatch.setattr(compile_cache, "_parents", lambda: places)
    assert program.of() == (6, False)
    assert program.said == []
    assert program.of() == (6, True)
    assert [*(tmp_path / "home").rglob("*.nbc")]


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have other folders")
@pytest.mark.parametrize("home", [None, "", "~nobody-of-that-name", "relative"])
def test_without_a_home_nothing_is_put_into_the_current_folder(
    home: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(config, "CACHE_DIR", "")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr("os.path.expanduser", lambda path: path.replace("~", home or "~", 1))
    assert all(place.is_absolute() for place in compile_cache._parents())


def test_threads_that_compile_at_once_all_get_there(program: Program) -> None:
    program.start()
    found: list[int] = []
    threads = [threading.Thread(target=lambda: found.append(loop(twice)(3))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [6] * 4
    assert program.said == []
    assert program.of() == (6, True)


def test_other_settings_of_the_compiler_have_code_of_their_own(
    program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    program.of()
    with monkeypatch.context() as context:
        context.setenv("NUMBA_BOUNDSCHECK", "1")
        assert program.of() == (6, False)
    assert program.of() == (6, True)


def test_of_code_that_is_no_longer_used_only_the_latest_is_kept(program: Program) -> None:
    place = program.folder / "pounce"
    for age in range(12):
        old = place / f"compiled-{age:016x}"
        (old / "sim").mkdir(parents=True)
        os.utime(old, (LONG_AGO - age, LONG_AGO - age))
    others = place / "something-else"
    others.mkdir()
    program.of()
    kept = sorted(path.name for path in place.glob("compiled-*"))
    assert len(kept) == compile_cache.KEPT_FOLDERS
    assert {f"compiled-{age:016x}" for age in range(compile_cache.KEPT_FOLDERS - 1)} < {*kept}
    assert others.is_dir()


def test_code_that_is_used_counts_as_late(program: Program) -> None:
    program.of()
    (folder,) = program.folder.glob("pounce/compiled-*")
    os.utime(folder, (LONG_AGO, LONG_AGO))
    program.of()
    assert folder.stat().st_mtime > LONG_AGO
