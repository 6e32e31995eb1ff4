"""The keys of the page, one row each; the page's script (``app/web/keys.js``) goes by it."""

import json
from collections.abc import Iterable, Mapping
from typing import Any, Final, NamedTuple

from app.picture.layers import LAYERS as PICTURED
from app.util.html import escaped


class Key(NamedTuple):
    """One key that acts by itself, whatever is written on it."""

    code: str
    """Its place, by the name that browsers have for it: what an American keyboard has there."""
    hotkey: Any
    """What viser calls it, or would call it."""
    does: str
    repeats: bool = False
    """Whether it acts again and again while it is held down."""
    shift: bool = False
    """Whether it is this key only with shift."""
    of_time: bool = False
    """Whether it is for the time bar, which acts on it in its frame."""

    @property
    def name(self) -> str:
        """What it is told from others by: its place, with shift if it takes that."""
        return f"Shift+{self.code}" if self.shift else self.code

    @property
    def character(self) -> str:
        """What it types on an American keyboard; its name if it types nothing."""
        return " " if self.hotkey == "space" else self.hotkey.lower()


PLAY: Final = Key("Space", "space", "pause or play")
STEP: Final = Key("KeyS", "S", "one step", repeats=True)
TRIAL: Final = Key("KeyT", "T", "one trial", repeats=True)
SLOWER: Final = Key("KeyJ", "J", "slower", repeats=True)
FASTER: Final = Key("KeyK", "K", "faster", repeats=True)
LAYERS: Final = tuple(Key(f"Digit{digit}", digit, "a layer") for digit in "1234567890")
"""In the order of the layers."""
NEXT_SKILL: Final = Key("KeyN", "N", "add the next skill")
EXPLORE: Final = Key("KeyE", "E", "explore the chosen skill")
FREEZE: Final = Key("KeyF", "F", "freeze the selection, or let it learn")
UNDO: Final = Key("KeyU", "U", "undo what was just done by hand")
WATCH: Final = Key("KeyW", "W", "watch a hunt")
CAMERA: Final = Key("KeyR", "R", "show all of the board again")
PRESENT: Final = Key("KeyP", "P", "presentation mode, or back")
SIDE: Final = Key("KeyC", "C", "runs side by side, or back to one board")
LIST: Final = Key("KeyH", "H", "this list")
"""As does ?, wherever it is."""
TIME: Final = (
    Key("Home", "Home", "back to the beginning", of_time=True),
    Key("End", "End", "live: what happens now", of_time=True),
    Key("Comma", ",", "one step back", repeats=True, of_time=True),
    Key("Period", ".", "one step on", repeats=True, of_time=True),
    Key("Comma", "<", "one trial back", repeats=True, shift=True, of_time=True),
    Key("Period", ">", "one trial on", repeats=True, shift=True, of_time=True),
    Key("BracketLeft", "[", "to the event before", repeats=True, of_time=True),
    Key("BracketRight", "]", "to the next event", repeats=True, of_time=True),
    Key("KeyA", "A", "this moment is A", of_time=True),
    Key("KeyB", "B", "mark this moment, with a line of text", of_time=True),
    Key("KeyL", "L", "play from A to here again and again, or not", of_time=True),
)
"""What the time bar does with a key; the others do what they say."""
KEYS: Final = (
    PLAY,
    STEP,
    TRIAL,
    SLOWER,
    FASTER,
    *LAYERS,
    NEXT_SKILL,
    EXPLORE,
    FREEZE,
    UNDO,
    WATCH,
    CAMERA,
    PRESENT,
    SIDE,
    LIST,
    *TIME,
)

_OF_CONTROLS: Final[Mapping[str, tuple[Key, ...]]] = {
    "play": (PLAY,),
    "step": (STEP,),
    "trial": (TRIAL,),
    "speed": (SLOWER, FASTER),
    "scrub": (*TIME[:9], TIME[10]),
    "add_skill": (NEXT_SKILL,),
    "explore": (EXPLORE,),
    "freeze": (FREEZE,),
    "undo": (UNDO,),
    "side": (SIDE,),
    "marks": (TIME[9],),
    "watch": (WATCH,),
    "all": KEYS,
    **{f"layer.{name}": (key,) for name, key in zip(PICTURED, LAYERS, strict=False)},
}
"""What lessons show, by the names that they have for it, with the keys that do it; others have
none."""

_ARROWS: Final = (
    "a block or the playhead that has the focus: 100 trials, with shift 1,000; with alt a block's"
    " end"
)
_ABOUT: Final = (
    "Keys act by their place, whatever letter is there, but not while you type in a field.",
    "A click on the board inspects a cell; shift and a click sets the predator down there. A drag"
    " moves the board, the wheel or two fingers zoom.",
)


def keys_of(controls: Iterable[str]) -> list[str]:
    """Names of the keys that act where a lesson shows these controls alone."""
    return sorted({key.name for name in controls for key in _OF_CONTROLS.get(name, ())})


def table_html() -> str:
    """The table of keys for the page's script; nothing is to be seen of it."""
    table = [
        {"name": k.name, "character": k.character, "repeats": k.repeats, "ofTime": k.of_time}
        for k in KEYS
    ]
    return f'<div hidden data-keys="{escaped(json.dumps(table))}"></div>'


def list_html() -> str:
    """The list of keys for people; the page's script writes what their keyboard has there."""
    first, last, zeroth = map(_shown, (LAYERS[0], LAYERS[-2], LAYERS[-1]))
    rows = [
        (_shown(PLAY), PLAY.does),
        (f"{_shown(STEP)}, {_shown(TRIAL)}", f"{STEP.does}, {TRIAL.does}"),
        (f"{_shown(SLOWER)}, {_shown(FASTER)}", f"{SLOWER.does}, {FASTER.does}"),
        (f"{first} … {last}, {zeroth}", "the layers, in their order"),
        *(
            (_shown(key), key.does)
            for key in (NEXT_SKILL, EXPLORE, FREEZE, UNDO, WATCH, CAMERA, PRESENT, SIDE)
        ),
        (f"{_shown(LIST)}, <kbd>?</kbd>", LIST.does),
        ("<kbd>Esc</kbd>", "close a list like this, or end the presentation"),
    ]
    in_time = [
        *(
            (f"{_shown(one)}, {_shown(other)}", f"{one.does}, {other.does}")
            for one, other in zip(TIME[:8:2], TIME[1:8:2], strict=True)
        ),
        *((_shown(key), key.does) for key in TIME[8:]),
        ("<kbd>\N{LEFTWARDS ARROW}</kbd> <kbd>\N{RIGHTWARDS ARROW}</kbd>", _ARROWS),
    ]
    table = _table("key", rows) + _table("in time", in_time)
    about = "".join(f"<p>{sentence}</p>" for sentence in _ABOUT)
    return (
        f'<div class="pounce-keys">{table}{about}'
        '<label><input type="checkbox" class="pounce-single-keys" checked> Single keys act, in this'
        " browser</label></div>"
    )


def _table(head: str, rows: Iterable[tuple[str, str]]) -> str:
    body = "".join(f"<tr><td>{shown}</td><td>{does}</td></tr>" for shown, does in rows)
    return (
        f"<table><thead><tr><th>{head}</th><th>does</th></tr></thead><tbody>{body}</tbody></table>"
    )


def _shown(key: Key) -> str:
    return f'<kbd data-code="{key.name}">{escaped(key.hotkey)}</kbd>'
