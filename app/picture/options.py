"""The options of a learner in pictures: their names and colours, and which of them is greedy."""

import numpy as np

from app.live.snapshot import Snapshot
from app.picture.colours import OPTION_COLOURS, move_colours
from app.picture.frames import UNTURNED, folds, in_frame
from app.picture.look import Look
from app.picture.theme import Theme
from app.words.plain import MOVE_NAMES, plain
from learners.names import COMMANDS, MOVES

TIE = 1e-3
"""Options tie with the best that are worth less than it by no more than this share of it: about
a hundredth of a step nearer to capture."""


def has_moves(snapshot: Snapshot) -> bool:
    """Whether the options are the nine moves, and not skills or commands."""
    return snapshot.spec.learner.options == MOVES


def kind_of(snapshot: Snapshot) -> str:
    """What an option is called in a sentence."""
    if snapshot.spec.learner.options == COMMANDS:
        return "command"
    return "move" if has_moves(snapshot) else "skill"


def option_names(snapshot: Snapshot) -> tuple[str, ...]:
    """Options as people say them."""
    if has_moves(snapshot):
        return MOVE_NAMES
    return tuple(map(plain, snapshot.spec.learner.sub_policies))


def option_colours(snapshot: Snapshot, theme: Theme) -> np.ndarray:
    """(option, 3) float64."""
    return move_colours(theme) if has_moves(snapshot) else OPTION_COLOURS


def option_shown(snapshot: Snapshot, look: Look) -> int:
    """The option that is shown: a look may still name one of a former run."""
    return min(max(look.option, 0), snapshot.selection_q.shape[-1] - 1)


def present(snapshot: Snapshot) -> list[int]:
    """Options that have values, in order."""
    return np.flatnonzero(np.isfinite(snapshot.selection_q).any(axis=(0, 1, 2))).tolist()


def lone_option(snapshot: Snapshot) -> str | None:
    """What to say where there is nothing to choose from."""
    there = present(snapshot)
    if len(there) > 1:
        return None
    return f"Only {option_names(snapshot)[there[0]]} is there" if there else "None is there"


def options_in_frame(snapshot: Snapshot, look: Look) -> np.ndarray:
    """By what is chosen, ``(heading, distance, direction, option)``, of headings that take part.

    Options that are moves are those of the picture, so they turn with it.
    """
    values = in_frame(snapshot.choice_q, snapshot, look)
    if not (folds(look) and has_moves(snapshot)):
        return values
    return np.take_along_axis(values, UNTURNED[:, None, None, :], axis=-1)


def greedy(values: np.ndarray) -> np.ndarray:
    """The one best action along the last axis, -1 where others tie with it or none has a value."""
    # Actions first, because the reductions below are many times faster along that axis.
    by_action = np.ascontiguousarray(np.moveaxis(values, -1, 0))
    best = by_action.max(axis=0)
    rivals = by_action >= best - np.float32(TIE) * np.abs(best)
    clear = np.isfinite(best) & (rivals.sum(axis=0, dtype=np.int8) == 1)
    return np.where(clear, rivals.argmax(axis=0), -1)
