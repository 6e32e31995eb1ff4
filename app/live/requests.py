"""What is asked of a session, by any thread: values that its worker carries out in their order."""

import math
from dataclasses import dataclass

from app.live.lines import MadeAgain
from app.live.places import Place
from app.live.racer import Entry
from app.live.records import Journal
from app.live.story import Act, LongText
from learners.commands import Command
from learners.schedule_spec import ScheduleSpec
from learners.spec import RunSpec


@dataclass(frozen=True)
class Begin:
    """Play, unless somebody has said by then whether the learner is to go on or to stand still."""


@dataclass(frozen=True)
class Play:
    """Learn on, up to the preset's last trial."""


@dataclass(frozen=True)
class GoOn:
    """Learn on past the last trial, for as many trials again as the preset has."""


@dataclass(frozen=True)
class Pause:
    """Stand still."""


@dataclass(frozen=True)
class StepOnce:
    """Pause, and make one step."""


@dataclass(frozen=True)
class TrialOnce:
    """Pause, and go to the start of the next trial."""


@dataclass(frozen=True)
class SetSpeed:
    """Aim at so many steps per second."""

    steps_per_s: float


@dataclass(frozen=True)
class SkipOpening:
    """Show the first hunts slowly no longer."""


@dataclass(frozen=True)
class StartAgain:
    """Set the run aside and begin another, which plays if that one was going on.

    One that was over, or had stopped, is followed by one that stands still, at whatever speed.
    """

    spec: RunSpec
    preset: str
    """As shown."""
    seed: int
    schedule: ScheduleSpec | None = None
    """Takes the place of the preset's own by a command, before the first step."""
    paused: bool = False
    """Stand still at its beginning, whether or not the last one went on."""


@dataclass(frozen=True)
class OpenRun:
    """Make a run of an experiment again, up to where it ended, and pause there."""

    spec: RunSpec
    preset: str
    """As shown."""
    seed: int
    step: int
    """Where it ended."""
    digest: str
    """Of its tables there."""
    name: str
    """What it is called: "figure_4_1: timed, seed 3"."""


@dataclass(frozen=True)
class GoBack:
    """Take up the run again that was set aside; the one that is shown is set aside for it."""


@dataclass(frozen=True)
class RunTo:
    """Learn up to the start of a trial at full speed, whatever speed is set, and stand still there.

    A run that was to have fewer trials has as many then. Playing, pausing or stepping meanwhile
    gives it up.
    """

    trial: int


@dataclass(frozen=True)
class PauseAtJoins:
    """Stand still, from here on or no longer, at each trial at which the schedule adds a skill.

    The skill is there with the next step: up to then its plan can still be changed.
    """

    on: bool


@dataclass(frozen=True)
class Branch:
    """Give a command at a moment of the past: a branch begins there, and its line stays as it is.

    At the very moment at which a branch begins, the command is one more of those that made it, and
    the branch with it takes its place; unless something hangs on that: branches of its own, marks,
    or that it has been live.
    """

    place: Place
    command: Command
    viewer: int | None = None
    """Who gave it, to be told of the new line in ``Status.branched``."""


@dataclass(frozen=True)
class MakeLive:
    """Let a branch be the live run; the former one stays as a line of its own, where it stands.

    It goes on from a step, or from as far as it is known. What is known of it beyond that step is
    made again as it goes on; it does so at once if the former one did.
    """

    line: int
    step: int | None = None


@dataclass(frozen=True)
class NameLine:
    """Call a line by a name; by none ("") it is called as it was at first."""

    line: int
    name: str


@dataclass(frozen=True)
class DeleteLine:
    """Take a branch out of the tree; refused while it is live, or while branches begin on it."""

    line: int


@dataclass(frozen=True)
class BringBack:
    """Put a branch back that was deleted."""

    line: int


@dataclass(frozen=True)
class AddMark:
    """Give a moment a line of text."""

    place: Place
    text: str


@dataclass(frozen=True)
class RemoveMark:
    """Take a mark away, by its number."""

    number: int


@dataclass(frozen=True)
class TakeUp:
    """Show a session that was made again from its journal, with all its lines, and go on in it.

    It takes the place of all that there is, which is in a journal of its own, and stands still. Its
    runs have numbers that this session has not had.
    """

    made_again: MadeAgain
    journal: Journal | None
    """Of the session that is taken up: what is done from here on is written there."""
    is_shared: bool = False
    """Whether it is from elsewhere, and was not kept here."""


@dataclass(frozen=True)
class StartRace:
    """Let runs learn side by side, in the place of those that did before; the live run pauses."""

    entries: tuple[Entry, ...]
    playing: bool = True
    """Whether they go on at once."""
    speed: float = math.inf
    """Steps per second of each."""


@dataclass(frozen=True)
class EndRace:
    """Let no runs learn side by side any more; nothing is kept of them. The live run stands."""


@dataclass(frozen=True)
class TakeLesson:
    """Have a lesson be on, where it was left, with its run; or from its beginning.

    What is on the board is set aside for its run, as :class:`StartAgain` does.
    """

    name: str
    source: str
    """How its file was named; empty if it came without one."""
    digest: str
    """Of its text."""
    text: LongText
    language: str
    begin: StartAgain
    """Its run, if that is to begin."""
    start: int = 0
    """The trial in which its first card finds that run, which comes there at full speed."""
    follows: bool = True
    """Whether that run follows its schedule from there on."""
    speed: float = 20_000.0
    """Steps per second that are set then."""
    is_anew: bool = False
    """From the beginning, whatever was done in it before."""
    runs_anew: bool = False
    """With another run, whatever was done in the one before; but at the same card."""


@dataclass(frozen=True)
class LeaveLesson:
    """Have no lesson be on; its run stays on the board."""


@dataclass(frozen=True)
class Tell:
    """Do something in the lesson that is on; where the live run is then is filled in."""

    act: Act
    lesson: str
    """Its name: another one may be on by now, and is not meant."""


RequestOfRun = Begin | Play | GoOn | Pause | StepOnce | TrialOnce | RunTo | Command
"""What is asked of one run."""
RequestOfLines = Branch | MakeLive | NameLine | DeleteLine | BringBack | AddMark | RemoveMark
"""What is asked of the tree of runs."""
RequestOfLesson = TakeLesson | LeaveLesson | Tell
"""What is asked of lessons."""
Request = (
    RequestOfRun
    | RequestOfLines
    | RequestOfLesson
    | SetSpeed
    | SkipOpening
    | PauseAtJoins
    | StartAgain
    | OpenRun
    | GoBack
    | TakeUp
    | StartRace
    | EndRace
)
