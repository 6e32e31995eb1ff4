"""Links that hold a session: who is let in by them, and how little they do by themselves."""

from collections.abc import Iterator
from urllib.parse import parse_qs, urljoin, urlsplit

import pytest

from app.server.access import Access
from app.server.links import Links, address_of_link
from tests.support.server import Lab, first_line_for, get_path, lab_of

TOKEN = "correct-horse-battery"
CODE = "eNq_-0" * 300
WHOLE = 2_000


def is_whole(code: str) -> bool:
    return 0 < len(code) <= WHOLE and code.replace("-", "").replace("_", "").isalnum()


@pytest.fixture
def links() -> Links:
    return Links(is_whole)


@pytest.fixture
def lab(links: Links) -> Iterator[Lab]:
    with lab_of(links=links) as lab:
        yield lab


@pytest.fixture
def locked(links: Links) -> Iterator[Lab]:
    """A lab that wants a token."""
    with lab_of(links=links, access=Access(TOKEN)) as lab:
        yield lab


def question_of(location: str, path: str) -> dict[str, list[str]]:
    """What a browser asks for next, below a path as well; it is the lab's own page."""
    place = urlsplit(urljoin(f"https://host/below/{path}", location))
    assert (place.netloc, place.path) == ("host", "/below/")
    return parse_qs(place.query, keep_blank_values=True)


def test_a_link_leads_to_the_page_with_a_ticket_that_is_good_for_once(
    lab: Lab, links: Links
) -> None:
    path = f"{address_of_link(CODE)}?fixedDpr=1&shared=x&a=%26%22"
    answer = get_path(lab.port, f"/{path}", {})
    assert (answer.status, answer.headers["Cache-Control"]) == (303, "no-store")
    question = question_of(answer.headers["Location"], path)
    (ticket,) = question.pop("shared")
    assert question == {"fixedDpr": ["1"], "a": ['&"']}
    assert CODE not in answer.headers["Location"]
    assert links.take(ticket) == CODE
    assert links.take(ticket) is None
    assert links.take("x") is None


@pytest.mark.parametrize(
    "code", ["", "a b", "%2e%2e", "../web/lab.js", "a/b", "a" * (WHOLE + 1), "a.b", "<script>", "%"]
)
def test_what_is_no_whole_link_is_said_and_kept_nowhere(lab: Lab, links: Links, code: str) -> None:
    path = f"/s/{code}".replace(" ", "%20")
    answer = get_path(lab.port, path, {"Accept": "text/html"})
    assert answer.status == 404
    text = answer.read().decode()
    assert "This link to a session is not whole." in text
    assert "<script" not in text
    assert len(links) == 0


def test_an_address_that_is_longer_than_any_is_not_read(lab: Lab) -> None:
    line = first_line_for(
        lab.port, f"GET /s/{'a' * 20_000} HTTP/1.1", f"Host: 127.0.0.1:{lab.port}"
    )
    assert b" 200 " not in line
    assert get_path(lab.port, "/", {}).status == 200


def test_of_links_that_nobody_asks_for_the_newest_are_kept(lab: Lab, links: Links) -> None:
    first = links.keep("first")
    tickets = [links.keep(f"code{number}") for number in range(32)]
    assert links.take(first) is None
    assert links.take(tickets[0]) == "code0"


def test_without_the_token_a_link_opens_nothing(locked: Lab, links: Links) -> None:
    path = f"/s/{CODE}"
    answer = get_path(locked.port, path, {"Accept": "text/html"})
    assert answer.status == 401
    assert b'name="token"' in answer.read()
    assert get_path(locked.port, f"{path}?token=nonsense-nonsense", {}).status == 401
    assert len(links) == 0


def test_with_the_token_it_leads_to_the_page_that_keeps_it(locked: Lab, links: Links) -> None:
    path = f"/s/{CODE}?token={TOKEN}"
    answer = get_path(locked.port, path, {})
    assert answer.status == 303
    # A cookie that came here would be of this folder alone.
    assert "Set-Cookie" not in answer.headers
    question = question_of(answer.headers["Location"], path[1:])
    assert question["token"] == [TOKEN]
    page = get_path(locked.port, f"/{answer.headers['Location'].removeprefix('../')}", {})
    assert page.status == 303
    cookie = page.headers["Set-Cookie"].partition(";")[0]
    (ticket,) = question["shared"]
    assert page.headers["Location"] == f"?shared={ticket}"
    again = get_path(locked.port, f"/s/{CODE}", {"Cookie": cookie})
    assert "token" not in again.headers["Location"]
    assert links.take(ticket) == CODE


def test_a_stranger_and_a_page_of_another_site_are_refused(lab: Lab, links: Links) -> None:
    for headers in ({"Host": "evil.example"}, {"Origin": "http://evil.example"}):
        assert get_path(lab.port, f"/s/{CODE}", headers).status == 403
    assert len(links) == 0


def test_a_server_that_takes_none_has_none() -> None:
    with lab_of() as lab:
        assert get_path(lab.port, f"/s/{CODE}", {}).status == 404
