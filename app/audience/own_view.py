"""What a page is sent of the learner of its seat, in parts: board, words, and what can be done.

A part is JSON as the page takes it (``app/web/audience/own.js``). Buttons are told with what they
say when they are pressed; whatever comes back is judged all the same.
"""

from collections.abc import Iterator, Sequence
from typing import Any, Final, Protocol

from app.audience.own import Own
from app.audience.pictures import Parts, part
from app.audience.taps import (
    SPEEDS,
    AddOwn,
    AgainOwn,
    ExploreOwn,
    FreezeOwn,
    PlayOwn,
    StepOwn,
    Tap,
    TrialOwn,
)
from app.explain import sentence
from app.live.status import Status
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import Look
from app.picture.theme import DARK, LIGHT
from app.player.boards import described, ground_sent, over_sent, world_key, world_sent
from app.player.headline import readings_html
from app.words.numbers import counted, speed_in_words
from app.words.plain import plain


class Seat(Protocol):
    """Whose a learner is."""

    @property
    def number(self) -> int: ...

    @property
    def shape(self) -> str: ...

    @property
    def is_taken(self) -> bool: ...


CONTROLS: Final = ("play", "speed", "add_skill", "explore")
"""What there is on the page where no lesson says."""
MOST_CONTROLS: Final = 4
_FIRST: Final = (
    "play",
    "add_skill",
    "explore",
    "speed",
    "trial",
    "freeze",
    "step",
    "start_again",
)
"""Those that there can be; where a lesson has more than fit, the first of these."""
_ORDER: Final = (
    "play",
    "step",
    "trial",
    "speed",
    "add_skill",
    "explore",
    "freeze",
    "start_again",
)
"""In which they stand."""
ORDER: Final = ("own", "own_world", "own_ground", "own_over", "own_words")
"""Kinds of parts, in the order in which a page takes them in."""
OVER_S: Final = 2.5
WORDS_S: Final = 1.0
"""Between two at least, while nobody does anything."""


def controls_of(shown: frozenset[str]) -> tuple[str, ...]:
    """The few controls there are of those that a lesson shows."""
    few = [control for control in _FIRST if control in shown or "all" in shown][:MOST_CONTROLS]
    return tuple(control for control in _ORDER if control in few)


class OwnView:
    """What is sent of one learner to pages that are all dark, or all light."""

    def __init__(self, dark: bool) -> None:
        self.parts: Parts = {}
        self.at_s = -10.0
        """When it was painted last."""
        self._look = Look(theme=DARK if dark else LIGHT)
        self._world = ""
        self._ground_of: object = None
        self._over_of: object = None
        self._words_of: tuple[object, bool] = (None, False)
        self._over_s = self._words_s = -10.0

    def is_of(self, status: Status) -> bool:
        """Whether all is painted that is to be seen of it."""
        return (
            self._ground_of is status.snapshot
            and self._over_of is status.snapshot
            and self._said(status)
        )

    def _said(self, status: Status) -> bool:
        """Whether the words are of how it stands."""
        moment, playing = self._words_of
        return moment is status.snapshot and playing == status.playing

    def paint(self, status: Status, asked: bool, now_s: float) -> None:
        """Make those parts anew that are others by now.

        Args:
            status: of the learner; the same moment is the same object.
            asked: whether somebody has done something, and waits to see it.
            now_s: the time.
        """
        self.at_s = now_s
        moment, look = status.snapshot, self._look
        world = moment.spec.world
        if self._world != world_key(world):
            self._world = world_key(world)
            self.parts["own_world"] = part("own_world", {"world": world_sent(world)})
        if self._ground_of is not moment:
            self._ground_of = moment
            board = ground_sent(moment, look, Extras(), rests=not status.playing)
            self.parts["own_ground"] = part("own_ground", {"board": board})
        if not self._said(status) and (asked or now_s - self._words_s >= WORDS_S):
            self._words_of, self._words_s = (moment, status.playing), now_s
            self.parts["own_words"] = part("own_words", _words(status, look))
        # Lines take longer to find than all the rest: whoever taps sees them a moment later.
        is_due = not status.playing or now_s - self._over_s >= OVER_S
        if self._over_of is not moment and not asked and is_due:
            self._over_of, self._over_s = moment, now_s
            board = over_sent(moment, look, Extras())
            self.parts["own_over"] = part("own_over", {"board": board})


