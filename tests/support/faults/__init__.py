"""Disks that fail, and programs that are killed: libraries in C that stand before the C library."""

import shutil
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent


def built(name: str, folder: Path) -> Path:
    """The library of a file of this folder, made in another; skips where nothing can make it."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("a C compiler, cc, makes the disk that fails, and there is none")
    library = folder / f"{name}.so"
    source = HERE / f"{name}.c"
    command = [compiler, "-shared", "-fPIC", "-o", str(library), str(source), "-ldl"]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    if made.returncode:
        pytest.skip(f"the disk that fails cannot be made here: {made.stderr[-200:]}")
    return library
