"""Play and pause, steps and trials, and how fast: of the live run, or of the past that is shown."""

import math
from typing import Final

import viser

from app.live.requests import (
    GoOn,
    Pause,
    PauseAtJoins,
    Play,
    Request,
    RunTo,
    SetSpeed,
    StepOnce,
    TrialOnce,
)
from app.live.status import Status
from app.live.worker import FULL_SPEED
from app.page.inbox import Ask, Intent, StatusOf
from app.page.number_field import Limits, NumberField
from app.page.widgets import CALM, Input, add_buttons, add_hints, assign
from app.schedule.blocks import planned_joins
from app.server.callbacks import RefusedError
from app.words.numbers import counted, in_short
from learners.names import MAX_TRIALS

SPEEDS: Final = 7.0
"""Where the speed slider means as fast as it goes."""
_SPEED_MARKS: Final = (
    (0.0, "1"),
    (1.0, "10"),
    (2.0, "100"),
    (3.0, "1 k"),
    (4.0, "10 k"),
    (5.0, "100 k"),
    (6.0, "1 M"),
    (SPEEDS, "max"),
)
_ROUND: Final = (1.0, 1.25, 1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 6.3, 8.0)
"""The speeds of a tenth of the slider each, up to the next power of ten."""


def speed_of(slider: float) -> float:
    """Steps per second at a place of the speed slider, a round number."""
    if slider >= SPEEDS:
        return FULL_SPEED
    power, tenth = divmod(round(10 * slider), 10)
    return _ROUND[tenth] * 10.0**power


def slider_of(speed: float) -> float:
    """Place of the speed slider for a speed."""
    return (
        SPEEDS if speed == FULL_SPEED else round(min(max(math.log10(speed), 0.0), SPEEDS - 0.1), 1)
    )


def speed_label(speed: float) -> str:
    """A speed in words short enough for the slider."""
    if speed == FULL_SPEED:
        return "Full speed"
    if speed < 1_000:
        number = f"{speed:.3g}"
    elif speed < 1e6:
        number = f"{speed / 1e3:.3g} k"
    else:
        number = in_short(speed)
    return f"{number} step/s" if number == "1" else f"{number} steps/s"


def faster(by: float, status: Status) -> SetSpeed:
    """What sets the speed so much farther along the slider; below 0 it is slower."""
    return SetSpeed(speed_of(min(max(slider_of(status.speed) + by, 0.0), SPEEDS)))


def play_or_pause(status: Status) -> Request:
    """What lets the learner go on, or the past that is shown, or holds it still.

    Raises:
        RefusedError: the run is over.
    """
    if status.finished and not status.exhausted:
        more = counted(status.snapshot.spec.trials, "trial")
        raise RefusedError(
            f"the {counted(status.snapshot.trial, 'trial')} are over; under Run the learner can"
            f" go on for {more} more, or start again"
        )
    return Pause() if status.playing else Play()


class Transport:
    """The widgets, in the container that is current; shared by all browsers."""

    def __init__(self, gui: viser.GuiApi, ask: Ask, status_of: StatusOf, status: Status) -> None:
        self._ask = ask
        self._status_of = status_of
        self._play = gui.add_button(
            "Pause",
            icon=viser.Icon.PLAYER_PAUSE,
            hint="Let the learner go on, or hold it still (space); in the past, what is shown.",
        )
        self._play.on_click(Intent(self._played))
        self._further = gui.add_button(
            "Go on",
            icon=viser.Icon.PLAYER_TRACK_NEXT,
            color=CALM,
            visible=False,
            hint="Let the run have as many trials again as it was to have.",
        )
        self._further.on_click(Intent(lambda client, _: ask(client, GoOn())))
        add_hints(gui, self._play, self._further)
        add_buttons(
            gui,
            "Go on by",
            {"One step": StepOnce(), "One trial": TrialOnce()},
            ask,
            hint="Pause, and make one step (S) or go on to the start of the next trial (T).",
        )
        self._build_stops(gui, status)
        # The last: what is written below it needs room.
        speed = gui.add_slider(
            speed_label(status.speed),
            min=0.0,
            max=SPEEDS,
            step=0.1,
            initial_value=slider_of(status.speed),
            marks=_SPEED_MARKS,
            hint="Steps that the learner makes in a second (J slower, K faster). At max it is as"
            " fast as this machine goes. What is learned is the same at any speed.",
        )
        self._speed = Input(speed, lambda client, place: ask(client, SetSpeed(speed_of(place))))

    def _build_stops(self, gui: viser.GuiApi, status: Status) -> None:
        self._trial = NumberField(
            gui,
            "Run to trial",
            _next_stop(status),
            Limits(1, MAX_TRIALS),
            hint="The trial at whose start the learner is to stand still.",
        )
        self._run_to = gui.add_button(
            "Run to it, and pause",
            icon=viser.Icon.PLAYER_SKIP_FORWARD,
            color=CALM,
            hint="Learn at full speed up to the start of that trial, and stand still there.",
        )
        add_hints(gui, self._run_to)
        self._run_to.on_click(Intent(self._sent))
        self._at_joins = Input(
            gui.add_checkbox(
                "Pause when a skill joins",
                False,
                hint="Stand still at the start of each trial in which the schedule adds a skill:"
                " what is planned for it can still be changed.",
            ),
            lambda client, on: self._ask(client, PauseAtJoins(on)),
        )

    def update(self, status: Status) -> None:
        """Show what is true."""
        label, icon = "Pause", viser.Icon.PLAYER_PAUSE
        if not status.playing:
            label, icon = "Play", viser.Icon.PLAYER_PLAY
            if status.finished:
                label = f"The {counted(status.snapshot.trial, 'trial')} are over"
        if status.exhausted:
            label = "This run has had all its trials"
        if status.error is not None:
            label = "Stopped by an error: start again"
        if status.behind is not None:
            what = "the branch" if status.behind.branch else "the past"
            label = f"{'Pause' if status.playing else 'Play'} {what}"
        stuck = status.exhausted or status.error is not None
        # First, so that a page that says what can be done can have it done.
        assign(self._play, "disabled", stuck or status.finished)
        if self._play.label != label:
            self._play.label = label
            self._play.icon = icon
        assign(self._further, "visible", status.finished and not stuck)
        more = counted(status.snapshot.spec.trials, "trial")
        assign(self._further, "label", f"Go on for {more} more")
        self._speed.show(slider_of(status.speed))
        live = "" if status.behind is None else "Live run: "
        assign(self._speed.handle, "label", f"{live}{speed_label(status.speed)}")
        self._show_stops(status)

    def _show_stops(self, status: Status) -> None:
        to = status.runs_to
        label = "Run to it, and pause" if to is None else f"On the way to trial {to:,} …"
        assign(self._run_to, "label", label)
        if status.behind is None and self._trial.number <= status.snapshot.trial:
            # Nobody can go there any more.
            self._trial.show(_next_stop(status))
        self._at_joins.show(status.pauses_at_joins)

    def _played(self, client: viser.ClientHandle, _: object) -> None:
        self._ask(client, play_or_pause(self._status_of(client)))

    def _sent(self, client: viser.ClientHandle, _: object) -> None:
        self._ask(client, RunTo(int(self._trial.read())))


def _next_stop(status: Status) -> int:
    """A trial to run to: where the schedule adds the next skill, or where the run is to end."""
    snapshot = status.snapshot
    ahead = planned_joins(snapshot.control)
    joins = min((trial for trial in ahead.values() if trial > snapshot.trial), default=None)
    end = max(snapshot.spec.trials, snapshot.trial + 1)
    return min(end if joins is None else joins, MAX_TRIALS)
