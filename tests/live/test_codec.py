"""Records come back as they were, and nothing else is taken for one."""

import json
import math
from typing import Any, get_args

import pytest
from hypothesis import given

from app.live.codec import UnknownRecordError, decoded, encoded
from app.live.records import Gave, Record
from learners.commands import Command, Explore, FreezeSelection
from tests.support.journals import COMMANDS, RECORDS, records


def test_every_kind_of_record_and_of_command_is_tried() -> None:
    assert {type(record) for record in RECORDS} == set(get_args(Record))
    assert {type(command) for command in COMMANDS} == set(get_args(Command))


@pytest.mark.parametrize("record", RECORDS)
def test_a_record_comes_back_as_it_was(record: Record) -> None:
    found = decoded(json.loads(json.dumps(encoded(record))))
    assert found == record
    assert type(found) is type(record)


@given(records())
def test_any_record_comes_back_as_it_was(record: Record) -> None:
    assert decoded(json.loads(json.dumps(encoded(record)))) == record


def test_where_an_exploration_acts_is_written_only_if_that_is_not_everywhere() -> None:
    assert encoded(Gave(0, 1, Explore("avoid", 9, 0.5)))["command"] == EXPLORE
    somewhere = EXPLORE | {"value_at_most": 1.0}
    assert encoded(Gave(0, 1, Explore("avoid", 9, 0.5, value_at_most=1.0)))["command"] == somewhere


GAVE = encoded(Gave(3, 70, FreezeSelection(True)))
EXPLORE = {"do": "Explore", "skill": "avoid", "duration_trials": 9, "probability": 0.5}


@pytest.mark.parametrize(
    ("document", "message"),
    [
        (None, "null is not allowed; allowed: values with keys"),
        ([], "[] is not allowed; allowed: values with keys"),
        ({}, "kind: null is not allowed; allowed: began, gave, "),
        ({"kind": ["gave"]}, 'kind: ["gave"] is not allowed; allowed: began, gave, '),
        ({"kind": "gives"}, 'kind: "gives" is not allowed; allowed: began, gave, '),
        (GAVE | {"step": -1}, "step: -1 is not allowed"),
        (GAVE | {"step": 2**63}, "step: 9223372036854775808 is not allowed"),
        (GAVE | {"step": "70"}, 'step: "70" is not allowed'),
        (GAVE | {"step": True}, "step: true is not allowed"),
        (GAVE | {"more": 1}, "more: 1 is not allowed"),
        ({key: GAVE[key] for key in ("kind", "run", "command")}, "step: "),
        (GAVE | {"command": {"do": "Exec"}}, 'do: "Exec" is not allowed; allowed: Introduce, '),
        (GAVE | {"command": {"do": "FreezeSelection", "frozen": 1}}, "frozen: 1 is not allowed"),
        (GAVE | {"command": EXPLORE | {"value_at_most": math.inf}}, "value_at_most: Infinity is"),
        (GAVE | {"command": EXPLORE | {"value_at_most": "1"}}, 'value_at_most: "1" is not allowed'),
        (GAVE | {"command": "FreezeSelection"}, '"FreezeSelection" is not allowed'),
        ({"kind": "branched", "commands": "ab"}, 'commands: "ab" is not allowed; allowed: up to'),
        ({"kind": "branched", "commands": [{}] * 1_001}, "commands: [{}, "),
        ({"kind": "named_line", "run": 1, "name": "a" * 1_001}, 'name: "aaa'),
    ],
)
def test_what_is_no_record_is_said(document: Any, message: str) -> None:
    with pytest.raises(UnknownRecordError) as refused:
        decoded(document)
    assert str(refused.value).startswith(message)
    assert len(str(refused.value)) < 250


def test_whatever_could_be_read_can_be_refused_however_deep_it_lies() -> None:
    refused = 0
    for depth in range(1, 1_500):
        try:
            document = json.loads(
                f'{{"kind":"gave","run":0,"step":0,"command":{"[" * depth}{"]" * depth}}}'
            )
        except RecursionError:
            break
        with pytest.raises(UnknownRecordError, match="allowed"):
            decoded(document)
        refused += 1
    assert refused > 100
