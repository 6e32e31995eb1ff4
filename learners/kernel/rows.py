"""One row of a table of action values, with what choosing and learning ask of it kept up to date.

A row holds up to 12 values and three words more, 64 bytes in all, so that it is one line of the
cache:

====== ==========================================================
word   meaning
====== ==========================================================
0...11 value of each action; minus infinity where there is none
BEST   the largest value, max over a of Q(s, a): the row's utility
SECOND an upper bound of all values but the largest
GREEDY the set of actions that have the largest value
====== ==========================================================

Only when the greedy action falls to the bound must the row be scanned again. The result is the
same, to the last bit, as scanning at each step.
"""

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic, overload

from sim.bits import U, lowest
from sim.compiled import loop, piece

WORDS = 16
MAX_ACTIONS = 12
BEST = 12
SECOND = 13
GREEDY = 14

NO_VALUE = np.float32(-np.inf)

_ROW = U(WORDS)
_BEST = U(BEST)
_SECOND = U(SECOND)
_GREEDY = U(GREEDY)
_ZERO = U(0)
_ONE = U(1)
_LINE_BYTES = 64


def new_table(n_rows: int, n_actions: int, value: float) -> np.ndarray:
    """A table whose rows hold ``n_actions`` equal values, ``(row * WORDS,) float32``, aligned."""
    n_words = n_rows * WORDS
    raw = np.zeros(n_words + _LINE_BYTES // 4, dtype=np.float32)
    skip = (-raw.ctypes.data % _LINE_BYTES) // 4
    table = raw[skip : skip + n_words]
    values(table)[:, :n_actions] = value
    values(table)[:, n_actions:] = NO_VALUE
    rescan_all(table, table.view(np.uint32))
    return table


def copy_table(table: np.ndarray) -> np.ndarray:
    """A copy that is aligned as well."""
    copied = new_table(table.size // WORDS, 0, 0.0)
    copied[:] = table
    return copied


def values(table: np.ndarray) -> np.ndarray:
    """View of the values, ``(row, action) float32``."""
    return table.reshape(-1, WORDS)[:, :MAX_ACTIONS]


def best(table: np.ndarray) -> np.ndarray:
    """View of each row's largest value, ``(row,) float32``."""
    return table.reshape(-1, WORDS)[:, BEST]


def greedy_sets(words: np.ndarray) -> np.ndarray:
    """Each row's set of the actions that have the largest value, ``(row,) uint16``, copied.

    Args:
        words: the table as ``uint32``.
    """
    return words.reshape(-1, WORDS)[:, GREEDY].astype(np.uint16)


def scan(
    table: np.ndarray, row: np.uint64, changed: np.uint64, value: np.float32
) -> tuple[np.uint64, np.float32, np.float32]:
    """Greedy set, largest and next smaller value of a row, were some of its actions changed.

    Args:
        table: the values; aligned, see :func:`new_table`.
        row: first word of the row.
        changed: set of actions whose value is not the one in the table.
        value: what it is instead.
    """
    row_values = table[row : row + _BEST].copy()
    for action in range(MAX_ACTIONS):
        if int(changed) >> action & 1:
            row_values[action] = value
    top = row_values.max()
    is_greedy = row_values == top
    members = U(sum(1 << action for action in range(MAX_ACTIONS) if is_greedy[action]))
    return members, top, np.max(row_values, where=~is_greedy, initial=NO_VALUE)


@intrinsic
def _scan_lanes(typingctx, table, row, changed, value):
    """``scan`` without a branch: the row is one vector. All of it is portable LLVM."""
    found = types.Tuple((types.uint64, types.float32, types.float32))
    n_lanes = WORDS

    def codegen(context, builder, signature, args):
        lane = ir.FloatType()
        lanes = ir.VectorType(lane, n_lanes)
        flags = ir.VectorType(ir.IntType(1), n_lanes)
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), n_lanes), [0] * n_lanes)
        none = ir.Constant(lanes, [ir.Constant(lane, float("-inf"))] * n_lanes)
        actions = ir.Constant(flags, [1] * MAX_ACTIONS + [0] * (n_lanes - MAX_ACTIONS))
        largest = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(lane, [lanes]), "llvm.vector.reduce.fmax.v16f32"
        )

        def spread(number):
            first = builder.insert_element(none, number, ir.Constant(ir.IntType(32), 0))
            return builder.shuffle_vector(first, none, zeros)

        array = context.make_array(signature.args[0])(context, builder, args[0])
        pointer = builder.bitcast(builder.gep(array.data, [args[1]]), lanes.as_pointer())
        stored = builder.select(actions, builder.load(pointer, align=_LINE_BYTES), none)
        is_changed = builder.bitcast(builder.trunc(args[2], ir.IntType(n_lanes)), flags)
        values = builder.select(is_changed, spread(args[3]), stored)
        # No value is NaN; without that promise the maximum takes twice the instructions.
        top = builder.call(largest, [values], fastmath=("nnan",))
        is_greedy = builder.and_(builder.fcmp_ordered("==", values, spread(top)), actions)
        others = builder.select(is_greedy, none, values)
        second = builder.call(largest, [others], fastmath=("nnan",))
        members = builder.zext(builder.bitcast(is_greedy, ir.IntType(n_lanes)), ir.IntType(64))
        return context.make_tuple(builder, signature.return_type, [members, top, second])

    return found(table, row, changed, value), codegen


