"""Sets of small numbers as the bits of one word.

``count`` and ``lowest`` are single machine instructions when compiled; the plain
Python bodies mean the same and are what runs with the compiler switched off.
"""

import numpy as np
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic, overload

from sim.compiled import piece

U = np.uint64
"""Unsigned words keep array indexing free of the check for negative indices."""

_ZERO = U(0)
_ONE = U(1)
_HALF = U(16)


def count(bits: np.uint64) -> np.uint64:
    """Number of members of the set."""
    return U(int(bits).bit_count())


def lowest(bits: np.uint64) -> np.uint64:
    """Smallest member of a set that is not empty."""
    word = int(bits)
    return U((word & -word).bit_length() - 1)


@intrinsic
def _ctpop(typingctx, bits):
    def codegen(context, builder, signature, args):
        return builder.ctpop(args[0])

    return types.uint64(types.uint64), codegen


@intrinsic
def _cttz(typingctx, bits):
    def codegen(context, builder, signature, args):
        return builder.cttz(args[0], ir.Constant(ir.IntType(1), 1))

    return types.uint64(types.uint64), codegen


@overload(count)
def _compiled_count(bits):
    return lambda bits: _ctpop(bits)  # pyright: ignore[reportCallIssue]


@overload(lowest)
def _compiled_lowest(bits):
    return lambda bits: _cttz(bits)  # pyright: ignore[reportCallIssue]


@piece
def pick(bits: np.uint64, draw16: np.uint64) -> np.uint64:
    """A member of the set chosen by a uniform draw from 0...65,535.

    The chance of any two members differs by less than one part in 5,000 for sets of up to 12.
    """
    if bits & (bits - _ONE) != _ZERO:
        skip = (draw16 * count(bits)) >> _HALF
        if bits & (bits + _ONE) == _ZERO:
            return skip  # the first so many numbers, as in a row nothing is known of yet
        while skip != _ZERO:
            bits &= bits - _ONE
            skip -= _ONE
    return lowest(bits)
