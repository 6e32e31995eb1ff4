"""What an experiment asks for, as its file states it (validated, frozen).

Values that are varied are looked at only as far as there must be some: what a preset says of each
of them is said of the variants that are made of them (:mod:`app.documents.variants`).
"""

from collections.abc import Sequence
from typing import Annotated, Any, Final, Self, cast

from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    TypeAdapter,
    model_validator,
)

from app.documents.faults import written_so
from app.documents.ranges import Linear, Logarithmic, range_of
from app.documents.samples import Sample
from app.documents.tree import Key, key_of
from app.metrics import METRICS, NAMES
from learners.measures import RECENT_TRIALS
from learners.names import MAX_TRIALS, Truth, did_you_mean
from learners.spec import RunSpec
from sim.rng import MAX_SEED
from sim.spec import Problem, ProblemsError, Spec

MAX_RUNS: Final = 100_000
MAX_STEPS: Final = 10**12
MAX_LABEL: Final = 200

_KEYS_OF_PRESETS: Final = "keys of presets"
_MEANS: Final = tuple(metric.column for metric in METRICS)


def _values(value: Any) -> list[Any] | Linear | Logarithmic:
    return cast("list[Any]", value) if isinstance(value, list) and value else range_of(value)


def _share(value: Any) -> Any:
    if not isinstance(value, int | float) or isinstance(value, bool) or not 0 <= value <= 1:
        hint = written_so(value, decimals=True)
        raise ValueError(f"must be a share of captures; allowed: 0 to 1{hint}")
    return value


def _metric(value: Any) -> Any:
    if value not in NAMES:
        hint = did_you_mean(value, NAMES)
        raise ValueError(f"is not measured{hint}; allowed: {', '.join(NAMES)}")
    return value


def _metrics(names: tuple[str, ...]) -> tuple[str, ...]:
    if not set(names) & set(_MEANS):
        raise ValueError(f"has nothing to chart; allowed: also one of {', '.join(_MEANS)}")
    return names


def _each_once(stated: object) -> object:
    items = cast("list[object]", stated) if isinstance(stated, list) else []
    first = {repr(item): index for index, item in reversed(list(enumerate(items)))}
    twice = [(index, item) for index, item in enumerate(items) if first[repr(item)] != index]
    if twice:
        message = "is there twice; allowed: each once"
        raise ProblemsError([Problem((index,), item, message) for index, item in twice])
    return cast("object", stated)


_Seed = Annotated[int, Field(ge=0, le=MAX_SEED)]
_STRICT: Final = ConfigDict(strict=True)
_N_SEEDS: Final = TypeAdapter(Annotated[int, Field(ge=1, le=MAX_RUNS)], config=_STRICT)
_LISTED: Final = TypeAdapter(Annotated[list[_Seed], Field(min_length=1)], config=_STRICT)


def _seeds(value: Any) -> Sequence[int]:
    match value:
        case list():
            return tuple(_LISTED.validate_python(value))
        case dict():
            return SeedRange.model_validate(value).seeds
        case _:
            return range(_N_SEEDS.validate_python(value))


class SeedRange(Spec):
    """Seeds that are so far apart; both ends belong to them."""

    start: _Seed
    stop: _Seed
    step: Annotated[int, Field(ge=1, le=MAX_SEED)] = 1

    @model_validator(mode="after")
    def _has_an_end(self) -> Self:
        if not self.start <= self.stop:
            raise ValueError("is no range; allowed: start up to stop")
        if len(self.seeds) > MAX_RUNS:
            raise ValueError(f"has {len(self.seeds)} seeds; allowed: up to {MAX_RUNS}")
        return self

    @property
    def seeds(self) -> range:
        """All of them."""
        return range(self.start, self.stop + 1, self.step)


class Choice(Spec):
    """Values that are taken together, by dotted keys of presets, and perhaps a label."""

    model_config = ConfigDict(extra="allow")

    label: Annotated[str, Field(max_length=MAX_LABEL)] = ""

    @model_validator(mode="after")
    def _has_keys(self) -> Self:
        problems: list[Problem] = []
        for name, value in (self.model_extra or {}).items():
            try:
                key_of(name)
            except ValueError as error:
                problems.append(Problem((name,), value, str(error)))
        if problems:
            raise ProblemsError(problems)
        return self


