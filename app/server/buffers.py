"""viser's outgoing buffers, which are filled by one thread and emptied by another.

`AsyncMessageBuffer.push` sets an `asyncio.Event` from the thread that pushes, though such an event
belongs to the thread of its loop: while a page begins to wait there, setting it fails with "deque
mutated during iteration", which under load ends whoever pushed. It then asks the loop to set it,
which is all that is needed.
"""

import asyncio
import threading
from typing import Any

import viser
from viser.infra._async_message_buffer import AsyncMessageBuffer


def make_safe(server: viser.ViserServer) -> None:
    """Let any thread push to the buffers of a server, which nobody is connected to yet."""
    websocks = server._websock_server
    thread = websocks._server_thread
    assert thread is not None

    def make_safe_for(buffer: AsyncMessageBuffer) -> None:
        buffer.message_event = _LoopsEvent(thread)
        # A page may go away between two lines of a frame; what was meant for it is rightly lost.
        buffer._warned_push_after_done = True

    make_safe_for(websocks._broadcast_buffer)
    # Called before anybody waits for what is in the buffer of a page.
    websocks.on_client_connect(lambda page: make_safe_for(page.get_message_buffer()))


class _LoopsEvent(asyncio.Event):
    """An event that only the thread of its loop can set; to others, setting it does nothing."""

    def __init__(self, thread: threading.Thread) -> None:
        super().__init__()
        self._thread = thread

    def set(self) -> Any:
        if threading.current_thread() is self._thread:
            super().set()
