"""The keys of the page, one row each; the page's script (``app/web/keys.js``) goes by it."""

import json
from collections.abc import Iterable
from html import escape
from typing import Any, Final, NamedTuple


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
CAMERA: Final = Key("KeyR", "R", "reset the camera")
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
    CAMERA,
    LIST,
)

_ABOUT: Final = (
    "Keys act by their place, whatever letter is there, but not while you type in a field. The"
    " arrows turn the camera.",
    "A click on the board inspects a cell; shift and a click sets the predator down there.",
)


def table_html() -> str:
    """The table of keys for the page's script; nothing is to be seen of it."""
    table = [{"code": k.code, "character": k.character, "repeats": k.repeats} for k in KEYS]
    return f'<div hidden data-keys="{escape(json.dumps(table))}"></div>'


def list_html() -> str:
    """The list of keys for people; the page's script writes what their keyboard has there."""
    rows = [
        _row([PLAY], PLAY.does),
        _row([STEP, TRIAL], f"{STEP.does}, {TRIAL.does}"),
        _row([SLOWER, FASTER], f"{SLOWER.does}, {FASTER.does}"),
        _row([LAYERS[0], LAYERS[-2], LAYERS[-1]], "the layers, in their order", " … "),
        *(_row([key], key.does) for key in (NEXT_SKILL, EXPLORE, FREEZE, CAMERA)),
        _row([LIST], LIST.does, more=", <kbd>?</kbd>"),
        "<tr><td><kbd>Esc</kbd></td><td>close a list like this</td></tr>",
    ]
    about = "".join(f"<p>{sentence}</p>" for sentence in _ABOUT)
    return (
        '<div class="pounce-keys"><table><thead><tr><th>key</th><th>does</th></tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table>{about}"
        '<label><input type="checkbox" class="pounce-single-keys" checked> Single keys act, in this'
        " browser</label></div>"
    )


def _row(keys: Iterable[Key], does: str, between: str = ", ", more: str = "") -> str:
    shown = between.join(f'<kbd data-code="{key.code}">{key.hotkey}</kbd>' for key in keys)
    return f"<tr><td>{shown}{more}</td><td>{does}</td></tr>"
