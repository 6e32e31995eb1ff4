"""A run that is over, as one record: what is written down, read back, reported on and shown."""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import dropwhile
from pathlib import Path
from typing import Any, Final, NamedTuple, cast

from app.documents.experiment_spec import Stop
from app.documents.experiments import Experiment
from app.metrics import BY_COLUMN, PASSAGES

DONE: Final = "done"
FAILED: Final = "failed"


class Origin(NamedTuple):
    """What all runs of a folder have in common."""

    folder: Path
    """Where the archives of their arrays are."""
    metrics: Sequence[str]
    """Columns of :mod:`app.metrics` that were measured."""
    limited: bool
    """Whether a stop condition or a number of steps may have ended runs before their trials did."""
    stop: Stop | None
    """What ended a run as soon as it was so good, if it ever was."""
    horizon: int | None = None
    """Steps at which all runs were measured; None where the experiment states none."""
    steps_alone: bool = False
    """Whether runs end after a number of steps, whatever trials their presets have."""

    @property
    def states_horizon(self) -> bool:
        """Whether a horizon is stated that is not simply where the runs end."""
        return self.horizon is not None and not self.steps_alone


def origin_of(experiment: Experiment, folder: Path) -> Origin:
    """What the runs of an experiment have in common."""
    stop = experiment.stop
    limited = stop is not None or experiment.steps is not None
    steps_alone = experiment.steps is not None and experiment.trials is None
    return Origin(folder, experiment.metrics, limited, stop, experiment.horizon_steps, steps_alone)


@dataclass(frozen=True)
class Record:
    """A run that is over, or has failed."""

    key: str
    """Of its row, and of the archive of its arrays."""
    variant: str
    preset: str
    """As the experiment names it."""
    overrides: Mapping[str, Any]
    settings: Mapping[str, Any]
    seed: int
    error: str
    """Why it failed, with a traceback; empty if it did not."""
    version: str
    digest: str
    seconds: float
    """That it took; NaN where that is not known."""
    ended_at: str
    """In UTC; empty where that is not known."""
    values: Mapping[str, float]
    """Of all metrics, by column: NaN where there is nothing, infinite for a passage that was
    never reached."""
    arrays: str
    """Checksum of the archive of its arrays; empty if there is none."""
    origin: Origin

    @property
    def trials(self) -> int:
        """Trials that it finished."""
        return _whole(self.values["trials"])

    @property
    def steps(self) -> int:
        """Steps that it took."""
        return _whole(self.values["steps"])

    @property
    def preset_trials(self) -> int:
        """Trials of its preset that it finished; it may have gone on until a horizon."""
        return self.trials if self.origin.steps_alone else min(self.trials, self.settings["trials"])

    @property
    def preset_name(self) -> str:
        """Name of its preset, without the folder and the ending of a file."""
        return Path(self.preset).stem

    @property
    def gist(self) -> str:
        """What went wrong, on one line; empty if nothing did."""
        return gist(self.error) or (FAILED if self.error else "")

    @property
    def identity(self) -> str:
        """What it is a function of, as a text."""
        settings = {key: self.settings[key] for key in self.settings if key != "description"}
        stop = self.origin.stop
        ending = [self.origin.limited, stop and stop.model_dump()]
        return json.dumps([self.preset_name, settings, *ending, self.seed], sort_keys=True)


def all_values(found: Mapping[str, float | int | None], wanted: Sequence[str]) -> dict[str, float]:
    """The values of a record, of all metrics.

    Args:
        found: by column; None where there is nothing, or a passage was never reached.
        wanted: columns that were measured.
    """
    never = {name: math.inf for name in PASSAGES if name in wanted}
    return {
        name: never.get(name, math.nan) if (value := found.get(name)) is None else float(value)
        for name in BY_COLUMN
    }


def row_of(record: Record) -> dict[str, Any]:
    """A record as a row of the table of results, by column."""
    row = {
        "key": record.key,
        "variant": record.variant,
        "preset": record.preset,
        "overrides": json.dumps(record.overrides),
        "settings": json.dumps(record.settings),
        "seed": record.seed,
        "status": FAILED if record.error else DONE,
        "error": record.error or None,
        "version": record.version,
        "digest": record.digest or None,
        "seconds": record.seconds,
        "ended_at": record.ended_at or None,
        "arrays": record.arrays or None,
    }
    values = record.values.items()
    return row | {name: value if math.isfinite(value) else None for name, value in values}


def records_of(rows: Iterable[Mapping[str, Any]], origin: Origin) -> list[Record]:
    """Rows of a table of results as records.

    Raises:
        ValueError, TypeError, KeyError: one is no row.
    """
    # The runs of a variant share their settings, which are most of what a row holds.
    mapping = cache(_mapping)
    return [
        Record(
            key=str(row["key"]),
            variant=str(row["variant"]),
            preset=str(row["preset"]),
            overrides=mapping(row["overrides"]),
            settings=mapping(row["settings"]),
            seed=int(row["seed"]),
            error="" if row["status"] == DONE else str(row["error"] or row["status"]),
            version=str(row["version"]),
            digest=str(row["digest"] or ""),
            seconds=math.nan if row["seconds"] is None else float(row["seconds"]),
            ended_at=str(row["ended_at"] or ""),
            values=all_values(row, origin.metrics if row["status"] == DONE else ()),
            arrays=str(row["arrays"] or ""),
            origin=origin,
        )
        for row in rows
    ]


def gist(error: str) -> str:
    """What went wrong in a run, on one line: the type of the error and all of its message.

    Args:
        error: of the record of a run that failed.
    """
    lines = error.strip().splitlines()
    # A traceback is indented; what was raised begins after its last line of code.
    places = [index for index, line in enumerate(lines) if line.startswith('  File "')]
    said = lines[places[-1] + 1 :] if places else lines
    return " ".join(line.strip() for line in dropwhile(_is_code, said))


def _is_code(line: str) -> bool:
    return line.startswith("    ")


def _mapping(text: str) -> Mapping[str, Any]:
    found = json.loads(text)
    if not isinstance(found, dict):
        raise ValueError("settings are not a mapping")
    return cast("Mapping[str, Any]", found)


def _whole(value: float) -> int:
    return 0 if math.isnan(value) else int(value)
