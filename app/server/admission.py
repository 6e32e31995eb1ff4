"""Which messages of a page are let through, and what it is told of those that are not."""

import asyncio
import functools
import logging
import math
from collections.abc import Callable
from typing import Any, Final, NamedTuple, cast

import viser
from viser import _messages as wire
from viser._gui_handles import GuiFormHandle
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode

from app.server.door import Door
from app.server.outbox import WATCH_S, Outbox
from app.server.pace import ACTED_S, RECEIVED_S, Pace
from app.server.shapes import NotAMessageError, SenselessError, Shaped, read
from app.server.values import name_of, update_fault
from app.server.workers import Workers

MAX_FILE_NAME_CHARACTERS: Final = 255

GRACE_S: Final = 1.5
"""How long a page may take to mend a wrong value itself before it is set right and told.

A number field sends every keystroke, so 15 typed into a field for 10 to 100 arrives as 1 and then
as 15; putting the old value back in between would make typing impossible.
"""

TELL_S = 0.25
"""A page is told at most once in this time why something was dropped: the newest reason."""

DOUBLE_S = 0.4
"""A click on the same button that comes so soon is the second of a double click, and not meant."""

UPLOAD_S = 30.0
"""An upload of which nothing has come for so long makes room for another."""

_TURN_S = 0.01
"""How soon a page whose callbacks take their time is looked at again."""

log = logging.getLogger(__name__)


class CheckedConnection(ServerConnection):
    """A websocket connection from which only admissible messages are received.

    What the page sends faster than it is worth acting on waits, and so does the page in the end:
    its messages stay in the network. A page that does not take what is sent to it is let go.
    """

    def __init__(self, *args: Any, door: Door, **options: Any) -> None:
        super().__init__(*args, **options)
        self._door = door
        self._pace = Pace()

    @functools.cached_property
    def _desk(self) -> "_Desk":
        # viser enters the connection in this table before it first receives from it.
        server = self._door.server
        assert server is not None
        table = server._websock_server._live_connections
        client_id = next(number for number, other in table.items() if other is self)
        desk = _Desk(server, client_id, self._door)
        self._watch(Outbox(server._websock_server._client_state_from_id[client_id].message_buffer))
        return desk

    async def recv(self, decode: bool | None = None) -> Any:
        desk = self._desk
        while True:
            message = self._pace.next(self.loop.time())
            if message is None:
                await self._take_in(decode)
                continue
            await self._pay(ACTED_S)
            # Frames that wait in the queue come without a pause. With one, viser has acted on the
            # message before, and this one is judged by the state that it left.
            await asyncio.sleep(0)
            while not desk.may_act():
                await asyncio.sleep(_TURN_S)
            if desk.admits(message):
                return message.frame

    async def _take_in(self, decode: bool | None) -> None:
        """Wait for the next frame, or until it is time for a message that is held."""
        try:
            async with asyncio.timeout(self._pace.wait_s(self.loop.time())):
                frame = await super().recv(decode)
        except TimeoutError:
            return
        except ConnectionClosed:
            # What the page sent before it went is worth as much as if it had stayed.
            if not self._pace.release():
                raise
            return
        await self._pay(RECEIVED_S)
        try:
            message = read(frame, RULES)
        except SenselessError as error:
            self._desk.refuse(str(error))
        except NotAMessageError:
            log.info("closed a connection that sent something else than messages")
            await self.close(CloseCode.UNSUPPORTED_DATA, "not a message")
            # What viser takes for an ordinary end, unlike the decoder's own errors.
            raise self.protocol.close_exc from None
        else:
            self._desk.queue(message, self._pace, self.loop.time())

    async def _pay(self, cost_s: float) -> None:
        wait_s = self._pace.charge(cost_s, self.loop.time())
        if wait_s > 0:
            await asyncio.sleep(wait_s)

    def _watch(self, outbox: Outbox) -> None:
        """Look at what waits for the page, again and again; end the connection if it must."""
        if self.transport.is_closing():
            return
        fault = outbox.fault(self.transport.get_write_buffer_size(), self.loop.time())
        if fault is None:
            self.loop.call_later(WATCH_S, self._watch, outbox)
            return
        log.warning("closed the connection of a page: %s", fault)
        # Not with a farewell, for which it would have to take all that waits.
        self.transport.abort()


