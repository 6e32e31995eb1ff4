"""Files of lessons as somebody might write them who means ill, or whose editor does."""

import random
import re
from typing import Final

_VALUES: Final = (
    *("null", "~", "true", "false", "-1", "0", "7", "+1", "+0", "-5", "+9999999", "1e9", ".nan"),
    *("-.inf", "9" * 19, "9" * 4_000, "+" + "9" * 300, "0x10", "1_000", "on", "off", "yes"),
    *('""', "''", '" "', '"\\x1b[31m"', '"\\0"', '"\\ud800"', '"\\u202e"', '"\\UFFFFFFFF"'),
    *("[]", "{}", "[[]]", "{do: true}", "{do: 1}", "{? [a] : b}", "[+5000, 3]", "{captures: 0}"),
    *(
        "say",
        "free",
        "spread",
        "behind",
        "octants",
        "timed",
        "/etc/passwd",
        "../timed",
        "a" * 70_000,
    ),
    *(
        '"<script>alert(1)</script>"',
        '"**`**`"',
        "word " * 60,
        "a" * 2_000,
        "&x [*x]",
        "!!python/x",
    ),
    *("*x", "<<", "{<<: {say: x}}", "{extends: timed}", "[" * 60, "{a: " * 30 + "1" + "}" * 30),
    *(
        "{all: " * 9 + "[]" + "}" * 9,
        "{not: {not: {measure: trial, above: 1}}}",
        "{opened: {cell: []}}",
    ),
    *("[" + "1, " * 3_000 + "]", "{" + "".join(f"k{n}: 1, " for n in range(2_500)) + "}"),
)
_KEYS: Final = (
    *("say", "ask", "do", "see", "why", "free", "extends", "<<", "?", "on", "1", '""', "is", "for"),
    *("check", "all", "not", "steps", "texts", "__class__", "a" * 500, '"\\u202e"', "not_there"),
)
_BYTES: Final = (
    b"\0",
    b"\xff\xfe",
    b"\x1b",
    "\u202e".encode(),
    b"\t",
    b"\r",
    b": ",
    b"- ",
    b"#",
    b"'",
)


def mutation(data: bytes, seed: int) -> bytes:
    """Another file: with bytes changed, or with other keys, values and lines."""
    chance = random.Random(seed)
    if seed % 4 == 0:
        return _of_bytes(data, chance)
    lines = data.decode().splitlines(keepends=True)
    for _ in range(chance.choice((1, 1, 2, 8))):
        _change(lines, chance)
    return "".join(lines).encode(errors="surrogatepass")


def _of_bytes(data: bytes, chance: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(chance.choice((1, 1, 3, 30))):
        at = chance.randrange(max(len(changed), 1))
        match chance.randrange(4):
            case 0:
                changed[at : at + 1] = bytes([chance.randrange(256)])
            case 1:
                del changed[at:]
            case 2:
                del changed[at : at + chance.choice((1, 2, 40, 400))]
            case _:
                changed[at:at] = chance.choice(_BYTES)
    return bytes(changed)


def _change(lines: list[str], chance: random.Random) -> None:
    """One line is changed, dropped, moved or multiplied."""
    if not lines:
        return
    at = chance.randrange(len(lines))
    line = lines[at]
    keys = list(re.finditer(r"[\w.]+(?=:)", line))
    values = list(re.finditer(r"(?<=: )(\"[^\"]*\"|[^,{}\[\]\n]+)", line))
    match chance.randrange(7):
        case 0 | 1 if values:
            found = chance.choice(values)
            lines[at] = line[: found.start()] + chance.choice(_VALUES) + line[found.end() :]
        case 2 if keys:  # As a whole, with what is below it.
            del lines[at + 1 : _end(lines, at)]
            lines[at] = line[: keys[0].end()] + ": " + chance.choice(_VALUES) + "\n"
        case 3 if keys:
            found = chance.choice(keys)
            lines[at] = line[: found.start()] + chance.choice(_KEYS) + line[found.end() :]
        case 4:
            del lines[at : chance.choice((at + 1, _end(lines, at)))]
        case 5:
            lines[at:at] = lines[at : _end(lines, at)] * chance.choice((1, 1, 2, 20))
        case _:
            moved = lines[at : (end := _end(lines, at))]
            del lines[at:end]
            places = [n for n, other in enumerate(lines) if _indent(other) == _indent(line)]
            to = chance.choice(places or [0])
            lines[to:to] = moved


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip(" "))


def _end(lines: list[str], at: int) -> int:
    """Where what begins with a line ends: with it are all that are indented below it."""
    below = range(at + 1, len(lines))
    return next((n for n in below if _indent(lines[n]) <= _indent(lines[at])), len(lines))
