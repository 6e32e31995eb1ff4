"""What the door makes of bytes, before viser's decoder sees them."""

import math
import sys
import warnings
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from viser import _messages as wire
from viser.infra import _messages as decoder

from app.server import admission, shapes
from app.server.admission import RULES
from app.server.shapes import NotAMessageError, SenselessError, read
from tests.support.server import CAMERA, Lab, is_update, lab_of

DRAG = {
    "phase": "start",
    "name": "/a",
    "instance_index": None,
    "start_position": (0.0, 0.0, 0.0),
    "start_screen_pos": (0.0, 0.0),
    "end_position": (0.0, 0.0, 0.0),
    "end_screen_pos": (0.0, 0.0),
    "button": "left",
    "modifier": "shift",
    "owner": "",
}
RAY = {"ray_origin": (0.0, 0.0, 0.0), "ray_direction": (0.0, 0.0, 1.0)}
POSE = {"wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.0, 0.0, 0.0)}

EXAMPLES: dict[type[wire.Message], dict[str, Any]] = {
    wire.ViewerCameraMessage: dict(vars(CAMERA)),
    wire.GetRenderResponseMessage: {"payload": b"x", "render_uuid": "a"},
    wire.LocalStorageGetItemResponseMessage: {"value": None, "error": None, "request_uuid": "a"},
    wire.SceneNodeClickMessage: {
        "name": "/a",
        "instance_index": 1,
        **RAY,
        "screen_pos": (0.5, 0.5),
        "modifier": None,
        "owner": "",
    },
    wire.SceneNodeDragMessage: DRAG,
    wire.TransformControlsUpdateMessage: {"name": "/a", **POSE, "owner": ""},
    wire.TransformControlsDragStartMessage: {"name": "/a", "owner": ""},
    wire.TransformControlsDragEndMessage: {"name": "/a", "owner": ""},
    wire.ScenePointerMessage: {
        "event_type": "click",
        **RAY,
        "screen_pos": ((0.5, 0.5),),
        "modifier": None,
    },
    wire.GuiUpdateMessage: {"uuid": "a", "updates": {"value": [1, 2.5, "x"]}},
    wire.GuiButtonHoldMessage: {"uuid": "a", "frequency": 10.0},
    wire.GuiFormSubmitMessage: {"uuid": "a"},
    wire.GuiFormDirtyMessage: {"uuid": "a"},
    wire.CommandTriggerMessage: {"uuid": "a"},
    wire.FileTransferStartUpload: {
        "source_component_uuid": "a",
        "transfer_uuid": "b",
        "filename": "preset.yaml",
        "mime_type": "",
        "part_count": 1,
        "size_bytes": 3,
    },
    wire.FileTransferPart: {
        "source_component_uuid": "a",
        "transfer_uuid": "b",
        "part_index": 0,
        "content": b"abc",
    },
}
"""For each type that is let through, fields that its page may send."""

FIELDS = [(kind, name) for kind, fields in EXAMPLES.items() for name in fields]

ANYTHING = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**64 - 1)
    | st.floats()
    | st.text(max_size=20)
    | st.binary(max_size=20)
    | st.sampled_from(["click", "shift", "left", "value"]),
    lambda inner: (
        st.lists(inner, max_size=5)
        | st.dictionaries(st.text(max_size=5) | st.integers(0, 9), inner, max_size=3)
    ),
    max_leaves=12,
)


def packed(kind: type[wire.Message], fields: dict[str, Any]) -> bytes:
    return msgspec.msgpack.encode({**fields, "type": kind.__name__})


def outcome_of(frame: Any) -> str:
    """What the door makes of a frame; what it lets through is read by viser without a warning."""
    try:
        message = read(frame, RULES)
    except SenselessError:
        return "senseless"
    except NotAMessageError:
        return "no message"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        taken = wire.Message.deserialize(frame)
    assert type(taken) is message.kind
    for name in EXAMPLES[message.kind]:
        # By their texts, in which two NaN are equal.
        assert repr(getattr(taken, name)) == repr(getattr(message.content, name))
    return "message"


def test_there_is_an_example_of_everything_that_is_let_through() -> None:
    assert EXAMPLES.keys() == RULES.keys()


@pytest.mark.parametrize("kind", EXAMPLES)
def test_what_a_page_sends_is_a_message(kind: type[wire.Message]) -> None:
    assert outcome_of(packed(kind, EXAMPLES[kind])) == "message"


