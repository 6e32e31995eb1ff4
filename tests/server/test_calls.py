"""Links of a page that call the lab."""

import re
from collections.abc import Iterator
from urllib.parse import quote

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.server.calls import MAX_CALL_CHARACTERS, Calls, address_of
from tests.support.server import OWN, Lab, first_line_for, get_path, lab_of


class Callee:
    """Takes the calls that begin with "take", and notes all."""

    def __init__(self) -> None:
        self.calls: list[str] = []

    def take(self, words: str) -> bool:
        self.calls.append(words)
        if words.startswith("fail"):
            raise ValueError("no such cell\nand more")
        return words.startswith("take")


@pytest.fixture
def callee() -> Callee:
    return Callee()


@pytest.fixture
def called(callee: Callee) -> Iterator[Lab]:
    """A lab that hands its calls to the callee."""
    with lab_of(on_call=callee.take) as lab:
        yield lab


CALLS = (
    ("take", "take"),
    ("take/this/and%20that", "take/this/and that"),
    ("take%2Fthis%2fand+that", "take/this/and+that"),
    ("take%3Fx%23y%25z%26", "take?x#y%z&"),
    ("take%E2%86%92%F0%9F%90%88%CE%B5", "take→🐈ε"),
    ("take%0A%00%5C..%5C..", "take\n\0\\..\\.."),
    ("take/../..//", "take/../..//"),
    ("take?a=query", "take"),
)


@pytest.mark.parametrize(("path", "words"), CALLS)
def test_taken_call_leaves_the_page_where_it_is(
    called: Lab, callee: Callee, path: str, words: str
) -> None:
    answer = get_path(called.port, f"/call/{path}", OWN)
    assert (answer.status, answer.read()) == (204, b"")
    assert callee.calls == [words]
    assert answer.headers["Cache-Control"] == "no-store"
    assert answer.headers["Content-Security-Policy"] == "frame-ancestors 'none'"
    assert answer.headers["X-Frame-Options"] == "DENY"
    assert answer.headers["X-Content-Type-Options"] == "nosniff"
    assert "Content-Length" not in answer.headers
    assert "Content-Type" not in answer.headers


@pytest.mark.parametrize("path", ["other", "", "other/take", "%74ak"])
def test_call_that_is_not_taken_is_not_found(called: Lab, callee: Callee, path: str) -> None:
    answer = get_path(called.port, f"/call/{path}", OWN)
    assert answer.status == 404
    assert len(callee.calls) == 1
    assert answer.headers["Cache-Control"] == "no-store"
    assert answer.headers["X-Frame-Options"] == "DENY"


def test_call_without_a_callee_is_not_found(lab: Lab) -> None:
    assert get_path(lab.port, "/call/take", OWN).status == 404


def test_calls_are_limited_in_length(called: Lab, callee: Callee) -> None:
    # What counts is what arrives: each of these characters makes six of the path.
    longest = "take" + "ε" * (MAX_CALL_CHARACTERS - 4)
    assert get_path(called.port, f"/call/{quote(longest)}", OWN).status == 204
    assert get_path(called.port, f"/call/{quote(longest)}x", OWN).status == 404
    assert callee.calls == [longest]


@pytest.mark.parametrize("path", ["take%FF", "take%C3", "take%ED%A0%80", "take\udcff", "takeε"])
def test_call_that_is_no_text_is_not_found(called: Lab, callee: Callee, path: str) -> None:
    lines = ("Host: localhost", "Sec-Fetch-Site: same-origin")
    line = first_line_for(called.port, f"GET /call/{path} HTTP/1.1", *lines)
    assert line.split()[1] == b"404"
    assert callee.calls == []


@pytest.mark.parametrize("path", ["/call", "/", "/calls/take", "//call/take", "/x/call/take"])
def test_all_other_paths_are_answered_as_before(called: Lab, callee: Callee, path: str) -> None:
    # No header says where it comes from, which only a call has to.
    assert get_path(called.port, path, {}).status == (200 if path == "/" else 404)
    assert callee.calls == []


