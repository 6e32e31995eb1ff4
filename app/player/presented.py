"""What a presenter's browser shows, as it is handed to those who show it to an audience."""

from typing import Any, Final, NamedTuple, Protocol

import msgspec

from app.live.status import Status
from app.picture.layer import Extras
from app.picture.look import Look
from app.player.classroom import Card, Classroom


class Presented(NamedTuple):
    """What the presenter sees now."""

    status: Status
    """What is true at the moment that they look at."""
    look: Look
    extras: Extras
    bar: msgspec.Raw | None
    """The time bar of the line that they look at, as JSON; None as long as there is none."""
    moment: dict[str, Any]
    """Where they are on it, as a frame is told (``Moment`` in ``app/web/time/state.js``)."""
    events: tuple[int, ...] = ()
    """Steps of what happened in that line."""
    is_away: bool = False
    """Whether their browser is gone; then the rest is as they left it."""
    card: Card | None = None
    """The card of a lesson that they have before them, if there is one."""


FEWEST_SHOWN: Final = 5
"""From so many on, what members of a class did is shown, without saying who."""


class OwnLearners(NamedTuple):
    """How the learners stand that members of a class have of their own."""

    learners: int
    playing: int
    """Those of them that learn now."""
    rewards: tuple[tuple[int, float], ...]
    """Trial and mean reward of each, the best first; empty as long as there are only few."""


class Stand(Protocol):
    """Those who only look, and where they do. Methods may be called from any thread."""

    @property
    def addresses(self) -> tuple[str, ...]:
        """Addresses to open, that on this machine first."""
        ...

    @property
    def code(self) -> str | None:
        """What who opens one is asked for; None if whoever comes is let in."""
        ...

    @property
    def n_watchers(self) -> int:
        """How many look."""
        ...

    @property
    def classroom(self) -> Classroom | None:
        """They as a class that answers; None if they only look."""
        ...

    @property
    def own(self) -> OwnLearners | None:
        """How the learners stand that those have of their own who look; None if they have none."""
        ...

    def show(self, live: Status, presented: Presented | None) -> None:
        """Show them how the run stands, and what the presenter sees; None before one has come."""
        ...

    def close(self) -> None:
        """Let nobody look any more."""
        ...
