"""What a branch does otherwise than the line that it left, in words: its name, and a note on it.

Both are found by what holds once the branch's first commands are carried out, beside what held
before them: however often a thing is set there, only what comes of it is said.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Final, NamedTuple

from app.schedule.blocks import NEVER, planned_joins
from app.words.plain import joined_by_and, parameter_name, plain, shortened
from learners.commands import Command, Event
from learners.control import Control, Episode, evolve, exploration_of
from learners.parameters import parameters_of, value_of
from learners.schedule_spec import EpisodeSpec, ScheduleSpec

MOST_CHARACTERS: Final = 40
"""Of a computed name."""
_MOST_SAID: Final = 3
"""Differences that a note tells; the others are counted."""
_SYMBOLS: Final = {
    "learner.epsilon": "ε",
    "learner.alpha": "α of selection",
    "learner.skill_alpha": "α of skills",
    "learner.gamma": "γ",
    "world.capture_reward": "capture reward",
    "world.flight_reward": "flight reward",
    "world.vision_radius": "vision radius",
}


class _Difference(NamedTuple):
    """One thing that is otherwise on a branch."""

    lead: str
    skill: str
    """In the middle of its name; cut if need be. Empty for what is not of a skill."""
    rest: str
    said: str
    """As a note has it, after "Here"."""

    def name(self, characters: int) -> str:
        """What the branch is called by it."""
        room = max(characters - len(self.lead) - len(self.rest), 1)
        skill = shortened(plain(self.skill), room)
        return shortened(f"{self.lead}{skill}{self.rest}", characters)


def name_of(before: Control, trial: int, commands: Sequence[Command]) -> str:
    """A name for a branch: "avoid 2,500 earlier", "no avoid", "ε 0.2".

    Args:
        before: what held where it left its line, before its commands.
        trial: the running trial there.
        commands: given there, each of which can be carried out after the ones before.

    Returns:
        A plain text of 1 to ``MOST_CHARACTERS`` characters.
    """
    found = _differences(before, trial, commands)
    if not found:
        return "the same again"
    more = f" and {len(found) - 1} more" if len(found) > 1 else ""
    return f"{found[0].name(MOST_CHARACTERS - len(more))}{more}"


def difference_in_words(before: Control, trial: int, commands: Sequence[Command]) -> str:
    """What is otherwise on a branch and how to go back, as plain sentences.

    Args:
        before: what held where it left its line, before its commands.
        trial: the running trial there.
        commands: as :func:`name_of` takes them.
    """
    found = [difference.said for difference in _differences(before, trial, commands)]
    if len(found) > _MOST_SAID:
        left = len(found) - _MOST_SAID + 1
        found = [*found[: _MOST_SAID - 1], f"{left} other things are set otherwise"]
    here = joined_by_and(found) if found else f"nothing is otherwise from trial {trial:,} on"
    return f"Here {here}. End goes back to the live run, which is as it was."


def differences(one: Control, other: Control, trial: int) -> list[str]:
    """What is otherwise where another control holds, in words, the most telling first."""
    return [difference.said for difference in _differences_between(one, other, trial)]


def _differences(before: Control, trial: int, commands: Iterable[Command]) -> list[_Difference]:
    """What is otherwise after some commands, the most telling first."""
    after = before
    for command in commands:
        after = evolve(after, Event(len(after.history), 0, trial, 0, command, "hand"))
    return _differences_between(before, after, trial)


def _differences_between(before: Control, after: Control, trial: int) -> list[_Difference]:
    finders: tuple[Callable[[Control, Control, int], Iterator[_Difference]], ...] = (
        _skills,
        _explorations,
        _planned_explorations,
        _teaching,
        _parameters,
        _held_still,
        _freezes,
        _definitions,
    )
    return [difference for find in finders for difference in find(before, after, trial)]


def _skills(before: Control, after: Control, trial: int) -> Iterator[_Difference]:
    """Skills that join at another time, or leave."""
    # Whether the schedule is followed is a difference of its own.
    is_followed = before.schedule_on or after.schedule_on
    was_planned = planned_joins(before) if is_followed else {}
    is_planned = planned_joins(after) if is_followed else {}
    for skill in after.spec.learner.skills:
        name, then = plain(skill), was_planned.get(skill)
        if skill in before.present:
            if skill not in after.present:
                said = f"{name} leaves at trial {trial:,}"
                yield _Difference("no ", skill, "", said)
            continue
        now = trial if skill in after.present else is_planned.get(skill)
        rules = before.spec.schedule.rule_of(skill), after.spec.schedule.rule_of(skill)
        if now is None and rules[1] is not None:
            if rules[0] != rules[1] and is_followed:
                another = "a rule" if rules[0] is None else "another rule"
                yield _Difference("", skill, f" by {another}", f"{name} joins by {another}")
        elif now is None:
            if then is not None:
                said = f"{name} does not join at trial {then:,}"
                yield _Difference("no ", skill, "", said)
        elif then is None or (now == then and skill in after.present):
            rest = " added" if skill in after.present else f" at trial {now:,}"
            said = f"{name} joins at trial {now:,}"
            if rules[0] is not None and is_followed:
                said += " and not by its rule"
            yield _Difference("", skill, rest, said)
        elif now != then:
            way = "earlier" if now < then else "later"
            said = f"{name} joins at trial {now:,} and not at {then:,}"
            yield _Difference("", skill, f" {abs(now - then):,} {way}", said)


def _share(probability: float) -> str:
    return f"{100 * probability:.3g}%"


def _explorations(before: Control, after: Control, trial: int) -> Iterator[_Difference]:
    """Skills that the learner is made to take from now on, or no longer."""
    was: dict[str, Episode] = {episode.skill: episode for episode in before.running(trial)}
    runs: dict[str, Episode] = {episode.skill: episode for episode in after.running(trial)}
    for skill, episode in runs.items():
        if was.get(skill) != episode:
            share = _share(episode.probability)
            said = (
                f"{plain(skill)} is explored in {share} of the steps"
                f"{_where(episode.value_at_most)} until trial {episode.until_trial:,}"
            )
            yield _Difference("", skill, f" explored at {share}", said)
    for skill in was:
        if skill not in runs and skill in after.present:
            said = f"{plain(skill)} is not explored from trial {trial:,} on"
            yield _Difference("", skill, " not explored", said)


def _planned_explorations(before: Control, after: Control, trial: int) -> Iterator[_Difference]:
    """Explorations ahead that are planned otherwise, or not at all, or anew."""
    was, now = before.spec.schedule, after.spec.schedule
    gone = [episode for episode in was.episodes if episode not in now.episodes]
    for episode in (episode for episode in now.episodes if episode not in was.episodes):
        of_skill = (other for other in gone if other.skill == episode.skill)
        former = next(of_skill, None)
        if former is not None:
            gone.remove(former)
        skill, first = episode.skill, now.starts_at(episode)
        when = f"trials {first:,} to {first + episode.duration - 1:,}"
        if first >= NEVER:
            when = f"for {episode.duration:,} trials once it joins"
        share, at_most = _share(episode.probability), exploration_of(episode).value_at_most
        said = f"{plain(skill)} is explored in {share} of the steps{_where(at_most)}, {when}"
        yield _Difference("", skill, _planned_otherwise(episode, former, was, first), said)
    for episode in gone:
        first = was.starts_at(episode)
        since = "once it joins" if first >= NEVER else f"from trial {first:,} on"
        said = f"{plain(episode.skill)} is not explored {since}"
        yield _Difference("", episode.skill, " not explored", said)


def _where(value_at_most: float | None) -> str:
    if value_at_most is None:
        return ""
    return f" where nothing else is worth more than {value_at_most:g}"


def _planned_otherwise(
    episode: EpisodeSpec, former: EpisodeSpec | None, was: ScheduleSpec, first: int
) -> str:
    """What of an exploration is not as it was, where that is one thing alone."""
    if former is not None and former.probability == episode.probability:
        if was.starts_at(former) != first:
            return " explored on joining" if first >= NEVER else f" explored from {first:,} on"
        if former.duration == episode.duration:
            return " explored elsewhere"
        return f" explored for {episode.duration:,}"
    return f" explored at {_share(episode.probability)}"


def _teaching(before: Control, after: Control, trial: int) -> Iterator[_Difference]:
    """Whether a script teaches, and for how long from now on."""
    was, now = (max(control.taught_until - trial, 0) for control in (before, after))
    if now == 0 < was:
        yield _Difference("not taught", "", "", f"no script teaches from trial {trial:,} on")
    elif was != now:
        said = f"a script teaches until trial {after.taught_until:,}"
        yield _Difference(f"taught for {now:,}", "", "", said)


def _parameters(before: Control, after: Control, trial: int) -> Iterator[_Difference]:
    for key in parameters_of(after.spec):
        then, now = value_of(before.spec, key), value_of(after.spec, key)
        if then != now:
            name = parameter_name(key)
            said = f"{name[:1].lower()}{name[1:]} is {now:g} and not {then:g}"
            yield _Difference(_SYMBOLS[key], "", f" {now:g}", said.replace("-", "\N{MINUS SIGN}"))


def _held_still(before: Control, after: Control, trial: int) -> Iterator[_Difference]:
    """What is frozen by hand, and whether the schedule is followed."""
    for name, verb, was, now in (
        ("selection", "is", before.selection_frozen, after.selection_frozen),
        ("skills", "are", before.skills_frozen, after.skills_frozen),
    ):
        if was != now:
            held = "frozen" if now else "not frozen"
            yield _Difference(name, "", f" {held}", f"the {name} {verb} {held} by hand")
    if before.schedule_on != after.schedule_on:
        followed = "followed" if after.schedule_on else "not followed"
        yield _Difference("schedule", "", f" {followed}", f"the schedule is {followed}")


def _freezes(before: Control, after: Control, trial: int) -> Iterator[_Difference]:
    """Freezes of skills to come that last longer or shorter."""
    was, now = before.spec.schedule, after.spec.schedule
    for skill in _to_join(after) & _to_join(before):
        then, trials = was.freeze_of(skill), now.freeze_of(skill)
        if then != trials:
            said = f"the freeze for {plain(skill)} lasts {trials:,} trials and not {then:,}"
            yield _Difference("", skill, f", freeze of {trials:,}", said)


def _to_join(control: Control) -> set[str]:
    """Skills that the schedule has join, or a rule."""
    skills = control.spec.learner.skills
    by_rule = {skill for skill in skills if control.spec.schedule.rule_of(skill) is not None}
    return (by_rule - {*control.present}) | planned_joins(control).keys()


def _definitions(before: Control, after: Control, trial: int) -> Iterator[_Difference]:
    for skill in after.spec.learner.custom_skills:
        if skill not in before.spec.learner.custom_skills and skill not in after.present:
            yield _Difference("", skill, " defined", f"there is a skill {plain(skill)} to add")
