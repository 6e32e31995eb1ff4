"""Moments of the past are made in a thread of their own, for all who look at one."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from app.live import snapshot
from app.live.past import Past
from app.live.places import Place
from app.live.snapshot import Snapshot
from app.live.wishes import Wishes
from learners.commands import CommandError
from learners.kernel.state import NOT_REACHED, selection_q_of
from learners.run import Run

LEARNING_STEPS: Final = 2_000
"""Steps before a moment whose changes *Learning now* shows: some twenty trials."""


def moment_at(
    past: Past,
    place: Place,
    preset: str,
    is_wanted: Callable[[], bool] = lambda: True,
    curve_steps: int | None = None,
    quietly: bool = False,
) -> Snapshot | None:
    """What a line looked like at a moment; the same whenever it is made.

    Args:
        past: of the line.
        place: the moment; beyond what is known of the line, where that ends.
        preset: name of its preset.
        is_wanted: asked every few milliseconds; once it says no, that is the end of it.
        curve_steps: as :func:`app.live.snapshot.take` has it.
        quietly: keep no checkpoints for it (:meth:`Past.run_at`).

    Returns:
        The snapshot; None if it was not wanted any more.
    """
    while True:
        step = min(max(place.step, 0), past.end_step)
        run = past.run_at(step - LEARNING_STEPS, is_wanted, quietly)
        if run is None:
            return None
        before = selection_q_of(run.spec, run.state)
        if past.take_on(run, step):
            break
        # The line has gone another way in between, which does not happen often.
    made = snapshot.take(run, preset, place.line, curve_steps=curve_steps)
    lately = snapshot.change_between(before, made.selection_q)
    return replace(made, learning_now=lately)


class Moments(Wishes[Place, Snapshot]):
    """Makes moments of lines, each wished by its place."""

    def __init__(
        self, past_of: Callable[[int], Past | None], preset_of: Callable[[int], str]
    ) -> None:
        """Prepare; the thread begins with the first wish.

        Args:
            past_of: the past of a line by its number; None if that is not here any more.
            preset_of: name of a line's preset, as shown.
        """
        super().__init__("moments")
        self._past_of = past_of
        self._preset_of = preset_of

    def rise_of(self, line: int, state: int, trial: int) -> Place | None:
        """The moment at which the value of a state first rose above 0: the step that made it so.

        Takes some milliseconds, so it is to be called by something that is done in the thread.

        Args:
            line: number of the line.
            state: its index in the flat ``(heading, distance, direction)`` table.
            trial: in which it rose, as ``first_reach`` has it.

        Returns:
            The moment; None if the value did not rise in that trial, or the line is not here.
        """
        past = self._past_of(line)
        if past is None or not 0 <= trial <= past.end_trial:
            return None
        before, after = past.step_of_trial(trial), past.step_of_trial(trial + 1)
        run = past.run_at(before)
        if run is None or not 0 <= state < run.state.first_reach.size:
            return None
        if _has_risen(run, state):
            return Place(line, before) if run.state.first_reach[state] == trial else None
        ahead = run.copy()
        if not past.take_on(ahead, after) or not _has_risen(ahead, state):
            return None
        # It has not risen before the first of the two, and has risen after the second.
        while after - before > 1:
            middle = (before + after) // 2
            ahead = run.copy()
            if not past.take_on(ahead, middle):
                return None
            if _has_risen(ahead, state):
                after = middle
            else:
                before, run = middle, ahead
        return Place(line, after)

    def _made(self, wish: Place, is_wanted: Callable[[], bool]) -> Snapshot | None:
        past = self._past_of(wish.line)
        if past is None:
            raise CommandError("that line is not here any more")
        return moment_at(past, wish, self._preset_of(wish.line), is_wanted)

    def _is_still(self, wish: Place, made: Snapshot) -> bool:
        past = self._past_of(wish.line)
        return (
            past is not None and made.step == wish.step and past.is_still(made.step, made.control)
        )


def _has_risen(run: Run, state: int) -> bool:
    return int(run.state.first_reach[state]) != NOT_REACHED
