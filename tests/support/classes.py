"""A class: so many seats that look at a port and answer, all of them in one thread."""

import asyncio
import contextlib
import http.client
import threading
import zlib
from collections.abc import Callable, Coroutine, Mapping
from typing import Any, Final

import msgspec
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from tests.support.server import PATIENCE_S

Parts = dict[str, dict[str, Any]]


HERE: Final = "127.0.0.1"


def cookies_of(port: int, code: str | None = None, source: str = HERE) -> str:
    """What a browser's cookies are once it has opened the page."""
    cookies: list[str] = []
    for path in ([f"/?token={code}"] if code else []) + ["/"]:
        connection = http.client.HTTPConnection(
            HERE, port, timeout=PATIENCE_S, source_address=(source, 0)
        )
        connection.request("GET", path, headers={"Cookie": "; ".join(cookies)})
        answer = connection.getresponse()
        answer.read()
        cookies += [
            value.partition(";")[0]
            for name, value in answer.getheaders()
            if name.lower() == "set-cookie"
        ]
        connection.close()
    return "; ".join(cookies)


class Pupil:
    """A page at a seat: what came last of each kind, and its connection."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.parts: Parts = {}
        self.reading: asyncio.Task[None] | None = None

    @property
    def seat(self) -> Mapping[str, Any] | None:
        """Number and shape."""
        return self.parts["seat"]["seat"]

    @property
    def ballot(self) -> int | None:
        """The question that is open."""
        ask = self.parts.get("lesson", {}).get("ask")
        return None if ask is None or not ask["open"] else ask["ballot"]


class Pupils:
    """So many pages, each with a cookie of its own unless some are given."""

    def __init__(
        self,
        port: int,
        n: int = 1,
        code: str | None = None,
        cookies: list[str] | None = None,
        source: str = HERE,
    ) -> None:
        """They come from the address ``source``."""
        self._port, self._source = port, source
        self._changed = threading.Condition()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="pupils", daemon=True)
        self._thread.start()
        self.cookies = cookies or [cookies_of(port, code, source) for _ in range(n)]
        self.all: list[Pupil] = []
        for cookie in self.cookies:
            self.all.append(self._run(self._come(cookie)))
        self.wait_for(lambda pupil: {"seat", "lesson"} <= pupil.parts.keys())

    def send(self, texts: Callable[[int], str | bytes | None]) -> None:
        """Have each send a message, or none, all at once."""
        sent = [(pupil, texts(n)) for n, pupil in enumerate(self.all)]
        self._run(_all(pupil.connection.send(text) for pupil, text in sent if text is not None))

    def answer(self, value_of: Callable[[int], Any]) -> None:
        """Have each answer what is open, or not if that is None; and wait until it counts."""
        self.wait_for(lambda pupil: pupil.ballot is not None)
        values = [value_of(n) for n in range(len(self.all))]
        ballots = [pupil.ballot for pupil in self.all]

        def text(n: int) -> str | None:
            told = {"do": "answer", "ballot": ballots[n], "value": values[n]}
            return None if values[n] is None else msgspec.json.encode(told).decode()

        self.send(text)
        for pupil, value in zip(self.all, values, strict=True):
            if value is not None:
                self.until(lambda pupil=pupil: pupil.parts["seat"]["answer"] is not None)

    def wait_for(self, condition: Callable[[Pupil], bool]) -> None:
        """Wait until that is so of each."""
        self.until(lambda: all(map(condition, self.all)))

    def until(self, condition: Callable[[], bool]) -> None:
        """Wait until that is so."""
        with self._changed:
            assert self._changed.wait_for(condition, PATIENCE_S)

    def close(self) -> None:
        """Leave."""
        self._run(self._leave())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(PATIENCE_S)
        self._loop.close()

    def _run(self, work: Coroutine[Any, Any, Any]) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(PATIENCE_S)

    async def _come(self, cookie: str) -> Pupil:
        place = f"127.0.0.1:{self._port}"
        connection = await connect(
            f"ws://{place}/socket",
            additional_headers={"Origin": f"http://{place}", "Cookie": cookie},
            compression=None,
            max_size=None,
            proxy=None,
            open_timeout=PATIENCE_S,
            ping_interval=None,
            local_addr=(self._source, 0),
        )
        await connection.send('{"do": "follow", "dark": false}')
        pupil = Pupil(connection)
        pupil.reading = asyncio.create_task(self._read(pupil))
        return pupil

    async def _leave(self) -> None:
        for pupil in self.all:
            # Whether or not anybody listens any more.
            pupil.connection.transport.abort()
        await asyncio.gather(*(pupil.reading for pupil in self.all if pupil.reading is not None))

    async def _read(self, pupil: Pupil) -> None:
        with contextlib.suppress(ConnectionClosed):
            async for letter in pupil.connection:
                assert isinstance(letter, bytes)
                parts = msgspec.json.decode(zlib.decompress(letter))
                with self._changed:
                    pupil.parts |= {part["kind"]: part for part in parts}
                    self._changed.notify_all()


async def _all(works: Any) -> None:
    await asyncio.gather(*works)
