"""Pre-training: before the first trial each skill learns for some steps by itself (section 3.2).

One skill after the other, in the order of the options, chooses every move and learns from each,
whether it is present yet or not; the selection neither chooses nor learns. It starts where trials
start, and again where one would end. These starts have numbers from ``MAX_TRIALS`` on, which no
trial has, so that trials start where they do without pre-training.

Its steps are steps of the run, and visits of states are counted. No trial is logged; the first one
has them among its steps, so that steps up to the end of any trial are those of the log.
"""

from typing import NamedTuple

import numpy as np

from learners.names import MAX_TRIALS
from sim.bits import U
from sim.compiled import piece


class Alone(NamedTuple):
    """A skill that is being pre-trained."""

    skill: str
    until_step: int
    """Steps of the run when it is over."""
    is_last: bool
    """Whether trials begin after it."""


def alone_at(step: int, steps_each: int, skills: tuple[str, ...]) -> Alone | None:
    """The skill that makes the next step by itself; None once trials have begun.

    Args:
        step: steps made.
        steps_each: for which each skill is pre-trained.
        skills: of the preset, in order.
    """
    if step >= steps_each * len(skills):
        return None
    place = step // steps_each
    return Alone(skills[place], (place + 1) * steps_each, place == len(skills) - 1)


def start_number(exercise: int) -> int:
    """Number, among starts of trials, of one in pre-training, by its own number from 0."""
    return MAX_TRIALS + exercise


@piece
def is_alone(alone: np.uint64 | None) -> bool:
    """Whether a skill is being pre-trained."""
    return alone is not None


@piece
def lone_option(alone: np.uint64 | None, option: np.uint64) -> np.uint64:
    """The skill that is being pre-trained, whatever was chosen; else what was."""
    if alone is None:
        return option
    return U(alone)
