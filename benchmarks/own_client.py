"""Phones with a learner of their own: ``python -m benchmarks.own_client PORT N``.

They run in a process of their own, so that what is measured is the lab and not its readers. Each
has its learner learn at the fastest level. For each line on standard input, for how many seconds
they are to tap and how often a second, a line on standard output has the milliseconds that each tap
took until what came of it was there, as JSON. ``begin`` has them learn again, where the lab has
begun something else.
"""

import asyncio
import http.client
import json
import random
import sys
import time
import zlib
from collections.abc import Callable, Iterator
from typing import Any

from websockets.asyncio.client import ClientConnection, connect

_PATIENCE_S = 60.0


class Phone:
    """One of them."""

    def __init__(self) -> None:
        self.connection: ClientConnection | None = None
        self.own: dict[str, Any] = {}
        """How its learner was last said to stand."""
        self.has_come = asyncio.Event()

    async def read(self, port: int, dark: bool) -> None:
        """Have a learner, and take in whatever comes."""
        place = f"127.0.0.1:{port}"
        async with connect(
            f"ws://{place}/socket",
            additional_headers={"Origin": f"http://{place}", "Cookie": await _seat(port)},
            compression=None,
            max_size=None,
            open_timeout=60,
            proxy=None,
        ) as connection:
            self.connection = connection
            await self.say({"do": "own", "dark": dark})
            async for letter in connection:
                assert isinstance(letter, bytes)
                for part in json.loads(zlib.decompress(letter)):
                    if part["kind"] == "own":
                        self.own = part
                self.has_come.set()

    async def say(self, told: dict[str, Any]) -> None:
        assert self.connection is not None
        await self.connection.send(json.dumps(told))

    async def stands(self, condition: Callable[[dict[str, Any]], bool]) -> None:
        """Wait until its learner is said to stand so."""
        while not condition(self.own):
            self.has_come.clear()
            await asyncio.wait_for(self.has_come.wait(), _PATIENCE_S)

    async def begin(self) -> list[float]:
        """Let it learn as fast as it may."""
        await self.stands(lambda own: bool(own.get("controls")) and not own["busy"])
        await self.say({"do": "own_speed", "level": _levels(self.own) - 1})
        await self.say({"do": "own_play", "on": True})
        await self.stands(lambda own: own["playing"])
        return []

    async def tap(self, seconds: float, per_s: float) -> list[float]:
        """Change the speed now and then; returns the milliseconds until that was seen."""
        took_ms: list[float] = []
        until_s = time.perf_counter() + seconds
        fastest = _levels(self.own) - 1
        while (wait_s := random.uniform(0.5, 1.5) / per_s) < until_s - time.perf_counter():
            await asyncio.sleep(wait_s)
            if self.own["controls"][0]["label"] == "Start again":
                await self.say({"do": "own_again"})
                await self.stands(lambda own: own["playing"])
            # There and back, so that it goes on as fast as before.
            for level in (fastest - 1, fastest):
                began_s = time.perf_counter()
                await self.say({"do": "own_speed", "level": level})
                await self.stands(lambda own, level=level: _level(own) == level)
                took_ms.append(1_000 * (time.perf_counter() - began_s))
        return took_ms


def _speed(own: dict[str, Any]) -> dict[str, Any]:
    return next(control for control in own["controls"] if control["control"] == "speed")


def _level(own: dict[str, Any]) -> int:
    return _speed(own)["level"]


def _levels(own: dict[str, Any]) -> int:
    return len(_speed(own)["words"])


async def _seat(port: int) -> str:
    """The cookie of a browser that is new."""

    def asked() -> str:
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=_PATIENCE_S)
        connection.request("GET", "/")
        return (connection.getresponse().headers["Set-Cookie"] or "").partition(";")[0]

    return await asyncio.to_thread(asked)


def _lines() -> Iterator[str]:
    while line := sys.stdin.readline():
        yield line


async def _main(port: int, n_phones: int) -> None:
    phones = [Phone() for _ in range(n_phones)]
    reading = [
        asyncio.create_task(phone.read(port, dark=number % 4 == 0))
        for number, phone in enumerate(phones)
    ]
    await asyncio.gather(*(phone.begin() for phone in phones))
    lines = _lines()
    while (line := await asyncio.to_thread(next, lines, "")) != "":
        if line.strip() == "begin":
            doing = [phone.begin() for phone in phones]
        else:
            seconds, per_s = map(float, line.split())
            doing = [phone.tap(seconds, per_s) for phone in phones]
        took = await asyncio.gather(*doing)
        n_there = sum(not task.done() for task in reading)
        told = {"took_ms": [one for each in took for one in each], "seats": n_there}
        sys.stdout.write(json.dumps(told) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    asyncio.run(_main(int(sys.argv[1]), int(sys.argv[2])))
