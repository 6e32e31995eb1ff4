"""The command ``pounce bench``: its words, its progress and its answers.

Like the command line, it imports what takes long only once it is needed.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, arg

from app.cli import terminal
from app.cli.answers import (
    EXIT_FAILED,
    EXIT_OK,
    Flag,
    UsageError,
    complain,
    filled,
    number,
    say,
    shown,
    spec_of,
    table,
    whole_number,
)
from app.util import interrupts

if TYPE_CHECKING:
    from benchmarks.compare import Rates
    from learners.spec import RunSpec

MAX_REPETITIONS = 1_000
MAX_WATCHERS = 1_000
MAX_SEATS = 60
"""Fewer than learners may be at work for a class."""
MAX_PAGES = 63
"""One fewer than the lab lets in, since one more page clicks."""

EXAMPLES = (
    "pounce bench",
    "pounce bench timed --repetitions 9",
    "pounce bench --json",
    "pounce bench --learners",
    "pounce bench --page --json",
    "pounce bench --load 31 --json",
    "pounce bench --audience 100 --json",
    "pounce bench --own 30 --json",
    "pounce bench --scrub --json",
    "pounce bench --side --json",
)


@dataclass(frozen=True)
class Bench:
    """Measure how fast the learners are on this machine."""

    presets: Annotated[
        Positional[tuple[str, ...]],
        arg(
            metavar="[PRESET]",
            help_behavior_hint="(may be several; default: all that C knows)",
        ),
    ] = ()
    """Shipped presets, or files; - is standard input."""
    json: Flag = False
    """Print one JSON object and nothing else."""
    repetitions: Annotated[str, arg(metavar="N")] = "5"
    """Interleaved measurements, of which the median counts."""
    learners: Flag = False
    """Measure each preset beside timed alone, and what it costs that a rule is watched."""
    page: Flag = False
    """Measure what the live page costs the learner, with no browser, one and five."""
    load: Annotated[str | None, arg(metavar="N", help_behavior_hint=f"(1 to {MAX_PAGES})")] = None
    """Measure what so many pages cost: clicks, the learner's share, memory."""
    audience: Annotated[
        str | None, arg(metavar="N", help_behavior_hint=f"(1 to {MAX_WATCHERS})")
    ] = None
    """Measure what so many phones that look on cost: the presenter's clicks, also while each
    answers once a second, the learner's share, and what each is sent."""
    own: Annotated[str | None, arg(metavar="N", help_behavior_hint=f"(1 to {MAX_SEATS})")] = None
    """Measure what so many learners of an audience's own cost: how soon a tap is answered, and the
    presenter's learner's share."""
    scrub: Flag = False
    """Measure walking in the past: moments a second, how soon one shows, the learner's share."""
    side: Flag = False
    """Measure how often a browser shows four runs side by side while all learn at full speed."""


def obey(command: Bench) -> int:
    """Measure, and say what came of it; returns the exit code.

    Raises:
        UsageError: the words make no sense.
    """
    from app.documents import presets
    from app.documents.sources import called

    repetitions = whole_number("--repetitions", command.repetitions, 1, MAX_REPETITIONS)
    specs = {called(name): spec_of(name) for name in command.presets or presets.shipped()}
    many = [one is not None for one in (command.load, command.audience, command.own)]
    if sum([command.learners, command.page, command.scrub, command.side, *many]) > 1:
        raise UsageError(
            "--learners, --page, --load, --audience, --own, --scrub and --side exclude each other;"
            " allowed: one of them"
        )
    preset = next(iter(specs)) if command.presets else "timed"
    if command.side:
        return _measure_side(command, repetitions)
    if command.learners:
        return _measure_learners(command, specs, repetitions)
    if command.page:
        return _measure_page(command, preset, specs, repetitions)
    if command.scrub:
        return _measure_scrub(command, preset, specs[preset], repetitions)
    if command.load is not None:
        n_pages = whole_number("--load", command.load, 1, MAX_PAGES)
        return _measure_load(command, preset, specs, repetitions, n_pages)
    if command.audience is not None:
        n_watchers = whole_number("--audience", command.audience, 1, MAX_WATCHERS)
        return _measure_audience(command, preset, specs, repetitions, n_watchers)
    if command.own is not None:
        n_seats = whole_number("--own", command.own, 1, MAX_SEATS)
        return _measure_own(command, preset, specs, repetitions, n_seats)
    from benchmarks.compare import MismatchError, compare, incomparable

    if not command.presets:
        specs = {name: spec for name, spec in specs.items() if incomparable(spec) is None}
    for name, spec in specs.items():
        if problem := incomparable(spec):
            raise UsageError(f"{shown(name)}: the programs compared do not know {problem}")
    try:
        with interrupts.undoing(), terminal.status() as on_progress:
            found = compare(specs, repetitions, on_progress)
    except MismatchError as error:
        complain(str(error))
        return EXIT_FAILED
    for note in found["notes"]:
        complain(filled(note))
    learners = found["learners"]
    say(json.dumps({"learners": learners}) if command.json else _speeds(learners))
    return EXIT_OK


def _measured(
    command: Bench, measure: Callable[[Callable[[str], None]], Any], words: Callable[[Any], str]
) -> int:
    """Measure, and say what was found: as JSON if that is wanted, else in words."""
    try:
        with interrupts.undoing(), terminal.status() as on_progress:
            found = measure(on_progress)
    except RuntimeError as error:
        complain(str(error))
        return EXIT_FAILED
    say(json.dumps(found) if command.json else words(found))
    return EXIT_OK


