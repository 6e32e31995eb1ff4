"""Files of sessions as somebody might make them who means ill, or whose disk does."""

import copy
import json
import random
from typing import Any, Final, cast

from app.live.written import with_sums, without_sums

_VALUES: Final[tuple[Any, ...]] = (
    *(None, True, False, -1, 0, 1, 7, 500, 2**31, 2**53, 2**63 - 1, 2**63, 2**64, 10**400),
    *(0.5, -0.0, 1e-320, 1e308, float("nan"), float("inf"), float("-inf")),
    *("", "0", "moves", "avoid", "approach", "sneak", "introduction", "a" * 99, "a" * 2_000),
    *("\x1b[31m", "\x00", "\ud800", "\u202e", "<script>alert(1)</script>", "a\nb", "..", "/etc"),
    *([], {}, [[]], {"do": "Undo", "number": 0}, {"kind": "began"}, ["approach"] * 3_000),
    *({"do": "FreezeSkills", "frozen": True}, [{"do": "Undo", "number": 5}], ["avoid"]),
)
_KEYS: Final = ("run", "parent", "step", "kind", "do", "sum", "spec", "__class__", "a" * 500, "")
_KINDS: Final[tuple[dict[str, Any], ...]] = (
    *({"kind": "deleted", "run": 1}, {"kind": "brought_back", "run": 1}),
    *({"kind": "went_live", "run": 1, "step": None}, {"kind": "went_live", "run": 0, "step": 5}),
    *({"kind": "went_live", "run": 1, "step": 2**62}, {"kind": "unmarked", "number": 1}),
    *({"kind": "named_line", "run": 1, "name": "<b>x"}, {"kind": "deleted", "run": 0}),
    {"kind": "marked", "number": 9, "run": 0, "step": 10**9, "trial": 0, "text": "far"},
    {"kind": "stood", "run": 0, "step": 2**62, "trial": 1, "digest": "ab" * 32, "until_trial": 9},
    {"kind": "stood", "run": 0, "step": 10**8, "trial": 1, "digest": "ab" * 32, "until_trial": 9},
    {"kind": "branched", "run": 5, "parent": 1, "step": 0, "commands": [], "instead_of": 1},
    {"kind": "gave", "run": 0, "step": 10**7, "command": {"do": "FreezeSkills", "frozen": True}},
)


def packed(data: bytes) -> bytes:
    """A file's lines as a link has them; of what is damaged the first lines, or other bytes."""
    return without_sums(data) or data


def mutation(data: bytes, seed: int) -> bytes:
    """Another file: with some bytes changed, or with right checksums over what makes no sense."""
    chance = random.Random(seed)
    return _of_bytes(data, chance) if seed % 3 == 0 else _of_documents(data, chance)


def _of_bytes(data: bytes, chance: random.Random) -> bytes:
    """Bytes flipped, cut off, doubled, or in another place; some with right checksums."""
    changed = bytearray(data)
    for _ in range(chance.choice((1, 1, 3, 30))):
        at = chance.randrange(max(len(changed), 1))
        length = chance.choice((1, 2, 40, 400))
        match chance.randrange(5):
            case 0:
                changed[at : at + 1] = bytes([chance.randrange(256)])
            case 1:
                del changed[at:]
            case 2:
                del changed[at : at + length]
            case 3:
                changed[at:at] = changed[at : at + length]
            case _:
                changed[at:at] = chance.choice((b"\n", b"\r\n", b"{", b'"', b"[" * 3_000, b"\0"))
    lines = bytes(changed)
    return with_sums(without_sums(lines)) if chance.random() < 0.5 else lines


def _of_documents(data: bytes, chance: random.Random) -> bytes:
    documents = [json.loads(line) for line in without_sums(data).splitlines()]
    for _ in range(chance.choice((1, 1, 2, 8))):
        place = chance.randrange(len(documents))
        match chance.randrange(10):
            case 0:
                documents.insert(place, copy.deepcopy(chance.choice(documents)))
            case 1 if len(documents) > 1:
                del documents[place]
            case 2:
                chance.shuffle(documents)
            case 3 | 4:
                documents.insert(place + 1, copy.deepcopy(chance.choice(_KINDS)))
            case _:
                documents[place] = _changed(documents[place], chance)
    lines = [json.dumps(document, separators=(",", ":")).encode() for document in documents]
    if chance.random() < 0.1:
        place = chance.randrange(len(lines))
        lines[place] = lines[place][:-1] + chance.choice(
            (b',"run":0}', b',"kind":"gave"}', b',"x":' + b"[" * 4_000 + b"]" * 4_000 + b"}")
        )
    return with_sums(b"".join(line + b"\n" for line in lines))


def _changed(parts: Any, chance: random.Random) -> Any:
    """Something of JSON with one value in it, however deep, left out, changed or added."""
    kind = cast(Any, type)(parts)
    has_keys = kind is dict
    if kind not in (dict, list) or not parts or chance.random() < 0.1:
        return copy.deepcopy(chance.choice(_VALUES))
    keys: list[Any] = list(parts if has_keys else range(len(parts)))
    key = chance.choice(keys)
    match chance.randrange(8):
        case 0:
            del parts[key]
        case 1 if has_keys:
            parts[chance.choice(_KEYS)] = copy.deepcopy(chance.choice(_VALUES))
        case _:
            parts[key] = _changed(parts[key], chance)
    return parts
