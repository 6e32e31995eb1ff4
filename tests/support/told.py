"""What the lab says to the frame of a lesson: a state for each kind of card, as recorded."""

from typing import Any, Final

SPREAD: Final = [
    ["clockwise", "Clockwise"],
    ["counter", "Counter-clockwise"],
    ["both", "Both ways at once"],
    ["no", "Not at all"],
]
PARTS: Final = [
    ["exploration", "Forced exploration"],
    ["timers", "Timers"],
    ["freeze", "The freeze after a skill joins"],
    ["safe", "Safe introduction"],
]


def asks(kind: str, **what: Any) -> dict[str, Any]:
    """A question that nobody has answered."""
    return {
        "kind": kind,
        "options": [],
        "low": None,
        "high": None,
        "unit": None,
        "from": None,
        "to": None,
        "confidence": False,
        "answer": None,
        "said": None,
        "locked": False,
        **what,
    }


def card(kind: str, html: str, **what: Any) -> dict[str, Any]:
    """A card on which there is nothing but words."""
    return {
        "kind": kind,
        "id": f"a_{kind}",
        "html": html,
        "ask": None,
        "reveal": None,
        "check": None,
        "hints": [],
        "next_hint": None,
        "busy": None,
        **what,
    }


def told(shown: dict[str, Any] | None, **what: Any) -> dict[str, Any]:
    """All that the lab says where a card is shown; without one there is but the list."""
    above = {key: what.pop(key) for key in ("list", "fault", "free") if key in what}
    lesson: dict[str, Any] = {
        "name": "which_way_round",
        "title": "Which way round?",
        "language": "en",
        "languages": ["en", "de"],
        "n": 9,
        "at": 3,
        "furthest": 4,
        "show": ["play", "speed", "layer.value"],
        "keys": ["Space", "KeyJ", "KeyK", "Digit1"],
        "card": shown,
        "controls": [],
        "inspect": None,
        "notes": None,
        "next": True,
        "last": False,
        "said": "",
        "vote": None,
        **what,
    }
    listed = [
        _listed("where_value_comes_from", "Where value comes from", 4, at=None),
        _listed("the_cone", "The cone", 5, needs=[{"en": "Where value comes from"}], at=6),
        _listed("which_way_round", "Which way round?", 6, needs=[{"en": "The cone"}], at=3),
        _listed("all_at_once", "All at once?", 8, at=None, languages=["en"]),
    ]
    return {
        "kind": "lesson",
        "list": listed,
        "fault": None,
        "free": False,
        **above,
        "lesson": None if shown is None else lesson,
    }


def _listed(name: str, title: str, minutes: int, **what: Any) -> dict[str, Any]:
    return {
        "name": name,
        "titles": {"en": title},
        "minutes": minutes,
        "needs": [],
        "languages": ["en", "de"],
        "n": 9,
        **what,
    }


def _revealed(kind: str, guess: Any, run: Any, many: dict[str, Any], **what: Any) -> dict[str, Any]:
    """A question that was answered, and what came out."""
    others = what.pop("others", {})
    reveal = {
        "ready": True,
        "html": "So it was in <b>all</b> runs.",
        "guess": guess,
        "run": run,
        "twenty": {"n": 20, **many},
        **others,
    }
    ask = asks(kind, answer=guess, said=70, locked=True, **what)
    return told(card("ask", "What will come of it?", ask=ask, reveal=reveal))


NEW_SKILL: Final = "It now learns to <b>circle clockwise</b>. Which way will value spread?"
TO_DO: Final = "Add <b>circle clockwise</b>, and have it explored for 2,000 trials."
TRIALS: Final = list(range(11_500, 17_001, 1_100))
CONTROLS: Final = [
    {"control": "play", "label": "Play", "kind": "button", "value": None, "on": True},
    {
        "control": "speed",
        "label": "Speed",
        "kind": "slider",
        "value": 2000,
        "options": [[20, "20 steps/s"], [2000, "2 k steps/s"], [200000, "200 k steps/s"]],
        "on": True,
    },
    {
        "control": "layer",
        "label": "Layer",
        "kind": "choice",
        "value": "value",
        "options": [["value", "State value"], ["reach", "First reach"]],
        "on": True,
    },
    {"control": "freeze", "label": "Freeze", "kind": "toggle", "value": False, "on": True},
    {
        "control": "add_skill.circle_clockwise",
        "label": "Add circle clockwise now",
        "kind": "button",
        "value": None,
        "on": True,
        "main": True,
    },
    {
        "control": "explore.circle_clockwise",
        "label": "Explore circle clockwise",
        "kind": "button",
        "value": None,
        "on": False,
        "why": "It is not there yet",
    },
]
_DIRECTION: Final = {"options": SPREAD, "confidence": True}
_NUMBER: Final = {"low": 0, "high": 3456, "unit": "states"}
_SKETCH: Final = {"from": 11_500, "to": 17_000, "low": -50, "high": 100}
_SKETCHED: Final = [[trial, 10 * place] for place, trial in enumerate(TRIALS)]
_CLASS: Final = {"n": 31, "counts": {"clockwise": 21, "counter": 6, "both": 4}}
_VOTE: Final = {
    "code": "4821",
    "address": "http://192.168.0.7:8090",
    "seats": 31,
    "answered": 12,
    "asking": True,
    "hidden": True,
    "few": False,
    "can": ["again", "reveal", "end"],
}

