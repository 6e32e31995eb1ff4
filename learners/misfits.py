"""What does not go together in a schedule with the learner it is for."""

from collections.abc import Iterator, Sequence

from learners.learner_spec import LearnerSpec
from learners.names import INTRODUCTION, did_you_mean
from learners.schedule_spec import ScheduleSpec, TriggerSpec
from learners.skills import CIRCLES
from sim.spec import Problem


def misfits(schedule: ScheduleSpec, learner: LearnerSpec) -> Iterator[Problem]:
    """All that does not, each with what is allowed."""
    yield from _without_skills(schedule, learner)
    yield from _unknown_skills(schedule, learner)
    yield from _without_a_time(schedule)
    yield from _no_first_skill(schedule, learner.skills)
    yield from _without_a_table(schedule, learner)
    yield from _misplaced_episodes(schedule)
    yield from _nothing_to_reach(schedule, learner)


def _without_skills(schedule: ScheduleSpec, learner: LearnerSpec) -> Iterator[Problem]:
    if schedule.introduce is not None and not learner.skills:
        message = f"is a rule by which skills join, and the options are {learner.options}"
        yield Problem(("introduce",), schedule.introduce.by, f"{message}; allowed: none")
    if schedule.pretrain and not learner.skills:
        message = f"trains skills, and the options are {learner.options}; allowed: 0"
        yield Problem(("pretrain",), schedule.pretrain, message)
    reason = None if schedule.teach is None else not_for_script(learner)
    if schedule.teach is not None and reason is not None:
        yield Problem(("teach",), schedule.teach.script, reason)


def not_for_script(learner: LearnerSpec) -> str | None:
    """Why no script can teach a learner, and what would be allowed; None if one can."""
    if learner.selection != "learned":
        return "is for a selection that learns; allowed: none"
    missing = [skill for skill in ("approach", "avoid") if skill not in learner.skills]
    if not any(circle in learner.skills for circle in CIRCLES):
        missing.append("a circle")
    if not missing:
        return None
    return (
        f"chooses {', '.join(missing)}, not among the learner's options; allowed: none,"
        " or options with approach, avoid and a circle"
    )


def _without_a_table(schedule: ScheduleSpec, learner: LearnerSpec) -> Iterator[Problem]:
    """What goes by the table of a selection that has none."""
    if learner.selection == "learned":
        return
    for key, rule in _rules(schedule):
        if rule.by == "change":
            message = f"asks how much a table changes, and {learner.selection} has none"
            yield Problem(key, rule.by, f"{message}; allowed: novelty, reach")
    for index, episode in enumerate(schedule.episodes):
        if episode.where is not None:
            key = ("episodes", index, "where", "value_at_most")
            message = f"asks what a table says of a state, and {learner.selection} has none"
            yield Problem(key, episode.where.value_at_most, f"{message}; allowed: none")


def _unknown_skills(schedule: ScheduleSpec, learner: LearnerSpec) -> Iterator[Problem]:
    allowed = ", ".join(learner.skills) or f"none, because the options are {learner.options}"
    named: list[tuple[tuple[str | int, ...], str]] = [
        *((("skills", skill), skill) for skill in schedule.skills),
        *(
            (("episodes", index, "skill"), episode.skill)
            for index, episode in enumerate(schedule.episodes)
        ),
    ]
    for key, skill in named:
        if skill not in learner.skills:
            known = learner.known_skills
            hint = "" if skill in known else did_you_mean(skill, known)
            message = f"is not among the learner's options{hint}; allowed: {allowed}"
            yield Problem(key, skill, message)


def _without_a_time(schedule: ScheduleSpec) -> Iterator[Problem]:
    for skill, timer in schedule.skills.items():
        if timer.at is None and schedule.rule_of(skill) is None:
            message = "is missing; allowed: a trial, or a rule under introduce"
            yield Problem(("skills", skill, "at"), ..., message)


def _no_first_skill(schedule: ScheduleSpec, skills: Sequence[str]) -> Iterator[Problem]:
    earliest = min(skills, key=schedule.introduced_at, default=None)
    if earliest is not None and schedule.introduced_at(earliest) > 0:
        yield Problem(
            ("skills", earliest, "at"),
            schedule.introduced_at(earliest),
            "leaves nothing to do before it; allowed: 0 for at least one skill",
        )


def _misplaced_episodes(schedule: ScheduleSpec) -> Iterator[Problem]:
    taken: dict[str, list[tuple[int, int]]] = {}
    for index, episode in enumerate(schedule.episodes):
        key = ("episodes", index, "at")
        joins = schedule.introduced_at(episode.skill)
        first = schedule.starts_at(episode)
        if first < joins and schedule.rule_of(episode.skill) is not None:
            message = f"is a trial, and a rule says when {episode.skill} joins"
            yield Problem(key, episode.at, f"{message}; allowed: {INTRODUCTION}")
        elif first < joins:
            yield Problem(
                key,
                episode.at,
                f"starts before {episode.skill} joins; allowed: {joins} or later,"
                f" or {INTRODUCTION}",
            )
        for other_first, other_end in taken.get(episode.skill, []):
            if first < other_end and other_first < first + episode.duration:
                yield Problem(
                    key,
                    episode.at,
                    f"overlaps the episode of {episode.skill} from trial {other_first}"
                    f" to {other_end}; allowed: one at a time for each skill",
                )
                break
        taken.setdefault(episode.skill, []).append((first, first + episode.duration))


def _nothing_to_reach(schedule: ScheduleSpec, learner: LearnerSpec) -> Iterator[Problem]:
    if learner.initial_q <= 0:
        return
    for key, rule in _rules(schedule):
        if rule.by == "reach":
            message = (
                "waits for states whose value rises above 0, and all begin there, with initial_q"
                f" {learner.initial_q:g}"
            )
            yield Problem(key, rule.by, f"{message}; allowed: novelty, change")


def _rules(schedule: ScheduleSpec) -> Iterator[tuple[tuple[str, ...], TriggerSpec]]:
    """Rules by which skills join, and the keys of what they watch."""
    if schedule.introduce is not None:
        yield ("introduce", "by"), schedule.introduce
    for skill, timer in schedule.skills.items():
        if timer.introduce is not None:
            yield ("skills", skill, "introduce", "by"), timer.introduce
