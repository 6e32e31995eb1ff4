"""Fields and sliders that take a number: as it was typed, or not at all.

A number field of viser drops in the browser what it takes for no part of a number, so that 12,000
comes to the server as 12. So these are text fields, and the text is read here. A page sends each
keystroke, and ends the text with a line break when it is finished: by Enter, or as the focus leaves
(``app/page/page.js``). Nothing takes effect before, or before it has rested for a while.
"""

import asyncio
import contextlib
import time
from collections.abc import Callable
from typing import Any, Final, NamedTuple

import viser

from app.page.widgets import TOUCHED_S, assign, on_change, show
from app.server.callbacks import RefusedError
from app.words import typed
from app.words.typed import NumeralError

Changed = Callable[[viser.GuiEvent, float], object]
"""Called with what a person, and not the program, has set."""

DIALS_HTML: Final = '<div class="pounce-dials"></div>'
"""Stands in each container of dials; the stylesheet of the page goes by it."""
_ECHO_S: Final = 1.0
"""A text that was finished may come once more so much later, unfinished: a page sends keystrokes
with a delay, but the end of a text at once."""
_REST_S: Final = 2.0
"""A text that has not changed for so long is finished, if it is a number."""
_GIVEN_UP_S: Final = 30.0
"""What was begun and left so long ago makes room for what is true."""
_LONGEST_QUOTE: Final = 40
_AS_A_NUMBER: Final = " as a number"


class Limits(NamedTuple):
    """The numbers that a field takes."""

    low: float
    high: float
    whole: bool = True
    share: bool = False
    """Whether it may be given in percent, too."""
    grouped: bool = True
    """Whether thousands are set apart; those of a seed, which is a name, are not."""

    def read(self, text: str) -> float:
        """The number that a text means.

        Raises:
            NumeralError: it is none of those.
        """
        if self.whole:
            return typed.whole(text, int(self.low), int(self.high))
        return typed.decimal(text, self.low, self.high, self.share)

    def write(self, number: float) -> str:
        """A number as a field shows it."""
        if self.whole:
            return f"{int(number):,}" if self.grouped else str(int(number))
        return typed.plain(number)


class NumberField:
    """A field for a number, which is part of a form or live.

    What stands in a form is read when a button is pressed, and stays there if it is no number. Live
    numbers are in force as soon as they are finished, and what is none is taken out of the field
    again, so that this shows what is true.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        label: str,
        value: float,
        limits: Limits,
        hint: str | None = None,
        changed: Changed | None = None,
        live: bool = False,
    ) -> None:
        """``changed`` is called with finished numbers."""
        self._limits = limits
        self._number = value
        self._changed = changed
        self._live = live
        self._finished, self._finished_s = "", 0.0
        self._rest: asyncio.TimerHandle | None = None
        self.handle: Any = gui.add_text(label, limits.write(value), hint=hint)
        on_change(self.handle, self._typed)

    @property
    def text(self) -> str:
        """What stands in the field, finished or not."""
        return str(self.handle.value).strip()

    def read(self) -> float:
        """The number that stands in the field, finished or not.

        Raises:
            RefusedError: there stands none.
        """
        text = self.text
        if text == self._limits.write(self._number):
            return self._number
        try:
            return self._limits.read(text)
        except NumeralError as error:
            raise RefusedError(self._complaint(text, error)) from error

    def put(self, number: float) -> None:
        """Have a number stand in the field, whatever stands there."""
        self._number = number
        assign(self.handle, "value", self._limits.write(number))

    def show(self, number: float) -> None:
        """Let the field show what is true, unless somebody is changing it."""
        is_typed = str(self.handle.value) != self._limits.write(self._number)
        patience_s = _GIVEN_UP_S if is_typed else TOUCHED_S
        if time.time() - self.handle.update_timestamp > patience_s:
            self.put(number)

    def _typed(self, event: viser.GuiEvent, text: str) -> None:
        if self._rest is not None:
            self._rest.cancel()
        if text.endswith("\n"):
            self._finished, self._finished_s = text.strip(), time.monotonic()
            self._finish(event)
        elif text == self._finished and time.monotonic() - self._finished_s < _ECHO_S:
            self._finish(event, aloud=False)
        elif self._live:
            loop = asyncio.get_running_loop()
            self._rest = loop.call_later(_REST_S, self._finish_if_number, event)

    def _finish(self, event: viser.GuiEvent, aloud: bool = True) -> None:
        """Take what stands in the field, or say why not."""
        try:
            self._take(event, self.read())
        except RefusedError as error:
            if self._live:
                self.put(self._number)
            if aloud and event.client is not None:
                event.client.add_notification("Not taken", str(error), auto_close_seconds=8)

    def _finish_if_number(self, event: viser.GuiEvent) -> None:
        with contextlib.suppress(RefusedError):
            self._take(event, self.read())

    def _take(self, event: viser.GuiEvent, number: float) -> None:
        is_new = number != self._number
        self.put(number)
        if is_new and self._changed is not None:
            self._changed(event, number)

    def _complaint(self, text: str, error: NumeralError) -> str:
        label = self.handle.label.removesuffix(_AS_A_NUMBER)
        return f"{label}: {text[:_LONGEST_QUOTE]!r} is {error}"


class Dial:
    """A slider and a field for one number; viser's own field beside a slider is not shown."""

    def __init__(
        self,
        gui: viser.GuiApi,
        label: str,
        value: float,
        limits: Limits,
        step: float,
        hint: str | None = None,
        changed: Changed | None = None,
    ) -> None:
        """``changed`` is called with each place of the slider and each number; it makes it live."""
        self._limits = limits
        self._changed = changed
        self._slider: Any = gui.add_slider(
            label,
            min=limits.low,
            max=limits.high,
            step=step,
            initial_value=self._place(value),
            hint=hint,
        )
        self.field = NumberField(
            gui, label + _AS_A_NUMBER, value, limits, hint, self._set, live=changed is not None
        )
        on_change(self._slider, self._moved)

    def read(self) -> float:
        """The number that is set.

        Raises:
            RefusedError: in the field there stands none.
        """
        return self.field.read()

    def show(self, number: float) -> None:
        """Let both show what is true, unless somebody is changing them."""
        show(self._slider, self._place(number))
        self.field.show(number)

    def disable(self, disabled: bool) -> None:
        """Whether neither can be changed."""
        assign(self._slider, "disabled", disabled)
        assign(self.field.handle, "disabled", disabled)

    def _place(self, number: float) -> float:
        """Where the slider stands: at a number, or at the end that is nearest to it."""
        return min(max(number, self._limits.low), self._limits.high)

    def _moved(self, event: viser.GuiEvent, place: float) -> None:
        self.field.put(float(place))
        if self._changed is not None:
            self._changed(event, float(place))

    def _set(self, event: viser.GuiEvent, number: float) -> None:
        assign(self._slider, "value", self._place(number))
        if self._changed is not None:
            self._changed(event, number)
