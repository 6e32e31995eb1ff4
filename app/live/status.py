"""How a session stands at a moment: what everybody reads of it."""

from dataclasses import dataclass, replace

from app.live.held import Opened
from app.live.opening import Opening
from app.live.places import Behind, LineSeen, Mark, Place
from app.live.snapshot import Snapshot
from app.live.story import Stories, Story


@dataclass(frozen=True)
class Status:
    """How the worker stands, and the moment it last published."""

    snapshot: Snapshot
    """Its ``generation`` is what the run that is shown is told from others by."""
    playing: bool
    finished: bool
    """The run has had the trials it was to have; it goes on if it is asked to (:class:`GoOn`)."""
    exhausted: bool
    """The run has had all the trials a run may have."""
    preparing: bool
    """The learner's code is being compiled, once on each machine."""
    speed: float
    """Steps per second that are set; slower while ``opening`` is there."""
    steps_per_s: float
    """Steps per second made, over the last second."""
    error: str | None
    """What stopped the worker; the state is kept."""
    answered: int
    """Requests answered so far: the ticket of the last one."""
    is_own: bool = True
    """Whether the run that is shown began here, and was not made again from results."""
    is_resumed: bool = False
    """Whether it was made again from what was kept of an earlier session."""
    is_shared: bool = False
    """Whether it was made again from what somebody shared."""
    opened: Opened | None = None
    """The run of an experiment that is made again, or that stands as it ended."""
    aside: str | None = None
    """What was set aside for the run that is shown, in words; None if nothing was."""
    opening: Opening | None = None
    """The first hunts, while they are shown slowly and the speed rises after them."""
    lines: tuple[LineSeen, ...] = ()
    """The tree of the run that is shown: where that began, and what branched off since."""
    marks: tuple[Mark, ...] = ()
    """Moments of these lines that were given a line of text, in their order."""
    branched: tuple[tuple[int, Place], ...] = ()
    """Who gave a command at a moment of the past, and where the line begins that came of it; the
    newest last, and only some of them."""
    runs_to: int | None = None
    """Trial at whose start it is to stand still, on its way there at full speed."""
    pauses_at_joins: bool = False
    """Whether it stands still at each trial at which the schedule adds a skill."""
    journal: str | None = None
    """Why what is done cannot be written down; None while it is, or if nobody asked for it."""
    stories: Stories = Stories()  # noqa: RUF009  (it never changes)
    """Lessons that were taken, and how they stand."""
    behind: Behind | None = None
    """What the moment that is shown is to the live run; None if it is that itself. A session shows
    nothing else: it is said by whoever shows somebody the past."""

    @property
    def story(self) -> Story | None:
        """The lesson that is on; None if none is."""
        return self.stories.on

    def seen_at(self, shown: Snapshot, playing: bool) -> "Status":
        """What is true where somebody looks at another moment: of the run, what it was there; of
        the lab, what it is.

        Args:
            shown: the moment, of any line.
            playing: whether what is looked at is being played.
        """
        line = next((line for line in self.lines if line.number == shown.generation), None)
        branch = "" if line is None or line.is_live else line.name
        now = self.snapshot
        return replace(
            self,
            snapshot=shown,
            behind=Behind(branch, now.trial - shown.trial, now.step - shown.step),
            playing=playing,
            finished=False,
            exhausted=False,
            preparing=False,
            error=None,
            opened=None,
            opening=None,
        )
