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

from sim.bits import U
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


def greedy(table: np.ndarray) -> np.ndarray:
    """View of each row's set of greedy actions as bits, ``(row,) uint32``."""
    return table.view(np.uint32).reshape(-1, WORDS)[:, GREEDY]


@loop
def rescan(table: np.ndarray, words: np.ndarray, row: np.uint64) -> None:
    """Find the largest value, the next smaller one and the greedy set anew."""
    top = NO_VALUE
    second = NO_VALUE
    members = _ZERO
    action = _ZERO
    while action < _BEST:
        value = table[row + action]
        if value > top:
            second = top
            top = value
            members = _ONE << action
        elif value == top:
            members |= _ONE << action
        elif value > second:
            second = value
        action += _ONE
    table[row + _BEST] = top
    table[row + _SECOND] = second
    words[row + _GREEDY] = np.uint32(members)


@loop
def rescan_all(table: np.ndarray, words: np.ndarray) -> None:
    """Bring every row up to date after its values were written from outside."""
    row = _ZERO
    while row < U(table.size):
        rescan(table, words, row)
        row += _ROW


@piece
def write(
    table: np.ndarray, words: np.ndarray, row: np.uint64, action: np.uint64, value: np.float32
) -> None:
    """Give an action of a row a new value and keep the row up to date."""
    table[row + action] = value
    top = table[row + _BEST]
    members = U(words[row + _GREEDY])
    this = _ONE << action
    if value > top:
        if members != this:
            table[row + _SECOND] = top
            words[row + _GREEDY] = np.uint32(this)
        table[row + _BEST] = value
    elif value == top:
        words[row + _GREEDY] = np.uint32(members | this)
    elif members == this:
        if value > table[row + _SECOND]:
            table[row + _BEST] = value
        else:
            rescan(table, words, row)
    else:
        words[row + _GREEDY] = np.uint32(members & ~this)
        if value > table[row + _SECOND]:
            table[row + _SECOND] = value


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
