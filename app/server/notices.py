"""What a page is told and asked, each one at a time: the newest takes the place of the last.

A page that does what is refused again and again gets no pile of notifications, and one that never
reads has none waiting for it.
"""

import threading
import time
import weakref
from typing import Any, Final, NamedTuple

import viser
from viser._gui_handles import GuiModalHandle

UPDATE_S: Final = 1.0
"""What is told again within this time changes the notification that stands; a person may close it,
and one that comes later is to be seen."""

_lock = threading.Lock()


class _Notice(NamedTuple):
    handle: viser.NotificationHandle
    shown_s: float


_notices: weakref.WeakKeyDictionary[viser.ClientHandle, _Notice] = weakref.WeakKeyDictionary()
_modals: weakref.WeakKeyDictionary[viser.ClientHandle, GuiModalHandle] = weakref.WeakKeyDictionary()


def tell(
    client: viser.ClientHandle,
    title: str,
    body: str,
    *,
    color: Any = None,
    auto_close_seconds: float = 8.0,
) -> None:
    """Show a page a notification, in the place of the one that it was shown last."""
    now_s = time.monotonic()
    with _lock:
        last = _notices.get(client)
        if last is not None and now_s - last.shown_s < UPDATE_S:
            handle = last.handle
            handle.title, handle.body, handle.color = title, body, color
            handle.auto_close_seconds = auto_close_seconds
            return
        if last is not None:
            last.handle.remove()
        handle = client.add_notification(
            title, body, color=color, auto_close_seconds=auto_close_seconds
        )
        _notices[client] = _Notice(handle, now_s)


def open_modal(client: viser.ClientHandle, title: str) -> GuiModalHandle:
    """A modal of a page, in the place of the one that was opened there last."""
    with _lock:
        last = _modals.get(client)
        if last is not None:
            close_modal(last)
        modal = client.gui.add_modal(title)
        _modals[client] = modal
    return modal


def close_modal(modal: GuiModalHandle) -> None:
    """Close a modal, unless it is closed."""
    if not modal.closed:
        modal.close()