_Key = Annotated[Key, PlainValidator(key_of)]
_Values = Annotated[list[Any] | Linear | Logarithmic, PlainValidator(_values)]
Settings = Annotated[dict[_Key, Any], Field(description=_KEYS_OF_PRESETS)]
"""One value for each key."""
Columns = Annotated[dict[_Key, _Values], Field(description=_KEYS_OF_PRESETS)]
"""The values of each key."""
Groups = Annotated[
    tuple[Columns, ...],
    Field(strict=False, min_length=1, description="groups of keys that move together"),
]
Choices = Annotated[
    tuple[Annotated[Choice, Field(description=_KEYS_OF_PRESETS)], ...],
    Field(strict=False, min_length=1, description="mappings of keys of presets to values"),
]


_WHICH_SEEDS: Final = f"1 to {MAX_RUNS}, a list of seeds from 0 to {MAX_SEED}, or {{start, stop}}"
Seeds = Annotated[
    Sequence[_Seed],
    PlainValidator(_seeds),
    BeforeValidator(_each_once),
    Field(description=_WHICH_SEEDS),
]
"""A count stands for the seeds from 0."""


class PresetItem(Spec):
    """A preset, and what is varied in it alone."""

    preset: Any = None
    """A name, a path, or a whole preset, which needs a label; looked at where it is opened."""
    label: Annotated[str, Field(max_length=MAX_LABEL)] = ""
    set: Settings = Field(default_factory=dict)
    grid: Columns = Field(default_factory=dict)
    linked: Groups = ()
    settings: Choices = ()
    sample: Sample | None = None
    seeds: Seeds | None = None
    """Its own; None where it has those of the experiment."""

    @model_validator(mode="before")
    @classmethod
    def _by_name(cls, value: object) -> object:
        return cast("object", value) if isinstance(value, dict) else {"preset": value}


class Stop(Spec):
    """When a run has learned enough: looked at every ``every`` trials."""

    success: Annotated[float, BeforeValidator(_share), Field(ge=0, le=1)]
    """Share of captures."""
    trials: Annotated[int, Field(ge=1, le=MAX_TRIALS)] = RECENT_TRIALS
    """So many of the most recent trials count; before there are as many, a run goes on."""
    every: Annotated[int, Field(ge=1, le=MAX_TRIALS)] = 100


class ExperimentSpec(Spec):
    """Presets, what is varied in them, and how they are run."""

    description: Annotated[str, Field(max_length=400)] = ""
    presets: Annotated[
        tuple[PresetItem, ...],
        Field(
            strict=False,
            min_length=1,
            description="presets, each a name, a path, or {preset, label, ...}",
        ),
    ] = ()
    set: Settings = Field(default_factory=dict)
    """In all presets, as what follows."""
    grid: Columns = Field(default_factory=dict)
    linked: Groups = ()
    settings: Choices = ()
    sample: Sample | None = None
    seeds: Seeds = range(1)
    common_starts: Truth = True
    """Whether all variants run with the same seeds, and so with the same starts of trials."""
    trials: Annotated[int, Field(ge=1, le=MAX_TRIALS)] | None = None
    """Trials of each run; None where the presets say how many."""
    steps: Annotated[int, Field(ge=1, le=MAX_STEPS)] | None = None
    """Steps of each run; where ``trials`` is None they alone count."""
    horizon: Annotated[int, Field(ge=1, le=MAX_STEPS)] | None = None
    """Steps at which all runs are measured, and until which each goes on at least."""
    greedy_every: Annotated[int, Field(ge=0, le=MAX_TRIALS)] = 2_000
    """Trials from one point of the greedy curve to the next; 0 where there is none."""
    metrics: Annotated[
        tuple[Annotated[str, PlainValidator(_metric)], ...],
        Field(strict=False, min_length=1, description=f"names from {', '.join(NAMES)}"),
        AfterValidator(_metrics),
        BeforeValidator(_each_once),
    ] = NAMES
    """Columns of :mod:`app.metrics` that are measured; charts show the first of them."""
    stop: Stop | None = None

    @model_validator(mode="after")
    def _gets_to_its_horizon(self) -> Self:
        if self.horizon is not None and self.steps is not None and self.horizon > self.steps:
            message = f"lies beyond the end of all runs; allowed: up to steps, {self.steps}"
            raise ProblemsError([Problem(("horizon",), self.horizon, message)])
        return self

    @property
    def horizon_steps(self) -> int | None:
        """Steps at which all runs are measured; where steps alone count, these, unless stated."""
        if self.horizon is None and self.trials is None:
            return self.steps
        return self.horizon

    def last_trial(self, spec: RunSpec) -> int:
        """Trials after which a run of a preset ends, whatever else may end it."""
        return MAX_TRIALS if self.steps is not None and self.trials is None else spec.trials
