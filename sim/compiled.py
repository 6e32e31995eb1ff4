"""How the inner loops are compiled.

Numba's own cache notices a change of the file that holds a function, but not of the files
whose pieces were inlined into it. So the cache lives in a folder named by a digest of all
sources that take part: a change anywhere starts a new one.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, TypeVar, cast

from numba import config, njit

_ROOT = Path(__file__).resolve().parent.parent
_SOURCES = sorted([*_ROOT.glob("sim/*.py"), *_ROOT.glob("learners/*.py")])

SOURCE_DIGEST: Final = hashlib.sha256(b"".join(p.read_bytes() for p in _SOURCES)).hexdigest()
"""Of all sources that decide what a run comes to."""

_CACHE_DIR = "CACHE_DIR"

if not getattr(config, _CACHE_DIR):
    _folder = _ROOT / "sim" / "__pycache__" / f"compiled-{SOURCE_DIGEST[:16]}"
    setattr(config, _CACHE_DIR, str(_folder))

# The loops create no arrays, and the caller holds those it passes in. Without ``_nrt=False``
# Numba counts references to each of them at every use, atomically: five times slower.
_OPTIONS: dict[str, Any] = {"nogil": True, "cache": True, "error_model": "numpy", "_nrt": False}

Function = TypeVar("Function", bound=Callable[..., Any])


def loop(function: Function) -> Function:
    """Compile a loop that is called from Python, once per batch of steps."""
    return cast(Function, njit(**_OPTIONS)(function))


def piece(function: Function) -> Function:
    """Compile a small function of its own name that becomes a part of the loops that call it."""
    return cast(Function, njit(**_OPTIONS, forceinline=True)(function))
