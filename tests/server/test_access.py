"""The token of a lab on the network."""

import logging
import re
from collections.abc import Iterator
from urllib.parse import urljoin

import pytest
from websockets.exceptions import InvalidStatus

from app.server import access
from app.server.access import MAX_GUESSES, Access, is_token, new_token
from tests.support.server import OWN, Lab, Page, first_line_for, get, get_path, lab_of

TOKEN = "correct-horse-battery"


@pytest.fixture
def locked() -> Iterator[Lab]:
    """A lab that wants a token."""
    with lab_of(access=Access(TOKEN), on_call=lambda words: True) as lab:
        yield lab


def cookie_of(lab: Lab, question: str = f"?token={TOKEN}") -> str:
    """What a browser gives back that came with the token."""
    answer = get_path(lab.port, f"/{question}", {})
    assert answer.status == 303
    return answer.headers["Set-Cookie"].partition(";")[0]


PATHS = ("/", "/index.html", "/?fixedDpr=1", "/web/lab.js", "/call/x", "/nothing", "/?token=")


@pytest.mark.parametrize("path", PATHS)
def test_nothing_is_served_without_the_token(locked: Lab, path: str) -> None:
    for headers in ({}, {"Cookie": f"pounce-{locked.port}="}, {"Cookie": f"other={TOKEN}"}):
        answer = get_path(locked.port, path, {**OWN, **headers})
        assert answer.status == 401
        text = answer.read()
        assert b"viser" not in text.lower()
        assert TOKEN.encode() not in text


@pytest.mark.parametrize("given", [{}, {"Cookie": "pounce-8080=x"}, {"Origin": "{own}"}])
def test_no_websocket_opens_without_the_token(locked: Lab, given: dict[str, str]) -> None:
    headers = {
        name: value.format(own=f"http://127.0.0.1:{locked.port}") for name, value in given.items()
    }
    with pytest.raises(InvalidStatus) as refusal:
        Page(locked.port, additional_headers=headers)
    assert refusal.value.response.status_code == 401


def test_the_token_comes_once_and_is_a_cookie_from_then_on(locked: Lab) -> None:
    answer = get_path(locked.port, f"/?token={TOKEN}&fixedDpr=1&a=%26%22", {})
    assert answer.status == 303
    place = urljoin("http://host/lab/?token=x", answer.headers["Location"])
    assert place == "http://host/lab/?fixedDpr=1&a=%26%22"
    cookie, *attributes = answer.headers["Set-Cookie"].split("; ")
    assert set(attributes) == {"HttpOnly", "SameSite=Lax"}
    assert cookie.startswith(f"pounce-{locked.port}=")
    assert TOKEN not in cookie
    for path in ("/", "/web/lab.js"):
        assert get_path(locked.port, path, {"Cookie": f"a=b; {cookie};c"}).status == 200
    assert get_path(locked.port, "/call/x", {"Cookie": cookie, **OWN}).status == 204
    Page(locked.port, additional_headers={"Cookie": cookie}).close()


def test_the_token_does_not_stand_for_the_origin(locked: Lab) -> None:
    own = {"Cookie": cookie_of(locked)}
    assert get_path(locked.port, "/", {**own, "Host": "evil.example"}).status == 403
    assert get_path(locked.port, "/", {**own, "Origin": "http://evil.example"}).status == 403
    assert get_path(locked.port, "/call/x", own).status == 403


def test_a_person_without_the_token_gets_a_form_for_it(locked: Lab) -> None:
    question = "?token=nonsense-nonsense&fixedDpr=1&a=%22%3E%3Cscript%3E"
    answer = get_path(locked.port, f"/{question}", {"Accept": "text/html"})
    assert answer.status == 401
    text = answer.read().decode()
    assert "That is not the token" in text
    assert re.search(r'<form method="get">.*name="token".*</form>', text)
    assert '<input type="hidden" name="fixedDpr" value="1" />' in text
    assert "<script" not in text
    assert "nonsense" not in text
    assert "Referrer-Policy" in answer.headers


def test_a_question_that_is_no_text_is_refused_like_any_other(locked: Lab) -> None:
    line = "GET /?a=\udcff&%ff=%ed%a0%80 HTTP/1.1"
    lines = ("Host: localhost", "Accept: text/html")
    assert b"401" in first_line_for(locked.port, line, *lines)
    assert b"303" in first_line_for(locked.port, line.replace("?", f"?token={TOKEN}&"), *lines)


def test_guesses_are_few_and_those_who_are_in_stay_in(
    locked: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    cookie = cookie_of(locked)

    def status(token: str) -> int:
        return get_path(locked.port, f"/?token={token}", {}).status

    # The same again is no further guess: a page that was left open asks and asks.
    assert {status("the-token-of-yesterday") for _ in range(MAX_GUESSES + 5)} == {401}
    statuses = [status(f"guess-{guess}") for guess in range(MAX_GUESSES)]
    assert statuses == [401] * (MAX_GUESSES - 2) + [429] * 2
    assert status(TOKEN) == 429
    assert get_path(locked.port, "/", {"Cookie": cookie}).status == 200
    monkeypatch.setattr(access, "WINDOW_S", 0.0)
    assert status(TOKEN) == 303


def test_an_address_for_a_program_is_good_once() -> None:
    lock = Access(TOKEN)
    with lab_of(access=lock) as lab:
        question = lock.question_for_once()
        assert TOKEN not in question
        cookie = cookie_of(lab, question)
        assert get_path(lab.port, "/", {"Cookie": cookie}).status == 200
        assert get_path(lab.port, f"/{question}", {}).status == 401


def test_a_page_is_told_that_it_lacks_the_token(locked: Lab) -> None:
    origin = f"http://127.0.0.1:{locked.port}"
    answer = get_path(locked.port, f"/why?origin={origin}", {})
    assert answer.status == 200
    assert "This lab wants its token" in answer.read().decode()
    own = {"Cookie": cookie_of(locked)}
    assert get_path(locked.port, f"/why?origin={origin}", own).status == 204


def test_the_token_is_in_no_log(locked: Lab, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG)
    cookie = cookie_of(locked)
    get_path(locked.port, f"/nothing?token={TOKEN}", {"Cookie": cookie})
    get(locked.port, Host="evil.example", Referer=f"http://evil.example/?token={TOKEN}")
    get_path(locked.port, f"/?a=1&token={TOKEN}&b", {"Content-Length": "3"})
    # What it asks for is part of what is wrong with it.
    assert b"400" in first_line_for(locked.port, f"GET /?token={TOKEN} HTTP/1.0")
    said = "\n".join(record.getMessage() for record in caplog.records)
    assert "HTTP/1.0" in said
    assert TOKEN not in said
    assert cookie not in said


def test_tokens_are_long_and_plain() -> None:
    assert len({new_token() for _ in range(100)}) == 100
    assert is_token(new_token())
    assert is_token("a" * 12)
    assert not any(map(is_token, ("a" * 11, "a" * 201, "a" * 12 + " ", "a;b" * 5, "ä" * 12, "")))
