"""The replay page as a file: small, whole, and open to nobody's markup."""

import json
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest

from app.player import replay_page
from app.player.replay_page import ReplayError, without_styles
from app.util.html import Markup
from tests.support.replays import HOSTILE, fewer_moments, small_branchy, small_recorded

WEB = Path(replay_page.__file__).parent.parent / "web"


@pytest.fixture(autouse=True, scope="module")
def few() -> Iterator[None]:
    with fewer_moments():
        yield


@pytest.fixture(scope="module")
def page() -> str:
    return replay_page.replay_page(small_branchy())


def test_it_is_below_its_bound_and_the_same_each_time(page: str) -> None:
    assert len(page.encode()) < replay_page.MOST_BYTES
    assert replay_page.replay_page(small_branchy()) == page


def test_it_is_thinned_until_it_fits(page: str, monkeypatch: pytest.MonkeyPatch) -> None:
    n_moments = len(moments_of(page))
    monkeypatch.setattr(replay_page, "MOST_BYTES", len(page.encode()) - 20_000)
    thin = replay_page.replay_page(small_branchy())
    assert len(thin.encode()) < replay_page.MOST_BYTES
    assert 0 < len(moments_of(thin)) < n_moments
    monkeypatch.setattr(replay_page, "MOST_BYTES", 250_000)
    with pytest.raises(ReplayError, match="too long for one page"):
        replay_page.replay_page(small_branchy())


def moments_of(page: str) -> list[object]:
    import base64
    import zlib

    found = re.search(r'id="replay-film">([^<]+)<', page)
    assert found is not None
    raw = zlib.decompress(base64.b64decode(found[1]))
    return json.loads(raw[4 : 4 + int.from_bytes(raw[:4], "little")])["shots"]


class _Elements(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))


def test_nothing_runs_but_its_own_scripts_and_nothing_is_loaded(page: str) -> None:
    reader = _Elements()
    reader.feed(page)
    policy = next(
        attrs["content"] for tag, attrs in reader.found if "http-equiv" in attrs and tag == "meta"
    )
    assert policy is not None
    assert policy.startswith("default-src 'none'; script-src 'nonce-")
    assert "unsafe" not in policy
    nonce = re.search(r"'nonce-([^']+)'", policy)
    assert nonce is not None
    for tag, attrs in reader.found:
        assert not any(name.startswith("on") or name == "style" for name in attrs), attrs
        if tag in ("script", "style") and attrs.get("type") not in (
            "application/json",
            "text/plain",
        ):
            assert attrs["nonce"] == nonce[1]
        for name in ("src", "href"):
            assert (attrs.get(name) or "data:").startswith(("data:image/png", "data:"))
    assert [a["type"] for t, a in reader.found if t == "script"] == [
        *("importmap", "application/json", "text/plain", "module"),
    ]


def test_what_people_wrote_is_text(page: str) -> None:
    assert HOSTILE[:30] not in page
    assert "&lt;/script&gt;" in page
    # In data for scripts as well, which would end there.
    assert "\\u003c/script>" in page


def test_its_modules_are_the_lab_s_own_but_for_the_names_of_what_they_import(page: str) -> None:
    found = re.search(r'<script type="importmap"[^>]*>(.*?)</script>', page, re.DOTALL)
    assert found is not None
    modules = json.loads(found[1])["imports"]
    assert {"pounce/player/board.js", "pounce/time/draw.js", "pounce/replay/replay.js"} <= {
        *modules
    }
    assert not any("channel" in name for name in modules)
    for name, address in modules.items():
        kind, _, text = address.partition(",")
        assert kind == "data:text/javascript"
        own = (WEB / name.removeprefix("pounce/")).read_text("utf-8")
        folder = (WEB / name.removeprefix("pounce/")).parent

        def renamed(at: re.Match[str], folder: Path = folder) -> str:
            target = (folder / at[2]).resolve().relative_to(WEB)
            return f'{at[1]}"pounce/{target.as_posix()}"'

        imports = re.compile(r'((?:^|\n)\s*import\s*|\bfrom\s*)"(\.[^"]+)"')
        assert unquote(text) == imports.sub(renamed, own)
        for imported in re.findall(r'(?:\bimport\s*|\bfrom\s*)"([^"]+)"', unquote(text)):
            assert imported in modules


def test_without_scripts_it_says_what_happened_and_shows_four_moments() -> None:
    page = replay_page.replay_page(small_recorded())
    assert page.count("<figure>") == 4
    # The poster, which stands there until the page plays, is a picture as well.
    assert page.count("data:image/png;base64,") == 5
    for what in ("circle clockwise joins", "the first capture", "the end of what is recorded"):
        assert what in page


def test_styles_that_stand_in_elements_become_rules() -> None:
    html = Markup(
        '<p style="color:red">a</p><b style="color:red">b</b><i style="x:&quot;&lt;">c</i>'
    )
    text, rules = without_styles(html)
    assert text == '<p data-s="s0">a</p><b data-s="s0">b</b><i data-s="s1">c</i>'
    assert rules == '[data-s="s0"] { color:red }\n[data-s="s1"] { x:"\\3c  }'
