"""What one browser looks at, and the status that is true there.

Whatever is drawn or read for a browser goes by that status: the session's own while it looks at
what is live, and otherwise one with the snapshot of the moment that it looks at.
"""

from collections.abc import Hashable
from typing import Protocol

from app.live.places import Place
from app.live.snapshot import Snapshot
from app.live.status import Status
from app.page.time.walk import Ground, Walk


class Makes(Protocol):
    """Who makes snapshots of moments of the past, elsewhere: the newest wish of each viewer."""

    def want(self, viewer: Hashable, wish: Place) -> None:
        """Wish for a moment."""
        ...

    def found(self, viewer: Hashable) -> Snapshot | None:
        """The newest that was made for a viewer; None if there is none yet."""
        ...

    def fault(self, viewer: Hashable) -> str | None:
        """Why the last moment that a viewer wished could not be made; None if it was."""
        ...

    def forget(self, viewer: Hashable) -> None:
        """Make nothing more for a viewer."""
        ...


class Outlook:
    """One browser's. The render loop alone has to do with it."""

    def __init__(self, viewer: int, makes: Makes) -> None:
        self.viewer = viewer
        """By which it is told from others."""
        self.walk = Walk()
        self.place: Place | None = None
        """The moment that is looked at, as it was last known; None for what is live."""
        self._makes = makes
        self._moment = Wish(makes, viewer)
        self._at_a = Wish(makes, (viewer, "a"))
        self._made_of: tuple[Status, Snapshot, bool] | None = None
        self._made: Status | None = None

    @property
    def since(self) -> Snapshot | None:
        """The moment A, with which others are compared; None if there is none, or not yet."""
        return self._at_a.found

    @property
    def fault(self) -> str | None:
        """Why the moment that is looked at cannot be shown; None if it can."""
        return None if self.place is None else self._makes.fault(self.viewer)

    @property
    def is_there(self) -> bool:
        """Whether what is shown is the moment that is looked at, and not one on the way there."""
        shown = self._moment.found
        if self.place is None or shown is None:
            return self.place is None
        return self.place == (shown.generation, shown.step)

    def leave(self) -> None:
        """Have nothing more made."""
        self._moment.drop()
        self._at_a.drop()

    def status(self, live: Status, now_s: float, ground: Ground) -> Status:
        """What is true for this browser; until a moment has been made, what was before.

        It is the same object until it is another.
        """
        self.place = self.walk.at(now_s, ground)
        a = self.walk.a
        self._at_a.show(a)
        if self.place is None:
            self._moment.show(None)
            return live
        self._moment.show(self.place)
        shown = self._moment.found
        if shown is None:
            return live
        of = (live, shown, self.walk.direction != 0)
        if self._made is None or self._made_of is None or not _are_same(of, self._made_of):
            self._made_of, self._made = of, live.seen_at(shown, of[2])
        return self._made


class Wish:
    """A moment that is to be made, and the latest that was."""

    def __init__(self, makes: Makes, viewer: Hashable) -> None:
        self._makes, self._viewer = makes, viewer
        self._place: Place | None = None
        self._found: Snapshot | None = None

    @property
    def found(self) -> Snapshot | None:
        """The latest; None if there is none."""
        if self._place is not None:
            # One on the way there is better than the one before.
            self._found = self._makes.found(self._viewer) or self._found
        return self._found

    def show(self, place: Place | None) -> None:
        """Have a moment made, or none any more; what was made stays until it is there."""
        if place is None:
            self.drop()
        elif place != self._place:
            self._makes.want(self._viewer, place)
            self._place = place

    def drop(self) -> None:
        """Have nothing made any more, and forget what was."""
        if self._place is not None:
            self._makes.forget(self._viewer)
            self._place = self._found = None


def _are_same(one: tuple[object, ...], other: tuple[object, ...]) -> bool:
    # Snapshots and what holds them can be long to compare.
    return all(mine is yours for mine, yours in zip(one, other, strict=True))
