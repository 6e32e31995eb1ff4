"""A scene for several browsers, as the page that each of them has would come to show it."""

from collections.abc import Iterator
from typing import Any, cast

import msgspec.msgpack
import numpy as np
import pytest
import viser
import zstandard

from app.server.server import close_server, open_server
from app.server.stage import Stage


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    server = open_server(port=0)
    yield server
    close_server(server)


@pytest.fixture
def stage(server: viser.ViserServer) -> Stage:
    return Stage(server)


class Page:
    """What a page makes of the frames that it is sent."""

    def __init__(self) -> None:
        self.seen = 0
        self.nodes: dict[str, dict[str, Any]] = {}

    def take(self, stage: Stage) -> int:
        """Take in what is new; returns the number of messages."""
        frame, self.seen = stage.frame_since(self.seen), stage.now
        return 0 if frame is None else self.show(frame)

    def turn_to(self, stage: Stage, former: Stage) -> None:
        """Look at another stage."""
        self.seen = stage.now
        self.show(stage.frame_in_place_of(former))

    def show(self, frame: bytes) -> int:
        """Take in a frame; returns the number of messages."""
        size, n_packed = (int.from_bytes(frame[at : at + 8], "little") for at in (0, 8))
        inner = zstandard.decompress(frame[16 : 16 + n_packed], max_output_size=size)
        content = msgspec.msgpack.decode(inner)
        arrays: list[bytes] = []
        place = 16 + n_packed
        for length in content["binaryBufferLengths"]:
            place += -place % 8
            arrays.append(frame[place : place + length])
            place += length
        assert place == len(frame)
        for message in content["messages"]:
            self._show(message, arrays)
        return len(content["messages"])

    def _show(self, message: dict[str, Any], arrays: list[bytes]) -> None:
        def whole(value: Any) -> Any:
            if not isinstance(value, dict) or "__binary_index" not in value:
                return cast(object, value)
            array = cast(dict[str, Any], value)
            raw = arrays[int(array["__binary_index"])]
            return np.frombuffer(raw, str(array["dtype"])).tolist()

        name = message["name"]
        assert message["owner"] == ""
        if message["type"] == "RemoveSceneNodeMessage":
            self.nodes.pop(name, None)
        elif message["type"] == "SceneNodeUpdateMessage":
            self.nodes[name].update({k: whole(v) for k, v in message["updates"].items()})
        elif "props" in message:
            self.nodes[name] = {k: whole(v) for k, v in message["props"].items()}


def dots(stage: Stage, name: str = "/dots", count: int = 3) -> viser.PointCloudHandle:
    """Some dots, all of another size."""
    return stage.scene.add_point_cloud(
        name, np.zeros((count, 3), np.float32), np.zeros((count, 3), np.uint8), precision="float32"
    )


def test_a_page_that_comes_late_shows_what_the_first_one_shows(stage: Stage) -> None:
    cloud = dots(stage)
    first = Page()
    first.take(stage)
    for size in (0.5, 0.25):
        cloud.point_size = size
        cloud.colors = np.full((3, 3), int(100 * size), np.uint8)
        first.take(stage)
    late = Page()
    late.take(stage)
    assert late.nodes == first.nodes
    assert late.nodes["/dots"]["point_size"] == 0.25
    assert late.nodes["/dots"]["colors"] == [25] * 9


def test_a_page_gets_what_is_new_and_of_that_the_newest(stage: Stage) -> None:
    cloud = dots(stage)
    page = Page()
    page.take(stage)
    assert page.take(stage) == 0
    for size in range(1, 20):
        cloud.point_size = float(size)
    assert page.take(stage) == 1
    assert page.nodes["/dots"]["point_size"] == 19.0


def test_who_turns_to_another_stage_sees_what_one_sees_who_comes_to_it(
    server: viser.ViserServer, stage: Stage
) -> None:
    page, late, other = Page(), Page(), Stage(server)
    dots(stage, "/both")
    dots(stage, "/here")
    passing = dots(stage, "/passing")
    dots(other, "/both", count=1)
    dots(other, "/there")
    page.take(stage)
    # It is not told any more that this is gone.
    passing.remove()
    page.turn_to(other, stage)
    late.take(other)
    assert page.nodes == late.nodes
    assert page.take(other) == 0
    page.turn_to(stage, other)
    late = Page()
    late.take(stage)
    assert page.nodes == late.nodes
    assert "/passing" not in page.nodes


def test_pages_that_stand_alike_get_the_very_same_bytes(stage: Stage) -> None:
    cloud = dots(stage)
    seen = stage.now
    cloud.point_size = 0.5
    assert stage.frame_since(seen) is stage.frame_since(seen)
    assert stage.frame_since(seen) != stage.frame_since(0)


def test_what_was_removed_is_gone_and_may_come_again(stage: Stage) -> None:
    cloud = dots(stage)
    page = Page()
    page.take(stage)
    cloud.point_size = 0.5
    cloud.remove()
    page.take(stage)
    assert "/dots" not in page.nodes
    dots(stage, count=1)
    late = Page()
    for each in (page, late):
        each.take(stage)
        assert each.nodes["/dots"]["point_size"] != 0.5
        assert len(each.nodes["/dots"]["colors"]) == 3


def test_a_stage_keeps_no_more_than_what_is_there(stage: Stage) -> None:
    cloud = dots(stage)
    everything = Page().take(stage)
    for size in range(1_000):
        cloud.point_size = float(size)
        cloud.colors = np.zeros((3, 3), np.uint8)
    assert Page().take(stage) <= everything + 2
