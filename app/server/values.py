"""Whether a widget allows a value."""

import itertools
import math
import numbers
from collections.abc import Callable, Sequence
from typing import Any, Final

import viser

MAX_TEXT_CHARACTERS: Final = 2_000


def name_of(handle: Any) -> str:
    return getattr(handle._impl.props, "label", None) or "This"


def _is_real(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def update_fault(handle: Any, updates: dict[Any, Any]) -> str | None:
    """Why the widget may not be updated so; None if it may. A page only ever sets `value`."""
    if updates.keys() != {"value"}:
        return "This page tried to change more than a value."
    complaint_about = _COMPLAINTS.get(type(handle))
    name = name_of(handle)
    if complaint_about is None:
        return f"{name} takes no value."
    complaint = complaint_about(handle, updates["value"])
    return None if complaint is None else f"{name} {complaint}."


def _number_complaint(value: Any, like: Any, low: Any, high: Any) -> str | None:
    """What is wrong with a number for a widget that now holds the number `like`.

    A page has one kind of number and sends 3.0 as an integer, so a widget of floats takes both, and
    a widget of integers takes a float that is whole.
    """
    if not _is_real(value):
        return "needs a number"
    if isinstance(like, numbers.Integral) and value != int(value):
        return "needs a whole number"
    if low is not None and value < low:
        return f"must be at least {low}"
    if high is not None and value > high:
        return f"must be at most {high}"
    return None


def _list_complaint(values: Any, like: Sequence[Any], lows: Any, highs: Any) -> str | None:
    """The first complaint about a list of numbers; limits are a sequence, or None."""
    size = len(like)
    if not isinstance(values, list | tuple) or len(values) != size:
        return f"needs {size} numbers"
    nothing = (None,) * size
    complaints = map(_number_complaint, values, like, lows or nothing, highs or nothing)
    return next((complaint for complaint in complaints if complaint is not None), None)


def _slider_complaint(handle: Any, value: Any) -> str | None:
    return _number_complaint(value, handle.value, handle.min, handle.max)


def _multi_slider_complaint(handle: Any, values: Any) -> str | None:
    now = handle.value
    complaint = _list_complaint(values, now, [handle.min] * len(now), [handle.max] * len(now))
    if complaint is not None:
        return complaint
    if any(later < earlier for earlier, later in itertools.pairwise(values)):
        return "needs its marks in order"
    if handle.fixed_endpoints and (values[0], values[-1]) != (now[0], now[-1]):
        return "has fixed ends"
    return None


def _vector_complaint(handle: Any, values: Any) -> str | None:
    return _list_complaint(values, handle.value, handle.min, handle.max)


def _color_complaint(handle: Any, values: Any) -> str | None:
    size = len(handle.value)
    return _list_complaint(values, [0] * size, [0] * size, [255] * size)


def _choice_complaint(handle: Any, value: Any) -> str | None:
    return None if isinstance(value, str) and value in handle.options else "has no such choice"


def _flag_complaint(handle: Any, value: Any) -> str | None:
    return None if isinstance(value, bool) else "is either on or off"


def _text_complaint(handle: Any, value: Any) -> str | None:
    if not isinstance(value, str):
        return "needs a text"
    if len(value) > MAX_TEXT_CHARACTERS:
        return f"takes at most {MAX_TEXT_CHARACTERS} characters"
    return None


_COMPLAINTS: Final[dict[type, Callable[[Any, Any], str | None]]] = {
    viser.GuiSliderHandle: _slider_complaint,
    viser.GuiNumberHandle: _slider_complaint,
    viser.GuiMultiSliderHandle: _multi_slider_complaint,
    viser.GuiVector2Handle: _vector_complaint,
    viser.GuiVector3Handle: _vector_complaint,
    viser.GuiRgbHandle: _color_complaint,
    viser.GuiRgbaHandle: _color_complaint,
    viser.GuiDropdownHandle: _choice_complaint,
    viser.GuiButtonGroupHandle: _choice_complaint,
    viser.GuiCheckboxHandle: _flag_complaint,
    viser.GuiButtonHandle: _flag_complaint,
    viser.GuiTextHandle: _text_complaint,
}
"""For each kind of widget that a page may set: what is wrong with a value, None if nothing is."""
