"""The replay page: one file that plays a session by itself, from disk and without a network.

What draws it are the lab's own modules (``app/web/player``, ``app/web/time``), which stand in the
file as they are, in an import map; only the names by which they import each other are others, for a
module in a map has no folder. No script runs but those, and nothing is loaded: the file's own
policy forbids it.
"""

import base64
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from html import unescape
from pathlib import Path
from typing import Any, Final, NamedTuple
from urllib.parse import quote

from app import __version__
from app.live.places import LineSeen
from app.picture.layers import LAYERS
from app.player.boards import world_sent
from app.player.film import Film, Shot
from app.player.reel import (
    LAYERS_SHOWN,
    LineBars,
    Recorded,
    Stop,
    Tell,
    bars_of,
    shots_of,
    stops_of,
    view_name,
)
from app.player.shapes import Picture, svg_of
from app.player.sketch import sketch
from app.server.web_files import modules_of
from app.util.html import Markup, element, escaped, joined
from app.words import glossary
from app.words.numbers import counted
from app.words.plain import HEADING_NAMES

MOST_BYTES: Final = 1_000_000
"""Of the whole file."""
MOST_MOMENTS: Final = 280
FEWEST_MOMENTS: Final = 24

_WEB: Final = Path(__file__).parent.parent / "web"
_START: Final = _WEB / "replay" / "replay.js"
_STYLES: Final = (
    *(
        f"time/{name}.css"
        for name in ("time", "curve", "rule", "tree", "lanes", "over", "axis", "hand")
    ),
    "readings.css",
    "terms.css",
    "replay/replay.css",
)
_IMPORT: Final = re.compile(r'((?:^|\n)\s*import\s*|\bfrom\s*)"(\.[^"]+)"')
_STYLE: Final = re.compile(r' style="([^"]*)"')
_SAFE: Final = " !$&'()*+,-./:;=?@_~[]{}|^`"
"""Characters that need not be written otherwise in the address of a module."""
_STILLS: Final = 4
_SIDE: Final = 560
"""Of the boards that stand there as pictures, in pixels."""


class ReplayError(Exception):
    """A replay that cannot be written; the message says why."""


def replay_page(recorded: Recorded, tell: Tell = lambda _, __: None) -> str:
    """The page of a session, with as many moments as there is room for.

    Raises:
        ReplayError: not even the fewest fit.
    """
    stops = stops_of(recorded, MOST_MOMENTS, tell)
    bars = bars_of(recorded, tell)
    film, shots = Film(), list[Shot]()
    for shot in shots_of(recorded, stops, tell):
        film.add(shot)
        shots.append(shot)
    tell("The page is written", 0.0)
    around = _page(recorded, bars, shots, "")
    room = (MOST_BYTES - len(around.encode())) * 3 // 4
    kept = thinned(recorded, bars, film, stops, room)
    packed = base64.b64encode(film.packed(kept)).decode()
    return _page(recorded, bars, shots, packed)


def thinned(
    recorded: Recorded,
    bars: Mapping[int, LineBars],
    film: Film,
    stops: Sequence[Stop],
    room: int,
) -> list[int]:
    """The places of the moments that are kept, so that the film takes no more than so many bytes.

    Ends of lines and what happened are kept as long as there is room for these alone.

    Raises:
        ReplayError: there is no room for the fewest.
    """
    wanted = {
        Stop(number, happening.step) for number, of in bars.items() for happening in of.happenings
    }
    for line in recorded.lines:
        wanted |= {Stop(line.number, step) for step in (line.fork_step, line.until_step)}
    share = 1.0
    while True:
        kept = _some(stops, wanted if share > 0.2 else _ends(recorded), share)
        size = len(film.packed(kept))
        if size <= room:
            return kept
        if len(kept) <= FEWEST_MOMENTS:
            raise ReplayError(
                f"this session is too long for one page: {size:,} bytes of film, and room for"
                f" {max(room, 0):,}"
            )
        share *= min(room / size, 0.97)


