"""What a watcher is sent of a moment, in parts: each is sent again only when it is another.

A part is JSON as the page takes it (``app/web/audience``). All that lies below is plain: nothing
here knows who watches, or when.
"""

import zlib
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

import msgspec

from app.audience.wishes import offer_of
from app.charts.bar.rule import watched_at
from app.live.places import Place
from app.live.status import Status
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.player.boards import ground_sent, over_sent, world_sent
from app.player.moments import words_sent
from app.server.watchers import Watcher
from app.util.html import element
from sim.spec import WorldSpec

ORDER: Final = (
    "lab",
    "stand",
    "seat",
    "lesson",
    "offer",
    "world",
    "ground",
    "over",
    "legend",
    "said",
    "readings",
    "bar",
    "moment",
)
"""Kinds of parts, in the order in which a page takes them in."""

Parts = dict[str, bytes]
"""Of each kind the newest."""

_LEVEL: Final = 6


def part(kind: str, content: Mapping[str, Any]) -> bytes:
    """One part."""
    return msgspec.json.encode({"kind": kind, **content})


def letter_of(parts: Iterable[bytes]) -> bytes:
    """Parts as they are sent: a JSON list of them, as ``zlib`` packs it."""
    return zlib.compress(b"[" + b",".join(parts) + b"]", _LEVEL)


def by_what_they_miss(
    parts: Parts,
    watchers: Iterable[Watcher],
    order: Iterable[str],
    theirs: Callable[[Watcher], Parts] = lambda _: {},
) -> dict[tuple[tuple[str, bytes], ...], list[Watcher]]:
    """Those who can take something in, by the parts of which they have another than this.

    They count as having it from then on.

    Args:
        parts: what there is, by kind.
        watchers: who are to have it.
        order: of kinds, in which they are sent; others are not.
        theirs: what there is for one of them besides.
    """
    groups: dict[tuple[tuple[str, bytes], ...], list[Watcher]] = {}
    for watcher in watchers:
        if not watcher.is_ready:
            continue
        there = parts | theirs(watcher)
        missing = tuple(
            (kind, there[kind])
            for kind in order
            if kind in there and watcher.seen.get(kind) != there[kind]
        )
        if missing:
            groups.setdefault(missing, []).append(watcher)
            watcher.seen.update(missing)
    return groups


def world_part(world: WorldSpec) -> bytes:
    """The world, which pages keep."""
    return part("world", {"world": world_sent(world)})


def ground_part(status: Status, look: Look, extras: Extras) -> bytes:
    """Colours, and the hunt."""
    board = ground_sent(status.snapshot, look, extras, rests=not status.playing)
    return part("ground", {"board": board})


def over_part(status: Status, look: Look, extras: Extras) -> bytes:
    """Lines and words over the colours."""
    return part("over", {"board": over_sent(status.snapshot, look, extras)})


def word_parts(status: Status, look: Look, extras: Extras) -> Parts:
    """What is read beside the board."""
    words = words_sent(status, look, extras)
    sentence = words["sentence"]
    title = LAYERS[look.layer].title_of(status.snapshot.spec.learner)
    if status.error:
        sentence = str(element("b", status.error))
    return {
        "legend": part("legend", {"html": words["legend"], "title": title}),
        "said": part(
            "said",
            {
                "html": sentence,
                "caption": words["caption"],
                "described": words["described"],
            },
        ),
        "readings": part("readings", {"html": words["readings"]}),
    }


def offer_part(status: Status) -> bytes:
    """What one can choose from, of what is live."""
    return part("offer", offer_of(status.snapshot))


def moment_on_bar(live: Status, status: Status, place: Place | None, line: int) -> dict[str, Any]:
    """Where somebody who looks around is on the presenter's bar, as its scripts take it.

    Args:
        live: how the live run stands.
        status: what is shown.
        place: the moment that was wished, if it is none of now.
        line: whose bar it is.
    """
    now, shown = live.snapshot, status.snapshot
    return {
        "line": line,
        "step": shown.step if place is None else place.step,
        "trial": shown.trial,
        "live": place is None,
        "behind_trials": now.trial - shown.trial,
        "behind_steps": now.step - shown.step,
        "playing": place is None and live.playing,
        "direction": 1,
        "rate": 1.0,
        "rates": [],
        "a": None,
        "loop": None,
        "holds": False,
        "stops": False,
        "until_step": None,
        "watched": watched_at(shown),
    }
