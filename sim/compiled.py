"""How the inner loops are compiled."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit
from numba.core import config
from numba.core.dispatcher import Dispatcher

from sim.compile_cache import CompileCache

# The loops create no arrays, and the caller holds those it passes in. Without ``_nrt=False``
# Numba counts references to each of them at every use, atomically: five times slower.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": False}

Function = TypeVar("Function", bound=Callable[..., Any])


def loop(function: Function) -> Function:
    """Compile a loop that is called from Python, once per batch of steps."""
    return _compiled(function)


def piece(function: Function) -> Function:
    """Compile a small function of its own name that becomes a part of the loops that call it."""
    return _compiled(function, forceinline=True)


def is_compiled() -> bool:
    """Whether loops are compiled: an environment variable of Numba's may have it switched off."""
    return not cast(Any, config).DISABLE_JIT


def _compiled(function: Function, **options: Any) -> Function:
    compiled = njit(**_OPTIONS, **options)(function)
    # With Numba switched off by its environment variable, it stays plain Python.
    if isinstance(compiled, Dispatcher):
        cast(Any, compiled)._cache = CompileCache(function)
    return cast(Function, compiled)
