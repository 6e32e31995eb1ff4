"""What one browser asks for, and what that means at the moment that it looks at.

While it looks at what is live, it is the session that is asked. In the past, to play, to pause and
to step is done by the browser's own walk, and a command makes a branch there, to which that browser
goes. What is asked while a branch is being made waits for it, so that it is done there as well.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, NamedTuple

from app.explain.branches import difference_in_words
from app.live.places import Place
from app.live.requests import Branch, Pause, Play, Request, StepOnce, TrialOnce
from app.live.status import Status
from app.live.worker import Reply
from app.page.time.outlook import Outlook
from app.page.time.walk import Ground, WalkError
from app.server.callbacks import RefusedError
from learners.commands import Command
from learners.control import Control

_MOST_WAITING: Final = 32
"""Requests of one browser that may wait for its branch."""

Submit = Callable[[Request, Reply], object]
"""Hands a request to the session; the reply may come in any thread."""


class _Made(NamedTuple):
    """What a branch does otherwise than the line that it left."""

    line: int
    step: int
    before: Control
    trial: int
    commands: tuple[Command, ...]
    said: str
    """The same in words."""


@dataclass
class _Making:
    """A branch that was asked for and is not there yet."""

    request: Branch
    before: Control
    trial: int
    refuse: Reply


class Asks:
    """One browser's. The render loop alone has to do with it, but for what it is told by."""

    def __init__(
        self,
        outlook: Outlook,
        submit: Submit,
        later: Callable[[Callable[[], object]], object],
    ) -> None:
        """Ask for nothing yet.

        Args:
            outlook: what the browser looks at.
            submit: hands a request to the session.
            later: has something done in the render loop; called in any thread.
        """
        self._outlook = outlook
        self._submit, self._later = submit, later
        self._waiting: deque[tuple[Request, Reply]] = deque()
        self._making: _Making | None = None
        self._made: _Made | None = None
        self._known: set[int] = set()
        """Lines that this browser has been taken to."""
        self._error: str | None = None
        """What had stopped the learner: what stops it anew has stopped a branch on its way, too."""

    @property
    def is_branching(self) -> bool:
        """Whether a branch is being made by what was asked last."""
        return self._making is not None

    @property
    def note(self) -> str:
        """What the branch that is looked at does otherwise, as long as it is this browser's own."""
        made, place = self._made, self._outlook.place
        if made is None or place is None or place.line != made.line:
            return ""
        return made.said

    def take(
        self, request: Request, refuse: Reply, status: Status, ground: Ground, now_s: float
    ) -> None:
        """Do what is asked, or have it done.

        Args:
            request: what is asked.
            refuse: told why it could not be done, later and in any thread.
            status: what is true for the browser.
            ground: what is known of the lines.
            now_s: the time.

        Raises:
            RefusedError: it cannot be done there.
            WalkError: there is nothing more in that direction.
        """
        if self._making is not None and isinstance(request, Command):
            if len(self._waiting) >= _MOST_WAITING:
                raise RefusedError("a branch is being made; wait until it is there")
            self._waiting.append((request, refuse))
            return
        walk, place = self._outlook.walk, self._outlook.place
        if place is None:
            self._submit(request, refuse)
            return
        match request:
            case Play():
                walk.play(1, now_s, ground)
            case Pause():
                walk.pause(now_s, ground)
            case StepOnce():
                walk.go_by("steps", 1, now_s, ground)
            case TrialOnce():
                walk.go_by("trials", 1, now_s, ground)
            case _ if isinstance(request, Command):
                walk.pause(now_s, ground)
                self._branch(place, request, refuse, status)
            case _:
                self._submit(request, refuse)

    def follow(self, live: Status, ground: Ground, now_s: float) -> None:
        """Go to the branch that was made by what this browser asked, once it is there."""
        if live.error not in (None, self._error):
            self._refuse(f"the learner has stopped: {live.error}")
        self._error = live.error
        mine = [place for viewer, place in live.branched if viewer == self._outlook.viewer]
        new = [place for place in mine if place.line not in self._known]
        if not new:
            return
        self._known = {place.line for place in mine}
        making = self._making
        if making is None:
            return
        branch = new[-1]
        try:
            self._outlook.walk.look(branch.line, branch.step, now_s, ground)
        except WalkError as error:
            # Somebody has deleted it meanwhile, or has begun another run.
            self._refuse(str(error))
            return
        self._making = None
        waiting, self._waiting = self._waiting, deque()
        self._made = self._as_made(branch, making)
        status = self._outlook.status(live, now_s, ground)
        for request, refuse in waiting:
            self.take(request, refuse, status, ground, now_s)

    def _refuse(self, reason: str) -> None:
        """Say of the branch that is being made, and of what waits for it, that it is not to be."""
        making, self._making = self._making, None
        waiting, self._waiting = self._waiting, deque()
        if making is not None:
            for refuse in (making.refuse, *(refuse for _, refuse in waiting)):
                refuse(reason)

    def _branch(self, place: Place, command: Command, refuse: Reply, status: Status) -> None:
        snapshot = status.snapshot
        request = Branch(place, command, self._outlook.viewer)
        self._making = making = _Making(request, snapshot.control, snapshot.trial, refuse)

        def refused(reason: str) -> None:
            refuse(reason)
            self._later(lambda: self._give_up(making))

        self._submit(request, refused)

    def _give_up(self, making: _Making) -> None:
        if self._making is making:
            self._making = None
            self._waiting.clear()

    def _as_made(self, branch: Place, making: _Making) -> _Made:
        former, place = self._made, making.request.place
        before, trial, commands = making.before, making.trial, (making.request.command,)
        if former is not None and place == (former.line, former.step):
            # One more of the commands that made that branch, in whose place this one is.
            before, trial = former.before, former.trial
            commands = (*former.commands, *commands)
        said = difference_in_words(before, trial, commands)
        return _Made(branch.line, branch.step, before, trial, commands, said)