FOREIGN_CALLERS = (
    {},
    *({"Sec-Fetch-Site": site} for site in ("cross-site", "same-site", "none", "", "Same-Origin")),
    {"Sec-Fetch-Site": "cross-site", "Referer": "http://localhost:{port}/"},
    *(
        {"Referer": referer}
        for referer in (
            "",
            "about:blank",
            "http://evil.example/",
            "http://evil.example/http://localhost:{port}/",
            "http://evil.example/?http://localhost:{port}/",
            "http://evil.example:{port}/",
            "http://localhost/",
            "http://localhost:{other}/",
            "https://localhost/",
            "http://localhost:{port}.evil.example/",
            "http://localhost:{port}@evil.example/",
            "http://evil.example?@localhost:{port}/",
            "//localhost:{port}/",
            "localhost:{port}/",
        )
    ),
    {**OWN, "Origin": "http://evil.example"},
    {**OWN, "Host": "evil.example:{port}"},
    {"Host": "evil.example:{port}", "Referer": "http://evil.example:{port}/"},
)


@pytest.mark.parametrize("headers", FOREIGN_CALLERS, ids=repr)
def test_only_our_own_page_may_call(called: Lab, callee: Callee, headers: dict[str, str]) -> None:
    headers = {"Host": "localhost:{port}", **headers}
    for name, value in headers.items():
        headers[name] = value.format(port=called.port, other=called.port - 1)
    answer = get_path(called.port, "/call/take", headers)
    assert answer.status == 403
    assert callee.calls == []
    assert answer.headers["Cache-Control"] == "no-store"
    assert answer.headers["X-Frame-Options"] == "DENY"


@pytest.mark.parametrize("name", ["Sec-Fetch-Site", "Referer"])
def test_source_of_a_call_must_be_there_once(called: Lab, callee: Callee, name: str) -> None:
    own, foreign = {
        "Sec-Fetch-Site": ("same-origin", "cross-site"),
        "Referer": (f"http://localhost:{called.port}/", "http://evil.example/"),
    }[name]
    lines = ("GET /call/take HTTP/1.1", f"Host: localhost:{called.port}", f"{name}: {own}")
    assert first_line_for(called.port, *lines, f"{name}: {foreign}").split()[1] == b"403"
    assert callee.calls == []
    assert first_line_for(called.port, *lines).split()[1] == b"204"


@pytest.mark.parametrize("page", ["/", "/?fixedDpr=1", "/index.html?a=http://evil.example/"])
def test_referer_tells_where_the_browser_says_nothing_else(called: Lab, page: str) -> None:
    for host, referer in (("127.0.0.1", "localhost"), ("localhost", "localhost")):
        headers = {
            "Host": f"{host}:{called.port}",
            "Referer": f"http://{referer}:{called.port}{page}",
        }
        assert get_path(called.port, "/call/take", headers).status == 204
    forwarded = {"Host": "localhost:9000", "Referer": f"http://localhost:9000{page}"}
    assert get_path(called.port, "/call/take", forwarded).status == 204


def test_network_lab_takes_calls_of_its_own_pages(callee: Callee) -> None:
    with lab_of(host="0.0.0.0", on_call=callee.take) as lab:
        address = f"192.168.7.7:{lab.port}"
        own = {"Host": address, "Referer": f"http://{address}/"}
        assert get_path(lab.port, "/call/take", own).status == 204
        neighbour = own | {"Referer": f"http://192.168.7.8:{lab.port}/"}
        assert get_path(lab.port, "/call/take", neighbour).status == 403
        assert get_path(lab.port, "/call/take", {"Host": address}).status == 403
    assert callee.calls == ["take"]


@pytest.mark.parametrize("method", ["POST", "HEAD", "PUT", "OPTIONS", "get"])
def test_only_get_calls(called: Lab, callee: Callee, method: str) -> None:
    lines = ("Host: localhost", "Sec-Fetch-Site: same-origin")
    line = first_line_for(called.port, f"{method} /call/take HTTP/1.1", *lines)
    assert b"204" not in line
    assert get_path(called.port, "/call/take/again", OWN).status == 204
    assert callee.calls == ["take/again"]


