"""The archive of a run's arrays: packed, sealed by a checksum, and read back whatever its bytes.

An archive that cannot be read, or is not the one that its checksum is of, is one thing to whoever
reads results: :class:`ArchiveError`, and the run counts as one that is missing.
"""

import hashlib
import io
import math
import os
import stat
import zipfile
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from app.metrics.course import GreedyCurve
from learners.names import MAX_TRIALS
from sim.world import CAPTURE, TIMEOUT

_LEVEL: Final = 3
"""Of compression: a quarter of the usual time, for a twentieth more bytes."""
LARGEST_BYTES: Final = 16 * MAX_TRIALS
"""Of an archive and of all its arrays together; five of a trial, and little beside that."""

_KINDS: Final[Mapping[str, tuple[str, int]]] = {
    "outcome": ("iu", 1),
    "steps": ("iu", 1),
    "introductions": ("iu", 2),
    "introduced": ("U", 1),
    "moments": ("iu", 1),
    "value_share": ("f", 3),
    "value_distance": ("f", 3),
    "greedy_trial": ("iu", 1),
    "greedy_step": ("iu", 1),
    "greedy_reward": ("f", 1),
    "probe_names": ("U", 1),
    "probe_values": ("f", 1),
}
"""By name of an array: the kinds of number it may hold, and how many axes it has."""
_HEADERS: Final = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}


class ArchiveError(Exception):
    """The arrays of a run are damaged, gone or not its own; the message says which."""


class Arrays(NamedTuple):
    """What is kept of a run beside its row, as :func:`app.experiments.task.arrays_of` has it."""

    outcome: np.ndarray
    """(trial,) int8."""
    steps: np.ndarray
    """(trial,) int64."""
    joined: dict[str, tuple[int, int]]
    """Trial and step of each skill that joined after the start."""
    moments: np.ndarray
    """(moment,) int64."""
    value_share: np.ndarray
    """(moment, ring, direction) float32."""
    value_distance: np.ndarray
    """(moment, ring, direction) float32."""
    greedy: GreedyCurve
    facts: dict[str, float]
    """By name, as :mod:`app.experiments.facts` has them; none of them is NaN."""


def packed(arrays: dict[str, np.ndarray], compressed: bool = True) -> bytes:
    """Arrays as a NumPy archive."""
    out = io.BytesIO()
    kind = zipfile.ZIP_DEFLATED if compressed else zipfile.ZIP_STORED
    # numpy's own way takes no level, and the one that it has a tenth of the time of a run.
    with zipfile.ZipFile(out, "w", kind, compresslevel=_LEVEL) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, array, allow_pickle=False)
    return out.getvalue()


def checksum(archive: bytes) -> str:
    """By which an archive is known again."""
    return hashlib.sha256(archive).hexdigest()


def path_of(folder: Path, key: str) -> Path:
    """Where the archive of a run is in a folder of results."""
    return folder / "arrays" / f"{key}.npz"


def is_whole(folder: Path, key: str, known: str | None) -> bool:
    """Whether the archive of a run is there, and is the one of a checksum."""
    path = path_of(folder, key)
    try:
        found = path.stat()
        mark = found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns
        return _checksum_of(path, mark) == known
    except (ArchiveError, OSError):
        return False


@lru_cache(maxsize=50_000)
def _checksum_of(path: Path, mark: tuple[int, ...]) -> str:
    """The checksum of a file as it is now; the page asks for the same ones every few seconds."""
    return checksum(_bytes_of(path))


def read(folder: Path, key: str, known: str | None) -> bytes:
    """The archive of a run, if it is the one of a checksum.

    Raises:
        ArchiveError: it is not, or cannot be read.
    """
    try:
        archive = _bytes_of(path_of(folder, key))
    except OSError as error:
        raise ArchiveError(f"its arrays cannot be read: {error.strerror or error}") from error
    if checksum(archive) != known:
        raise ArchiveError("its arrays are damaged, or another run's")
    return archive


def _bytes_of(path: Path) -> bytes:
    # What stands in its place may be a pipe, which would be waited for.
    with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb") as file:
        found = os.fstat(file.fileno())
        if not stat.S_ISREG(found.st_mode):
            raise ArchiveError("its arrays are no file")
        if found.st_size > LARGEST_BYTES:
            raise ArchiveError("its arrays are too large")
        return file.read()


def unpacked(archive: bytes, n_trials: int, n_steps: int) -> Arrays:
    """The arrays in an archive.

    Args:
        archive: of a run.
        n_trials: that the run finished.
        n_steps: that it took, with those of a trial that it did not finish.

    Raises:
        ArchiveError: they are damaged, or not those of such a run.
    """
    try:
        return _unpacked(archive, n_trials, n_steps)
    except Exception as error:
        # Of damaged bytes zlib, zipfile and NumPy each say something else, and memory may run out.
        raise ArchiveError(f"its arrays cannot be read: {error}") from error


def _unpacked(archive: bytes, n_trials: int, n_steps: int) -> Arrays:
    with zipfile.ZipFile(io.BytesIO(archive)) as parts:
        # As large as they say they are, before memory is taken for them.
        if sum(part.file_size for part in parts.infolist()) > LARGEST_BYTES:
            raise ValueError("they are too large")
        found = {name: _array(parts.read(f"{name}.npy")) for name in _KINDS}
    for name, (kinds, n_axes) in _KINDS.items():
        if found[name].dtype.kind not in kinds or found[name].ndim != n_axes:
            raise ValueError(f"{name!r} is not what it should be")
    outcome, steps = found["outcome"], found["steps"].astype(np.int64)
    moments, share, distance = found["moments"], found["value_share"], found["value_distance"]
    if not len(outcome) == len(steps) == n_trials or not share.shape == distance.shape:
        raise ValueError("they do not fit together")
    if len(share) != len(moments) or not (steps >= 0).all() or steps.sum() > n_steps:
        raise ValueError("they do not fit together")
    if not ((outcome >= CAPTURE) & (outcome <= TIMEOUT)).all():
        raise ValueError("trials end as none can")
    curve = GreedyCurve(found["greedy_trial"], found["greedy_step"], found["greedy_reward"])
    if not len(curve.trial) == len(curve.step) == len(curve.reward):
        raise ValueError("they do not fit together")
    facts = dict(zip(found["probe_names"].tolist(), found["probe_values"].tolist(), strict=True))
    if not np.isfinite(found["probe_values"]).all():
        raise ValueError("they hold a fact that is no number")
    introduced = zip(found["introduced"].tolist(), found["introductions"].tolist(), strict=True)
    joined = {name: (trial, step) for name, (trial, step) in introduced if trial > 0}
    return Arrays(outcome, steps, joined, moments, share, distance, curve, facts)


def _array(data: bytes) -> np.ndarray:
    """An array as a file of NumPy's has it, made only if it is as large as that file says."""
    stream = io.BytesIO(data)
    shape, is_transposed, dtype = _HEADERS[np.lib.format.read_magic(stream)](stream)
    rest = stream.read()
    if dtype.hasobject or not dtype.itemsize or math.prod(shape) * dtype.itemsize != len(rest):
        raise ValueError("an array is not as large as it says")
    return np.ndarray(shape, dtype, rest, order="F" if is_transposed else "C")
