"""Who makes the runs of an experiment: a *crew*, here of threads of this machine.

The kernel holds no lock, so threads use all cores. A cluster is a crew as well
(:mod:`app.experiments.cluster`).
"""

import contextlib
import queue
import threading
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple, Protocol, Self

from app.experiments.task import Finished, Task, failed, perform
from learners.run import Run


class CrewError(Exception):
    """Those who are to make runs cannot, or cannot any more; the message says why."""


class ClusterError(CrewError):
    """A cluster cannot be used, or was lost."""


class Switch:
    """Lets an experiment go on, wait, or end; set from any thread."""

    def __init__(self) -> None:
        self._changing = threading.Lock()
        self._going = threading.Event()
        self._going.set()
        self._ended = False

    @property
    def paused(self) -> bool:
        """Whether it is to wait."""
        return not self._going.is_set()

    @property
    def ended(self) -> bool:
        """Whether it is to end, and what is in flight to be given up."""
        return self._ended

    def pause(self) -> None:
        """Let everything wait where it stands."""
        with self._changing:
            if not self._ended:
                self._going.clear()

    def go_on(self) -> None:
        """Let it go on."""
        self._going.set()

    def end(self) -> None:
        """Let it end; there is no way back."""
        with self._changing:
            self._ended = True
            self._going.set()

    def wanted(self) -> bool:
        """Whether a run in flight is to go on; waits while it is paused."""
        self._going.wait()
        return not self._ended


class UnderWay(NamedTuple):
    """How far a run has come."""

    trial: int
    step: int


class Crew(Protocol):
    """Those who make runs. Used as a context, by one thread."""

    @property
    def switch(self) -> Switch:
        """Pauses or ends the runs."""
        ...

    @property
    def size(self) -> int:
        """Runs that are made at a time."""
        ...

    @property
    def busy(self) -> int:
        """Tasks that were started and have not come back."""
        ...

    def start(self, task: Task) -> None:
        """Take a task, now or as soon as there is room.

        Raises:
            CrewError: nobody can make it.
        """
        ...

    def finished(self, wait_s: float) -> list[Finished]:
        """What has come back; waits a moment for the first. Tasks given up do not come back.

        Raises:
            CrewError: nothing will come back any more. Not after the context was left.
        """
        ...

    def under_way(self) -> Mapping[str, UnderWay]:
        """How far runs have come, by key, as far as it is known."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *exception: object) -> None:
        """Give up what is in flight; where that can be known, wait until nobody works on it."""
        ...


class Threads:
    """A crew of threads of this machine."""

    def __init__(self, size: int, switch: Switch | None = None) -> None:
        self.size = size
        self.switch = Switch() if switch is None else switch
        self._executor = ThreadPoolExecutor(size, thread_name_prefix="run")
        self._over: queue.SimpleQueue[Finished | None] = queue.SimpleQueue()
        self._under_way: dict[str, UnderWay] = {}
        self.busy = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.switch.end()
        self._executor.shutdown(cancel_futures=True)

    def start(self, task: Task) -> None:
        try:
            self._executor.submit(self._work, task)
        except RuntimeError as error:
            # Where the system gives no more threads, those that there are take it in turn.
            if not self.busy:
                raise CrewError(f"no thread can be had: {error}") from error
        self.busy += 1

    def finished(self, wait_s: float) -> list[Finished]:
        found = []
        with contextlib.suppress(queue.Empty):
            over = self._over.get(timeout=wait_s)
            while True:
                self.busy -= 1
                if over is not None:
                    found.append(over)
                over = self._over.get_nowait()
        return found

    def under_way(self) -> Mapping[str, UnderWay]:
        return self._under_way.copy()

    def _work(self, task: Task) -> None:
        def note(run: Run) -> None:
            self._under_way[task.key] = UnderWay(run.trial, run.step)

        over = None
        try:
            over = perform(task, note, self.switch.wanted)
        except BaseException as error:  # noqa: BLE001 - whatever ended it, the run is noted
            over = failed(task.key, error)
        finally:
            self._under_way.pop(task.key, None)
            self._over.put(over)
