"""A scene that several browsers see alike: drawn once, packed once, and sent to each.

viser has a scene for all browsers together and one for each. Between them, a stage is for those
that want to see the same: what is drawn on it goes nowhere by itself, but is kept as messages, of
each thing the newest. A browser gets those that came since its last frame, in one piece.
"""

import contextlib
import time
from types import SimpleNamespace
from typing import Any, cast

import msgspec.msgpack
import viser
import zstandard
from viser import _messages as wire
from viser import infra
from viser._scene_api import SceneApi

_ALIGNMENT = 8
"""Arrays in a frame begin at a multiple of so many bytes."""


class Stage:
    """A scene for browsers that look alike. Used by one thread."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._kept = _Newest()
        # As far as a scene cares, somebody with a connection: the one to which it sends.
        owner = SimpleNamespace(_websock_connection=self._kept, client_id="", _viser_server=server)
        self.scene = SceneApi(
            cast(viser.ClientHandle, owner), server._thread_executor, server.get_event_loop()
        )
        """Where to draw."""
        self._packed: dict[int, bytes] = {}
        self._packed_at = 0

    @property
    def now(self) -> int:
        """How many messages there have been: where a browser stands that has seen them all."""
        return self._kept.count

    def frame_since(self, seen: int) -> bytes | None:
        """All that is new since a browser stood at ``seen``, as one frame; None if nothing is.

        From 0 on, it is everything there is.
        """
        if seen == self.now:
            return None
        if self._packed_at != self.now:
            self._packed.clear()
            self._packed_at = self.now
        if seen not in self._packed:
            self._packed[seen] = packed(self._kept.since(seen))
        return self._packed[seen]

    def frame_in_place_of(self, former: "Stage") -> bytes:
        """All there is, for a browser that has what was drawn on another stage until now.

        What that has and this has not is taken away.
        """
        gone = sorted(former._kept.names() - self._kept.names("create"))
        removals = [wire.RemoveSceneNodeMessage(name) for name in gone]
        return packed([*removals, *self._kept.since(0)])


class _Newest(infra.WebsockMessageHandler):
    """What was to be sent: of each thing the newest message, in the order in which they came."""

    def __init__(self) -> None:
        super().__init__()
        self.count = 0
        self._messages: dict[str, tuple[int, infra.Message]] = {}

    def queue_message(self, message: infra.Message) -> None:
        if message.lifecycle_phase == "remove":
            # Nothing is left of what is gone but that it is gone.
            self.remove_entity_state_from_buffer("scene", cast(Any, message).name)
        key = message.redundancy_key()
        # Behind all others, wherever the one before it was.
        self._messages.pop(key, None)
        self.count += 1
        self._messages[key] = (self.count, message)

    def get_message_buffer(self) -> Any:
        return self

    def remove_entity_state_from_buffer(self, entity_type: str, entity_id: str) -> None:
        """Forget what was said of a thing, but not that it was made; viser calls this."""
        for key, (_, message) in list(self._messages.items()):
            if message.targets_entity_state(entity_type, entity_id):
                del self._messages[key]

    def names(self, *phases: str) -> set[str]:
        """Of all things that there are or were, or of which the last that is known is a phase."""
        phases = phases or ("create", "remove")
        messages = (message for _, message in self._messages.values())
        return {cast(Any, m).name for m in messages if m.lifecycle_phase in phases}

    def sanctioned_dead_writes(self) -> contextlib.AbstractContextManager[None]:
        """Nothing is ever dead here; viser calls this around what it sends as a node goes."""
        return contextlib.nullcontext()

    def since(self, seen: int) -> list[infra.Message]:
        """Messages that came after the first ``seen``, the oldest first."""
        found: list[infra.Message] = []
        for number, message in reversed(self._messages.values()):
            if number <= seen:
                break
            found.append(message)
        return found[::-1]


def packed(messages: list[wire.Message] | list[infra.Message]) -> bytes:
    """Messages as viser's page takes them from a websocket.

    Two sizes (little-endian, 8 bytes each), the messages (MessagePack, compressed), and their
    arrays, each from a multiple of 8 bytes on.
    """
    arrays: list[memoryview] = []
    inner = msgspec.msgpack.encode(
        {
            "messages": tuple(message.as_serializable_dict(arrays) for message in messages),
            "timestampSec": time.perf_counter(),
            "binaryBufferLengths": tuple(array.nbytes for array in arrays),
        }
    )
    compressed = zstandard.compress(inner, level=1)
    head = len(inner).to_bytes(8, "little") + len(compressed).to_bytes(8, "little")
    parts: list[bytes | memoryview] = [head, compressed]
    length = len(head) + len(compressed)
    for array in arrays:
        padding = bytes(-length % _ALIGNMENT)
        parts += [padding, array]
        length += len(padding) + array.nbytes
    return b"".join(parts)
