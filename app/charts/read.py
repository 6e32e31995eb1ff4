"""Charts of results that are read back from their folders."""

import json
from collections.abc import Iterable, Sequence

from app.analysis import estimates
from app.analysis.estimates import Axis, Windows
from app.charts.greedy import averaged
from app.charts.model import Lane, Line, Mark, Schedules, ValueMap, ValueMaps
from app.charts.styles import Style
from app.experiments.record import Record
from app.results import spread
from app.results.read import Group, Reader, Trace
from app.words.plain import plain
from learners.learner_spec import LearnerSpec
from learners.schedule_spec import ScheduleSpec, TriggerSpec
from sim import geometry
from sim.spec import WorldSpec


def line_of(
    reader: Reader,
    label: str,
    runs: Sequence[Record],
    axis: Axis,
    style: Style,
    windows: Windows = "steps",
) -> Line:
    """The learning curve of runs, averaged, with its interval.

    Args:
        reader: of their logs.
        label: of the line.
        runs: of one learner.
        axis: what it is drawn against.
        style: of the line.
        windows: what its windows are counted in, where the axis is of steps.
    """
    traces = reader.traces(runs)
    found = reader.band(runs, axis, windows)
    marks = _marks(traces, axis)
    greedy = averaged([trace.greedy for trace in traces], axis)
    return Line(label, found, style, len(traces), marks, greedy=greedy)


def _marks(traces: Sequence[Trace], axis: Axis) -> list[Mark]:
    """Introductions that all runs have come to, at the median over the runs."""
    medians = estimates.medians_of_all([trace.introductions for trace in traces])
    return [
        Mark(step if axis == "steps" else trial, plain(name))
        for name, (trial, step) in medians.items()
    ]


def value_maps_of(reader: Reader, runs: Sequence[Record]) -> ValueMaps:
    """How far value had spread in runs of one learner, at the moments that the thesis names.

    Args:
        reader: of their logs.
        runs: at least one; those without pictures of a moment have no part in its map.
    """
    settings = runs[0].settings
    moments = spread.moments_of(settings)
    pictures = reader.pictures(runs) if moments else []
    maps: list[ValueMap] = []
    for name, trial in moments.items():
        found = [value for picture in pictures if (value := picture.at(trial)) is not None]
        if found:
            title = f"{name}: after {trial:,} trials"
            maps.append(ValueMap(title, spread.averaged(found), len(found)))
    world = WorldSpec.model_validate(settings["world"])
    return ValueMaps(maps, geometry.ring_edges(world), world.vision_radius * world.scale)


def schedules_of(groups: Iterable[Group]) -> Schedules:
    """The schedules of variants that have one, each once, with the names of all that have it.

    A learner whose skills are all there from the start, and of which none is explored, has none.
    """
    named: dict[str, list[Group]] = {}
    for group in groups:
        settings = group.runs[0].settings
        parts = {key: settings[key] for key in ("learner", "schedule", "trials") if key in settings}
        if parts.get("schedule"):
            options = parts["learner"]["options"]
            key = json.dumps([options, parts["schedule"], parts["trials"]], sort_keys=True)
            named.setdefault(key, []).append(group)
    lanes: list[Lane] = []
    for alike in named.values():
        settings = alike[0].runs[0].settings
        schedule = ScheduleSpec.model_validate(settings["schedule"])
        learner = LearnerSpec.model_validate(settings["learner"])
        if not (schedule.skills or schedule.episodes or schedule.introduce):
            continue
        name = ", ".join(dict.fromkeys(group.label for group in alike))
        lanes += [
            Lane(
                name,
                skill,
                schedule.introduced_at(skill),
                schedule.freeze_of(skill),
                [
                    (first := schedule.starts_at(e), first + e.duration, e.probability)
                    for e in schedule.episodes
                    if e.skill == skill
                ],
                int(settings["trials"]),
                _in_words(schedule.rule_of(skill)),
            )
            for skill in learner.skills
        ]
    return Schedules(lanes)


def _in_words(rule: TriggerSpec | None) -> str:
    if rule is None:
        return ""
    return f"once {rule.by} of {rule.window:,} trials is below {rule.below:g}"
