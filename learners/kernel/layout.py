"""How the tables of a learner are laid out: which rows they have, and what each row is about.

The selection of most learners has a row for each main state. The manager of commands has one for
each heading and *region* (section 3.2): a block of so many sectors and so many rings, counted from
the first of each. Where they do not come out even, the last one of a row is smaller.

The tables of sub-policies, which are skills or commands, lie one behind the other. Most have a row
for each reading of the skills; one that sees the prey's heading has as many for each heading.
"""

from typing import NamedTuple

import numpy as np

from learners.names import COMMANDS
from learners.spec import RunSpec
from sim.bits import U
from sim.spec import N_HEADINGS


class Regions(NamedTuple):
    """Which region each reading of the selection lies in: ``ring * n_sectors + sector`` of it."""

    of_reading: np.ndarray
    """(reading,) uint32."""
    n_regions: np.uint64
    n_sectors: np.uint64
    """Regions of one ring of them."""


def regions_of(spec: RunSpec) -> Regions | None:
    """The regions of a manager; None if the selection tells all its readings apart."""
    if spec.learner.options != COMMANDS:
        return None
    side, world = spec.learner.region, spec.world
    ring, sector = np.divmod(np.arange(world.n_readings), world.n_directions)
    n_rings, n_sectors = -(-world.n_distances // side), -(-world.n_directions // side)
    of_reading = (ring // side * n_sectors + sector // side).astype(np.uint32)
    return Regions(of_reading, U(n_rings * n_sectors), U(n_sectors))


def n_selection_rows(spec: RunSpec) -> int:
    """Rows of the selection table: main states, or headings and regions."""
    regions = regions_of(spec)
    return spec.world.n_states if regions is None else N_HEADINGS * int(regions.n_regions)


def by_main_state(spec: RunSpec, of_rows: np.ndarray) -> np.ndarray:
    """What the selection table has by row, by main state; each state has what its region has.

    Args:
        spec: of the run.
        of_rows: ``(row, ...)``.

    Returns:
        ``(heading, distance, direction, ...)``, a copy.
    """
    world, regions = spec.world, regions_of(spec)
    shape = (N_HEADINGS, world.n_distances, world.n_directions, *of_rows.shape[1:])
    if regions is None:
        return of_rows.reshape(shape).copy()
    by_heading = of_rows.reshape(N_HEADINGS, int(regions.n_regions), *of_rows.shape[1:])
    return by_heading[:, regions.of_reading].reshape(shape)


def first_rows(spec: RunSpec) -> np.ndarray:
    """Row at which the table of each sub-policy begins, and at last how many rows there are.

    ``(sub-policy + 1,) uint64``. In a table that sees headings, row ``heading * n_skill_states +
    state`` is meant, in any other ``state``.
    """
    learner, n_states = spec.learner, spec.world.n_skill_states
    sizes = [n_states * views_of(spec, name) for name in learner.sub_policies]
    return np.cumsum([0, *sizes], dtype=np.uint64)


def views_of(spec: RunSpec, sub_policy: str) -> int:
    """Headings that a sub-policy tells apart: all, or it takes them for one."""
    return N_HEADINGS if spec.learner.sees_heading(sub_policy) else 1


def by_sub_policy(spec: RunSpec, of_rows: np.ndarray) -> np.ndarray:
    """What the tables of sub-policies have by row, by sub-policy and what it sees.

    Args:
        spec: of the run.
        of_rows: ``(row, ...)``.

    Returns:
        ``(sub-policy, distance, direction, ...)``, distance and direction as skills see them; if
        any of them sees headings, ``(sub-policy, heading, distance, direction, ...)``, where those
        that do not have the same for each heading. A copy.
    """
    names, of_skills = spec.learner.sub_policies, spec.world.of_skills
    shape = of_skills.n_distances, of_skills.n_directions, *of_rows.shape[1:]
    views = [views_of(spec, name) for name in names]
    if max(views, default=1) == 1:
        return of_rows.reshape(len(names), *shape).copy()
    found = np.empty((len(names), N_HEADINGS, *shape), of_rows.dtype)
    first = first_rows(spec).astype(np.int64)
    for number, seen in enumerate(views):
        found[number] = of_rows[first[number] : first[number + 1]].reshape(seen, *shape)
    return found
