"""A channel between the lab and the page in a browser's frame, and who is kept out of it."""

import contextlib
import queue
import random
import socket
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest
import websockets.sync.client
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.frames import CloseCode

from app.server import channels
from app.server.access import Access
from app.server.channels import MAX_MESSAGE_BYTES, MOST_AT_ONCE, REPLACED, Channel, Channels
from tests.support.server import OWN, PATIENCE_S, Lab, Page, get_path, lab_of

TOKEN = "correct-horse-battery"


class Seek(msgspec.Struct, tag_field="do", tag="seek", forbid_unknown_fields=True):
    """A message with something in it."""

    step: int


class Pause(msgspec.Struct, tag_field="do", tag="pause", forbid_unknown_fields=True):
    """A message that says no more than that."""


class Frame:
    """The page of a frame, as far as the server can tell."""

    def __init__(
        self, port: int, address: str, headers: dict[str, str] | None = None, **options: Any
    ) -> None:
        given = {"Origin": f"http://127.0.0.1:{port}"} | (headers or {})
        self.socket = websockets.sync.client.connect(
            f"ws://127.0.0.1:{port}/{address}socket",
            sock=socket.create_connection(("127.0.0.1", port)),
            additional_headers={name: value for name, value in given.items() if value},
            user_agent_header=None,
            open_timeout=PATIENCE_S,
            ping_interval=None,
            **options,
        )

    def send(self, message: dict[str, Any]) -> None:
        self.socket.send(msgspec.json.encode(message).decode())

    def receive(self) -> dict[str, Any]:
        return msgspec.json.decode(self.socket.recv(timeout=PATIENCE_S))

    def close_code(self) -> int:
        """The code with which the server ends this connection."""
        with pytest.raises(ConnectionClosed) as closed:
            self.socket.recv(timeout=PATIENCE_S)
        assert closed.value.rcvd is not None
        return closed.value.rcvd.code

    def close(self) -> None:
        self.socket.close()


class Host:
    """A lab with the channel of one browser, and the frames that were opened."""

    def __init__(self, lab: Lab, channels: Channels) -> None:
        self.lab, self.channels = lab, channels
        self.taken: queue.Queue[Seek | Pause] = queue.Queue()
        self.opened: queue.Queue[None] = queue.Queue()
        self.channel: Channel = channels.enter(
            Seek | Pause, self.taken.put, lambda: self.opened.put(None)
        )
        self.frames: list[Frame] = []

    def frame(self, headers: dict[str, str] | None = None, **options: Any) -> Frame:
        """A frame that is connected."""
        frame = Frame(self.lab.port, self.channel.address, headers, **options)
        self.frames.append(frame)
        self.opened.get(timeout=PATIENCE_S)
        return frame

    def refusal(self, address: str | None = None, **headers: str) -> int:
        """With which status a websocket is kept out."""
        with pytest.raises(InvalidStatus) as refused:
            Frame(self.lab.port, address or self.channel.address, headers)
        return refused.value.response.status_code

    def hears(self, frame: Frame) -> bool:
        """Whether a message is taken, and nothing that came before it."""
        frame.send({"do": "seek", "step": 123})
        return self.taken.get(timeout=PATIENCE_S) == Seek(123)


@pytest.fixture
def host() -> Iterator[Host]:
    channels = Channels()
    with lab_of(channels=channels) as lab:
        host = Host(lab, channels)
        yield host
        for frame in host.frames:
            frame.close()


def test_messages_go_both_ways(host: Host) -> None:
    assert not host.channel.is_open
    frame = host.frame()
    assert host.channel.is_open
    frame.send({"do": "seek", "step": 12})
    frame.send({"do": "pause"})
    assert host.taken.get(timeout=PATIENCE_S) == Seek(12)
    assert host.taken.get(timeout=PATIENCE_S) == Pause()
    host.channel.send("bar", {"trials": [1, 2], "text": msgspec.Raw(b'"as it is"')})
    assert frame.receive() == {"kind": "bar", "trials": [1, 2], "text": "as it is"}


def test_what_is_said_before_anybody_listens_is_not_lost(host: Host) -> None:
    for number in range(3):
        host.channel.send("said", {"number": number})
        host.channel.send("bar", {"number": number})
    frame = host.frame()
    assert [frame.receive() for _ in range(2)] == [
        {"kind": "said", "number": 2},
        {"kind": "bar", "number": 2},
    ]


