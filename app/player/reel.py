"""A session that is played from its moments: which of them, and what is seen and read at each.

A run has millions of steps and a film some hundred moments, so these are dense where much changes:
each is as far from the next as a share of the trials, of the steps and of all that changed on the
board adds up to. Whatever happened (:mod:`app.explain.happenings`) has a moment of its own.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any, Final, NamedTuple

import numpy as np

from app.charts.bar.model import Moment as BarMoment
from app.charts.bar.model import bar_of
from app.charts.bar.sent import Around, Sent, bar_sent
from app.charts.bar.tree import known_until, marks_on
from app.explain import sentence
from app.explain.happenings import Happening, first_capture_in, happenings_of
from app.live.lines import FIRST_RUN, Family
from app.live.past import Budget, Past
from app.live.places import LineSeen, Mark
from app.live.snapshot import Snapshot, take
from app.live.status import Status
from app.metrics.course import GreedyCurve, coherence_of, greedy_of
from app.picture.layer import Extras
from app.picture.layers import LAYERS
from app.picture.look import ALL, FOLDED, Look
from app.picture.shading import equivalent_steps, nearness
from app.picture.theme import DARK, LIGHT
from app.picture.value_maps import reward_of
from app.player.boards import board_sent, described, ground_sent
from app.player.film import Board, Shot, View
from app.player.headline import readings_html
from app.schedule.blocks import Past as Blocks
from learners.kernel.state import digest
from learners.measures import recent_reward
from learners.run import Run
from learners.spec import RunSpec

GREEDY_EVERY_TRIALS: Final = 2_000
"""How often greedy reward is measured along a line."""
_SLICE_STEPS: Final = 200_000
_BY_STEPS, _BY_TRIALS = 500, 300
"""Moments of a whole session that are looked at to find out how much changes."""
_FEWEST: Final = 12
"""Of one line."""
_SHARES: Final = (0.25, 0.25, 0.5)
"""What trials, steps and changes weigh."""
NOTHING: Final = Extras()
_CHOICE: Final = 0.3
"""What it weighs that a state's best option is another one, where a value that comes is 1."""

Tell = Callable[[str, float], object]
"""Told now and then what is being done, and which share of it is."""


@dataclass(frozen=True)
class Recorded:
    """A session as it can be played: its lines, of which each moment can be made again."""

    preset: str
    """As shown."""
    seed: int
    lines: tuple[LineSeen, ...]
    """Parents before those that branched off them."""
    pasts: Mapping[int, Past]
    marks: tuple[Mark, ...] = ()

    @property
    def live(self) -> LineSeen:
        """The line that is shown first."""
        return next((line for line in self.lines if line.is_live), self.lines[-1])


def recorded_run(
    spec: RunSpec, preset: str, seed: int, tell: Tell = lambda _, __: None
) -> Recorded:
    """A run that nobody did anything to, made from its first trial to its preset's last."""
    run = Run(spec, seed)
    past = Past(run, Budget())
    while run.trial < spec.trials:
        if run.advance(max_steps=_SLICE_STEPS, until_trial=spec.trials) == 0:
            break
        past.note(run)
        tell("The run is made", run.trial / spec.trials)
    line = LineSeen(
        number=0,
        parent=None,
        fork_step=0,
        fork_trial=0,
        name=FIRST_RUN,
        until_step=run.step,
        until_trial=run.trial,
        reward=recent_reward(run.state),
        digest=digest(run.state),
        is_live=True,
    )
    return Recorded(preset, seed, (line,), {0: past})


def recorded_family(family: Family) -> Recorded:
    """A session's tree of runs, which must stand still."""
    lines: list[LineSeen] = []
    for number in sorted(family.lines):
        line = family.lines[number]
        seen = line.seen(is_live=line is family.live, is_growing=False)
        lines.append(_with_digest(seen, line.past))
    pasts = {number: line.past for number, line in family.lines.items()}
    seed = family.held.run.seed
    return Recorded(family.preset, seed, tuple(lines), pasts, family.marks)


