"""What tables begin with, where a preset has perceptual templates for them (section 2.3.2).

A template is about states of which the middle, the mean of their cells, lies where it says. There
the option that it prefers begins with its value; of moves, each with the share of the value that is
the cosine between it and the way that is preferred, if that is above 0. Of several templates for
the same state and option the last counts. What is learned later moves these values like any other.
"""

import numpy as np

from learners.spec import RunSpec
from learners.template_spec import SELECTION, WAYS, TemplateSpec
from sim import geometry
from sim.geometry import MOVES, N_MOVES
from sim.spec import N_HEADINGS, WorldSpec

_AHEAD = {"outwards": 0.0, "counterclockwise": 90.0, "inwards": 180.0, "clockwise": 270.0}
"""Degrees that a way is turned from the one straight away from the prey."""


def seed_moves(spec: RunSpec, table: str, values: np.ndarray) -> None:
    """Let templates of moves change what a table begins with.

    Args:
        spec: of the run.
        table: ``selection``, or the skill.
        values: ``(row, move) float32``, a row for each reading, or for each heading and reading.
    """
    world = spec.world if table == SELECTION else spec.world.of_skills
    for template in spec.learner.templates:
        if template.table == table and template.prefer in WAYS:
            places, angle = _places(world, template)
            shares = _shares(angle + np.radians(_AHEAD[template.prefer]))
            by_view = values.reshape(-1, len(angle), values.shape[-1])
            for view, rows in enumerate(by_view):
                here = places[view]
                better = here[:, None] & (shares > 0)
                rows[:, :N_MOVES][better] = (template.value * shares)[better]


def seed_option(spec: RunSpec, skill: str, column: np.ndarray) -> None:
    """Let templates change what a skill is worth to the selection when it joins.

    Args:
        spec: of the run.
        skill: that joins.
        column: ``(heading * reading,) float32`` of the selection.
    """
    for template in spec.learner.templates:
        if template.table == SELECTION and template.prefer == skill:
            places, _ = _places(spec.world, template)
            column[places.ravel()] = template.value


def _places(world: WorldSpec, template: TemplateSpec) -> tuple[np.ndarray, np.ndarray]:
    """Where a template holds, ``(heading, reading) bool``; and the readings' bearings, radians."""
    n_readings = world.n_readings
    readings = geometry.readings(world).ravel()
    dx, dy = geometry.offsets(world)
    total = np.bincount(readings, np.hypot(dx, dy).ravel(), n_readings)
    distance = total / np.maximum(np.bincount(readings, minlength=n_readings), 1) / world.scale
    angle = np.arange(n_readings) % world.n_directions * (2 * np.pi / world.n_directions)
    heading = np.arange(N_HEADINGS)[:, None] * (2 * np.pi / N_HEADINGS)
    bearing = np.degrees(np.abs(np.angle(np.exp(1j * (angle - heading)))))
    (near, far), (least, most) = template.distance, template.bearing
    at_distance = (near <= distance) & (distance <= far)
    return at_distance & (least <= bearing + 1e-9) & (bearing - 1e-9 <= most), angle


def _shares(way: np.ndarray) -> np.ndarray:
    """Cosine between each move and the way preferred in a reading, ``(reading, move)``; 0 to stay.

    Rounded, so that a move across the way, which has none of it, has exactly 0.
    """
    dx, dy = MOVES[:, 0], MOVES[:, 1]
    length = np.maximum(np.hypot(dx, dy), 1)
    cosine = (np.cos(way)[:, None] * dx + np.sin(way)[:, None] * dy) / length
    return cosine.round(12)