def test_what_has_not_gone_out_yet_waits(host: Host) -> None:
    assert not host.channel.waits("bar")
    host.channel.send("bar", {"newest": True})
    assert host.channel.waits("bar")
    assert not host.channel.waits("moment")
    host.frame().receive()
    assert not host.channel.waits("bar")


def test_a_frame_that_comes_back_is_told_from_the_beginning(host: Host) -> None:
    host.frame().close()
    frame = host.frame()
    assert host.hears(frame)


def test_types_that_take_unknown_fields_are_refused() -> None:
    class Open(msgspec.Struct, tag="open"):
        pass

    with pytest.raises(TypeError, match="Open"):
        Channels().enter(Seek | Open, print, print)


# Who is kept out.


def test_only_a_page_of_ours_is_let_in(host: Host) -> None:
    own = f"http://127.0.0.1:{host.lab.port}"
    foreign = ("", "null", "https://evil.example", f"{own}.evil.example", f"{own[:-1]}", "x")
    assert {host.refusal(Origin=origin) for origin in foreign} == {403}
    assert host.refusal(Host="evil.example", Origin="http://evil.example") == 403
    assert host.hears(host.frame())


def test_only_who_knows_the_secret_is_let_in(host: Host) -> None:
    address = host.channel.address
    other_case = address.swapcase().replace("TIME", "time")
    for wrong in ("time/", "time//", "time/x/", address[:-2] + "/", other_case, f"{address}x/"):
        assert host.refusal(wrong) == 404
        assert get_path(host.lab.port, f"/{wrong}", {}).status == 404
    # Without the slash the page would look for its files in another folder.
    assert get_path(host.lab.port, f"/{address[:-1]}", {}).status == 404
    assert get_path(host.lab.port, f"/{address}index.html", {}).status == 404


def test_nothing_is_left_of_a_browser_that_has_gone(host: Host) -> None:
    frame = host.frame()
    host.channel.leave()
    assert frame.close_code() == CloseCode.GOING_AWAY
    assert host.refusal() == 404
    assert get_path(host.lab.port, f"/{host.channel.address}", {}).status == 404
    assert not host.channel.is_open
    # Nothing comes of what is sent all the same.
    host.channel.send("bar", {})
    host.channel.leave()


def test_secrets_are_long_and_of_one_browser_each(host: Host) -> None:
    other = host.channels.enter(Pause, print, lambda: None)
    assert len({other.address, host.channel.address}) == 2
    assert all(len(address) > 25 for address in (other.address, host.channel.address))
    frame = Frame(host.lab.port, other.address)
    host.channel.send("bar", {"mine": 1})
    other.send("bar", {"mine": 2})
    assert frame.receive()["mine"] == 2
    frame.close()


def test_each_page_of_a_browser_has_an_address_of_its_own_kind(host: Host) -> None:
    side = host.channels.enter(Pause, print, lambda: None, page="side")
    assert side.address.startswith("side/")
    assert side.frame_html("Runs").startswith('<iframe class="pounce-side"')
    answer = get_path(host.lab.port, f"/{side.address}", {})
    assert answer.status == 200
    assert b"../../web/side/frame.js" in answer.read()
    # Neither is found where the other is.
    for wrong in (
        side.address.replace("side/", "time/"),
        host.channel.address.replace("time/", "side/"),
    ):
        assert get_path(host.lab.port, f"/{wrong}", {}).status == 404
        assert host.refusal(wrong) == 404
    frame = Frame(host.lab.port, side.address)
    side.send("bar", {"mine": 1})
    assert frame.receive()["mine"] == 1
    frame.close()
    side.leave()
    assert get_path(host.lab.port, f"/{side.address}", {}).status == 404


def test_page_and_websocket_want_the_token() -> None:
    channels = Channels()
    with lab_of(channels=channels, access=Access(TOKEN)) as lab:
        host = Host(lab, channels)
        path = f"/{host.channel.address}"
        assert host.refusal() == 401
        assert host.refusal(Cookie=f"pounce-{lab.port}=x") == 401
        assert get_path(lab.port, path, {}).status == 401
        answer = get_path(lab.port, f"/?token={TOKEN}", {})
        cookie = answer.headers["Set-Cookie"].partition(";")[0]
        answer.read()
        assert get_path(lab.port, path, {"Cookie": cookie}).status == 200
        assert host.refusal(Cookie=cookie, Origin="") == 403
        frame = host.frame({"Cookie": cookie})
        assert host.hears(frame)
        frame.close()