def recorded_status(status: Status, past_of: Callable[[int], Past | None]) -> Recorded:
    """A session as it stands, which may go on meanwhile.

    Args:
        status: how it stands.
        past_of: the past of a line, by its number; None if it has gone.
    """
    pasts = {line.number: past_of(line.number) for line in status.lines}
    there = {number: past for number, past in pasts.items() if past is not None}
    lines = [
        _with_digest(replace(line, is_growing=False), there[line.number])
        for line in sorted(status.lines, key=lambda line: line.number)
        if line.number in there and (line.parent is None or line.parent in there)
    ]
    marks = tuple(mark for mark in status.marks if mark.place.line in there)
    snapshot = status.snapshot
    return Recorded(snapshot.preset, snapshot.seed, tuple(lines), there, marks)


def _with_digest(line: LineSeen, past: Past) -> LineSeen:
    """The line with the digest of its tables where it ends, which is not always at hand."""
    if line.digest:
        return line
    run = past.run_at(line.until_step)
    assert run is not None
    return replace(line, digest=digest(run.state), until_step=run.step, until_trial=run.trial)


# --- Which moments -------------------------------------------------------------------------------


class Stop(NamedTuple):
    """A moment of a line."""

    line: int
    step: int


def stops_of(recorded: Recorded, most: int, tell: Tell = lambda _, __: None) -> list[Stop]:
    """The moments to show: line by line, each in its order.

    A line has its own alone, and before these those of the line that it branched off. What happened
    is among them even if that makes more than ``most``.
    """
    lengths = [line.until_step - line.fork_step for line in recorded.lines]
    looks = [
        _changes(recorded, line, steps / max(sum(lengths), 1), tell)
        for line, steps in zip(recorded.lines, lengths, strict=True)
    ]
    total = [max(sum(float(look.added[:, i].sum()) for look in looks), 1e-12) for i in range(3)]
    weights = [look.added @ (np.array(_SHARES) / total) for look in looks]
    along = np.cumsum(np.concatenate([np.zeros(0), *weights]))
    wanted = np.linspace(0.0, along[-1] if along.size else 0.0, most)
    found: list[Stop] = []
    passed = 0.0
    for line, look, weight in zip(recorded.lines, looks, weights, strict=True):
        reached = passed + np.concatenate([[0.0], np.cumsum(weight)])
        here = wanted[(wanted >= reached[0]) & (wanted <= reached[-1])]
        passed = float(reached[-1])
        between = np.rint(np.interp(here, reached, look.steps)).astype(np.int64)
        events = [happening.step for happening in happenings_along(recorded, line)]
        own = [step for step in events if line.fork_step <= step <= line.until_step]
        steps = {line.fork_step, line.until_step, *between.tolist(), *own}
        found += [Stop(line.number, step) for step in sorted(steps)]
    return found


def stops_along(
    recorded: Recorded, line: int, most: int, tell: Tell = lambda _, __: None
) -> list[Stop]:
    """About so many moments of a line, those of the lines that it left among them."""
    until = known_until(line, recorded.lines)
    there = [
        stop
        for stop in stops_of(recorded, most, tell)
        if stop.line in until and stop.step < until[stop.line]
    ]
    return sorted(there, key=lambda stop: stop.step)


class _Looked(NamedTuple):
    """How much changed along a line."""

    steps: np.ndarray
    """(moment,) int64: moments at which it was looked at."""
    added: np.ndarray
    """(moment - 1, 3) float64: trials, steps, and what changed on the board in between."""


def _changes(recorded: Recorded, line: LineSeen, share: float, tell: Tell) -> _Looked:
    """How much changed along a line that has a share of the steps of all."""
    n_steps, n_trials = (max(round(n * share), _FEWEST) for n in (_BY_STEPS, _BY_TRIALS))
    past = recorded.pasts[line.number]
    first, last = past.trial_of_step(line.fork_step), past.trial_of_step(line.until_step)
    by_trial = np.linspace(first, last, n_trials).astype(np.int64)
    steps = np.concatenate(
        [
            np.linspace(line.fork_step, line.until_step, n_steps).astype(np.int64),
            [past.step_of_trial(trial) for trial in by_trial.tolist()],
        ]
    )
    steps = np.unique(np.clip(steps, line.fork_step, line.until_step))
    added = np.zeros((len(steps) - 1, 3))
    before: tuple[int, np.ndarray, np.ndarray] | None = None
    for place, snapshot in enumerate(_snapshots(recorded, line.number, steps.tolist())):
        now = snapshot.trial, _levels(snapshot), snapshot.choice_q.argmax(axis=-1)
        if before is not None:
            learned = float(np.abs(now[1] - before[1]).mean())
            chosen = float((now[2] != before[2]).mean())
            change = learned + _CHOICE * chosen
            added[place - 1] = now[0] - before[0], steps[place] - steps[place - 1], change
        before = now
        tell(f"{line.name} is looked at", place / len(steps))
    return _Looked(steps, added)