def _ends(recorded: Recorded) -> set[Stop]:
    return {Stop(line.number, line.until_step) for line in recorded.lines}


def _some(stops: Sequence[Stop], wanted: set[Stop], share: float) -> list[int]:
    """Places of stops that are wanted, and of a share of the others, evenly."""
    kept: list[int] = []
    due = 0.0
    for place, stop in enumerate(stops):
        due += share
        if stop in wanted:
            kept.append(place)
            due = min(due, 1.0) - share
        elif due >= 1.0:
            kept.append(place)
            due -= 1.0
    return kept


# --- The page ------------------------------------------------------------------------------------


def _page(
    recorded: Recorded, bars: Mapping[int, LineBars], shots: Sequence[Shot], film: str
) -> str:
    live = recorded.live
    end = next(shot for shot in reversed(shots) if shot.line == live.number)
    run = recorded.pasts[live.number].control.preset
    title = f"{recorded.preset}, seed {recorded.seed}"
    world = world_sent(run.world)
    own = [shot for shot in shots if shot.line == live.number]
    data = {
        "world": world,
        "line": live.number,
        "lines": [_line(line, bars[line.number]) for line in recorded.lines],
        "bars": {number: {"trials": of.trials, "steps": of.steps} for number, of in bars.items()},
    }
    said = _json(data)
    # Nothing that stands in the page can know it, as it is found of all that does.
    nonce = base64.b64encode(hashlib.sha256(f"{title}{said}{film}".encode()).digest()).decode()
    body, rules = without_styles(
        joined(
            [
                _header(recorded, live, title),
                _player(end, world),
                _events(recorded, bars),
                _stills(own, world),
                _how(),
                glossary.table_html(),
                Markup(f'<script type="application/json" id="replay-data">{said}</script>'),
                Markup(f'<script type="text/plain" id="replay-film">{film}</script>'),
                Markup(
                    f'<script type="module" nonce="{nonce}">import "{_name_of(_START)}";</script>'
                ),
            ]
        )
    )
    head = joined(
        [
            Markup('<meta charset="utf-8"/>'),
            Markup(f'<meta http-equiv="Content-Security-Policy" content="{_policy(nonce)}"/>'),
            Markup('<meta name="viewport" content="width=device-width, initial-scale=1"/>'),
            Markup(f'<meta name="generator" content="pounce {escaped(__version__)}"/>'),
            element("title", f"{title}: a replay"),
            Markup(f'<style nonce="{nonce}">{_styles()}\n{rules}</style>'),
            Markup(f'<script type="importmap" nonce="{nonce}">{_import_map()}</script>'),
        ]
    )
    content = joined([element("head", head), element("body", body)])
    return f"<!DOCTYPE html>\n{element('html', content, lang='en')}\n"


def without_styles(html: Markup) -> tuple[Markup, str]:
    """HTML whose elements have classes in place of styles, which the page's policy forbids, and the
    rules of these classes."""
    classes: dict[str, str] = {}

    def classed(found: re.Match[str]) -> str:
        name = classes.setdefault(unescape(found[1]), f"s{len(classes)}")
        return f' data-s="{name}"'

    text = _STYLE.sub(classed, html)
    rules = "\n".join(f'[data-s="{name}"] {{ {rule} }}' for rule, name in classes.items())
    return Markup(text), rules.replace("<", "\\3c ")


def _policy(nonce: str) -> str:
    return (
        f"default-src 'none'; script-src 'nonce-{nonce}'; style-src-elem 'nonce-{nonce}';"
        " img-src data:; base-uri 'none'; form-action 'none'"
    )


def _json(thing: object) -> str:
    """JSON that ends no script."""
    text = json.dumps(thing, separators=(",", ":"), ensure_ascii=True)
    return text.replace("<", "\\u003c")