def test_only_the_page_of_a_channel_may_be_framed_and_by_ours_alone(host: Host) -> None:
    answer = get_path(host.lab.port, f"/{host.channel.address}?x", {})
    assert answer.status == 200
    assert b"../../web/time/frame.js" in answer.read()
    policy = answer.headers.get_all("Content-Security-Policy")
    assert policy is not None
    assert [rule for rule in policy[0].split("; ") if rule.startswith("frame-anc")] == [
        "frame-ancestors 'self'"
    ]
    assert "default-src 'none'" in policy[0]
    assert "unsafe" not in policy[0]
    assert answer.headers.get_all("X-Frame-Options") == ["SAMEORIGIN"]
    assert answer.headers["Cache-Control"] == "no-store"
    assert answer.headers["X-Content-Type-Options"] == "nosniff"
    for path in (
        "/",
        "/web/lab.js",
        "/web/time/frame.js",
        "/time/x/",
        "/time/",
        "/why",
        "/nothing",
    ):
        answer = get_path(host.lab.port, path, OWN)
        assert answer.headers.get_all("Content-Security-Policy") == ["frame-ancestors 'none'"], path
        assert answer.headers.get_all("X-Frame-Options") == ["DENY"], path


def test_frames_take_no_room_from_pages() -> None:
    channels = Channels()
    with lab_of(channels=channels, max_clients=1) as lab:
        frames = [host.frame() for host in (Host(lab, channels) for _ in range(3))]
        page, _ = lab.page()
        assert lab.hears(page)
        with pytest.raises(InvalidStatus) as refused:
            Page(lab.port)
        assert refused.value.response.status_code == 503
        for frame in frames:
            frame.close()


# What a page may send.


@pytest.mark.usefixtures("no_traceback")
def test_the_newest_connection_of_a_frame_is_the_only_one(host: Host) -> None:
    frames = [host.frame() for _ in range(20)]
    assert {frame.close_code() for frame in frames[:-1]} == {REPLACED}
    host.channel.send("bar", {"number": 1})
    assert frames[-1].receive() == {"kind": "bar", "number": 1}
    assert host.hears(frames[-1])


DEEP = MAX_MESSAGE_BYTES // 2
SENSELESS = {
    "nothing": "",
    "no JSON": "seek",
    "no object": "[1, 2]",
    "no tag": '{"step": 1}',
    "unknown": '{"do": "erase"}',
    "too little": '{"do": "seek"}',
    "too much": '{"do": "pause", "step": 1}',
    "wrong type": '{"do": "seek", "step": "1"}',
    "no whole number": '{"do": "seek", "step": 1.5}',
    "no number": '{"do": "seek", "step": NaN}',
    "too large a number": '{"do": "seek", "step": 1e999}',
    "two messages": '{"do": "pause"}{"do": "pause"}',
    "deep": "[" * DEEP + "]" * DEEP,
    "deep within": '{"do": "seek", "step": ' + '{"a":' * 600,
    "deep where it is skipped": '{"do": "seek", "x": ' + "[" * DEEP,
    "half a letter": '{"do": "\\ud800"}',
    "bytes": b'{"do": "pause"}',
}


@pytest.mark.usefixtures("no_traceback")
@pytest.mark.parametrize("message", SENSELESS.values(), ids=SENSELESS)
def test_what_makes_no_sense_is_dropped(host: Host, message: str | bytes) -> None:
    frame = host.frame()
    frame.socket.send(message)
    assert host.hears(frame)
    assert host.channel.n_dropped == 1