def _words(status: Status, look: Look) -> dict[str, Any]:
    moment, said = status.snapshot, sentence.said(status)
    return {
        "sentence": str(said),
        "readings": readings_html(moment),
        "described": f"{described(moment, look)} {said.striptags()}",
        "legend": str(LAYERS[look.layer].legend(moment, look, Extras())),
    }


# --- What can be done -----------------------------------------------------------------------------


def own_part(own: Own, seat: Seat, controls: tuple[str, ...], notice: str) -> bytes:
    """How a learner stands, whose it is, and what its seat can do with it.

    Args:
        own: the learner.
        seat: whose it is.
        controls: which there are.
        notice: what has happened to it, or why something could not be done.
    """
    beginning = own.beginning
    goal = f"learns up to trial {beginning.start:,}" if own.is_new else "is made again"
    return part(
        "own",
        {
            "whose": (
                f"You have seat {seat.number}, {seat.shape}. The seed of your learner is"
                f" {own.seed}: {beginning.seed} and the number of your seat."
            ),
            "busy": f"Your learner {goal} …" if own.is_on_its_way else "",
            "notice": notice,
            "playing": own.learns,
            "controls": [
                {"control": control, **told} for control in controls for told in _told(control, own)
            ],
        },
    )


def waiting_part(seat: Seat) -> bytes:
    """That there is no room for a learner yet."""
    words = "Too many learners are at work. Yours begins as soon as one of them rests."
    return _nothing_but(words, f"You have seat {seat.number}, {seat.shape}.")


def seatless_part() -> bytes:
    """That there is no learner where there is no seat, be it that the class has ended."""
    return _nothing_but("You have no seat now, and so no learner. Load this page again to get one.")


def _nothing_but(notice: str, whose: str = "") -> bytes:
    told = {"whose": whose, "busy": "", "notice": notice, "playing": False}
    return part("own", {**told, "controls": ()})


def _told(control: str, own: Own) -> Iterator[dict[str, Any]]:
    """A control as a page draws it; nothing where it makes no sense for such a learner."""
    skills = own.run.spec.learner.skills
    match control:
        case "play" if own.is_over:
            yield _button("Start again", AgainOwn())
        case "play":
            yield _button("Pause" if own.playing else "Play", PlayOwn(not own.playing))
        case "step":
            yield _button("One step", StepOwn(), on=not own.is_over)
        case "trial":
            yield _button("One trial", TrialOwn(), on=not own.is_over)
        case "speed":
            words = [speed_in_words(speed) for speed in SPEEDS]
            yield {"kind": "level", "label": "Speed", "level": own.level, "words": words}
        case "add_skill" if skills:
            yield _adding(own)
        case "explore" if skills:
            yield _exploring(own)
        case "freeze":
            frozen = own.run.control.selection_frozen
            label = "Let it learn again" if frozen else "Freeze selection"
            yield _button(label, FreezeOwn(not frozen), on=not own.is_over)
        case "start_again":
            yield _button("Start again", AgainOwn())
        case _:
            return


def _adding(own: Own) -> dict[str, Any]:
    present = own.run.present
    absent = [skill for skill in own.run.spec.learner.skills if skill not in present]
    taps = [(plain(skill), AddOwn(skill)) for skill in absent]
    return _choice("Add", taps, "All skills have joined", on=not own.is_over)


def _exploring(own: Own) -> dict[str, Any]:
    run = own.run
    running = run.control.running(run.trial)
    if running:
        skill, left = running[0].skill, running[0].until_trial - run.trial
        label = f"Stop exploring {plain(skill)}"
        tap = ExploreOwn(skill, False)
        return {**_button(label, tap), "note": f"{counted(left, 'trial')} left"}
    # What joined last is what there is to explore.
    taps = [(plain(skill), ExploreOwn(skill, True)) for skill in reversed(run.present)]
    return _choice("Explore", taps, "No skill to explore yet", on=not own.is_over)


def _button(label: str, tap: Tap, on: bool = True) -> dict[str, Any]:
    return {"kind": "button", "label": label, "says": tap, "on": on}


def _choice(label: str, taps: Sequence[tuple[str, Tap]], nothing: str, on: bool) -> dict[str, Any]:
    if not taps:
        return {"kind": "button", "label": nothing, "says": None, "on": False}
    return {"kind": "choice", "label": label, "options": taps, "on": on}