def _line(line: LineSeen, bars: LineBars) -> dict[str, Any]:
    return {
        "number": line.number,
        "parent": line.parent,
        "fork": line.fork_step,
        "events": sorted({happening.step for happening in bars.happenings}),
    }


def _styles() -> str:
    return "\n".join((_WEB / name).read_text("utf-8") for name in _STYLES)


def _name_of(module: Path) -> str:
    return f"pounce/{module.relative_to(_WEB).as_posix()}"


def _import_map() -> str:
    addresses: dict[str, str] = {}
    for module in modules_of(_START):

        def renamed(found: re.Match[str], module: Path = module) -> str:
            return f'{found[1]}"{_name_of((module.parent / found[2]).resolve())}"'

        text = _IMPORT.sub(renamed, module.read_text("utf-8"))
        addresses[_name_of(module)] = f"data:text/javascript,{quote(text, _SAFE)}"
    return _json({"imports": addresses})


_HOW_TO_BEGIN: Final = (
    "A recording: the button with the arrow, or space, plays it; drag along the curve to go to a"
    " moment."
)


def _header(recorded: Recorded, live: LineSeen, title: str) -> Markup:
    facts = [
        counted(live.until_trial, "trial"),
        counted(live.until_step, "step"),
        *([counted(len(recorded.lines), "line")] if len(recorded.lines) > 1 else []),
        joined([glossary.term("digest"), " ", element("code", live.digest[:12])], ""),
        f"recorded with pounce {__version__}",
    ]
    switch = element(
        "button", "Dark or light", id="scheme", type="button", hidden="", class_="quiet"
    )
    return element(
        "header",
        joined(
            [
                element("div", element("h1", title) + switch, class_="top"),
                element("p", joined(facts, ", "), class_="facts"),
                element("p", _HOW_TO_BEGIN, class_="facts how", hidden=""),
                element(
                    "noscript",
                    element(
                        "p",
                        "Scripts are off here, so this page does not play; below are its last"
                        " moment, four of its moments and what happened.",
                        class_="note",
                    ),
                ),
            ]
        ),
    )


class _Choice(NamedTuple):
    key: str
    name: str


def _player(end: Shot, world: Mapping[str, Any]) -> Markup:
    """The board and what is read beside it; without scripts, of the last moment."""
    view = end.views[view_name("value", "turned")]
    legend, _, caption, about = view.texts
    layers = [
        element(
            "button",
            LAYERS[key].title,
            type="button",
            title=f"{LAYERS[key].title} ({number})",
            **{"data-layer": key, "aria-pressed": "false"},
        )
        for number, key in enumerate(LAYERS_SHOWN, 1)
    ]
    frames = [
        _Choice("turned", "all headings, turned"),
        _Choice("each", "each heading by itself"),
        *(_Choice(f"{number}", f"prey faces {name}") for number, name in enumerate(HEADING_NAMES)),
    ]
    options = joined((element("option", name, value=key) for key, name in frames), "")
    ways = joined(
        [
            element("div", joined(layers, ""), class_="layers", role="group", **_named("Layer")),
            element("select", options, id="frame", **_named("Headings that are shown")),
        ]
    )
    board = joined(
        [
            Markup('<canvas id="board" hidden></canvas>'),
            element("div", _board(view.light, world, about), id="poster"),
        ]
    )
    beside = joined(
        [
            element("p", Markup(end.texts[0]), id="sentence"),
            element("div", Markup(end.texts[1]), id="readings"),
            element("div", ways, id="ways", hidden=""),
            element("p", caption, id="caption"),
            element("div", Markup(legend), id="legend"),
        ]
    )
    return element(
        "main",
        joined(
            [
                element(
                    "div",
                    joined(
                        [
                            element("div", board, class_="place"),
                            element("div", beside, class_="beside"),
                        ]
                    ),
                    class_="stage",
                ),
                element("div", "", id="bar"),
                element("p", "", id="told", role="status", class_="unseen"),
            ]
        ),
    )