def _levels(snapshot: Snapshot) -> np.ndarray:
    """(heading, distance, direction): how near capture is, from 1 on; 0 where there is no value."""
    gamma = snapshot.spec.learner.gamma
    steps = equivalent_steps(snapshot.value, reward_of(snapshot), gamma)
    return np.where(snapshot.value > 0, 1.0 + np.nan_to_num(nearness(steps)), 0.0)


def _snapshots(recorded: Recorded, line: int, steps: Sequence[int]) -> Iterator[Snapshot]:
    """A line at some steps, which ascend; curves, which cost most, are those of the first."""
    former: Snapshot | None = None
    for run in _runs_at(recorded.pasts[line], steps):
        former = take(run, recorded.preset, line, former, new_curve=False)
        yield former


def _runs_at(past: Past, steps: Sequence[int]) -> Iterator[Run]:
    """A run of a line at each of some steps, which ascend; it is the same one where it can be."""
    run: Run | None = None
    for step in steps:
        if run is None or not past.take_on(run, step):
            run = past.run_at(step)
        assert run is not None
        yield run


# --- What is seen and read there -----------------------------------------------------------------

LAYERS_SHOWN: Final = ("value", "chosen", "reach")
"""Layers that a replay has."""
FRAMES: Final[Mapping[str, int]] = {"turned": FOLDED, "each": ALL}
"""How each of them is seen, by name: all headings turned, and each heading by itself."""


def view_name(layer: str, frame: str) -> str:
    """What a way to see moments is called in a film."""
    return f"{layer}/{frame}"


def shots_of(
    recorded: Recorded, stops: Sequence[Stop], tell: Tell = lambda _, __: None
) -> Iterator[Shot]:
    """What there is to be seen and read at some moments."""
    inks = Inks()
    for number, snapshot in enumerate(snapshots_at(recorded, stops), 1):
        yield shot_of(snapshot, inks)
        tell("Moments are drawn", number / len(stops))


def snapshots_at(recorded: Recorded, stops: Sequence[Stop]) -> Iterator[Snapshot]:
    """Moments of lines, those that follow one another on a line in its order."""
    for line, group in groupby(stops, key=lambda stop: stop.line):
        yield from _snapshots(recorded, line, [stop.step for stop in group])


class Inks:
    """Which colours lines have on dark pages, by those that they have on light ones.

    Where lines run takes longer to find than all else of a board, and is the same on both; so a
    board of lines that have been seen before is drawn for dark pages without them.
    """

    def __init__(self) -> None:
        self._known: dict[tuple[str, str], str] = {}

    def dark(self, light: Board, snapshot: Snapshot, look: Look) -> Board:
        """The board for dark pages of a moment whose board for light ones is known."""
        lines: list[dict[str, Any]] = light["lines"]
        keys = [(look.layer, str(line["colour"])) for line in lines]
        if all(key in self._known for key in keys):
            inked = [
                {**line, "colour": self._known[key]} for line, key in zip(lines, keys, strict=True)
            ]
            over = {"over": light["over"], "lines": inked, "labels": light["labels"]}
            return ground_sent(snapshot, look, NOTHING) | over
        board = board_sent(snapshot, look, NOTHING)
        self._known |= {key: line["colour"] for key, line in zip(keys, board["lines"], strict=True)}
        return board


def shot_of(snapshot: Snapshot, inks: Inks) -> Shot:
    """What there is to be seen and read at one moment."""
    said = sentence.said_of(snapshot)
    views = {
        view_name(layer, name): _view(snapshot, layer, frame, said.striptags(), inks)
        for layer in LAYERS_SHOWN
        for name, frame in FRAMES.items()
    }
    texts = str(said), str(readings_html(snapshot))
    return Shot(snapshot.generation, snapshot.step, snapshot.trial, texts, views)


