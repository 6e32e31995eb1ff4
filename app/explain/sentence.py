"""What is going on now, in words: read off the state, never off a script."""

from typing import NamedTuple

import numpy as np

from app.live.held import Opened
from app.live.session import Status
from app.live.snapshot import Snapshot
from app.words.plain import joined_by_and, plain
from learners.spec import MOVES
from sim import geometry
from sim.spec import WorldSpec

RECENT_REACH_TRIALS = 1_000
_DIGEST_SHOWN = 8
"""Characters of a digest that tell it from others at a glance."""
_BESIDE = np.radians(75)
"""Farther than this from straight behind the prey is beside the cone."""
_STANDING_SHARE = 1 / 170
"""Value that lately rose in fewer of the states than this has stopped spreading."""
_LEAN = 1 / 3
"""A front that grows so much more on one side than on the other goes round the prey, ..."""
_ROUND = 1 / 12
"""... if so much of it is beside the prey already."""


class Front(NamedTuple):
    """Where value first rose lately, as numbers of states in the prey's own frame.

    The first two count places out of the prey's sight, by the side of the line straight behind it.
    """

    counterclockwise: int
    clockwise: int
    beside: int
    """Those of both sides whose whole sector lies more than 75 degrees from straight behind."""
    inside: int
    """In the prey's visual field."""


def front(world: WorldSpec, first_reach: np.ndarray, trial: int) -> Front:
    """Count the states whose value first rose within the last ``RECENT_REACH_TRIALS`` trials."""
    turned = geometry.fold(first_reach, world.n_directions)
    fresh = ((turned >= 0) & (turned > trial - RECENT_REACH_TRIALS)).sum(axis=0)
    bearing = np.arange(world.n_directions) * 2 * np.pi / world.n_directions
    outer = geometry.ring_edges(world)
    middle = (outer + np.concatenate([[0], outer[:-1]])) / 2
    near = middle <= world.vision_radius * world.scale
    seen = near[:, None] & (np.cos(bearing) > 1e-9)
    from_behind = bearing - np.pi
    half = np.pi / world.n_directions
    unseen = np.where(seen, 0, fresh)
    return Front(
        counterclockwise=int(unseen[:, from_behind > 1e-9].sum()),
        clockwise=int(unseen[:, from_behind < -1e-9].sum()),
        beside=int(unseen[:, np.abs(from_behind) - half > _BESIDE].sum()),
        inside=int(fresh[seen].sum()),
    )


def _repertoire(snapshot: Snapshot) -> str:
    if snapshot.spec.learner.options == MOVES:
        return "Nine moves, no skills"
    names = [plain(introduction.skill) for introduction in snapshot.control.introductions]
    count = {1: "One skill", 2: "Two skills", 3: "Three skills"}.get(
        len(names), f"{len(names)} skills"
    )
    return f"{count}, {joined_by_and(names)}"


def success_share(snapshot: Snapshot) -> float:
    """Share of the recent trials that ended in capture; NaN before the first has ended."""
    total = sum(snapshot.recent)
    return snapshot.recent.captures / total if total else float("nan")


def _spread(snapshot: Snapshot) -> str:
    """What value is doing, from where it rose lately."""
    if not (snapshot.value > 0).any():
        return "no prey has been caught yet, so nothing is worth anything"
    lately = front(snapshot.spec.world, snapshot.first_reach, snapshot.trial)
    unseen = lately.counterclockwise + lately.clockwise
    if unseen + lately.inside < _STANDING_SHARE * snapshot.value.size:
        share = (snapshot.value > 0).mean()
        return (
            f"value has all but stopped spreading, {share:.0%} of the states are worth something,"
            f" and {success_share(snapshot):.0%} of recent hunts end in capture"
        )
    if lately.inside > unseen:
        return "value is spreading inwards, into the prey's visual field"
    lean = lately.counterclockwise - lately.clockwise
    if lean > _LEAN * unseen and lately.beside > _ROUND * unseen:
        return "value is spreading counter-clockwise from the cone, as a ring round the prey"
    if lately.beside > _LEAN * unseen:
        return "value is spreading round the prey as a ring"
    return "value is spreading back from the prey as a cone"


def sentence(status: Status) -> str:
    """One sentence on what is going on."""
    snapshot = status.snapshot
    if status.error is not None:
        return f"The learner stopped at trial {snapshot.trial:,} with an error; its state is kept."
    if status.preparing:
        return "Compiling the learner, once on this machine: a few seconds."
    lead = _repertoire(snapshot)
    exploring = []
    for episode in snapshot.control.episodes:
        if episode.until_trial > snapshot.trial:
            steps = "the other steps" if exploring else "the steps"
            exploring.append(
                f"{plain(episode.skill)} is taken in {episode.probability:.0%} of {steps} until"
                f" trial {episode.until_trial:,}"
            )
    clauses = []
    if exploring:
        clauses.append("; ".join(exploring))
    if snapshot.control.selection_frozen:
        clauses.append("the selection is frozen by hand")
    elif snapshot.selection_frozen:
        clauses.append(
            "the selection is frozen until trial"
            f" {snapshot.control.frozen_until:,}, while the skills learn"
        )
    if not snapshot.selection_frozen:
        clauses.append(_spread(snapshot))
    text = f"{lead}: {'; '.join(clauses)}."
    if status.finished:
        return f"The {snapshot.trial:,} trials are over. {text}"
    return text if status.playing else f"Paused. {text}"


def opened_run(snapshot: Snapshot) -> str:
    """What a run of an experiment is called for as long as it is on the board."""
    return f"{snapshot.preset}, seed {snapshot.seed}"


def provenance(opened: Opened) -> str:
    """Which run of an experiment this is, and whether it came out as in the results."""
    recorded, found = opened.digest[:_DIGEST_SHOWN], opened.found[:_DIGEST_SHOWN]
    if opened.same is None:
        return f"Making {opened.name} again …"
    if opened.same:
        return f"This is {opened.name}, as it ended: digest {found}, as in the results."
    return (
        f"This is {opened.name}, made again, but its tables differ from the results (digest"
        f" {recorded} there, {found} here): another version of pounce made them."
    )
