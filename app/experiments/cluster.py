"""A crew on a Dask cluster: other machines make the same runs, with the same results.

A run is a function of its task, so it does not matter which worker makes it, nor how often: a run
whose worker dies is made again by another. Tasks and results are plain values; Dask pickles them
between its processes, so whoever can reach a cluster can run code on it.
"""

import asyncio
import contextlib
import logging
import queue
import time
import uuid
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Final, Self

from distributed import Client, Future, Security, rpc

from app.experiments.crews import ClusterError, Switch, UnderWay
from app.experiments.store import version
from app.experiments.task import Finished, Task, failed, perform

CONNECT_S: Final = 10.0
"""Time within which a scheduler must answer, in seconds."""

_LOOK_S = 1.0
"""Time between two looks at how many workers there are."""
_SHOWN_WORKERS = 3
_DASK_LOGGERS = ("distributed", "distributed.client")
"""Those to which Dask gives a level and a way to the terminal."""

_log = logging.getLogger(__name__)


class Cluster:
    """A crew of the workers of a Dask cluster, which may come and go while it is at work.

    Pausing holds back what has not been handed out: runs that workers are at finish and come back.
    Ending takes back what workers have not begun; what they are at they finish for nobody.
    """

    def __init__(self, address: str, switch: Switch | None = None) -> None:
        """Connect to a scheduler, and see that its workers have this version of pounce.

        Args:
            address: ``tcp://HOST:PORT`` of a scheduler; with ``tls://``, certificates are those of
                Dask's configuration.
            switch: pauses or ends the runs.

        Raises:
            ClusterError: it cannot be used; the message says why.
        """
        self.switch = Switch() if switch is None else switch
        # Keys are shared by all who use a scheduler; results of others are not ours.
        self._mark = uuid.uuid4().hex
        self._version = version()
        self._over: queue.SimpleQueue[Finished] = queue.SimpleQueue()
        self._in_flight: dict[str, Future] = {}
        self._is_lost = False
        self._looked_at = time.monotonic()
        with contextlib.ExitStack() as stack:
            stack.enter_context(_quiet())
            self._client = _connected(address)
            stack.callback(self._client.close)
            try:
                self._refuse_others()
                self._threads = self._counted(self._client.nthreads())
            except OSError as error:
                raise ClusterError(
                    f"was lost while it was asked for its workers: {error}"
                ) from error
            if not self._threads:
                raise ClusterError(
                    "has no workers; allowed: a scheduler that has some, started by"
                    f" dask worker {address}"
                )
            self._loop: Any = self._client.loop
            self._stack = stack.pop_all()

    @property
    def size(self) -> int:
        """Threads of all workers, as of a moment ago; at least 1, so that runs wait in line."""
        return max(1, self._threads)

    @property
    def busy(self) -> int:
        """Tasks that were started and have not come back."""
        return len(self._in_flight)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        """Give up what is in flight. Workers finish the runs they are at, and nobody hears."""
        self.switch.end()
        self._stack.close()

    def start(self, task: Task) -> None:
        """Hand a task to the scheduler.

        Raises:
            ClusterError: the scheduler is lost.
        """
        self._refuse_loss()
        future = self._client.submit(
            perform_same, task, self._version, key=f"{task.key}-{self._mark}", pure=False
        )
        self._in_flight[task.key] = future
        # Brought by the loop itself and not by a done-callback of Dask: their one thread would
        # fetch results one by one, and would hold up the end of the program if one never came.
        self._loop.add_callback(self._bring, task.key, future)

    def finished(self, wait_s: float) -> list[Finished]:
        """What has come back; waits a moment for the first. Tasks given up do not come back.

        Raises:
            ClusterError: the scheduler is lost, and what came back before has been handed over.
        """
        found = []
        with contextlib.suppress(queue.Empty):
            over = self._over.get(timeout=wait_s)
            while True:
                future = self._in_flight.pop(over.key, None)
                if future is not None:
                    # Or workers would keep it.
                    future.release()
                    found.append(over)
                over = self._over.get_nowait()
        if self.switch.ended:
            self._in_flight.clear()
        elif not found:
            self._refuse_loss()
        if not self.switch.ended and time.monotonic() - self._looked_at >= _LOOK_S:
            self._looked_at = time.monotonic()
            self._loop.add_callback(self._look)
        return found

    def under_way(self) -> Mapping[str, UnderWay]:
        """Nothing: workers say only when a run is over."""
        return {}

    async def _bring(self, key: str, future: Future) -> None:
        """Wait for a run in Dask's loop, and put it in line."""
        try:
            over = await future
        except Exception as error:  # noqa: BLE001 - whatever it is, it is noted, and others go on
            was_told = future.status == "error" or future.cancelled()
            if not was_told or self._client.status != "running":
                # All futures are cancelled when the scheduler goes away: no fault of the runs.
                self._is_lost = True
                return
            over = failed(key, error)
        self._over.put(over)

    async def _look(self) -> None:
        """Count the workers in Dask's loop, so that a slow scheduler holds up nobody."""
        if self._client.status != "running":
            return
        # If the scheduler is lost, the client's own connection tells.
        with contextlib.suppress(OSError):
            threads = self._counted(await self._client.nthreads())
            if self._threads and not threads:
                _log.warning("the cluster has no workers at the moment; runs wait for the next one")
            self._threads = threads

    @staticmethod
    def _counted(threads: Any) -> int:
        return sum(threads.values())

    def _refuse_loss(self) -> None:
        if self._is_lost or self._client.status != "running":
            raise ClusterError("was lost; what is finished is kept; --resume goes on")

    def _refuse_others(self) -> None:
        """Results depend on the version; and Dask's scheduler, too, must know what a task is."""
        answers: dict[str, Any] = {}
        try:
            answers["the scheduler"] = self._client.run_on_scheduler(version)
        except OSError:
            raise
        except Exception as error:  # noqa: BLE001 - whatever it is, it has not this version
            answers["the scheduler"] = error
        on_workers: Any = self._client.run(version, on_error="return")
        answers.update(on_workers)
        wrong = []
        for who, answer in answers.items():
            # A worker that has just died is no matter.
            if answer != self._version and not isinstance(answer, OSError):
                wrong.append(f"{who} has {'none' if isinstance(answer, Exception) else answer}")
        if wrong:
            more = len(wrong) - _SHOWN_WORKERS
            others = f", and {more} more differ" if more > 0 else ""
            raise ClusterError(
                f"has another version of pounce than {self._version}, which is here:"
                f" {', '.join(wrong[:_SHOWN_WORKERS])}{others};"
                f" allowed: workers and a scheduler with pounce-lab[cluster] {self._version}"
            )


