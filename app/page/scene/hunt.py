"""Hunts on the board: predator, trail, how trials ended, and names on what is to be seen."""

import numpy as np
import viser

from app.live.snapshot import Snapshot
from app.page.scene.parts import OF_PARTS, Parts, in_linear_light
from app.page.scene.tags import Tags
from app.page.widgets import assign
from app.picture.look import Look, heading_shown
from app.picture.outlines import lifted, segments
from app.picture.theme import OUTCOME_SHAPES, Theme
from app.player.hunts import (
    Way,
    arrow_middle,
    end_of,
    ends_of,
    names_of,
    placed,
    sketched,
    way_of,
)
from sim.spec import WorldSpec
from sim.world import World

_PREDATOR_RADIUS, _HALO_RADIUS, _END_RADIUS = 0.13, 0.17, 0.1
_PATHS_EVERY_S = 1.0
# Heights above the board, so that what matters lies on top.
_Z_PATHS, _Z_TRAIL, _Z_RIM, _Z_END, _Z_HALO, _Z_PREDATOR, _Z_LAST = (
    *(0.028, 0.03),
    *(0.033, 0.035, 0.048, 0.05, 0.052),
)


class Chase(Parts):
    """One hunt: the predator, the way that it has come, and words beside what there is to see."""

    def __init__(self, scene: viser.SceneApi, name: str, theme: Theme) -> None:
        super().__init__(scene, name)
        self._theme = theme
        self._trail = self._line("trail", OF_PARTS, 3.0)
        self._halo = self._dots("halo", theme.unknown, _HALO_RADIUS)
        self._predator = self._dots("predator", theme.predator, _PREDATOR_RADIUS)
        self._last = {
            outcome: self._dots(f"last/{shape}", theme.of_outcome(outcome), _END_RADIUS, shape)
            for outcome, shape in OUTCOME_SHAPES.items()
        }
        self._tags = self._keep(Tags(scene, f"{name}/tags"))

    def show(self, world: World, spec: WorldSpec, look: Look, way: Way, shown: int) -> np.ndarray:
        """Draw the predator and its way in a picture whose prey faces ``shown``.

        Returns:
            ``(2,)``: where the predator is, in board units.
        """
        path = placed(world, spec, look, way.shown, way.heading, shown)
        # By its points and not its position, which browsers apply a frame ahead of the trail.
        here = lifted(path[-1:], _Z_PREDATOR)
        self._set(self._predator, "predator", here)
        self._set(self._halo, "halo", lifted(path[-1:], _Z_HALO))
        steps = np.zeros((0, 2, 2))
        if look.trail and len(path) > 1:
            steps = segments(path)
        colours = _fading(self._theme, len(steps))
        if way.outcome is not None:
            ink = in_linear_light(self._theme.of_outcome(way.outcome))
            colours = np.broadcast_to(ink, (len(steps), 2, 3))
        self._set(self._trail, "trail", lifted(steps, _Z_TRAIL), colours)
        for outcome, handle in self._last.items():
            # The outcome's own sign within the predator's dot.
            there = path[-1:] if outcome == way.outcome else path[:0]
            self._set(handle, f"last {outcome}", lifted(there, _Z_LAST))
        return path[-1]

    def hide(self) -> None:
        """Draw nothing."""
        nowhere = np.zeros((0, 3), np.float32)
        self._set(self._predator, "predator", nowhere)
        self._set(self._halo, "halo", nowhere)
        for outcome, handle in self._last.items():
            self._set(handle, f"last {outcome}", nowhere)
        none = np.zeros((0, 2, 3), np.float32)
        self._set(self._trail, "trail", none, none.astype(np.uint8))
        self._tags.show([])

    def name(self, spec: WorldSpec, look: Look, way: Way, here: np.ndarray, shown: int) -> None:
        """Say what is what, and what the hunt came to."""
        self._tags.show(names_of(spec, look, way, here, shown), [arrow_middle(shown)])

    def say_end(self, way: Way, here: np.ndarray) -> None:
        """Say what the hunt came to, and nothing else."""
        self._tags.show(end_of(way, here))


class HuntView(Parts):
    """The learner's own hunts on one board."""

    def __init__(self, scene: viser.SceneApi, theme: Theme) -> None:
        super().__init__(scene, "board")
        self._theme = theme
        self._paths = self._line("paths", OF_PARTS, 2.0)
        self._rims = self._dots("rims", theme.unknown, _END_RADIUS * 1.5)
        self._ends = {
            outcome: self._dots(f"ends/{shape}", np.zeros((1, 3), np.uint8), _END_RADIUS, shape)
            for outcome, shape in OUTCOME_SHAPES.items()
        }
        self._chase = self._keep(Chase(scene, "board", theme))
        self._paths_at = float("-inf")

    def update(
        self, snapshot: Snapshot, look: Look, now_s: float, rests: bool, named: bool, changed: bool
    ) -> None:
        """Show a moment.

        Args:
            snapshot: the moment.
            look: how the board is drawn.
            now_s: a clock, for what is drawn less often.
            rests: whether the learner stands still; at the start of a trial, the one that has
                just ended is shown until then.
            named: whether there are names on what is to be seen.
            changed: whether the board is drawn otherwise than before.
        """
        shown = heading_shown(look, snapshot.heading)
        if look.hunts:
            self._show_chase(snapshot, look, rests, named, shown)
        else:
            self._chase.hide()
        self._show_ends(snapshot, look, shown)
        if changed or now_s - self._paths_at >= _PATHS_EVERY_S:
            self._show_paths(snapshot, look, shown)
            self._paths_at = now_s

    def _show_chase(
        self, snapshot: Snapshot, look: Look, rests: bool, named: bool, shown: int
    ) -> None:
        world, spec = snapshot.world, snapshot.spec.world
        way = way_of(snapshot, rests)
        here = self._chase.show(world, spec, look, way, shown)
        if named:
            self._chase.name(spec, look, way, here, shown)
        else:
            self._chase.say_end(way, here)

    def _show_paths(self, snapshot: Snapshot, look: Look, shown: int) -> None:
        assign(self._paths, "visible", look.paths and look.hunts)
        if not (look.paths and look.hunts):
            return
        lines = [np.zeros((0, 2, 2))]
        colours = [np.zeros((0, 2, 3), np.uint8)]
        for path in snapshot.paths:
            lines.append(segments(sketched(snapshot, look, path, shown)))
            colour = in_linear_light(self._theme.of_outcome(path.outcome))
            colours.append(np.broadcast_to(colour, (len(lines[-1]), 2, 3)))
        points = lifted(np.concatenate(lines), _Z_PATHS)
        self._set(self._paths, "paths", points, np.concatenate(colours))

    def _show_ends(self, snapshot: Snapshot, look: Look, shown: int) -> None:
        ends = ends_of(snapshot, look, shown, self._theme)
        for outcome, handle in self._ends.items():
            of = ends.outcomes == outcome
            places = lifted(ends.places[of], _Z_END)
            self._set(handle, f"ends {outcome}", places, ends.colours[of])
        self._set(self._rims, "rims", lifted(ends.places, _Z_RIM))


def _fading(theme: Theme, n_segments: int) -> np.ndarray:
    """Colours of a trail from the oldest segment to the newest, ``(n, 2, 3) uint8``."""
    age = np.linspace(1.0, 0.0, n_segments)[:, None, None]
    fresh, faded = np.array(theme.predator, float), np.array(theme.unknown, float)
    return in_linear_light(np.broadcast_to(fresh * (1 - age) + faded * age, (n_segments, 2, 3)))
