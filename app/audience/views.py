"""What one can look at, and what those are sent who look at the same."""

from typing import Final, NamedTuple

from app.audience.pictures import Parts
from app.live.places import Place
from app.picture.look import Look
from app.server.turnstile import Turnstile

BYTES_PER_S: Final = 4_200.0
"""What a watcher is sent in the long run while the learner goes on."""
_BYTES_AT_ONCE: Final = 8_000.0


class Seen(NamedTuple):
    """What somebody looks at; whoever looks at the same is sent the same."""

    look: Look | None
    """None for that of the presenter."""
    dark: bool
    place: Place | None = None
    """A moment of the past; None for what is live, or for that of the presenter."""

    @property
    def is_presenters(self) -> bool:
        """Whether it is what the presenter looks at."""
        return self.look is None


class Subject(NamedTuple):
    """What has to be seen soon: while both stay, the run alone goes on."""

    done: tuple[object, ...]
    """What the presenter has done, as far as it is seen."""
    happened: tuple[object, ...]
    """What has happened in the run by itself."""


class View:
    """What those are sent who look at the same, and when it was made."""

    def __init__(self) -> None:
        self.parts: Parts = {}
        self.subject: Subject | None = None
        """Of what it was painted last; another is painted sooner."""
        self.is_answer = False
        """Whether what is sent next answers what the presenter did, which is at nobody's cost."""
        self.ground_of: tuple[object, ...] = ()
        self.over_of: tuple[object, ...] = ()
        self.words_of: tuple[object, ...] = ()
        """Of what each was made; kept, so that it is told by what that is."""
        self.due_s = 0.0
        """When it is to be painted again if nobody does anything."""
        self.at_s = -10.0
        self.over_s = self.words_s = self.bar_s = -10.0
        self.pace = Turnstile(BYTES_PER_S, _BYTES_AT_ONCE)