@pytest.mark.usefixtures("no_traceback")
def test_failing_call_is_logged_and_the_server_goes_on(
    called: Lab, caplog: pytest.LogCaptureFixture
) -> None:
    page, _ = called.page()
    for _ in range(2):
        answer = get_path(called.port, "/call/fail", OWN)
        assert answer.status == 500
        assert b"cell" not in answer.read()
        assert answer.headers["Cache-Control"] == "no-store"
    assert [record.getMessage() for record in caplog.records if record.levelname == "ERROR"] == [
        "Callee.take failed: ValueError: no such cell"
    ] * 2
    assert get_path(called.port, "/call/take", OWN).status == 204
    assert called.hears(page)


def test_each_secret_has_a_taker_of_its_own_until_it_leaves() -> None:
    calls = Calls()
    heard: list[tuple[str, str]] = []
    first = calls.enter(lambda words: heard.append(("first", words)))
    second = calls.enter(lambda words: heard.append(("second", words)))
    with lab_of(on_call=calls.take) as lab:

        def status(address: str) -> int:
            return get_path(lab.port, f"/{address}", OWN).status

        assert status(address_of(first, "cell 3/4")) == 204
        assert status(address_of(second, "ε?#%")) == 204
        assert status(address_of(second, "")) == 204
        assert status(f"call/{second}") == 204
        assert heard == [
            ("first", "cell 3/4"),
            ("second", "ε?#%"),
            ("second", ""),
            ("second", ""),
        ]
        heard.clear()
        calls.leave(first)
        calls.leave(first)
        calls.leave("never entered")
        assert status(address_of(first, "cell 3/4")) == 404
        assert status(address_of("", "cell 3/4")) == 404
        assert status(address_of(second[:-1], "cell 3/4")) == 404
        assert heard == []
        assert status(address_of(second, "cell 3/4")) == 204
        assert heard == [("second", "cell 3/4")]


def test_secrets_cannot_be_guessed() -> None:
    calls = Calls()
    entered = {calls.enter(print) for _ in range(1_000)}
    assert len(entered) == 1_000
    # 128 bits in characters of six bits each.
    assert all(re.fullmatch(r"[A-Za-z0-9_-]{22}", secret) for secret in entered)


@pytest.fixture(scope="module")
def switchboard() -> Iterator[tuple[Lab, Calls]]:
    calls = Calls()
    with lab_of(on_call=calls.take) as lab:
        yield lab, calls


MAX_WORDS = MAX_CALL_CHARACTERS - 23
"""What a secret and its slash leave."""


@given(words=st.text(max_size=MAX_WORDS).filter(lambda words: words not in (".", "..")))
def test_any_words_arrive(switchboard: tuple[Lab, Calls], words: str) -> None:
    lab, calls = switchboard
    heard: list[str] = []
    secret = calls.enter(heard.append)
    address = address_of(secret, words)
    assert re.fullmatch(r"call/[\w-]{22}/[\w.~%-]*", address, re.ASCII)
    assert get_path(lab.port, f"/{address}", OWN).status == 204
    assert heard == [words]
    calls.leave(secret)


@pytest.mark.parametrize("words", [".", "..", "x" * (MAX_WORDS + 1)])
def test_words_that_cannot_arrive_have_no_address(words: str) -> None:
    with pytest.raises(ValueError, match=r"cannot be called|at most 512"):
        address_of(Calls().enter(print), words)


def test_longest_words_have_an_address(switchboard: tuple[Lab, Calls]) -> None:
    lab, calls = switchboard
    # Each of these characters makes twelve of the address.
    address = address_of(calls.enter(lambda words: None), "🐈" * MAX_WORDS)
    assert get_path(lab.port, f"/{address}", OWN).status == 204
