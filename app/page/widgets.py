"""Widgets show the state and never are the state: the two ways in which they meet it."""

import time
from collections.abc import Callable
from typing import Any, Final

import viser

from app.server.callbacks import guarded

TOUCHED_S = 0.5
"""A widget that was touched so lately is left alone: its request may still be on its way."""

NAME_HTML: Final = '<div class="pounce-name"></div>'
"""Stands before a field for a name, whose text the page's script is to leave as it is typed."""


def assign(handle: Any, name: str, value: object) -> None:
    """Set a property only if it differs, so that nothing is sent for nothing."""
    if getattr(handle, name) != value:
        # viser sends plain texts alone, and no markup.
        setattr(handle, name, str(value) if isinstance(value, str) else value)


def show(handle: Any, value: object) -> None:
    """Let an input show what is true, unless somebody has just changed it."""
    if handle.value != value and time.time() - handle.update_timestamp > TOUCHED_S:
        handle.value = value


def on_change(handle: Any, changed: Callable[[viser.GuiEvent, Any], object]) -> None:
    """Call back with the new value whenever a person, and not the program, changes an input.

    On the event loop and not in a thread of viser's pool, where the value would be read only after
    the render loop may have set it back to what was true before.
    """

    @guarded
    async def taken(event: viser.GuiEvent) -> None:
        if event.client is not None:
            changed(event, handle.value)

    handle.on_update(taken)
