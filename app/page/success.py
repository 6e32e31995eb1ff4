"""Success maps: how hunts end by where they start, made beside the learner of moments as they are.

One for all that look at what is live, which is of a moment ago while the learner goes on; one for
each browser that looks at a moment of the past, which is of that moment or is not there yet.
"""

import logging
from collections.abc import Callable, Iterable

from app.explain.cell import moment_of, policy_of
from app.live.snapshot import Snapshot
from app.page.scene.gallery import Seen
from app.picture.layer import SuccessMap
from app.util.background import Maker
from learners import hunts

log = logging.getLogger(__name__)

_REST_S = 1.5
"""Pause between two maps of what is live, so that the learner keeps its cores."""
_REST_RATIO = 1.0
"""Pause after a map of the past, as a multiple of what it took: somebody waits for the next."""


def success_of(snapshot: Snapshot, wanted: Callable[[], bool]) -> SuccessMap | None:
    """How hunts end by where they start; None if it was no longer wanted."""
    try:
        outcomes = hunts.success_map(snapshot.world, policy_of(snapshot), snapshot.seed, wanted)
    except Exception:
        log.exception("no success map")
        raise
    return None if outcomes is None else SuccessMap(outcomes, snapshot.trial, snapshot.generation)


def _live_maker() -> Maker[SuccessMap | None]:
    return Maker(rest_s=_REST_S)


def _moment_maker() -> Maker[SuccessMap | None]:
    return Maker(rest_ratio=_REST_RATIO)


class SuccessMaps:
    """Of one session. The render loop alone has to do with it."""

    def __init__(self) -> None:
        self._makers: dict[int | None, Maker[SuccessMap | None]] = {}
        """By the browser that looks at a moment of its own, or None."""
        self._stopped = False

    def of(self, seen: Seen, snapshot: Snapshot) -> SuccessMap | None:
        """The map for what is seen of a moment, if there is one; has it made where it is shown."""
        maker = self._makers.get(seen.viewer)
        if seen.look.layer == "success":
            if maker is None:
                maker = _live_maker() if seen.viewer is None else _moment_maker()
                self._makers[seen.viewer] = maker
            maker.want(moment_of(snapshot), lambda: success_of(snapshot, lambda: not self._stopped))
        if maker is None:
            return None
        of, found = maker.latest
        if seen.viewer is not None and of != moment_of(snapshot):
            return None
        return found if isinstance(found, SuccessMap) else None

    def keep(self, seen: Iterable[Seen]) -> None:
        """Forget the maps of moments at which nobody looks any more."""
        viewers = {one.viewer for one in seen}
        for viewer in [viewer for viewer in self._makers if viewer not in {*viewers, None}]:
            del self._makers[viewer]

    def stop(self) -> None:
        """Make nothing more, and wait for what is being made."""
        self._stopped = True
        for maker in self._makers.values():
            maker.stop()
