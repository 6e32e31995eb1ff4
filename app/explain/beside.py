"""Runs side by side in words: what each of them is, who leads, and what each knows of one cell."""

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from markupsafe import Markup

from app.explain.cell import OUTCOME_NAMES, CellReading
from app.live.snapshot import Snapshot
from app.util.html import element, joined
from app.words.numbers import NONE, counted, shown_number, significant
from app.words.plain import joined_by_and, plain
from learners import measures
from learners.names import COMMANDS, MOVES
from learners.spec import RunSpec

_LEVEL: Final = 3.0
"""Rewards per trial no farther apart are level: a mean over the last trials is no surer."""
_COUNTS: Final = {2: "Two", 3: "Three", 4: "Four"}


def repertoire(spec: RunSpec) -> str:
    """What a learner chooses among, and how, in a few words for those who do not know its name."""
    return f"{_options_of(spec)}{_manner_of(spec)}"


def _manner_of(spec: RunSpec) -> str:
    """What is besides of how it chooses and learns, each after a comma."""
    learner, schedule, held = spec.learner, spec.schedule, spec.learner.held
    parts: list[str] = []
    if learner.selection != "learned":
        parts.append("selected by a rule")
    if held is not None:
        most = counted(held.most, "step")
        until = "the place changes" if held.until == "change" else ""
        parts.append(f"a choice is kept until {until}" if until else f"a choice is kept {most}")
    if schedule.pretrain and learner.skills:
        parts.append(f"pre-trained {schedule.pretrain:,} steps each")
    if schedule.teach is not None:
        parts.append(f"taught for {counted(schedule.teach.trials, 'trial')}")
    return "".join(f", {part}" for part in parts)


def _options_of(spec: RunSpec) -> str:
    skills = spec.learner.skills
    if spec.learner.options == MOVES:
        traces = "" if spec.learner.trace_decay is None else ", and traces of the last moves"
        return f"nine moves, no skills{traces}"
    if spec.learner.options == COMMANDS:
        return "five commands of a manager, no skills"
    joins = [spec.schedule.introduced_at(skill) for skill in skills]
    names = joined_by_and([plain(skill) for skill in skills])
    if len(set(joins)) == 1:
        when = "from the start" if joins[0] == 0 else f"from trial {joins[0]:,}"
        return f"{names}, {when}" if len(skills) == 1 else f"{names}, all {when}"
    by_time = sorted(zip(joins, skills, strict=True))
    by_rule = {skill for skill in skills if spec.schedule.rule_of(skill) is not None}
    if by_rule:
        parts = [
            plain(skill) + (" (by a rule)" if skill in by_rule else f" ({at:,})" if at else "")
            for at, skill in by_time
        ]
        return f"skills one by one: {', '.join(parts)}"
    parts = [plain(skill) + (f" ({at:,})" if at else "") for at, skill in by_time]
    return f"skills one by one, planned by trial: {', '.join(parts)}"


def standing(
    names: Sequence[str], snapshots: Sequence[Snapshot], step: int, common_starts: bool
) -> Markup:
    """What stands side by side, and who leads, in a sentence or two.

    Args:
        names: of the runs.
        snapshots: of one moment.
        step: steps that each has made.
        common_starts: whether trials of the same number start alike for all.
    """
    count = _COUNTS.get(len(names), str(len(names)))
    alike = ", from the same starts of trials" if common_starts else ""
    what = element("span", f"{count} runs, step for step{alike}.", class_="what")
    rewards = [one.recent_reward for one in snapshots]
    lead = leaders(snapshots, step)
    if not lead:
        return joined([what, " No trial has ended yet in all of them."], "")
    best = _mean(max(rewards[place] for place in lead))
    after = f" After {counted(step, 'step')} "
    others = [place for place in _compared(snapshots, step) if place not in lead]
    if not others:
        known = joined_by_and([names[place] for place in lead])
        whose = "they are level" if len(lead) > 1 else f"{known} is there alone"
        return joined([what, after, f"{whose}: ", best, "."], "")
    others.sort(key=lambda place: -rewards[place])
    behind = [f"{names[place]} {shown_number(rewards[place], '.0f')}" for place in others]
    verb = "leads with" if len(lead) == 1 else "lead with"
    who = element("b", joined_by_and([names[place] for place in lead]))
    return joined([what, after, who, f" {verb} {best}; ", joined_by_and(behind), "."], "")


def leaders(snapshots: Sequence[Snapshot], step: int) -> tuple[int, ...]:
    """Places of those whose reward is best, or level with the best, that first.

    A run that has not come as far does not count, unless its trials are over. Empty as long as
    there is one in which no trial has ended.

    Args:
        snapshots: of all runs.
        step: the moment.
    """
    rewards = [one.recent_reward for one in snapshots]
    compared = _compared(snapshots, step)
    if not compared or any(math.isnan(rewards[place]) for place in compared):
        return ()
    best = max(rewards[place] for place in compared)
    lead = [place for place in compared if best - rewards[place] <= _LEVEL]
    return tuple(sorted(lead, key=lambda place: -rewards[place]))


def ahead_of_others(snapshots: Sequence[Snapshot], step: int) -> tuple[int, ...]:
    """Those that lead, where there are others that do not; the arguments are those of `leaders`."""
    lead = leaders(snapshots, step)
    return lead if len(lead) < len(_compared(snapshots, step)) else ()


def _compared(snapshots: Sequence[Snapshot], step: int) -> list[int]:
    return [
        place
        for place, one in enumerate(snapshots)
        if one.step >= step or one.trial >= one.spec.trials
    ]


def _mean(reward: float) -> str:
    recent = measures.RECENT_TRIALS
    return f"{shown_number(reward, '.0f')} a trial (mean of the last {recent})"


class Row(NamedTuple):
    """A row of a table with a column for each run."""

    what: str
    values: tuple[str, ...]
    hint: str = ""


def cell_rows(readings: Sequence[CellReading | None]) -> list[Row]:
    """What each run knows of the same cell; None of one whose grid has no such cell."""
    rows = (
        ("worth", _worth, "Steps to a certain capture that is worth as much"),
        ("takes", _choice, "What is best there by what it knows"),
        ("since", _reach, "The trial in which the value first rose above 0"),
        ("visits", _visits, "Steps that began in this state so far"),
        ("a hunt", _end, "How one from here ends without random moves"),
    )
    return [
        Row(
            what,
            tuple("not on this board" if one is None else say(one) for one in readings),
            hint,
        )
        for what, say, hint in rows
    ]


def _worth(reading: CellReading) -> str:
    best = max((option.q for option in reading.options), default=0.0)
    if best <= 0:
        if not reading.unit.counts:
            return "nothing to any skill"
        return "will be seen" if best < 0 else "nothing yet"
    unit = reading.unit
    if not unit.counts:
        return f"{significant(best)} to a skill"
    return f"{unit.steps_in_words(best)} {unit.noun}s"


def _choice(reading: CellReading) -> str:
    best = [option.name for option in reading.options if option.greedy]
    return best[0] if len(best) == 1 else "no best one"


def _reach(reading: CellReading) -> str:
    return NONE if reading.first_reach is None else f"trial {reading.first_reach:,}"


def _visits(reading: CellReading) -> str:
    return f"{sum(option.visits for option in reading.options):,}"


def _end(reading: CellReading) -> str:
    return OUTCOME_NAMES[reading.outcome]
