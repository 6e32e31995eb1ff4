"""Which messages of a page are let through, tested from outside."""

import logging
import math
import queue
import socket
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest
import viser
from viser import _messages as wire

from app.server import admission, callbacks
from app.server.server import MAX_MESSAGE_BYTES
from tests.support.server import (
    CAMERA,
    PATIENCE_S,
    Lab,
    Page,
    UploadLab,
    get,
    is_update,
    lab_of,
    part_of,
    start_of,
)

# --- Values --------------------------------------------------------------------------------------


@pytest.fixture(autouse=True)
def every_reason_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(admission, "TELL_S", 0.0)


def add_widgets(gui: viser.GuiApi) -> dict[str, Any]:
    widgets = {
        "slider": gui.add_slider("Slider", 0.0, 1.0, 0.1, 0.5),
        "whole slider": gui.add_slider("Whole slider", 0, 10, 1, 5),
        "number": gui.add_number("Number", 5.0),
        "whole number": gui.add_number("Whole number", 50, min=10, max=100),
        "checkbox": gui.add_checkbox("Checkbox", False),
        "text": gui.add_text("Text", "nothing"),
        "dropdown": gui.add_dropdown("Dropdown", ("flat", "timed")),
        "choice": gui.add_button_group("Choice", ("slow", "fast")),
        "marks": gui.add_multi_slider("Marks", 0, 10, 1, (2, 5, 8)),
        "ends": gui.add_multi_slider("Ends", 0.0, 1.0, 0.1, (0.0, 0.5, 1.0), fixed_endpoints=True),
        "rgb": gui.add_rgb("Colour", (1, 2, 3)),
        "rgba": gui.add_rgba("Colour with alpha", (1, 2, 3, 4)),
        "vector2": gui.add_vector2("Point", (0.0, 0.0), min=(-1.0, -2.0), max=(1.0, 2.0)),
        "vector3": gui.add_vector3("Place", (0.0, 0.0, 0.0)),
        "button": gui.add_button("Button"),
        "upload": gui.add_upload_button("File"),
        "progress": gui.add_progress_bar(10.0),
        "disabled": gui.add_slider("Disabled", 0, 10, 1, 5, disabled=True),
        "disabled choice": gui.add_button_group("Choice", ("slow", "fast"), disabled=True),
        "hidden": gui.add_checkbox("Hidden", False, visible=False),
    }
    with gui.add_folder("Folder", visible=False), gui.add_folder("Inner"):
        widgets["in hidden folder"] = gui.add_checkbox("In a hidden folder", False)
    panel = gui.add_panel(visible=False)
    with panel.add_tab("Tab"):
        widgets["in hidden panel"] = gui.add_checkbox("In a hidden panel", False)
    with gui.add_tab_group().add_tab("Tab"):
        widgets["in tab"] = gui.add_checkbox("In a tab", False)
    with gui.add_modal("Modal"):
        widgets["in modal"] = gui.add_checkbox("In a modal", False)
    return widgets


@pytest.fixture(scope="module", params=["everyone's panel", "the page's own panel"])
def stage(request: pytest.FixtureRequest) -> Iterator[tuple[Lab, Page, dict[str, Any]]]:
    """A lab, a page and widgets of each kind, which every test must leave as they were."""
    with lab_of() as lab:
        page, client = lab.page()
        gui = lab.server.gui if request.param == "everyone's panel" else client.gui
        yield lab, page, add_widgets(gui)


NAN, INFINITY = math.nan, math.inf