def perform_same(task: Task, wanted_version: str) -> Finished | None:
    """Make a run on a worker, if results are those of the version that is wanted."""
    here = version()
    if here != wanted_version:
        error = ClusterError(f"the worker has pounce {here}, and {wanted_version} is wanted")
        return failed(task.key, error)
    return perform(task)


def _connected(address: str) -> Client:
    allowed = "allowed: tcp://HOST:PORT of a running Dask scheduler"
    try:
        # Dask's client waits for ever where something listens and says nothing. In a thread, since
        # the caller's own may be in the middle of an event loop, as a notebook's is.
        with ThreadPoolExecutor(1) as executor:
            asking = asyncio.wait_for(_identity(address), CONNECT_S)
            identity = executor.submit(asyncio.run, asking).result()
        if identity.get("type") != "Scheduler":
            raise ClusterError(f"is no Dask scheduler; {allowed}")
        return Client(address, timeout=CONNECT_S, name="pounce", set_as_default=False)
    except ClusterError:
        raise
    except Exception as error:
        # Whoever answers there may answer anything.
        reason = str(error) or f"no answer within {CONNECT_S:g} s"
        raise ClusterError(f"cannot be reached: {reason}; {allowed}") from error


async def _identity(address: str) -> Mapping[str, Any]:
    arguments = Security().get_connection_args("client")
    async with rpc(address, timeout=CONNECT_S, connection_args=arguments) as scheduler:
        found: Any = await scheduler.identity()
        return found


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Dask's reports of workers that come and go are no matter of a terminal; errors are raised."""
    loggers = [logging.getLogger(name) for name in _DASK_LOGGERS]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