def _named(name: str) -> dict[str, str]:
    return {"aria-label": name}


def _board(board: Mapping[str, Any], world: Mapping[str, Any], about: str) -> Markup:
    margin = 4
    shapes = tuple(sketch(board, world, margin, margin, _SIDE - 2 * margin))
    return svg_of(Picture(_SIDE, _SIDE, shapes, about))


def _events(recorded: Recorded, bars: Mapping[int, LineBars]) -> Markup:
    """What happened, as a table for each line."""
    parts = [element("h2", "What happened")]
    for line in recorded.lines:
        happenings = bars[line.number].happenings
        rows = [("trial", "step", "what happened")]
        rows += [(f"{one.trial:,}", f"{one.step:,}", one.text) for one in happenings]
        rows.append(
            (f"{line.until_trial:,}", f"{line.until_step:,}", "the end of what is recorded")
        )
        steps = [0, *(one.step for one in happenings), line.until_step]
        if len(recorded.lines) > 1:
            parts.append(element("h3", line.name))
        parts.append(_table(line, rows, steps))
    return element("section", joined(parts), class_="events")


def _table(line: LineSeen, rows: Sequence[Sequence[str]], steps: Sequence[int]) -> Markup:
    head = element("tr", joined((element("th", cell, scope="col") for cell in rows[0]), ""))
    body = [
        element(
            "tr",
            joined([element("th", row[0], scope="row"), *(element("td", c) for c in row[1:])], ""),
            **{"data-step": str(step), "data-line": str(line.number)},
        )
        for row, step in zip(rows[1:], steps[1:], strict=True)
    ]
    name = {"aria-label": f"What happened: {line.name}"}
    return element("table", element("thead", head) + element("tbody", joined(body)), **name)


def _stills(shots: Sequence[Shot], world: Mapping[str, Any]) -> Markup:
    """Four moments as pictures: what a sheet of paper has."""
    # From among the early ones, which show how it begins, to the last.
    last = len(shots) - 1
    chosen = [shots[round((number + 0.5) * last / (_STILLS - 0.5))] for number in range(_STILLS)]
    figures = [_still(shot, world) for shot in chosen]
    legend, _, caption, _ = chosen[-1].views[view_name("value", "turned")].texts
    content = joined(
        [
            element("h2", "Four moments"),
            element("div", joined(figures), class_="four"),
            element("p", caption),
            element("div", Markup(legend)),
        ]
    )
    return element("section", content, class_="stills")


def _still(shot: Shot, world: Mapping[str, Any]) -> Markup:
    view = shot.views[view_name("value", "turned")]
    said = Markup(shot.texts[0]).striptags()
    where = element("b", f"Trial {shot.trial:,}, step {shot.step:,}.")
    about = f"The board at trial {shot.trial:,}"
    return element(
        "figure",
        joined(
            [_board(view.light, world, about), element("figcaption", joined([where, said], " "))]
        ),
    )


_KEYS: Final = (
    ("Space", "play, or stand still"),
    (", and .", "one moment back, one on"),
    ("< and >", "ten moments back, ten on"),
    ("[ and ]", "to the event before, to the next"),
    ("Home and End", "the first moment, the last"),
    ("1, 2, 3", "value, chosen skill, first reach"),
    ("V", "all headings turned, or each by itself"),
    ("A and L", "this moment is A; play from A to here again and again"),
    ("D", "dark or light"),
)


def _how() -> Markup:
    rows = joined(
        element("tr", element("th", element("kbd", key), scope="row") + element("td", does))
        for key, does in _KEYS
    )
    about = (
        "The moments of this page lie closest where most changes; each of them is exactly what the"
        " lab shows. Drag along the curve to go through them."
    )
    content = joined(
        [
            element("summary", "Keys, and what this page is"),
            element("p", about),
            element("table", element("tbody", rows), **_named("Keys")),
        ]
    )
    return element("details", content, class_="how", hidden="")