def _measure_learners(command: Bench, specs: "dict[str, RunSpec]", repetitions: int) -> int:
    from benchmarks.speeds import measure_speeds

    def words(found: Any) -> str:
        rows = [
            (name, f"{speed['steps_per_s'] / 1e6:.1f}", number(speed["ratio_to_timed"], ".2f"))
            for name, speed in found["learners"].items()
        ]
        rules = [f"\n  {by:9}{number(share, '.3f')}" for by, share in found["watching"].items()]
        speeds = table(["learner", "M steps/s", "x timed"], rows)
        return f"{speeds}\n\nRate while a rule is watched, as a share of the rate without:" + (
            "".join(rules)
        )

    return _measured(command, lambda told: measure_speeds(specs, repetitions, told), words)


def _measure_page(
    command: Bench, preset: str, specs: "dict[str, RunSpec]", repetitions: int
) -> int:
    from benchmarks.page import compare_page

    def words(found: Any) -> str:
        shares = [f"\n  {n} browsers  {ratio:.2f}" for n, ratio in found["clients"].items()]
        title = f"Rate of {preset} beside the page, as a share of its rate without a page:"
        return title + "".join(shares)

    return _measured(
        command, lambda told: compare_page(specs[preset], preset, specs, repetitions, told), words
    )


def _measure_load(
    command: Bench, preset: str, specs: "dict[str, RunSpec]", repetitions: int, n_pages: int
) -> int:
    from benchmarks.load import measure_load

    def words(found: Any) -> str:
        clicks = found["click_ms"]
        return (
            f"{preset} at full speed, and {n_pages} pages that read every frame:\n"
            f"  a click shows after  {clicks['p50']:.0f} ms (median), {clicks['p95']:.0f} (95 %),"
            f" {clicks['max']:.0f} at most\n"
            f"  the learner keeps    {found['learner_share']:.2f} of its rate beside one page\n"
            f"  the lab holds        {found['rss_mb']:.0f} MB"
        )

    return _measured(
        command,
        lambda told: measure_load(specs[preset], preset, specs, n_pages, repetitions, told),
        words,
    )


def _measure_audience(
    command: Bench, preset: str, specs: "dict[str, RunSpec]", repetitions: int, n_watchers: int
) -> int:
    from benchmarks.audience import measure_audience

    def words(found: Any) -> str:
        clicks, voting = found["click_ms"], found["class_click_ms"]
        return (
            f"{preset} at full speed, its presenter, and {n_watchers} who look on:\n"
            f"  a click shows after  {clicks['p50']:.0f} ms (median), {clicks['p95']:.0f} (95 %)\n"
            f"  while all answer     {voting['p50']:.0f} ms (median), {voting['p95']:.0f} (95 %)\n"
            f"  each of them is sent {found['kB_per_s_each']:.1f} kB a second\n"
            f"  the learner keeps    {found['learner_share']:.2f} of its rate"
        )

    return _measured(
        command,
        lambda told: measure_audience(specs[preset], preset, specs, n_watchers, repetitions, told),
        words,
    )


def _measure_own(
    command: Bench, preset: str, specs: "dict[str, RunSpec]", repetitions: int, n_seats: int
) -> int:
    from benchmarks.own import measure_own

    def words(found: Any) -> str:
        taps = found["tap_ms"]
        return (
            f"{preset} at full speed, and {n_seats} of its audience, each with a learner of their"
            " own at the fastest level:\n"
            f"  a tap is answered after  {taps['p50']:.0f} ms (median), {taps['p95']:.0f} (95 %)\n"
            f"  each of them makes       {found['steps_per_s_each']:,} steps a second\n"
            f"  the presenter's keeps    {found['learner_share']:.2f} of its rate"
        )

    return _measured(
        command,
        lambda told: measure_own(specs[preset], preset, specs, n_seats, repetitions, told),
        words,
    )


def _measure_scrub(command: Bench, preset: str, spec: "RunSpec", repetitions: int) -> int:
    from benchmarks.scrub import STEPS, measure_scrub

    def words(found: Any) -> str:
        return (
            f"{preset} at full speed, and somebody who looks at its first"
            f" {STEPS / 1e6:.0f} M steps:\n"
            f"  moments painted      {found['moments_per_s']:.0f} a second\n"
            f"  a wish shows after   {found['p95_ms']:.0f} ms (95 %)\n"
            f"  the learner keeps    {found['learner_share']:.2f} of its rate"
        )

    return _measured(command, lambda told: measure_scrub(spec, preset, repetitions, told), words)


def _measure_side(command: Bench, repetitions: int) -> int:
    from benchmarks.side import measure_side

    def words(found: Any) -> str:
        return (
            "The thesis's four side by side at full speed, in a browser that draws in software:\n"
            f"  all boards shown  {found['shown_per_s']:.0f} times a second\n"
            f"  each run makes    {found['steps_per_s'] / 1e6:.2f} M steps a second,"
            f" {found['learner_share']:.2f} of its rate while nobody looks"
        )

    return _measured(command, lambda told: measure_side(repetitions, told), words)


def _speeds(learners: "Mapping[str, Rates]") -> str:
    rows = [
        (
            name,
            f"{rates['steps_per_s'] / 1e6:.2f}",
            number(rates["ratio_to_c"], ".2f"),
            number(rates["ratio_to_plain"], ".2f"),
            number(rates["ratio_to_python"], ".0f"),
        )
        for name, rates in learners.items()
    ]
    return table(["learner", "M steps/s", "x C", "x plain", "x Python"], rows)
