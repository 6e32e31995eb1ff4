"""Watchers that read every frame and draw nothing.

``python -m benchmarks.audience_client PORT N [class]``: with ``class`` each of them has a seat and
answers the question that is open once a second. They run in a process of their own, so that what is
measured is the port and not its readers. For each line on standard input, a number of seconds, a
line on standard output has, that much later, the bytes that came to all of them since the line
before, as JSON.
"""

import asyncio
import http.client
import itertools
import json
import sys
import zlib
from collections.abc import Iterator

from websockets.asyncio.client import ClientConnection, connect

_HEAD_BYTES = 4
"""Of a frame, before what is in it."""
OPTIONS = ("one", "other")
"""What a class answers in turns."""


class Reader:
    """One watcher."""

    def __init__(self, answers: bool) -> None:
        """``answers``: whether it is a seat of a class."""
        self.n_bytes = 0
        self._answers = answers
        self._ballot: int | None = None

    async def read(self, port: int, number: int, of: int) -> None:
        """Wish to see what the presenter sees, and take in whatever comes.

        Args:
            port: that of the audience.
            number: which of the watchers it is.
            of: how many there are.
        """
        place = f"127.0.0.1:{port}"
        cookie = await asyncio.to_thread(_cookie, port) if self._answers else ""
        async with connect(
            f"ws://{place}/socket",
            additional_headers={"Origin": f"http://{place}", "Cookie": cookie},
            compression=None,
            max_size=None,
            open_timeout=60,
            proxy=None,
        ) as connection:
            # Some devices are dark.
            await connection.send(json.dumps({"do": "follow", "dark": number % 4 == 0}))
            async with asyncio.TaskGroup() as tasks:
                tasks.create_task(self._read(connection))
                if self._answers:
                    tasks.create_task(self._answer(connection, number / of))

    async def _read(self, connection: ClientConnection) -> None:
        async for frame in connection:
            self.n_bytes += len(frame) + _HEAD_BYTES
            if self._answers and self._ballot is None:
                assert isinstance(frame, bytes)
                for part in json.loads(zlib.decompress(frame)):
                    if part["kind"] == "lesson" and part["ask"]:
                        self._ballot = part["ask"]["ballot"]

    async def _answer(self, connection: ClientConnection, after_s: float) -> None:
        await asyncio.sleep(after_s)
        for value in itertools.cycle(OPTIONS):
            if self._ballot is not None:
                answer = {"do": "answer", "ballot": self._ballot, "value": value}
                await connection.send(json.dumps(answer))
            await asyncio.sleep(1.0)


def _cookie(port: int) -> str:
    """What a browser keeps that opens the page."""
    connection = http.client.HTTPConnection("127.0.0.1", port)
    connection.request("GET", "/")
    answer = connection.getresponse()
    answer.read()
    return (answer.headers["Set-Cookie"] or "").partition(";")[0]


def _lines() -> Iterator[str]:
    while line := sys.stdin.readline():
        yield line


async def _main(port: int, n_watchers: int, answers: bool) -> None:
    readers = [Reader(answers) for _ in range(n_watchers)]
    tasks = [
        asyncio.create_task(reader.read(port, number, n_watchers))
        for number, reader in enumerate(readers)
    ]
    lines = _lines()
    before = 0
    while (line := await asyncio.to_thread(next, lines, "")) != "":
        await asyncio.sleep(float(line))
        n_bytes = sum(reader.n_bytes for reader in readers)
        n_there = sum(not task.done() for task in tasks)
        sys.stdout.write(json.dumps({"bytes": n_bytes - before, "watchers": n_there}) + "\n")
        before = n_bytes
        sys.stdout.flush()


if __name__ == "__main__":
    asyncio.run(_main(int(sys.argv[1]), int(sys.argv[2]), "class" in sys.argv))
