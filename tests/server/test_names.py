"""Under which names the lab is reached, and what is said to whom it refuses."""

import http.client
from collections.abc import Iterator

import pytest
from websockets.exceptions import InvalidStatus

from app.server.origin import Authority, declared_name, is_loopback, names_of_workspace
from tests.support.server import OWN, Lab, Page, get, get_path, lab_of

NAMES = (
    ("lab.example.edu", ("lab.example.edu", None)),
    (" LAB.Example.EDU. ", ("lab.example.edu", None)),
    ("lab.example.edu:8443", ("lab.example.edu", 8443)),
    ("x-8080.app.example.dev", ("x-8080.app.example.dev", None)),
    ("my_container:80", ("my_container", 80)),
    ("lübeck.example", ("xn--lbeck-kva.example", None)),
    ("xn--lbeck-kva.example", ("xn--lbeck-kva.example", None)),
    ("straße.example", ("xn--strae-oqa.example", None)),
    ("192.168.7.7:8000", ("192.168.7.7", 8000)),
    ("[FD00::2]:8000", ("[fd00::2]", 8000)),
)


@pytest.mark.parametrize(("text", "authority"), NAMES)
def test_names_are_taken_as_browsers_send_them(text: str, authority: Authority) -> None:
    assert declared_name(text) == authority


@pytest.mark.parametrize(
    "text",
    [
        "",
        ".",
        "a..b",
        "-a.example",
        "a-.example",
        "x y",
        "http://lab.example.edu",
        "lab.example.edu/path",
        "lab.example.edu:",
        "lab.example.edu:http",
        "lab.example.edu:65536",
        "user@lab.example.edu",
        "*.example.edu",
        "1.2.3",
        "300.1.1.1",
        "fd00::2",
        "[fd00:::2]",
        "a" * 64,
        "a." * 127 + "a",
        "\u2603\u200d.example",
    ],
)
def test_what_no_host_can_be_called_is_no_name(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        declared_name(text)


def test_workspaces_in_the_cloud_say_under_which_name_they_forward_a_port() -> None:
    codespace = {
        "CODESPACE_NAME": "fuzzy-cat",
        "GITHUB_CODESPACES_PORT_FORWARDING_DOMAIN": "app.example.dev",
    }
    assert names_of_workspace(codespace, 8080) == (("fuzzy-cat-8080.app.example.dev", None),)
    code = {"VSCODE_PROXY_URI": "https://code.example.edu:8443/proxy/{{port}}/"}
    assert names_of_workspace(code, 8080) == (("code.example.edu", 8443),)
    assert names_of_workspace({"CODESPACE_NAME": "fuzzy-cat"}, 8080) == ()
    assert names_of_workspace({"VSCODE_PROXY_URI": "/proxy/{{port}}/"}, 8080) == ()


@pytest.mark.parametrize(
    ("host", "expected"),
    [
        *((host, True) for host in ("127.0.0.1", "127.8.8.8", "::1", "localhost")),
        *((host, False) for host in ("0.0.0.0", "::", "192.168.7.7", "lab.example.edu")),
    ],
)
def test_loopback_is_told_from_the_network(host: str, expected: bool) -> None:
    assert is_loopback(host) is expected


@pytest.fixture(scope="module")
def named() -> Iterator[Lab]:
    """A lab that answers to two names besides its own, one with a port."""
    names = [declared_name(text) for text in ("lab.example.edu", "hub.example.edu:8443")]
    with lab_of(names=names, on_call=lambda words: True) as lab:
        yield lab


def is_let_in(lab: Lab, host: str, origin: str) -> bool:
    """Whether a page may open a websocket; the page's own file must be answered alike."""
    statuses = {get(lab.port, Host=host, Origin=origin).status}
    try:
        Page(lab.port, host, additional_headers={"Origin": origin}, port_in_name=False).close()
        statuses.add(200)
    except InvalidStatus as refusal:
        statuses.add(refusal.response.status_code)
    assert statuses in ({200}, {403})
    return statuses == {200}


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        # The proxy passes on the name that the browser knows, with or without TLS and a port.
        ("lab.example.edu", "http://lab.example.edu"),
        ("lab.example.edu", "https://lab.example.edu"),
        ("Lab.Example.Edu.", "https://lab.example.edu"),
        ("lab.example.edu:9000", "https://lab.example.edu:9000"),
        ("lab.example.edu:443", "https://lab.example.edu"),
        ("hub.example.edu:8443", "https://hub.example.edu:8443"),
        ("127.0.0.1", "https://127.0.0.1"),
        # It puts its own in place of the name: the owner has declared where the page comes from.
        ("127.0.0.1:{port}", "http://lab.example.edu"),
        ("127.0.0.1:{port}", "https://lab.example.edu"),
        ("localhost:{port}", "https://hub.example.edu:8443"),
    ],
)
def test_pages_under_a_declared_name_are_let_in(named: Lab, host: str, origin: str) -> None:
    assert is_let_in(named, host.format(port=named.port), origin)


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("lab.example.edu", "https://evil.example"),
        ("lab.example.edu", "https://lab.example.edu.evil.example"),
        ("lab.example.edu", "https://lab.example.edu:9000"),
        # Somebody else's port on a host of that name.
        ("127.0.0.1:{port}", "https://lab.example.edu:9000"),
        ("127.0.0.1:{port}", "https://hub.example.edu"),
        ("127.0.0.1:{port}", "ftp://lab.example.edu"),
        ("127.0.0.1:{port}", "lab.example.edu"),
        ("evil.example", "https://lab.example.edu"),
    ],
)
def test_a_declared_name_lets_in_nobody_else(named: Lab, host: str, origin: str) -> None:
    assert not is_let_in(named, host.format(port=named.port), origin)


