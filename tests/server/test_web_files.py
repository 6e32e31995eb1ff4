"""What the page has beside viser's."""

import gzip
import posixpath
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import app
from app.server import web_files
from tests.support.server import Lab, get, get_path, lab_of

WEB = Path(app.__file__).parent / "web"
TYPES = {".js": "text/javascript", ".css": "text/css"}


@pytest.fixture(scope="module")
def titled() -> Iterator[Lab]:
    with lab_of(label="cats & <dogs>") as lab:
        yield lab


def test_the_page_has_our_scripts_ahead_of_visers_and_our_title(titled: Lab) -> None:
    page = get(titled.port).read().decode()
    ours = page.index((WEB / "first.js").read_text("utf-8"))
    assert ours < page.index("data-p=")
    assert '<script type="module" src="web/lab.js"></script>' in page
    assert "<title>cats &amp; &lt;dogs&gt;</title>" in page
    assert "<title>Viser</title>" not in page
    packed = get(titled.port, **{"Accept-Encoding": "gzip"})
    assert packed.headers["Content-Encoding"] == "gzip"
    body = packed.read()
    assert int(packed.headers["Content-Length"]) == len(body)
    assert gzip.decompress(body).decode() == page
    assert get_path(titled.port, "/index.html?fixedDpr=1", {}).read().decode() == page


@pytest.mark.parametrize(
    "name", sorted(f.relative_to(WEB).as_posix() for f in WEB.rglob("*") if f.suffix in TYPES)
)
def test_own_files_are_served_as_they_are(titled: Lab, name: str) -> None:
    answer = get_path(titled.port, f"/web/{name}?x", {})
    assert answer.status == 200
    assert answer.read() == (WEB / name).read_bytes()
    assert answer.headers["Content-Type"] == f"{TYPES[Path(name).suffix]}; charset=utf-8"
    assert answer.headers["Cache-Control"] == "no-cache"


@pytest.mark.parametrize(
    "path",
    [
        *("/web/", "/web", "/web/nothing.js", "/web/../lab.py", "/web/%2e%2e/lab.py"),
        *("/WEB/lab.js", "/web/time/", "/web/time/index.html", "/web/time/../lab.js"),
    ],
)
def test_nothing_else_is_served(titled: Lab, path: str) -> None:
    assert get_path(titled.port, path, {}).status == 404


def test_a_page_that_is_refused_gets_what_it_needs_to_say_so(titled: Lab) -> None:
    foreign = {"Origin": "http://127.0.0.1:9"}
    assert get_path(titled.port, "/web/connection.js", foreign).status == 200
    assert get_path(titled.port, "/why?origin=http://127.0.0.1:9", foreign).status == 200
    assert get_path(titled.port, "/", foreign).status == 403
    # Under a name that is not ours it gets nothing.
    rebound = {"Host": "evil.example", "Origin": "http://evil.example"}
    assert get_path(titled.port, "/web/connection.js", rebound).status == 403
    assert get_path(titled.port, "/why", rebound).status == 403


@pytest.mark.parametrize("page", web_files.FRAMES)
def test_a_frame_asks_at_once_for_all_that_its_script_needs(
    titled: Lab, page: web_files.Frame
) -> None:
    html = web_files.frame_document(page).decode()
    asked = re.findall(r'modulepreload" href="../..(/web/[\w./]+)"', html)
    assert asked[-1] == f"/web/{page}/frame.js"
    known: set[str] = set()
    for path in asked:
        answer = get_path(titled.port, path, {})
        assert answer.status == 200
        # Each comes after what it needs, and nothing that it needs is not there.
        needed = re.findall(r'^(?:import|export)\b[^"]*"(\.[^"]+)";', answer.read().decode(), re.M)
        assert {posixpath.normpath(f"{path}/../{name}") for name in needed} <= known
        known.add(path)