ILLEGAL_VALUES = (
    *(("slider", v) for v in (99, -0.1, 1.0000001, NAN, INFINITY, -INFINITY, True)),
    *(("slider", v) for v in ("0.5", None, [0.5], {"x": 1}, b"1", [])),
    *(("whole slider", v) for v in (11, -1, 2.5, NAN, True, "3")),
    *(("number", v) for v in (NAN, INFINITY, False, "1e3", None)),
    *(("whole number", v) for v in (9, 101, 10.5, 2**63)),
    *(("checkbox", v) for v in (1, 0, "true", None, [])),
    *(("text", v) for v in ("x" * 2_001, 5, None, ["a"], b"bytes")),
    *(("dropdown", v) for v in ("unknown", "Flat", "", 0, None, ["flat"], {"flat": 1})),
    *(("choice", v) for v in ("unknown", True, 1)),
    *(("marks", v) for v in ([2, 5], [2, 5, 8, 9], [2, 5, 11], [-1, 5, 8], [8, 5, 2])),
    *(("marks", v) for v in ([2, 5.5, 8], [2, NAN, 8], [2, True, 8], 5, "258", None)),
    *(("ends", v) for v in ([0.1, 0.5, 1.0], [0.0, 0.5, 0.9])),
    *(("rgb", v) for v in ([1, 2], [1, 2, 256], [-1, 2, 3], [1.5, 2, 3], [1, 2, True], "#fff")),
    *(("rgba", v) for v in ([1, 2, 3], [1, 2, 3, 300])),
    *(("vector2", v) for v in ([0, 3], [-2, 0], [0, NAN], [0], [0, 0, 0])),
    *(("vector3", v) for v in ([0, 0], [0, 0, INFINITY], [0, 0, "1"], {"0": 0, "1": 0, "2": 0})),
    *(("button", v) for v in (1, "yes", None)),
    *(("upload", v) for v in (True, "file", {"name": "x", "content": b"y"})),
    *(("progress", v) for v in (50.0, "x")),
    ("disabled", 7),
    ("disabled choice", "fast"),
    *((name, True) for name in ("hidden", "in hidden folder", "in hidden panel")),
)


@pytest.mark.parametrize(("name", "value"), ILLEGAL_VALUES, ids=repr)
def test_illegal_value_is_dropped(stage: Any, name: str, value: Any) -> None:
    lab, page, widgets = stage
    handle = widgets[name]
    before, since = handle.value, handle.update_timestamp
    page.set(handle, value)
    assert lab.hears(page)
    assert (handle.value, type(handle.value)) == (before, type(before))
    assert handle.update_timestamp == since
    assert handle._impl.props.__dict__.get("label", "This") in lab.reason()
    assert lab.refused.empty()


