"""Folders of results: as tests make them up, what they hold, and how writing one may end."""

import contextlib
import json
import sqlite3
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from app.documents import presets
from app.experiments import archive, store, table
from app.experiments.table import SCHEMA_VERSION
from app.metrics import NAMES
from sim.world import CAPTURE, FLIGHT

N_TRIALS = 300
TABLE = "results.sqlite"
KILLED_IN_A_COMMIT = """
import os, signal, sqlite3, sys
database = sqlite3.connect(sys.argv[1])
database.execute("PRAGMA cache_size=1")
database.execute("BEGIN")
database.executemany(
    "INSERT INTO runs (key, variant, preset, overrides, settings, seed, status, version, seal)"
    " VALUES (?, 'v', 'p', '{}', ?, 0, 'done', '0', '')",
    [(f"half {number}", "x" * 3000) for number in range(200)],
)
os.kill(os.getpid(), signal.SIGKILL)
"""
"""A program that dies while it writes to the database whose path it is given."""


def pictures(
    trials: Sequence[int], share: np.ndarray, distance: np.ndarray
) -> dict[str, np.ndarray]:
    """Arrays of pictures of the value, ``share`` and ``distance (moment, ring, direction)``."""
    return {
        "moments": np.array(trials, np.int64),
        "value_share": share.astype(np.float32),
        "value_distance": distance.astype(np.float32),
    }


def greedy_curve(
    trials: Sequence[int] = (), steps: Sequence[int] = (), rewards: Sequence[float] = ()
) -> dict[str, np.ndarray]:
    """Arrays of a greedy curve."""
    return {
        "greedy_trial": np.array(trials, np.int64),
        "greedy_step": np.array(steps, np.int64),
        "greedy_reward": np.array(rewards, np.float32),
    }


def no_facts() -> dict[str, np.ndarray]:
    """Arrays of no facts."""
    return {"probe_names": np.zeros(0, np.str_), "probe_values": np.zeros(0)}


def add_run(
    folder: Path,
    seed: int,
    preset: str = "timed",
    variant: str = "",
    overrides: Mapping[str, Any] = {},
    share: float = 0.5,
    arrays: Mapping[str, Any] = {},
    **columns: Any,
) -> None:
    """Add a run of 300 trials of ten steps; a share of the trials, drawn by seed, are captures."""
    settings = presets.load(preset if preset in presets.shipped() else "timed")
    draw = np.random.default_rng(seed)
    outcome = np.where(draw.random(N_TRIALS) < share, CAPTURE, FLIGHT).astype(np.int8)
    world = json.loads(columns.get("settings", "{}")).get("world", {})
    shape = (0, world.get("n_distances", 18), world.get("n_directions", 24))
    key = f"k{len(list((folder / 'arrays').iterdir()))}"
    reward = float(np.where(outcome == CAPTURE, 100, -50).mean())
    row: dict[str, Any] = {
        "key": key,
        "variant": variant or preset,
        "preset": preset,
        "overrides": json.dumps(overrides),
        "settings": json.dumps({**settings.model_dump(mode="json"), "overrides": dict(overrides)}),
        "seed": seed,
        "status": "done",
        "version": "1",
        "digest": f"{variant}{preset}{overrides}{seed}{share}",
        "trials": N_TRIALS,
        "steps": 10 * N_TRIALS,
        "final_reward": reward,
        "area": reward / 2,
        "steps_to_50": 100 * seed + 100,
        **columns,
    }
    made = {
        "outcome": outcome,
        "steps": np.full(N_TRIALS, 10, np.int32),
        "introductions": np.array([[0, 0], [100, 1000]]),
        "introduced": np.array(["approach", "avoid"]),
        **pictures([], np.zeros(shape), np.zeros(shape)),
    }
    add_arrays(folder, key, **{**made, **arrays})
    with contextlib.closing(table.connect(folder)) as database:
        table.write(database, {**row, "arrays": checksum_in(folder, key)})
        _note_variant(database, row["variant"])


def add_arrays(folder: Path, key: str, **arrays: np.ndarray) -> None:
    """Put the archive of a run into place, without a word in its row."""
    (folder / "arrays" / f"{key}.npz").write_bytes(
        archive.packed({**greedy_curve(), **no_facts(), **arrays})
    )


def checksum_in(folder: Path, key: str) -> str:
    return archive.checksum((folder / "arrays" / f"{key}.npz").read_bytes())


def seal(folder: Path) -> None:
    """Make all that was changed by hand what pounce itself might have written."""
    with contextlib.closing(table.connect(folder)) as database:
        database.row_factory = sqlite3.Row
        rows = [dict(row) for row in database.execute("SELECT * FROM runs ORDER BY rowid")]
        database.row_factory = None
        for row in rows:
            if (folder / "arrays" / f"{row['key']}.npz").exists():
                row["arrays"] = checksum_in(folder, row["key"])
        table.write(database, *rows)


def _note_variant(database: sqlite3.Connection, label: str) -> None:
    """Add a variant to those of the experiment, unless it is one of them."""
    (text,) = database.execute("SELECT value FROM meta WHERE key = 'variants'").fetchone()
    labels = json.loads(text)
    if label in labels:
        return
    runs = database.execute("SELECT DISTINCT variant, overrides FROM runs")
    n_overrides = {variant: len(json.loads(overrides)) for variant, overrides in runs}
    labels = sorted([*labels, label], key=lambda label: (n_overrides.get(label, 0), label))
    table.note(database, variants=json.dumps(labels))


def new_folder(
    path: Path,
    version: str = str(SCHEMA_VERSION),
    name: str = "an experiment",
    metrics: Any = NAMES,
    **meta: str,
) -> Path:
    """A folder of results without a run."""
    (path / "arrays").mkdir(parents=True)
    values = {
        "name": name,
        "description": "",
        "source": "",
        "seeds": "[0, 1, 2]",
        "own_seeds": "{}",
        "horizon": "null",
        "steps_alone": "false",
        "variants": "[]",
        "steps": "null",
        "stop": "null",
        "metrics": json.dumps(metrics),
        **meta,
    }
    (path / TABLE).write_bytes(table.new(values))
    if version != str(SCHEMA_VERSION):
        with contextlib.closing(table.connect(path)) as database:
            table.note(database, schema_version=version)
    return path


def rows(path: Path) -> list[dict[str, Any]]:
    """All runs of a folder as the table of results has them."""
    database = sqlite3.connect(path / "results.sqlite")
    database.row_factory = sqlite3.Row
    names = ", ".join(store.COLUMNS)
    found = [dict(row) for row in database.execute(f"SELECT {names} FROM runs ORDER BY key")]
    database.close()
    return found
