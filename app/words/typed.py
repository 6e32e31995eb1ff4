"""Numbers as people type and paste them: what a text means, or why it is not taken.

All readings of a text are looked at, and it is taken where they come to the same. It may have

- digits of any script, and any dash for a minus;
- groups of three digits with one sign between them: a comma, a dot, an apostrophe, an underline or
  a blank of any kind;
- a decimal mark, which is a comma or a dot: where decimals go, or where an exponent follows;
- an exponent, as in 1e3;
- a percent sign, where shares go.

A dot alone is a decimal mark wherever there may be one, and 12.000 is 12000 only where whole
numbers go. 1,234 is 1234 there, and is not taken where it could be 1.234 as well. Nothing else is a
number, and no part of a text is left aside.
"""

import re
import unicodedata
from collections.abc import Iterator
from decimal import Decimal
from typing import Final

_LONGEST: Final = 100
"""Characters; a number has far fewer."""

_FAR: Final = 10**15
"""Far beyond the limits of anything in a file."""

_ALIKE: Final = {
    **dict.fromkeys("\u2010\u2011\u2012\u2013\u2212\ufe63", "-"),
    # The last is the Arabic sign between thousands.
    **dict.fromkeys("\u2018\u2019\u02bc\u066c", "'"),
    "\u066a": "%",
    "\t": " ",
}
"""Characters for which another of the same meaning is looked for; \u066b is a sure decimal mark."""
_FULL_WIDTH: Final = range(0xFF01, 0xFF5F)
"""Characters that are those of ASCII, in the width of Chinese ones."""

_GROUPS: Final = r"""
    [1-9]\d{0,2} (?P<by>[ ,.'_]) \d{3} (?:(?P=by)\d{3})*
    | [1-9]\d? (?:,\d{2})+ ,\d{3}  # As in India.
"""
_REST: Final = r"(?:(?P<mark>[.,\u066b])(?P<part>\d*))?(?:[eE](?P<power>[+-]?\d{1,3}))?"
_GROUPED: Final = re.compile(f"(?P<digits>{_GROUPS}){_REST}", re.ASCII | re.VERBOSE)
_UNGROUPED: Final = re.compile(rf"(?P<digits>\d*){_REST}", re.ASCII)


class NumeralError(ValueError):
    """A text that is not taken; the message goes on from it: ``'12.5' is not taken: …``."""

    def __init__(self, why: str, allowed: str) -> None:
        super().__init__(f"not taken: {why}; allowed: {allowed}")


def whole(text: str, low: int, high: int) -> int:
    """The whole number that a text means.

    Args:
        text: as it was typed.
        low: the least number that is allowed.
        high: the greatest one.

    Raises:
        NumeralError: it means none, more than one, or one outside of the limits.
    """
    allowed = f"a whole number, {low} to {high}"
    value = _meant(text, allowed, decimals=False)
    if value != value.to_integral_value():
        raise NumeralError("it is no whole number", allowed)
    _check_limits(value, low, high, allowed)
    return int(value)


def decimal(text: str, low: float, high: float, share: bool = False) -> float:
    """The number that a text means, which may have decimals.

    Args:
        text: as it was typed.
        low: the least number that is allowed; finite.
        high: the greatest one; finite.
        share: whether it is a part of a whole, which may be given in percent.

    Raises:
        NumeralError: it means none, more than one, or one outside of the limits.
    """
    allowed = f"a number, {plain(low)} to {plain(high)}"
    is_percent = share and _in_ascii(text).endswith("%")
    if is_percent:
        value = _meant(_in_ascii(text).removesuffix("%"), allowed, decimals=True) / 100
    else:
        value = _meant(text, allowed, decimals=True)
    number = float(value) + 0.0  # Not -0.0.
    _check_limits(number, low, high, allowed)
    return number


def plain(number: float) -> str:
    """A number as messages write it: in a way that is taken, with no more digits than it has."""
    return f"{int(number)}" if number == int(number) and abs(number) < 1e21 else f"{number:.12g}"


def rewritten(text: str, decimals: bool) -> str | None:
    """A number that people write in their own ways, as files have it; None if it is not one."""
    try:
        value = decimal(text, -_FAR, _FAR) if decimals else whole(text, -_FAR, _FAR)
    except NumeralError:
        return None
    return plain(value)


def _check_limits(value: Decimal | float, low: float, high: float, allowed: str) -> None:
    if value < low:
        raise NumeralError("it is too small", allowed)
    if value > high:
        raise NumeralError("it is too large", allowed)


def _meant(text: str, allowed: str, decimals: bool) -> Decimal:
    """The one number that a text means; raises `NumeralError`."""
    if not text.strip():
        raise NumeralError("it is empty", allowed)
    if len(text) > _LONGEST:
        raise NumeralError("it is too long", allowed)
    found = sorted(set(_readings(text, decimals)))
    if len(found) > 1:
        readings = " or ".join(f"{value.normalize():f}" for value in found)
        raise NumeralError(f"it could be {readings}", allowed)
    if not found:
        has_mark = not decimals and list(_readings(text, decimals=True))
        raise NumeralError("it has a decimal mark" if has_mark else "it is no number", allowed)
    return found[0]


def _readings(text: str, decimals: bool) -> Iterator[Decimal]:
    """What a text can mean, where whole numbers go or decimals do."""
    typed = _in_ascii(text)
    sign = typed[:1] if typed[:1] in ("+", "-") else ""
    typed = typed.removeprefix(sign).lstrip()
    for pattern in (_UNGROUPED, _GROUPED):
        match = pattern.fullmatch(typed)
        if match is None:
            continue
        digits, mark, part, power = match.group("digits", "mark", "part", "power")
        may_have_decimals = decimals or power is not None
        if mark and not may_have_decimals:
            continue
        if pattern is _GROUPED and may_have_decimals and digits.count(".") == 1 and not mark:
            continue  # The dot is a decimal mark.
        digits = re.sub(r"\D", "", digits)
        if digits or part:
            yield Decimal(f"{sign}{digits}.{part or ''}e{power or 0}")


def _in_ascii(text: str) -> str:
    """A text with each character as the one of ASCII that means the same, if there is one."""
    return "".join(map(_character_in_ascii, text)).strip()


def _character_in_ascii(character: str) -> str:
    if ord(character) in _FULL_WIDTH:
        return chr(ord(character) - _FULL_WIDTH.start + ord("!"))
    match unicodedata.category(character):
        case "Nd":
            return str(unicodedata.decimal(character))
        case "Zs":
            return " "
        case "Cf":  # Cannot be seen: directions of writing, and places where a line may break.
            return ""
        case _:
            return _ALIKE.get(character, character)