@pytest.mark.parametrize(("kind", "name"), FIELDS)
@settings(max_examples=25, deadline=None)
@given(value=ANYTHING)
def test_anything_in_a_field_is_judged_before_viser_reads_it(
    kind: type[wire.Message], name: str, value: Any
) -> None:
    assert outcome_of(packed(kind, {**EXAMPLES[kind], name: value})) in ("message", "senseless")


@pytest.mark.parametrize(("kind", "name"), FIELDS)
def test_every_field_must_be_there(kind: type[wire.Message], name: str) -> None:
    fields = {key: value for key, value in EXAMPLES[kind].items() if key != name}
    assert outcome_of(packed(kind, fields)) == "no message"


WRONG_SHAPES: tuple[dict[str, Any], ...] = (
    {"wxyz": ["A" * 3_000]},
    {"wxyz": (1.0, 0.0, 0.0)},
    {"wxyz": (1.0, 0.0, 0.0, 0.0, 0.0)},
    {"wxyz": "\x1b]0;mine\x07"},
    {"position": (0.0, 0.0, math.nan)},
    {"position": (0.0, 0.0, math.inf)},
    {"position": (0.0, 0.0, True)},
    {"position": {"0": 0.0}},
    {"fov": "1"},
    {"image_height": 1.5},
    {"image_height": None},
)


@pytest.mark.parametrize("changes", WRONG_SHAPES, ids=lambda changes: repr(changes)[:30])
def test_wrong_shape_of_a_camera_is_senseless(changes: dict[str, Any]) -> None:
    frame = packed(wire.ViewerCameraMessage, {**vars(CAMERA), **changes})
    assert outcome_of(frame) == "senseless"


def test_whole_numbers_are_numbers() -> None:
    # A page has one kind of number, and sends 1.0 as an integer.
    frame = packed(wire.ViewerCameraMessage, {**vars(CAMERA), "fov": 1, "wxyz": (1, 0, 0, 0)})
    assert outcome_of(frame) == "message"


def test_only_files_and_pictures_may_be_long() -> None:
    content = bytes(shapes.MAX_SHORT_BYTES)
    part = {**EXAMPLES[wire.FileTransferPart], "content": content}
    assert outcome_of(packed(wire.FileTransferPart, part)) == "message"
    update = {"uuid": "a", "updates": {"value": content}}
    assert outcome_of(packed(wire.GuiUpdateMessage, update)) == "senseless"


@pytest.mark.parametrize(
    "frame",
    [
        "text",
        b"\xdf\xff\xff\xff\xff",
        b"\x91" * 100_000,
        msgspec.msgpack.encode({f"key {n}": n for n in range(100)}),
        b"\x83\xa4type\xb0GuiUpdateMessage\xa4uuid\xa2\xff\xff\xa7updates\x80",
        b"\x83\xa4type\xb0GuiUpdateMessage\xa4uuid\xa1a\xa7updates" + b"\x91" * 50_000,
    ],
    ids=["text", "huge mapping", "deep nest", "many keys", "no UTF-8", "deep nest in a field"],
)
def test_what_cannot_be_read_is_no_message(frame: bytes | str) -> None:
    assert outcome_of(frame) == "no message"


@pytest.fixture(scope="module")
def open_lab() -> Iterator[Lab]:
    with pytest.MonkeyPatch.context() as patch, lab_of() as lab:
        patch.setattr(admission, "GRACE_S", 0.0)
        yield lab


HOSTILE = st.builds(
    lambda field, value: packed(field[0], {**EXAMPLES[field[0]], field[1]: value}),
    st.sampled_from(FIELDS),
    ANYTHING,
)


@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(frames=st.lists(HOSTILE, min_size=1, max_size=60))
def test_sequences_of_hostile_messages_change_nothing(open_lab: Lab, frames: list[bytes]) -> None:
    slider = open_lab.server.gui.add_slider("Slider", 0, 10, 1, 5)
    page, _ = open_lab.page()
    remembered = len(registry_of(decoder))
    for frame in frames:
        page.send_frame(frame)
    page.set(slider, 7)
    page.set(slider, "no number")
    # A page that sent nothing but messages is still heard, and still told.
    *_, correction = page.receive_until(lambda message: is_update(message, slider))
    assert correction["updates"]["value"] in (5, 7)
    assert open_lab.hears(page)
    assert len(registry_of(decoder)) == remembered
    slider.remove()
    page.close()


def registry_of(module: Any) -> dict[Any, Any]:
    """What Python remembers of the warnings of a module, with their texts."""
    return vars(sys.modules[module.__name__]).setdefault("__warningregistry__", {})