@pytest.mark.parametrize("name", ["X-Forwarded-Host", "X-Original-Host", "Forwarded"])
def test_what_a_header_says_of_another_proves_nothing(named: Lab, name: str) -> None:
    for own in ("lab.example.edu", f"127.0.0.1:{named.port}"):
        value = f"host={own};proto=http" if name == "Forwarded" else own
        assert get(named.port, **{"Host": "evil.example", name: value}).status == 403
        origin = {"Origin": "http://evil.example", name: "evil.example"}
        assert get(named.port, Host=own, **origin).status == 403


def test_a_call_may_come_from_a_page_under_a_declared_name(named: Lab) -> None:
    upstream = f"127.0.0.1:{named.port}"

    def status(referer: str) -> int:
        headers = {"Host": upstream, "Referer": referer}
        return get_path(named.port, "/call/x", headers).status

    assert status("http://lab.example.edu/lab/?fixedDpr=1") == 204
    assert status("https://hub.example.edu:8443/user/me/proxy/8080/") == 204
    assert status("http://evil.example/http://lab.example.edu/") == 403


def test_a_refusal_names_its_remedy_in_the_answer_and_in_the_log(
    named: Lab, caplog: pytest.LogCaptureFixture
) -> None:
    refused = get(named.port, Host="other.example.edu:9000").read().decode()
    assert "--name other.example.edu." in refused
    refused = get(named.port, Origin="https://other.example.edu:8443").read().decode()
    assert "--name other.example.edu:8443." in refused
    warnings = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert "'other.example.edu:9000'" in warnings[0]
    assert warnings[0].endswith("--name other.example.edu")
    assert "'https://other.example.edu:8443'" in warnings[1]
    assert warnings[1].endswith("--name other.example.edu:8443")


def test_a_person_reads_a_refusal_on_a_page_in_which_nothing_is_markup(named: Lab) -> None:
    answer = get(named.port, Host="<script>x.example", Accept="text/html,*/*;q=0.8")
    assert answer.status == 403
    assert answer.headers["Content-Type"] == "text/html; charset=utf-8"
    text = answer.read().decode()
    assert "This is not a name of this server" in text
    assert "<script" not in text
    answer = get(named.port, Origin="http://other.example.edu", Accept="text/html")
    assert "--name other.example.edu" in answer.read().decode()


@pytest.mark.parametrize("text", ["\x1b[31m", "\xff\x9b1m"])
def test_nothing_of_a_name_acts_on_the_terminal(
    named: Lab, caplog: pytest.LogCaptureFixture, text: str
) -> None:
    get(named.port, Origin=f"http://{text}")
    assert caplog.records
    assert all(record.getMessage().isprintable() for record in caplog.records)


def why(lab: Lab, origin: str, **headers: str) -> http.client.HTTPResponse:
    return get_path(lab.port, f"/why?origin={origin}", headers)


def test_a_page_can_ask_why_its_websocket_is_refused(named: Lab) -> None:
    upstream = f"127.0.0.1:{named.port}"
    assert why(named, "http://lab.example.edu", Host=upstream).status == 204
    answer = why(named, "http://127.0.0.1:9000", Host=upstream)
    assert answer.status == 200
    assert answer.headers["Content-Type"] == "text/plain; charset=utf-8"
    assert answer.headers["Cache-Control"] == "no-store"
    assert "--name 127.0.0.1:9000" in answer.read().decode()


def test_a_page_is_told_that_there_are_too_many() -> None:
    with lab_of(max_clients=1) as lab:
        assert why(lab, f"http://127.0.0.1:{lab.port}").status == 204
        lab.page()
        answer = why(lab, f"http://127.0.0.1:{lab.port}")
        assert "Too many open pages" in answer.read().decode()


def test_https_is_no_other_site(named: Lab) -> None:
    headers = {"Host": "localhost", "Referer": "https://localhost/"}
    assert get_path(named.port, "/call/x", headers).status == 204
    assert get_path(named.port, "/call/x", {**headers, **OWN}).status == 204
