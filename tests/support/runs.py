"""Experiments and runs that tests make up, and what is shown of them."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from urllib.parse import quote, unquote
from xml.etree import ElementTree

import numpy as np

from app.documents import experiments
from app.documents.experiments import Experiment
from app.experiments.archive import packed
from app.experiments.record import Origin, Record, all_values, origin_of
from app.metrics import FINAL_REWARD, NAMES
from app.results.gather import Gatherer, Gathering, PlacedRun
from tests.support.folders import greedy_curve, no_facts

NOTHING = math.nan
_N_TRIALS = 400
HOSTILE = ('<script>alert("1")</script>', 'it\'s & "quoted"', "Füchse 🦊 \u202eelbat\x07")
THESIS = "presets: [standard_q, hierarchical_3, timed, hierarchical_2]\nseeds: 3"
ONE_SETTING = "presets: [timed]\ngrid: {learner.gamma: [0.5, 0.6, 0.8, 0.9]}"
PLANE = (
    "presets: [timed]\ngrid: {learner.alpha: [0.1, 0.5, 0.9], learner.gamma: [0.5, 0.6, 0.8, 0.9]}"
)


def experiment_of(text: str) -> Experiment:
    """An experiment from a text."""
    return experiments.parse(f"trials: 400\n{text}", "some.yaml")


def called(labels: Sequence[str]) -> Experiment:
    """An experiment whose variants have these labels."""
    entries = "".join(
        f"  - {{preset: timed, label: {quoted(label)}, set: {{learner.alpha: {place / 1e5}}}}}\n"
        for place, label in enumerate(labels, 1)
    )
    return experiment_of(f"presets:\n{entries}")


def quoted(text: str) -> str:
    """A text as YAML takes it, whatever is in it."""
    return '"' + "".join(f"\\U{ord(character):08x}" for character in text) + '"'


def address(words: str) -> str:
    """What a link refers to."""
    return f"call/secret/{quote(words, safe='')}"


def fact(
    place: int,
    seed: int,
    value: float,
    error: str = "",
    *,
    seconds: float = 1.5,
    digest: str = "0123456789abcdef",
    **values: float,
) -> PlacedRun:
    """A run that is over, of some experiment's variant, with its final reward and other values."""
    found = {
        "final_reward": value,
        "final_success": 0.7,
        "trials": _N_TRIALS,
        "steps": 60_000,
        "steps_to_70": math.inf,
    }
    run = Record(
        key=f"key-{place}-{seed}",
        variant="",
        preset="",
        overrides={},
        settings={},
        seed=seed,
        error=error,
        version="1",
        digest=digest,
        seconds=seconds,
        ended_at="",
        values=all_values({}, ()) if error else all_values({}, ()) | found | values,
        arrays="",
        origin=Origin(Path(), NAMES, limited=False, stop=None),
    )
    return place, run


def reward(placed: PlacedRun) -> float:
    """What is charted of a run that was made up here."""
    return placed[1].values[FINAL_REWARD.column]


def gathering_of(experiment: Experiment, runs: Sequence[PlacedRun]) -> Gathering:
    """What there is, if these runs are over."""
    return Gathering(experiment, FINAL_REWARD, runs, -50.0, 100.0)


def some_runs(experiment: Experiment, n_seeds: int, seed: int = 0) -> list[PlacedRun]:
    """Runs of all variants with values between 0 and 100."""
    rng = np.random.default_rng(seed)
    return [
        fact(place, number, float(rng.uniform(0, 100)))
        for number in range(n_seeds)
        for place in range(len(experiment.variants))
    ]


class Shown:
    """A piece of HTML, by what is in it."""

    def __init__(self, html: str) -> None:
        self.root = ElementTree.fromstring(f"<root>{html}</root>")
        for element in self.root.iter():
            element.tag = element.tag.rpartition("}")[2]
            for name, value in element.attrib.items():
                assert not re.search(r"nan|inf", value) or name in {"title", "href", "class"}, value

    def all(self, tag: str, within: ElementTree.Element | None = None, **attributes: str) -> list:
        """Elements with a tag; attributes that are words of Python end in an underscore."""
        wanted = {name.rstrip("_").replace("_", "-"): value for name, value in attributes.items()}
        where = self.root if within is None else within
        return [
            element
            for element in where.iter(tag)
            if all(element.get(name) == value for name, value in wanted.items())
        ]

    def one(self, tag: str, **attributes: str) -> ElementTree.Element:
        """The only element with a tag and attributes."""
        (found,) = self.all(tag, **attributes)
        return found

    @property
    def text(self) -> str:
        """All that can be read."""
        return " ".join(self.root.itertext())

    @property
    def words(self) -> list[str]:
        """What the links call."""
        found = []
        for link in self.all("a"):
            assert link.get("target") == "pounce-calls"
            prefix, _, words = link.get("href").rpartition("/")
            assert prefix == "call/secret"
            found.append(unquote(words))
        return found

    def links(self, verb: str) -> Mapping[str, ElementTree.Element]:
        """Links that call a verb, by the rest of the words; each is there once."""
        found: dict[str, ElementTree.Element] = {}
        for words, link in zip(self.words, self.all("a"), strict=True):
            head, _, rest = words.partition("/")
            if head == verb:
                assert rest not in found
                found[rest] = link
        return found

    def value_at(self, axis: str) -> Callable[[float], float]:
        """From pixels along an axis to numbers, by what is written at its ticks."""
        ticks = self.one("g", class_=f"{axis}-ticks")
        (a, x), *_, (b, y) = [
            (float(t.get(axis)), float(t.text.replace("\N{MINUS SIGN}", "-").replace(",", "")))
            for t in ticks.iter("text")
        ]
        return lambda at: x + (at - a) / (b - a) * (y - x)


def _arrays() -> bytes:
    """The archive of a run."""
    rng = np.random.default_rng(0)
    nothing = np.zeros((0, 18, 24), np.float32)
    return packed(
        {
            "outcome": rng.integers(1, 4, _N_TRIALS).astype(np.int8),
            "steps": rng.integers(50, 240, _N_TRIALS),
            "introductions": np.asarray([(100, 15_000)], np.int64),
            "introduced": np.asarray(["avoid"]),
            "moments": np.zeros(0, np.int64),
            "value_share": nothing,
            "value_distance": nothing,
            **greedy_curve(),
            **no_facts(),
        }
    )


ARRAYS = _arrays()


def filled(experiment: Experiment, runs: Sequence[PlacedRun]) -> Gatherer:
    """A gatherer that has taken these runs in."""
    gatherer = Gatherer(experiment, 240 * _N_TRIALS)
    for place, run in runs:
        variant = experiment.variants[place]
        about = {"variant": variant.label, "preset": variant.preset}
        origin = origin_of(experiment, Path())
        gatherer.add(replace(run, **about, overrides=variant.overrides, origin=origin), ARRAYS)
    return gatherer