class _Transfer(NamedTuple):
    """A file that is on its way from one page."""

    gui: viser.GuiApi
    transfer_uuid: str
    source_uuid: str
    latest_s: float
    """When something of it came last, on the event loop's clock."""


class _Desk:
    """Judges the messages of one page, and sets the page right when one was dropped."""

    def __init__(self, server: viser.ViserServer, client_id: int, door: Door) -> None:
        self._server = server
        self._client_id = client_id
        self._door = door
        self._loop = asyncio.get_running_loop()
        self._transfer: _Transfer | None = None
        self._corrections: dict[str, asyncio.TimerHandle] = {}
        self._pressed = ("", -math.inf)
        """The button that was pressed last, and when."""
        self._reason: str | None = None
        self._told_s = -math.inf

    def queue(self, message: Shaped, pace: Pace, now_s: float) -> None:
        """Put a message where it belongs by what it is about."""
        content = message.content
        if message.kind is wire.ViewerCameraMessage:
            pace.take_value(wire.ViewerCameraMessage, message, now_s, apart=True)
        elif (
            message.kind is wire.GuiUpdateMessage
            and self._has_value(content.uuid)
            # A text that is finished counts, though its keystrokes may come once more behind it.
            and not _is_finished_text(content.updates.get("value"))
        ):
            pace.take_value(content.uuid, message, now_s)
        elif message.kind is wire.CommandTriggerMessage and self._is_command(content.uuid):
            pace.take_press(content.uuid, message, now_s)
        else:
            pace.take_act(message)

    def may_act(self) -> bool:
        """Whether another message of this page may have callbacks run."""
        return cast(Workers, self._server._thread_executor).is_free_for(self._client_id)

    def admits(self, message: Shaped) -> bool:
        """Whether viser may see this message; if not, what has to follow is under way."""
        if self._client is None and message.kind not in _MESSAGES_BEFORE_THE_FIRST_PICTURE:
            return False
        return RULES[message.kind](self, message.content)

    # Each rule says whether the message may pass. Messages for something that is not there (any
    # more) are dropped without a word: removing a widget while it is in use is nobody's fault.

    def _pass(self, message: Any) -> bool:
        return True

    def _click_or_box(self, message: wire.ScenePointerMessage) -> bool:
        # viser takes these fields for granted.
        if message.event_type == "click":
            ray = (message.ray_origin, message.ray_direction)
            return None not in ray and len(message.screen_pos) == 1
        return len(message.screen_pos) == 2

    def _update(self, message: wire.GuiUpdateMessage) -> bool:
        handle = self._input(message.uuid)
        if handle is None:
            return False
        correction = self._corrections.pop(message.uuid, None)
        if correction is not None:
            correction.cancel()
        # The first click may have had the button go away: nothing is to be said of the second.
        if isinstance(handle, viser.GuiButtonHandle) and self._is_second_click(message.uuid):
            return False
        fault = self._unavailable(handle) or update_fault(handle, message.updates)
        if fault is not None:
            self._corrections[message.uuid] = self._loop.call_later(
                GRACE_S, self._correct, handle, fault
            )
        return fault is None

    def _is_second_click(self, uuid: str) -> bool:
        former, self._pressed = self._pressed, (uuid, self._loop.time())
        return former[0] == uuid and self._pressed[1] - former[1] < DOUBLE_S

    def _hold(self, message: wire.GuiButtonHoldMessage) -> bool:
        handle = self._input(message.uuid)
        if handle is None:
            return False
        fault = self._unavailable(handle)
        if fault is not None:
            self.refuse(fault)
        return fault is None

    def _form(self, message: wire.GuiFormSubmitMessage | wire.GuiFormDirtyMessage) -> bool:
        for gui in self._guis:
            form = gui._container_handle_from_uuid.get(message.uuid)
            if isinstance(form, GuiFormHandle):
                return not _is_hidden(form)
        return False

    def _upload(self, message: wire.FileTransferStartUpload) -> bool:
        handle = self._input(message.source_component_uuid)
        if handle is None:
            return False
        fault = self._unavailable(handle) or self._upload_fault(handle, message)
        if fault is not None:
            self._end_upload(message.source_component_uuid, message.transfer_uuid)
            self.refuse(fault)
            return False
        self._transfer = _Transfer(
            handle._impl.gui_api,
            message.transfer_uuid,
            message.source_component_uuid,
            self._loop.time(),
        )
        return True

    def _upload_fault(self, handle: Any, message: wire.FileTransferStartUpload) -> str | None:
        name = name_of(handle)
        if not isinstance(handle, viser.GuiUploadButtonHandle):
            return f"{name} takes no file."
        if not 0 <= message.size_bytes <= self._door.max_upload_bytes:
            return f"{name} takes files of at most {self._door.max_upload_bytes // 1024} KiB."
        # The page sends parts of 512 KiB; tiny ones would cost far more memory than they carry.
        if not min(1, message.size_bytes) <= message.part_count <= -(-message.size_bytes // 2**16):
            return f"{name} got a file in a strange number of parts."
        if not 0 < len(message.filename) <= MAX_FILE_NAME_CHARACTERS:
            return f"{name} takes file names of at most {MAX_FILE_NAME_CHARACTERS} characters."
        if self._transfer is not None and self._loop.time() - self._transfer.latest_s > UPLOAD_S:
            self._give_up(self._transfer)
        # Also no second transfer under a name in use, which would take the first one's place.
        names = {message.transfer_uuid}
        if self._transfer is not None:
            names.add(self._transfer.transfer_uuid)
        if any(names & gui._current_file_upload_states.keys() for gui in self._guis):
            return f"{name} is busy with another file."
        return None

    def _upload_part(self, message: wire.FileTransferPart) -> bool:
        transfer = self._transfer
        # viser neither asks whose transfer a part is for, nor which widget started it.
        wanted = (message.transfer_uuid, message.source_component_uuid)
        if transfer is None or wanted != (transfer.transfer_uuid, transfer.source_uuid):
            return False
        state = transfer.gui._current_file_upload_states.get(transfer.transfer_uuid)
        if state is None or message.part_index in state["parts"]:
            return False
        if not 0 <= message.part_index < state["part_count"]:
            return False
        left = state["total_bytes"] - state["transferred_bytes"] - len(message.content)
        is_last = len(state["parts"]) + 1 == state["part_count"]
        if left < 0 or (is_last and left > 0):
            self._give_up(transfer)
            self.refuse(f"This file is {'longer' if left < 0 else 'shorter'} than announced.")
            return False
        self._transfer = transfer._replace(latest_s=self._loop.time())
        return True

    def _give_up(self, transfer: _Transfer) -> None:
        transfer.gui._current_file_upload_states.pop(transfer.transfer_uuid, None)
        self._end_upload(transfer.source_uuid, transfer.transfer_uuid)
        self._transfer = None

    @property
    def _client(self) -> viser.ClientHandle | None:
        """The page's handle; None before its first camera message, when it shows nothing yet."""
        return self._server._connected_clients.get(self._client_id)

    @property
    def _guis(self) -> tuple[viser.GuiApi, ...]:
        """The panels that the page shows: everyone's, and its own."""
        client = self._client
        return (self._server.gui,) if client is None else (self._server.gui, client.gui)

    def _input(self, uuid: str) -> Any:
        for gui in self._guis:
            handle = gui._gui_input_handle_from_uuid.get(uuid)
            if handle is not None and not handle._impl.removed:
                return handle
        return None

    def _has_value(self, uuid: str) -> bool:
        handle = self._input(uuid)
        return handle is not None and not handle._impl.is_button

    def _is_command(self, uuid: str) -> bool:
        return any(uuid in gui._command_handle_from_uuid for gui in self._guis)

    def _unavailable(self, handle: Any) -> str | None:
        # The props, because a button group's handle always says that it is enabled.
        disabled = getattr(handle._impl.props, "disabled", False)
        if self._client is None or disabled or _is_hidden(handle):
            return f"{name_of(handle)} is not available now."
        return None

    def refuse(self, reason: str) -> None:
        """Tell the page why something was dropped; of several reasons in a moment, the last."""
        if self._reason is None:
            # Not at once: what the callback raises is not to end the connection.
            self._loop.call_at(self._told_s + TELL_S, self._tell)
        self._reason = reason

    def _tell(self) -> None:
        reason, self._reason = self._reason, None
        self._told_s = self._loop.time()
        log.info("dropped a message of client %d: %s", self._client_id, reason)
        if reason is not None and self._door.on_refused is not None and self._client is not None:
            self._door.on_refused(self._client_id, reason)

    def _correct(self, handle: Any, reason: str) -> None:
        """Put the true value back into the page's widget, and say why."""
        state = handle._impl
        self._corrections.pop(state.uuid, None)
        if not (state.removed or state.is_button):
            self._send(wire.GuiUpdateMessage(state.uuid, {"value": state.value}))
        self.refuse(reason)

    def _end_upload(self, source_uuid: str, transfer_uuid: str) -> None:
        """Have the page give up an upload: it disables the button until all is acknowledged."""
        self._send(wire.FileTransferPartAck(source_uuid, transfer_uuid, 0, 0))
        self._send(wire.RemoveNotificationMessage(f"upload-{transfer_uuid}"))

    def _send(self, message: wire.Message) -> None:
        # The page's own queue: nobody else hears of it. It is gone once the page is.
        state = self._server._websock_server._client_state_from_id.get(self._client_id)
        if state is not None:
            state.message_buffer.push(message)


RULES: Final[dict[type[wire.Message], Callable[[_Desk, Any], bool]]] = {
    wire.ViewerCameraMessage: _Desk._pass,
    wire.GetRenderResponseMessage: _Desk._pass,
    wire.LocalStorageGetItemResponseMessage: _Desk._pass,
    wire.SceneNodeClickMessage: _Desk._pass,
    wire.SceneNodeDragMessage: _Desk._pass,
    wire.TransformControlsUpdateMessage: _Desk._pass,
    wire.TransformControlsDragStartMessage: _Desk._pass,
    wire.TransformControlsDragEndMessage: _Desk._pass,
    wire.ScenePointerMessage: _Desk._click_or_box,
    wire.GuiUpdateMessage: _Desk._update,
    wire.GuiButtonHoldMessage: _Desk._hold,
    wire.GuiFormSubmitMessage: _Desk._form,
    wire.GuiFormDirtyMessage: _Desk._form,
    wire.CommandTriggerMessage: _Desk._pass,  # viser itself asks whether it is enabled
    wire.FileTransferStartUpload: _Desk._upload,
    wire.FileTransferPart: _Desk._upload_part,
}
"""Everything that viser's page sends by itself, but for the requests for a share tunnel."""


def _is_finished_text(value: object) -> bool:
    return isinstance(value, str) and value.endswith("\n")


_MESSAGES_BEFORE_THE_FIRST_PICTURE: Final = (
    wire.ViewerCameraMessage,  # makes it a client, in viser's eyes
    wire.GuiUpdateMessage,  # refused then, but with the true value in return
)


def _is_hidden(handle: Any) -> bool:
    """Whether the widget or anything that it lies in is not shown."""
    state = handle._impl
    while state is not None:
        if not getattr(state.props, "visible", True):
            return True
        uuid = getattr(state, "parent_container_id", "root")
        if uuid == "root":
            return False
        try:
            container = state.gui_api._resolve_container_handle(uuid)
        except KeyError:
            return True  # Removed by another thread just now.
        # A tab is shown with the tab group or panel that it belongs to; a modal always is.
        state = getattr(getattr(container, "_parent", container), "_impl", None)
    return False
