"""Watchers that read every frame and draw nothing: ``python -m benchmarks.audience_client PORT N``.

They run in a process of their own, so that what is measured is the port and not its readers. For
each line on standard input, a number of seconds, a line on standard output has the bytes that came
to all of them in that time, as JSON.
"""

import asyncio
import json
import sys
from collections.abc import Iterator

from websockets.asyncio.client import ClientConnection, connect

_HEAD_BYTES = 4
"""Of a frame, before what is in it."""


class Reader:
    """One watcher."""

    def __init__(self) -> None:
        self.n_bytes = 0

    async def read(self, port: int, dark: bool) -> None:
        """Wish to see what the presenter sees, and take in whatever comes."""
        place = f"127.0.0.1:{port}"
        async with connect(
            f"ws://{place}/socket",
            additional_headers={"Origin": f"http://{place}"},
            compression=None,
            max_size=None,
            open_timeout=60,
            proxy=None,
        ) as connection:
            await self._read(connection, dark)

    async def _read(self, connection: ClientConnection, dark: bool) -> None:
        await connection.send(json.dumps({"do": "follow", "dark": dark}))
        async for frame in connection:
            self.n_bytes += len(frame) + _HEAD_BYTES


def _lines() -> Iterator[str]:
    while line := sys.stdin.readline():
        yield line


async def _main(port: int, n_watchers: int) -> None:
    readers = [Reader() for _ in range(n_watchers)]
    # Some devices are dark.
    tasks = [
        asyncio.create_task(reader.read(port, dark=number % 4 == 0))
        for number, reader in enumerate(readers)
    ]
    lines = _lines()
    while (line := await asyncio.to_thread(next, lines, "")) != "":
        before = sum(reader.n_bytes for reader in readers)
        await asyncio.sleep(float(line))
        n_bytes = sum(reader.n_bytes for reader in readers) - before
        n_there = sum(not task.done() for task in tasks)
        sys.stdout.write(json.dumps({"bytes": n_bytes, "watchers": n_there}) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    asyncio.run(_main(int(sys.argv[1]), int(sys.argv[2])))