def _view(snapshot: Snapshot, key: str, frame: int, said: str, inks: Inks) -> View:
    looks = [Look(theme, key, frame=frame) for theme in (LIGHT, DARK)]
    layer = LAYERS[key]
    legends = [str(layer.legend(snapshot, look, NOTHING)) for look in looks]
    caption = layer.caption(snapshot, looks[0], NOTHING)
    about = f"{described(snapshot, looks[0])} {said}"
    light = board_sent(snapshot, looks[0], NOTHING)
    return View(light, inks.dark(light, snapshot, looks[1]), (*legends, caption, about))


# --- Lines along their axes ----------------------------------------------------------------------


class LineBars(NamedTuple):
    """A line as the time bar draws it."""

    trials: Sent
    steps: Sent
    happenings: tuple[Happening, ...]


def bars_of(recorded: Recorded, tell: Tell = lambda _, __: None) -> dict[int, LineBars]:
    """The bar of each line, along trials and along steps, by the number of the line."""
    curves: dict[int, GreedyCurve] = {}
    found: dict[int, LineBars] = {}
    for place, line in enumerate(recorded.lines):
        tell("Hunts without exploration are made", place / len(recorded.lines))
        curves[line.number] = _greedy(recorded, line)
        past = recorded.pasts[line.number]
        run = past.run_at(line.until_step)
        assert run is not None
        end = take(run, recorded.preset, line.number)
        blocks = Blocks()
        notes = marks_on(line.number, recorded.lines, recorded.marks)
        greedy = _known(curves, line.number, recorded.lines)
        moment = BarMoment(end, blocks.blocks_of(end), blocks.left_out, greedy=greedy, notes=notes)
        happenings = happenings_along(recorded, line)
        around = Around(line.number, recorded.lines, notes, happenings, ahead=(), recorded=True)
        trials, steps = (
            bar_sent(bar_of(moment, unit, GREEDY_EVERY_TRIALS), around)
            for unit in ("trials", "steps")
        )
        found[line.number] = LineBars(trials, steps, happenings)
    return found


def happenings_along(recorded: Recorded, line: LineSeen) -> tuple[Happening, ...]:
    """What happened in a line, as far as it is played."""
    past = recorded.pasts[line.number]
    run = past.run_at(line.until_step)
    assert run is not None
    marks = tuple(mark for mark in recorded.marks if mark.place.line == line.number)
    capture = first_capture_in(past.outcomes[: run.trial])
    found = happenings_of(run.control, run.trial, past.step_of_trial, capture, marks)
    return tuple(happening for happening in found if happening.step <= line.until_step)


def _greedy(recorded: Recorded, line: LineSeen) -> GreedyCurve:
    """Greedy reward along a line, from where it branched off."""
    past = recorded.pasts[line.number]
    first, last = past.trial_of_step(line.fork_step), past.trial_of_step(line.until_step)
    every = GREEDY_EVERY_TRIALS
    trials = range(max(-(-first // every), 1) * every, last + 1, every)
    steps = sorted({*map(past.step_of_trial, trials), line.until_step})
    points = [
        (run.trial, run.step, greedy_of(run).reward, coherence_of(run).without_progress)
        for run in _runs_at(past, steps)
        if run.trial > 0
    ]
    columns = tuple(zip(*points, strict=True)) or ((), (), (), ())
    kinds = np.int64, np.int64, np.float32, np.float32
    return GreedyCurve(*(np.array(c, k) for c, k in zip(columns, kinds, strict=True)))


def _known(
    curves: Mapping[int, GreedyCurve], number: int, lines: Sequence[LineSeen]
) -> GreedyCurve:
    """What is known of a line, with what it has of those that it left."""
    parts = [
        GreedyCurve(*(each[curves[line].step <= until] for each in curves[line]))
        for line, until in reversed(known_until(number, lines).items())
    ]
    return GreedyCurve(*(np.concatenate(each) for each in zip(*parts, strict=True)))