def test_a_double_click_is_one_click(stage: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    lab, page, widgets = stage
    button = widgets["button"]._impl.gui_api.add_button("Twice")
    pressed: queue.Queue[Any] = queue.Queue()
    button.on_click(pressed.put)
    monkeypatch.setattr(admission, "DOUBLE_S", 1_000.0)
    for _ in range(2):
        page.set(button, True)
    assert lab.hears(page)
    pressed.get(timeout=PATIENCE_S)
    assert pressed.empty()
    # Nor is it complained of when the first of the two has the button go away.
    button.visible = False
    page.set(button, True)
    assert lab.hears(page)
    assert lab.refused.empty()
    button.remove()


LEGAL_VALUES = (
    ("slider", 1, 1.0),
    ("slider", 0.25, 0.25),
    ("whole slider", 3.0, 3),
    ("whole slider", 10, 10),
    ("number", -1e300, -1e300),
    ("whole number", 15, 15),
    ("checkbox", True, True),
    ("text", "x" * 2_000, "x" * 2_000),
    ("dropdown", "timed", "timed"),
    ("choice", "fast", "fast"),
    ("marks", [0, 5, 5], (0, 5, 5)),
    ("ends", [0, 0.7, 1], (0.0, 0.7, 1.0)),
    ("rgb", [0, 255, 7], (0, 255, 7)),
    ("rgba", [0, 255, 7, 0], (0, 255, 7, 0)),
    ("vector2", [1, -2], (1.0, -2.0)),
    ("vector3", [1e9, 0, -1], (1e9, 0.0, -1.0)),
    ("button", True, True),
    ("in tab", True, True),
    ("in modal", True, True),
)


@pytest.mark.parametrize(("name", "value", "expected"), LEGAL_VALUES)
def test_legal_value_is_taken(stage: Any, name: str, value: Any, expected: Any) -> None:
    lab, page, widgets = stage
    handle = widgets[name]
    before = handle.value
    page.set(handle, value)
    assert lab.hears(page)
    taken, handle.value = handle.value, before
    assert repr(taken) == repr(expected)
    assert lab.refused.empty()


@pytest.mark.parametrize(
    "updates",
    [
        {"disabled": True},
        {"update_cb": []},
        {"removed": True},
        {"value": 0.25, "label": "<b>"},
        {"max": 99.0, "value": 0.25},
        {"props": {}},
        {"Value": 0.25},
        {0: 0.25},
        {},
    ],
    ids=repr,
)
def test_only_the_value_can_be_set(stage: Any, updates: dict[Any, Any]) -> None:
    lab, page, widgets = stage
    handle = widgets["slider"]
    before = dict(vars(handle._impl)) | {"props": dict(vars(handle._impl.props))}
    page.update(handle, updates)
    assert lab.hears(page)
    assert dict(vars(handle._impl)) | {"props": dict(vars(handle._impl.props))} == before
    assert lab.reason() == "This page tried to change more than a value."


def test_limits_are_those_of_the_moment(lab: Lab) -> None:
    page, _ = lab.page()
    slider = lab.server.gui.add_slider("Slider", 0, 10, 1, 5)
    names = ["flat", "timed"]
    menu = lab.server.gui.add_dropdown("Menu", names)
    slider.max, menu.options = 20, ("timed", "new")
    page.set(slider, 15)
    page.set(menu, "new")
    assert lab.hears(page)
    assert (slider.value, menu.value) == (15, "new")
    slider.disabled = True
    page.set(slider, 1)
    page.set(menu, "flat")
    assert lab.hears(page)
    assert (slider.value, menu.value) == (15, "new")


def test_removed_widget_is_dropped_without_a_word(lab: Lab) -> None:
    page, _ = lab.page()
    slider = lab.server.gui.add_slider("Slider", 0, 10, 1, 5)
    slider.remove()
    page.set(slider, 7)
    assert lab.hears(page)
    assert slider.value == 5
    assert lab.refused.empty()


def test_page_is_set_right_and_no_other_hears_of_it(lab: Lab) -> None:
    slider = lab.server.gui.add_slider("Slider", 0.0, 1.0, 0.1, 0.5)
    (culprit, client), (bystander, _) = lab.page(), lab.page()
    culprit.set(slider, 99)
    *_, correction = culprit.receive_until(lambda message: is_update(message, slider))
    assert correction["updates"] == {"value": 0.5}
    assert lab.refused.get(timeout=PATIENCE_S) == (client.client_id, "Slider must be at most 1.0.")
    assert lab.hears(culprit)
    heard = bystander.receive_until(lab.is_probe)
    assert not any(is_update(message, slider) for message in heard)


def test_value_that_the_page_mends_itself_is_no_refusal(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(admission, "GRACE_S", 3_600.0)
    typed = lab.server.gui.add_number("Typed", 50, min=10, max=100)
    other = lab.server.gui.add_number("Other", 50, min=10, max=100)
    page, client = lab.page()
    page.set(typed, 1)
    assert lab.hears(page)
    connection: Any = lab.server._websock_server._live_connections[client.client_id]
    (correction,) = connection._desk._corrections.values()
    page.set(typed, 15)
    assert lab.hears(page)
    assert correction.cancelled()
    assert typed.value == 15
    monkeypatch.setattr(admission, "GRACE_S", 0.0)
    page.set(other, 1)
    assert lab.reason() == "Other must be at least 10."


def test_page_without_a_picture_changes_nothing(lab: Lab) -> None:
    slider = lab.server.gui.add_slider("Slider", 0, 10, 1, 5)
    page, _ = lab.page()
    silent = lab.silent_page()
    silent.set(slider, 7)
    *_, correction = silent.receive_until(lambda message: is_update(message, slider))
    assert correction["updates"] == {"value": 5}
    assert slider.value == 5
    assert lab.hears(page)


# --- Other messages ------------------------------------------------------------------------------


@pytest.mark.usefixtures("no_traceback")
@pytest.mark.parametrize(
    "frame",
    [
        b"",
        b"garbage",
        b"\xff" * 100,
        b"\x91" * 100_000,
        "text",
        *(
            msgspec.msgpack.encode(content)
            for content in (
                5,
                [],
                {},
                {"type": []},
                {"type": "NoSuchMessage"},
                {"type": "GuiUpdateMessage"},
                {"type": "GuiUpdateMessage", "uuid": "a", "updates": {}, "extra": 1},
                {"type": "ViewerCameraMessage", "wxyz": 5},
            )
        ),
    ],
    ids=lambda frame: repr(frame[:30]),
)
def test_unreadable_frame_ends_only_its_connection(lab: Lab, frame: bytes | str) -> None:
    page, _ = lab.page()
    culprit, _ = lab.page()
    culprit.send_frame(frame)
    assert culprit.close_code() == 1003
    assert lab.hears(page)


@pytest.mark.usefixtures("no_traceback")
def test_too_large_frame_ends_only_its_connection(lab: Lab) -> None:
    page, _ = lab.page()
    culprit, _ = lab.page()
    culprit.send_frame(bytes(MAX_MESSAGE_BYTES + 1))
    assert culprit.close_code() == 1009
    assert lab.hears(page)


@pytest.mark.usefixtures("no_traceback")
def test_garbage_instead_of_a_request_is_not_worth_a_traceback(lab: Lab) -> None:
    for garbage in (b"\x00\x01\r\n\r\n", b"POST / HTTP/1.1\r\nHost: localhost\r\n\r\n"):
        with socket.create_connection(("127.0.0.1", lab.port), timeout=PATIENCE_S) as raw:
            raw.sendall(garbage)
            raw.makefile("rb").read()
    assert get(lab.port).status == 200


@pytest.mark.usefixtures("no_traceback")
@pytest.mark.parametrize(
    "mapping",
    [
        {"type": "GuiUpdateMessage", "uuid": [], "updates": {"value": 1}},
        {"type": "GuiUpdateMessage", "uuid": "a", "updates": 5},
        {"type": "GuiFormDirtyMessage", "uuid": {}},
        {"type": "ViewerCameraMessage", **vars(CAMERA), "position": (NAN, 0.0, 0.0)},
        {"type": "GuiRemoveMessage", "uuid": "a"},
        {"type": "RunJavascriptMessage", "source": "alert(1)"},
        {"type": "ShareUrlRequest"},
        {"type": "ShareUrlDisconnect"},
    ],
    ids=lambda mapping: mapping["type"],
)
def test_senseless_message_is_dropped(lab: Lab, mapping: dict[str, Any]) -> None:
    page, client = lab.page()
    page.send_frame(msgspec.msgpack.encode(mapping))
    assert lab.reason() == "This page sent a message that makes no sense here."
    assert lab.hears(page)
    assert client.camera.position[0] == 0.0


def test_no_page_starts_a_share_tunnel(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    tunnels: list[Any] = []
    monkeypatch.setattr("viser._viser.ViserTunnel", lambda *address: tunnels.append(address))
    page, _ = lab.page()
    page.send(wire.ShareUrlRequest())
    assert lab.reason()
    assert lab.hears(page)
    assert tunnels == []
    # Nor is there anyone to hear such a request, were it let through.
    assert wire.ShareUrlRequest not in lab.server._websock_server._incoming_handlers
    assert wire.ShareUrlDisconnect not in lab.server._websock_server._incoming_handlers
    theme = page.receive_until(lambda message: message["type"] == "ThemeConfigurationMessage")[-1]
    assert theme["show_share_button"] is False


@pytest.mark.usefixtures("no_traceback")
@pytest.mark.parametrize(
    ("kind", "ray", "corners", "heard"),
    [
        ("click", (0.0, 0.0, 1.0), ((0.5, 0.5),), True),
        ("click", None, ((0.5, 0.5),), False),
        ("click", (0.0, 0.0, 1.0), (), False),
        ("click", (0.0, 0.0, NAN), ((0.5, 0.5),), False),
        ("rect-select", None, ((0.0, 0.0), (1.0, 1.0)), True),
        ("rect-select", None, ((0.0, 0.0),), False),
        ("hover", (0.0, 0.0, 1.0), ((0.5, 0.5),), False),
    ],
)
def test_incomplete_click_is_dropped(
    lab: Lab, kind: Any, ray: Any, corners: Any, heard: bool
) -> None:
    events: queue.Queue[Any] = queue.Queue()
    lab.server.scene.on_click()(events.put)
    lab.server.scene.on_rect_select()(events.put)
    page, _ = lab.page()
    page.send(wire.ScenePointerMessage(kind, ray, ray, corners, None))
    if heard:
        events.get(timeout=PATIENCE_S)
    assert lab.hears(page)
    assert events.empty()


def test_commands_and_held_buttons_must_be_enabled(lab: Lab) -> None:
    calls: queue.Queue[str] = queue.Queue()
    command = lab.server.gui.add_command("Command")
    command.on_trigger(lambda _: calls.put("command"))
    button = lab.server.gui.add_button("Button")
    button.on_hold(lambda _: calls.put("hold"), callback_hz=10.0)
    page, _ = lab.page()

    def use_both() -> None:
        page.send(wire.CommandTriggerMessage(command._impl.uuid))
        page.send(wire.GuiButtonHoldMessage(button._impl.uuid, 10.0))
        page.send(wire.GuiButtonHoldMessage(button._impl.uuid, 11.0))
        page.send(wire.CommandTriggerMessage("unknown"))
        assert lab.hears(page)

    use_both()
    assert {calls.get(timeout=PATIENCE_S) for _ in range(2)} == {"command", "hold"}
    command.disabled = button.disabled = True
    use_both()
    assert lab.reason() == "Button is not available now."
    assert calls.empty()


def test_only_forms_that_are_there_can_be_edited_and_submitted(lab: Lab) -> None:
    submitted: queue.Queue[Any] = queue.Queue()
    form = lab.server.gui.add_form("Form")
    form.on_submit(submitted.put)
    (page, _), (bystander, _) = lab.page(), lab.page()
    uuid = form._impl.uuid
    for message in (wire.GuiFormDirtyMessage, wire.GuiFormSubmitMessage):
        page.send(message("unknown"))
        page.send(message(uuid))
    submitted.get(timeout=PATIENCE_S)
    assert lab.hears(page)
    assert submitted.empty()
    heard = [m for m in bystander.receive_until(lab.is_probe) if m["type"].startswith("GuiForm")]
    assert {(m["type"], m["uuid"]) for m in heard} >= {("GuiFormDirtyMessage", uuid)}
    assert all(m["uuid"] == uuid for m in heard)
    silent = lab.silent_page()
    silent.send(wire.GuiFormDirtyMessage(uuid))
    box = lab.server.gui.add_checkbox("Box", False)
    silent.set(box, True)
    silent.receive_until(lambda message: is_update(message, box))
    assert lab.hears(page)
    heard = bystander.receive_until(lab.is_probe)
    assert not any(message["type"].startswith("GuiForm") for message in heard)
    form.visible = False
    page.send(wire.GuiFormSubmitMessage(uuid))
    assert lab.hears(page)
    assert submitted.empty()


# --- Uploads -------------------------------------------------------------------------------------


@pytest.fixture
def uploads() -> Iterator[UploadLab]:
    lab = UploadLab()
    yield lab
    lab.close()


@pytest.mark.parametrize("scope", ["shared", "own"])
def test_small_file_arrives(uploads: UploadLab, scope: str) -> None:
    button, page = getattr(uploads, scope), uploads.first_page
    for transfer, content in (("a", b"abc"), ("b", bytes(1024)), ("c", b"")):
        size = len(content)
        page.send(start_of(button, transfer, size_bytes=size, part_count=min(1, size)))
        if content:
            page.send(part_of(button, content, transfer))
        file = uploads.files.get(timeout=PATIENCE_S)
        assert (file.name, file.content) == ("preset.yaml", content)
    assert uploads.refused.empty()


@pytest.mark.parametrize("scope", ["shared", "own"])
@pytest.mark.parametrize(
    "changes",
    [
        {"size_bytes": 1025},
        {"size_bytes": -1},
        {"size_bytes": 0, "part_count": 1},
        {"part_count": 0},
        {"part_count": 2},
        {"part_count": 10**9},
        {"filename": "x" * 256},
        {"filename": ""},
    ],
    ids=repr,
)
def test_unfit_file_is_refused(uploads: UploadLab, scope: str, changes: dict[str, Any]) -> None:
    button, page = getattr(uploads, scope), uploads.first_page
    page.send(start_of(button, **changes))
    page.send(part_of(button, b"abc"))
    assert uploads.reason().startswith("File ")
    assert uploads.hears(page)
    assert uploads.transfers() == set()
    assert uploads.files.empty()
    # The page stops waiting, and takes back the notification that says that it is uploading.
    gone = page.receive_until(lambda message: message["type"] == "RemoveNotificationMessage")
    assert gone[-1]["uuid"] == "upload-t"
    [given_up] = [message for message in gone if message["type"] == "FileTransferPartAck"]
    assert given_up["transferred_bytes"] == given_up["total_bytes"] == 0


def test_only_enabled_upload_buttons_take_files(uploads: UploadLab) -> None:
    page = uploads.first_page
    slider = uploads.server.gui.add_slider("Slider", 0, 10, 1, 5)
    page.send(start_of(slider))
    assert uploads.reason() == "Slider takes no file."
    uploads.shared.disabled = True
    page.send(start_of(uploads.shared))
    assert uploads.reason() == "File is not available now."
    uploads.own.remove()
    page.send(start_of(uploads.own))
    assert uploads.hears(page)
    assert uploads.transfers() == set()


def test_one_file_at_a_time(uploads: UploadLab) -> None:
    page = uploads.first_page
    page.send(start_of(uploads.own, "first"))
    for second in ("second", "first"):
        page.send(start_of(uploads.shared, second))
        assert uploads.reason() == "File is busy with another file."
    other, _ = uploads.page()
    other.send(start_of(uploads.shared, "other"))
    assert uploads.hears(other)
    assert uploads.transfers() == {"first", "other"}
    page.send(part_of(uploads.own, b"abc", "first"))
    assert uploads.files.get(timeout=PATIENCE_S).content == b"abc"
    page.send(start_of(uploads.own, "third"))
    assert uploads.hears(page)
    assert uploads.transfers() == {"third", "other"}


def test_overlong_part_ends_the_transfer(uploads: UploadLab) -> None:
    page = uploads.first_page
    page.send(start_of(uploads.own))
    page.send(part_of(uploads.own, b"abcd"))
    assert uploads.reason() == "This file is longer than announced."
    assert uploads.hears(page)
    assert uploads.transfers() == set()
    page.send(start_of(uploads.own, "again"))
    page.send(part_of(uploads.own, b"abc", "again"))
    assert uploads.files.get(timeout=PATIENCE_S).content == b"abc"


def test_parts_go_to_the_widget_that_started_the_transfer(uploads: UploadLab) -> None:
    page = uploads.first_page
    slider = uploads.server.gui.add_slider("Slider", 0, 10, 1, 5)
    page.send(start_of(uploads.shared))
    page.send(part_of(slider, b"abc"))
    assert uploads.hears(page)
    assert slider.value == 5


def test_parts_of_another_page_are_dropped(uploads: UploadLab) -> None:
    page, (intruder, _) = uploads.first_page, uploads.page()
    page.send(start_of(uploads.shared))
    assert uploads.hears(page)
    intruder.send(part_of(uploads.shared, b"bad"))
    assert uploads.hears(intruder)
    page.send(part_of(uploads.shared, b"abc"))
    assert uploads.files.get(timeout=PATIENCE_S).content == b"abc"


# --- Callbacks -----------------------------------------------------------------------------------


def fail(_: Any) -> None:
    raise ValueError("no such preset\nand more")


async def fail_async(_: Any) -> None:
    raise ValueError("no such preset\nand more")


@pytest.mark.usefixtures("no_traceback")
@pytest.mark.parametrize("callback", [fail, fail_async])
def test_failure_is_told_to_the_acting_page(
    lab: Lab, caplog: pytest.LogCaptureFixture, callback: Any
) -> None:
    button = lab.server.gui.add_button("Button")
    button.on_click(callbacks.guarded(callback))
    (page, _), (bystander, _) = lab.page(), lab.page()
    page.set(button, True)
    told = page.receive_until(lambda message: message["type"] == "NotificationShowMessage")[-1]
    assert told["props"]["title"] == "That did not work"
    assert told["props"]["body"] == "ValueError: no such preset"
    assert [record.getMessage() for record in caplog.records if record.levelname == "ERROR"] == [
        f"{callback.__name__} failed: ValueError: no such preset"
    ]
    assert lab.hears(page)
    heard = bystander.receive_until(lab.is_probe)
    assert not any(message["type"] == "NotificationShowMessage" for message in heard)


def test_failure_at_connecting_is_told_to_the_new_page(lab: Lab) -> None:
    lab.server.on_client_connect(callbacks.guarded(fail))
    page, _ = lab.page()
    page.receive_until(lambda message: message["type"] == "NotificationShowMessage")


def test_failure_without_a_page_is_logged(lab: Lab, caplog: pytest.LogCaptureFixture) -> None:
    box = lab.server.gui.add_checkbox("Box", False)
    box.on_update(callbacks.guarded(fail))
    with caplog.at_level(logging.DEBUG, logger=callbacks.__name__):
        box.value = True
    assert [record.levelname for record in caplog.records] == ["ERROR", "DEBUG"]
    assert caplog.records[1].exc_info is not None


def test_guarded_callback_does_its_work() -> None:
    seen: list[int] = []
    callbacks.guarded(seen.append)(5)
    assert seen == [5]