@pytest.mark.usefixtures("no_traceback")
@pytest.mark.parametrize("in_parts", [False, True])
def test_a_huge_message_ends_its_connection_alone(host: Host, in_parts: bool) -> None:
    page, _ = host.lab.page()
    frame = host.frame()
    part = '{"do": "seek", "step": 1}'.ljust(MAX_MESSAGE_BYTES // 4)
    # It may end before the last part is on its way.
    with contextlib.suppress(ConnectionClosed):
        frame.socket.send([part] * 5 if in_parts else part * 5)
    assert frame.close_code() == CloseCode.MESSAGE_TOO_BIG
    # One of the largest size is read, and packed ones are as large as what is in them.
    frame = host.frame()
    frame.socket.send('{"do": "seek", "step": 1}'.ljust(MAX_MESSAGE_BYTES))
    assert host.taken.get(timeout=PATIENCE_S) == Seek(1)
    assert host.hears(frame)
    assert host.lab.hears(page)


@pytest.mark.usefixtures("no_traceback")
def test_a_text_that_is_none_ends_its_connection_alone(host: Host) -> None:
    frame = host.frame()
    frame.socket.send(b'{"do": "\xff"}', text=True)
    assert frame.close_code() == CloseCode.INVALID_DATA
    assert host.hears(host.frame())


def test_pings_are_answered(host: Host) -> None:
    assert host.frame().socket.ping().wait(PATIENCE_S)


def test_too_many_messages_are_dropped_and_counted(
    host: Host, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(channels, "MESSAGES_PER_S", 0.0)
    frame = host.frame()
    for step in range(MOST_AT_ONCE + 30):
        frame.send({"do": "seek", "step": step})
    # Behind them all.
    assert frame.socket.ping().wait(PATIENCE_S)
    taken = [host.taken.get(timeout=PATIENCE_S) for _ in range(MOST_AT_ONCE)]
    assert taken == [Seek(step) for step in range(MOST_AT_ONCE)]
    frame.close()
    assert host.hears(host.frame())
    assert host.channel.n_dropped == 30


def test_whoever_fails_to_take_a_message_takes_the_next(
    host: Host, caplog: pytest.LogCaptureFixture, no_traceback: None
) -> None:
    def fail(message: Pause) -> None:
        raise ValueError("no use for it")

    channel = host.channels.enter(Pause, fail, lambda: 1 // 0)
    frame = Frame(host.lab.port, channel.address)
    frame.send({"do": "pause"})
    channel.send("bar", {})
    assert frame.receive() == {"kind": "bar"}
    frame.close()
    assert host.hears(host.frame())
    said = "\n".join(record.getMessage() for record in caplog.records)
    assert "ZeroDivisionError" in said
    assert "no use for it" in said


def test_a_slow_reader_is_sent_the_newest_and_nothing_in_between(host: Host) -> None:
    # It takes the next message from the network when the one before has been read.
    frame = host.frame(max_queue=1)
    large = "x" * 100_000
    last = 500
    for number in range(last + 1):
        host.channel.send("bar", {"number": number, "large": large})
        host.channel.send("moment", {"number": number})
    numbers: dict[str, list[int]] = {"bar": [], "moment": []}
    while not all(found[-1:] == [last] for found in numbers.values()):
        message = frame.receive()
        numbers[message["kind"]].append(message["number"])
    assert all(len(found) < 20 for found in numbers.values())
    assert all(found == sorted(found) for found in numbers.values())
    assert host.hears(frame)


def hostile(chance: random.Random) -> str | bytes:
    """Some message that a stranger might send."""
    text = chance.choice(
        [
            '{"do": "seek", "step": 5}',
            '{"do": "pause"}',
            '{"do": "seek", "step": -9223372036854775809}',
            '{"do": "seek", "do": "pause", "step": 1, "step": 2}',
            '{"do": {"do": []}}',
            "{}",
            "null",
            '"' + "\\u0000" * 600 + '"',
            "9" * 4_000,
            "[" * chance.randrange(4_000),
            '{"":' * chance.randrange(900),
        ]
    )
    match chance.randrange(5):
        case 0:
            return text
        case 1:
            place = chance.randrange(len(text) + 1)
            return text[:place] + chr(chance.randrange(0x80)) + text[place + 1 :]
        case 2:
            return text.encode()[: chance.randrange(len(text) + 1)]
        case 3:
            return chance.randbytes(chance.randrange(200))
        case _:
            return text * chance.randrange(1, 4)


@pytest.mark.usefixtures("no_traceback")
def test_three_hundred_hostile_messages_harm_nobody(
    host: Host, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(channels, "MESSAGES_PER_S", 1e9)
    page, _ = host.lab.page()
    chance = random.Random(12)
    frame = host.frame()
    for _ in range(300):
        frame.socket.send(hostile(chance)[:MAX_MESSAGE_BYTES])
    frame.send({"do": "seek", "step": 77})
    while host.taken.get(timeout=PATIENCE_S) != Seek(77):
        pass
    assert host.lab.hears(page)
    assert host.channel.n_dropped > 100
