"""Fields and sliders that take a number: as it was typed, or not at all.

A number field of viser drops in the browser what it takes for no part of a number, so that 12,000
comes to the server as 12. So these are text fields, and the text is read here. A page sends each
keystroke, and ends the text with a line break when it is finished: by Enter, or as the focus leaves
(``app/web/fields.js``). Nothing takes effect before, or before it has rested for a while.
"""

import contextlib
import math
import time
from collections.abc import Callable
from typing import Any, Final, NamedTuple

import viser

from app.page.widgets import TOUCHED_S, Input, assign
from app.server.callbacks import RefusedError
from app.words import typed
from app.words.typed import NumeralError

Changed = Callable[[viser.ClientHandle, float], object]
"""Called with what a person, and not the program, has set."""

DIALS_HTML: Final = '<div class="pounce-dials"></div>'
"""Stands in each container of dials; the stylesheet of the page goes by it."""
_ECHO_S: Final = 1.0
"""A text that was finished may come once more so much later, unfinished: a page sends keystrokes
with a delay, but the end of a text at once."""
_REST_S: Final = 2.0
"""A text that has not changed for so long is finished, if it is a number."""
_SLIDER_REST_S: Final = 0.35
"""A slider that has not moved for so long has come to rest."""
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
        """``changed`` is called with finished numbers; a live field wants :meth:`settle` called."""
        self._limits = limits
        self._number = value
        self._changed = changed
        self._live = live
        self._finished, self._finished_s = "", -math.inf
        self._unfinished: tuple[viser.ClientHandle, str, float] | None = None
        """Who typed what, and when."""
        self.handle: Any = gui.add_text(label, limits.write(value), hint=hint)
        self._input = Input(self.handle, self._typed)

    @property
    def text(self) -> str:
        """What stands in the field, finished or not."""
        return str(self.handle.value).strip()

    @property
    def number(self) -> float:
        """The number that stood in the field last; what is typed and not finished is none."""
        return self._number

    def read(self) -> float:
        """The number that stands in the field, finished or not.

        Raises:
            RefusedError: there stands none.
        """
        return self._number_in(self.text)

    def put(self, number: float) -> None:
        """Have a number stand in the field, in the place of all that was typed so far."""
        self._number = number
        self._unfinished = None
        self._input.put(self._limits.write(number))

    def show(self, number: float) -> None:
        """Let the field show what is true, unless somebody is changing it."""
        is_typed = str(self.handle.value) != self._limits.write(self._number)
        if self._input.rests(_GIVEN_UP_S if is_typed else TOUCHED_S):
            self.put(number)

    def settle(self, now_s: float) -> None:
        """Take a live number that has rested; ``now_s`` is of the clock ``time.monotonic``."""
        if self._live and self._unfinished is not None:
            client, text, typed_s = self._unfinished
            if now_s - typed_s >= _REST_S:
                self._unfinished = None
                with contextlib.suppress(RefusedError):
                    self._take(client, self._number_in(text))

    def _typed(self, client: viser.ClientHandle, text: str) -> None:
        now_s = time.monotonic()
        self._unfinished = None
        if text.endswith("\n"):
            self._finished, self._finished_s = text.strip(), now_s
            self._finish(client, self._finished)
        elif text == self._finished and now_s - self._finished_s < _ECHO_S:
            self._finish(client, text, aloud=False)
        else:
            self._unfinished = client, text.strip(), now_s

    def _finish(self, client: viser.ClientHandle, text: str, aloud: bool = True) -> None:
        """Take a text, or say why not."""
        try:
            self._take(client, self._number_in(text))
        except RefusedError as error:
            if self._live:
                self.put(self._number)
            if aloud:
                client.add_notification("Not taken", str(error), auto_close_seconds=8)

    def _take(self, client: viser.ClientHandle, number: float) -> None:
        is_new = number != self._number
        self.put(number)
        if is_new and self._changed is not None:
            self._changed(client, number)

    def _number_in(self, text: str) -> float:
        if text == self._limits.write(self._number):
            return self._number
        try:
            return self._limits.read(text)
        except NumeralError as error:
            label = self.handle.label.removesuffix(_AS_A_NUMBER)
            complaint = f"{label}: {text[:_LONGEST_QUOTE]!r} is {error}"
            raise RefusedError(complaint) from error


class Dial:
    """A slider and a field for one number; viser's own field beside a slider is not shown.

    A live one takes effect once it has come to rest, so that a drag is one change.
    """

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
        """``changed`` makes it live: :meth:`settle` calls it with what the dial was set to."""
        self._limits = limits
        self._changed = changed
        self._wish: tuple[viser.ClientHandle, float, float] | None = None
        """Who has set it to what, and when."""
        slider = gui.add_slider(
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
        self._slider = Input(slider, self._moved)

    def read(self) -> float:
        """The number that is set.

        Raises:
            RefusedError: in the field there stands none.
        """
        return self.field.read()

    def show(self, number: float) -> None:
        """Let both show what is true, unless somebody is changing them."""
        if self._wish is None:
            self._slider.show(self._place(number))
            self.field.show(number)

    def settle(self, now_s: float) -> None:
        """Let what has come to rest take effect; ``now_s`` is of the clock ``time.monotonic``."""
        self.field.settle(now_s)
        if self._wish is not None and now_s - self._wish[2] >= _SLIDER_REST_S:
            client, number, _ = self._wish
            # Forgotten before it is asked for: what is set meanwhile is another change.
            self._wish = None
            if self._changed is not None:
                self._changed(client, number)

    def disable(self, disabled: bool) -> None:
        """Whether neither can be changed."""
        assign(self._slider.handle, "disabled", disabled)
        assign(self.field.handle, "disabled", disabled)

    def _place(self, number: float) -> float:
        """Where the slider stands: at a number, or at the end that is nearest to it."""
        return min(max(number, self._limits.low), self._limits.high)

    def _moved(self, client: viser.ClientHandle, place: float) -> None:
        self.field.put(float(place))
        if self._changed is not None:
            self._wish = client, float(place), time.monotonic()

    def _set(self, client: viser.ClientHandle, number: float) -> None:
        self._slider.put(self._place(number))
        if self._changed is not None:
            self._wish = client, number, -math.inf
