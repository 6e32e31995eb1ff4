"""The keys of the page, one row each; the page's script (``app/web/keys.js``) goes by it."""

import json
from typing import Any, Final, NamedTuple

from app.util.html import escaped


class Key(NamedTuple):
    """One key that acts by itself, whatever is written on it."""

    code: str
    """Its place, by the name that browsers have for it: what an American keyboard has there."""
    hotkey: Any
    """What viser calls it."""
    does: str
    repeats: bool = False
    """Whether it acts again and again while it is held down."""

    @property
    def character(self) -> str:
        """What it types on an American keyboard."""
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
LIST: Final = Key("KeyH", "H", "this list")
"""As does ?, wherever it is."""
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
    LIST,
)

_ABOUT: Final = (
    "Keys act by their place, whatever letter is there, but not while you type in a field.",
    "A click on the board inspects a cell; shift and a click sets the predator down there. A drag"
    " moves the board, the wheel or two fingers zoom.",
)


def table_html() -> str:
    """The table of keys for the page's script; nothing is to be seen of it."""
    table = [{"code": k.code, "character": k.character, "repeats": k.repeats} for k in KEYS]
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
            for key in (NEXT_SKILL, EXPLORE, FREEZE, UNDO, WATCH, CAMERA, PRESENT)
        ),
        (f"{_shown(LIST)}, <kbd>?</kbd>", LIST.does),
        ("<kbd>Esc</kbd>", "close a list like this, or end the presentation"),
    ]
    table = "".join(f"<tr><td>{shown}</td><td>{does}</td></tr>" for shown, does in rows)
    about = "".join(f"<p>{sentence}</p>" for sentence in _ABOUT)
    return (
        '<div class="pounce-keys"><table><thead><tr><th>key</th><th>does</th></tr></thead>'
        f"<tbody>{table}</tbody></table>{about}"
        '<label><input type="checkbox" class="pounce-single-keys" checked> Single keys act, in this'
        " browser</label></div>"
    )


def _shown(key: Key) -> str:
    return f'<kbd data-code="{key.code}">{key.hotkey}</kbd>'
