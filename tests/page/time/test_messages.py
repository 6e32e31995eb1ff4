"""What the frame of the time bar may send, and what is dropped."""

import re
from pathlib import Path
from typing import get_args

import msgspec
import pytest

import app
from app.live.lines import MOST_CHARACTERS
from app.page.time.messages import (
    AddExploration,
    AddMark,
    EditBlock,
    FromFrame,
    GoBy,
    Guess,
    Live,
    Play,
    Seek,
    Sketch,
)
from learners.names import MAX_TRIALS

SCRIPTS = Path(app.__file__).parent / "web" / "time"
DECODER = msgspec.json.Decoder(FromFrame)


def decoded(text: str) -> FromFrame:
    return DECODER.decode(text)


def test_what_a_hand_does_is_read() -> None:
    assert decoded('{"do":"seek","step":13900}') == Seek(13_900)
    assert decoded('{"do":"live"}') == Live()
    assert decoded('{"do":"play","direction":-1}') == Play(-1)
    assert decoded('{"do":"by","unit":"events","n":-1}') == GoBy("events", -1)
    edit = decoded('{"do":"edit","id":"episode:0:avoid","at":1200}')
    assert edit == EditBlock("episode:0:avoid", at=1_200)
    added = decoded('{"do":"add","skill":"avoid","at":5,"trials":2000,"probability":0.5}')
    assert added == AddExploration("avoid", 5, 2_000, 0.5)
    mark = decoded('{"do":"mark","text":"the ring closes","line":2,"step":9}')
    assert mark == AddMark("the ring closes", 2, 9)
    assert decoded('{"do":"guess","trial":24000}') == Guess(24_000)
    points = ",".join(f"[{trial},{-trial}.5]" for trial in range(1, 7))
    sketch = Sketch(tuple((trial, -trial - 0.5) for trial in range(1, 7)))
    assert decoded(f'{{"do":"sketch","points":[{points}]}}') == sketch


@pytest.mark.parametrize(
    "text",
    [
        '{"do":"seek","step":-1}',
        '{"do":"guess","trial":-1}',
        '{"do":"guess","trial":1.5}',
        '{"do":"guess"}',
        '{"do":"sketch","points":[]}',
        '{"do":"sketch","points":[[0,1],[1,1],[2,1],[3,1],[4,1]]}',
        '{"do":"sketch","points":[[0,1],[1,1],[2,1],[3,1],[4,1],[5,1],[6,1]]}',
        '{"do":"sketch","points":[[0,1],[1,1],[2,1],[3,1],[4,1],[5,1e7]]}',
        '{"do":"sketch","points":[[0,1],[1,1],[2,1],[3,1],[4,1],[5,NaN]]}',
        '{"do":"sketch","points":[[0,1],[1,1],[2,1],[3,1],[4,1],[-5,1]]}',
        '{"do":"sketch","points":[[0,1],[1,1],[2,1],[3,1],[4,1],[5,1,1]]}',
        '{"do":"seek","step":9007199254740993}',
        '{"do":"seek","step":1.5}',
        '{"do":"seek","step":true}',
        '{"do":"seek","step":1,"trial":1}',
        '{"do":"seek"}',
        '{"do":"play","direction":0}',
        '{"do":"rate","rate":1e300}',
        '{"do":"by","unit":"hours","n":1}',
        '{"do":"edit","id":"","at":1}',
        '{"do":"edit","id":"x","probability":1.01}',
        '{"do":"edit","id":"x","probability":NaN}',
        '{"do":"add","skill":"avoid","at":5}',
        '{"do":"mark","line":1,"step":1,"text":"' + "x" * 81 + '"}',
        '{"do":"mark","line":1,"step":1,"text":""}',
        '{"do":"loop","on":1}',
        '{"do":"explode"}',
        '{"step":1}',
        "[]",
        "{",
    ],
)
def test_what_no_hand_does_is_refused(text: str) -> None:
    with pytest.raises(msgspec.DecodeError):
        decoded(text)


def test_each_message_says_another_thing_is_to_be_done() -> None:
    kinds = get_args(FromFrame)
    tags = {kind.__struct_config__.tag for kind in kinds}
    assert len(tags) == len(kinds)
    assert {kind.__struct_config__.tag_field for kind in kinds} == {"do"}


@pytest.mark.parametrize(
    ("script", "name", "bound"),
    [
        ("state.js", "MOST_CHARACTERS", MOST_CHARACTERS),
        ("edit.js", "MOST_TRIALS", MAX_TRIALS),
    ],
)
def test_the_scripts_know_the_same_bounds(script: str, name: str, bound: int) -> None:
    text = (SCRIPTS / script).read_text("utf-8")
    (stated,) = re.findall(rf"const {name} = ([\d_]+);", text)
    assert int(stated) == bound
