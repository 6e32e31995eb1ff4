"""A short lesson in a small world, which asks and checks some of all that a lesson can."""

from typing import Final

from app.documents import lessons
from app.documents.lessons import Lesson

LESSON: Final = """\
title: Circling
minutes: 1
setup: {preset: timed, start: 400, schedule: "off", set: {world.size: 40, trials: 3000}}
show: [play, layer.value]
steps:
  - ask: direction
    id: spread
    text: Which way?
    options: [clockwise, counter-clockwise, both ways, not at all]
    reveal: {measure: spread_direction, at: +1500}
  - ask: moment
    id: moment
    text: When?
    reveal: {reach: right_flank, above: 0.2, at: +1500}
    varies: true
  - ask: sketch
    id: drawn
    text: Draw it.
    from: 400
    to: 1900
    reveal: {reward: 100, at: 1900}
  - do: {command: introduce, skill: circle_clockwise, explore: {trials: 500, chance: 0.95}}
    id: circle
    text: Let it circle.
    unlock: [add_skill, explore]
    check: {all: [{present: circle_clockwise}, {reach: right_flank, above: 0.2, by: +1500}]}
  - see: {same_as: spread}
    text: Which way did it go?
  - transfer:
      ask: direction
      text: And the other way?
      options: [clockwise, counter-clockwise, both ways, not at all]
      reveal: {measure: spread_direction, at: +1500}
      run: {swap: circle_counterclockwise}
    id: other
"""


def circling(change: tuple[str, str] = ("", "")) -> Lesson:
    """The lesson, perhaps with something replaced by something else."""
    return lessons.parse(LESSON.replace(*change) if change[0] else LESSON, "circling.yaml")
