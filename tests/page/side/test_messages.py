"""What the frame with runs side by side may send, and what is dropped."""

import re
from pathlib import Path
from typing import get_args

import msgspec
import pytest

import app
from app.page.side.messages import (
    Chosen,
    Compare,
    FromSide,
    GoBy,
    Point,
    Seek,
    SetSpeed,
    Start,
    StartFour,
)

SCRIPTS = Path(app.__file__).parent / "web" / "side"
DECODER = msgspec.json.Decoder(FromSide)


def decoded(text: str) -> FromSide:
    return DECODER.decode(text)


def test_what_a_hand_does_is_read() -> None:
    assert decoded('{"do":"four"}') == StartFour()
    start = decoded('{"do":"start","runs":[{"line":0},{"preset":"timed","seed":9}]}')
    assert start == Start((Chosen(line=0), Chosen(preset="timed", seed=9)))
    assert decoded('{"do":"seek","step":412344}') == Seek(412_344)
    assert decoded('{"do":"by","unit":"events","n":-1}') == GoBy("events", -1)
    assert decoded('{"do":"speed","steps_per_s":0}') == SetSpeed(0.0)
    compare = decoded('{"do":"compare","one":0,"other":3,"shown":true}')
    assert compare == Compare(0, 3, shown=True)
    assert decoded('{"do":"point","east":-4,"north":3}') == Point(-4, 3)
    assert decoded('{"do":"point","east":-4,"north":3,"heading":7}') == Point(-4, 3, 7)


@pytest.mark.parametrize(
    "text",
    [
        '{"do":"start","runs":[{"line":0}]}',
        '{"do":"start","runs":[{},{},{},{},{}]}',
        '{"do":"start","runs":[{"line":0,"name":"x"},{}]}',
        '{"do":"start","runs":[{"line":-1},{}]}',
        '{"do":"start","runs":[{"preset":"","seed":1},{}]}',
        '{"do":"start","runs":[{"preset":"timed","seed":-1},{}]}',
        '{"do":"start","runs":[{"preset":"timed","seed":9223372036854775808},{}]}',
        '{"do":"start","runs":[{"preset":"' + "x" * 201 + '","seed":1},{}]}',
        '{"do":"start","runs":{}}',
        '{"do":"four","seed":1}',
        '{"do":"seek","step":-1}',
        '{"do":"seek","step":1e9}',
        '{"do":"play","direction":2}',
        '{"do":"faster","by":71}',
        '{"do":"speed","steps_per_s":NaN}',
        '{"do":"speed","steps_per_s":1e8}',
        '{"do":"by","unit":"trials","n":1}',
        '{"do":"compare","one":0,"other":4,"shown":true}',
        '{"do":"compare","one":0,"other":1}',
        '{"do":"point","east":10001,"north":0}',
        '{"do":"point","east":0,"north":0,"heading":8}',
        '{"do":"explode"}',
        "[]",
        "{",
    ],
)
def test_what_no_hand_does_is_refused(text: str) -> None:
    with pytest.raises(msgspec.DecodeError):
        decoded(text)


def test_scripts_say_what_there_is_to_say_and_nothing_else() -> None:
    kinds = get_args(FromSide)
    tags = {kind.__struct_config__.tag for kind in kinds}
    assert len(tags) == len(kinds)
    scripts = "\n".join(file.read_text("utf-8") for file in SCRIPTS.glob("*.js"))
    said = set(re.findall(r'\bdo: "(\w+)"', scripts))
    assert said <= tags
    # Putting the runs away is for programs; a browser looks away.
    assert tags - said == {"end"}