@overload(scan)
def _compiled_scan(table, row, changed, value):
    return lambda table, row, changed, value: _scan_lanes(  # pyright: ignore[reportCallIssue]
        table, row, changed, value
    )


@piece
def rescan(
    table: np.ndarray, words: np.ndarray, row: np.uint64, changed: np.uint64, value: np.float32
) -> None:
    """Write the changed values of a row and find what is kept of it anew."""
    # Reads before it writes: a vector load right after a narrow store to it has to wait.
    members, top, second = scan(table, row, changed, value)
    if changed != _ZERO:
        table[row + lowest(changed)] = value
    table[row + _BEST] = top
    table[row + _SECOND] = second
    words[row + _GREEDY] = np.uint32(members)


@loop
def rescan_all(table: np.ndarray, words: np.ndarray) -> None:
    """Bring every row up to date after its values were written from outside."""
    row = _ZERO
    while row < U(table.size):
        rescan(table, words, row, _ZERO, NO_VALUE)
        row += _ROW


@piece
def write(
    table: np.ndarray, words: np.ndarray, row: np.uint64, action: np.uint64, value: np.float32
) -> None:
    """Give an action of a row a new value and keep the row up to date."""
    members = U(words[row + _GREEDY])
    this = _ONE << action
    # The only greedy action first: whether its value rises or falls is a coin's toss that no
    # branch predictor learns, and need not be asked while it stays above the others.
    if members == this:
        if value > table[row + _SECOND]:
            table[row + action] = value
            table[row + _BEST] = value
        else:
            rescan(table, words, row, this, value)
        return
    top = table[row + _BEST]
    table[row + action] = value
    if value < top:
        words[row + _GREEDY] = np.uint32(members & ~this)
        if value > table[row + _SECOND]:
            table[row + _SECOND] = value
    elif value == top:
        words[row + _GREEDY] = np.uint32(members | this)
    else:
        table[row + _SECOND] = top
        table[row + _BEST] = value
        words[row + _GREEDY] = np.uint32(this)


@piece
def best_without(
    table: np.ndarray, words: np.ndarray, row: np.uint64, action: np.uint64
) -> np.float32:
    """The largest value of a row but for one action's; minus infinity where there is no other."""
    if U(words[row + _GREEDY]) & ~(_ONE << action):
        return table[row + _BEST]
    top = NO_VALUE
    other = _ZERO
    while other < _BEST:
        if other != action and table[row + other] > top:
            top = table[row + other]
        other += _ONE
    return top


@piece
def greedy_among(
    table: np.ndarray, words: np.ndarray, row: np.uint64, allowed: np.uint64
) -> np.uint64:
    """The set of actions that are greedy among the allowed ones."""
    members = U(words[row + _GREEDY]) & allowed
    if members != _ZERO:
        return members
    top = NO_VALUE
    action = _ZERO
    while action < _BEST:
        here = _ONE << action
        if allowed & here:
            value = table[row + action]
            if value > top:
                top = value
                members = here
            elif value == top:
                members |= here
        action += _ONE
    return members