STATES: Final[dict[str, dict[str, Any]]] = {
    "list": told(None),
    "fault": told(None, fault="mine.yaml, line 3: minutes must be from 1 to 60"),
    "say": told(card("say", "The predator can only walk <b>straight up</b>."), at=0, furthest=0),
    "direction": told(card("ask", NEW_SKILL, ask=asks("direction", **_DIRECTION))),
    "committed": told(
        card(
            "ask",
            NEW_SKILL,
            ask=asks("direction", **_DIRECTION, answer="both", said=70, locked=True),
            busy="It learns on to trial 8,000; it is in trial 5,310 …",
        ),
        next=False,
    ),
    "number": told(card("ask", "How many?", ask=asks("number", **_NUMBER, confidence=True))),
    "sectors": told(card("ask", "Where?", ask=asks("sectors", answer=["w", "nw"]))),
    "moment": told(card("ask", "When?", ask=asks("moment", **{"from": 24_000, "to": 48_000}))),
    "sketch": told(card("ask", "What comes?", ask=asks("sketch", **_SKETCH))),
    "order": told(card("ask", "What matters most?", ask=asks("order", options=PARTS))),
    "direction revealed": _revealed(
        "direction", "clockwise", "counter", {"counts": {"counter": 19, "both": 1}}, options=SPREAD
    ),
    "class revealed": _revealed(
        "direction",
        "clockwise",
        "counter",
        {"counts": {"counter": 20}},
        options=SPREAD,
        others={"class": _CLASS, "before": {**_CLASS, "counts": {"clockwise": 29, "both": 2}}},
    ),
    "number revealed": _revealed(
        "number", 400, 130, {"values": [89 + 4 * place for place in range(20)]}, **_NUMBER
    ),
    "moment revealed": _revealed(
        "moment", 24_000, 32_000, {"values": [27_000 + 750 * place for place in range(20)]}
    ),
    "sectors revealed": _revealed(
        "sectors", ["w", "n"], ["w", "nw"], {"counts": {"w": 20, "nw": 18, "n": 1}}
    ),
    "sketch revealed": _revealed(
        "sketch",
        _SKETCHED,
        [[11_500, 13], [12_600, -20], [13_700, -18], [14_800, 60], [15_900, 52], [17_000, 66]],
        {
            "at": TRIALS,
            "low": [8, -26, -24, 50, 44, 60],
            "middle": [13, -20, -18, 60, 52, 66],
            "high": [20, -14, -12, 70, 60, 74],
        },
        **_SKETCH,
    ),
    "order revealed": _revealed(
        "order",
        ["freeze", "timers", "exploration", "safe"],
        ["exploration", "timers", "freeze", "safe"],
        {"counts": {"exploration": [12, 8, 0, 0], "timers": [8, 12, 0, 0]}},
        options=PARTS,
    ),
    "to do": told(
        card(
            "do",
            TO_DO,
            check={"verdict": "not yet", "html": "Value has come to 12 % of the right flank."},
            hints=["Look below."],
            next_hint="says",
        ),
        controls=CONTROLS,
        next=False,
    ),
    "done": told(
        card("do", TO_DO, check={"verdict": "yes", "html": "Done at trial 7,412."}),
        controls=CONTROLS,
        inspect="<b>16 west, 3 north</b><br>value 0.12",
    ),
    "never": told(
        card(
            "do",
            TO_DO,
            check={"verdict": "never", "html": "It can no longer come true."},
            hints=["Look below.", "Press Add."],
            next_hint="does",
        ),
        controls=CONTROLS,
        next=False,
    ),
    "see": told(card("see", "", ask=asks("direction", options=SPREAD))),
    "class asked": told(
        card("ask", NEW_SKILL, ask=asks("direction", options=SPREAD)),
        vote=_VOTE,
        notes="Wait until five have answered.",
    ),
    "free": told(card("free", "All is open now."), at=8, furthest=8, last=True, next=False),
    "German": told(
        card("ask", "Wohin?", ask=asks("direction", options=[["a", "Im Uhrzeigersinn"]])),
        language="de",
        title="Wie herum?",
    ),
}
"""By what they are."""
