"""How fast the compiled loop is beside the same learning in C, in plain numba, and in Python.

Rates are steps per second of the thread's own processor time. Machines have moods, so every
ratio is of two runs next to each other in time, and of many such ratios the median is given.
"""

import importlib.util
import json
import os
import shlex
import shutil
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict

import numpy as np

from benchmarks.plain import PlainRun
from benchmarks.schedule import explorations
from learners.kernel import rows
from learners.kernel.state import LearnerState
from learners.names import COMMANDS, MOVES
from learners.run import Run
from learners.spec import RunSpec
from sim.geometry import N_MOVES
from sim.rng import GAMMA, mix
from sim.world import CAPTURE, FLIGHT, TIMEOUT

if TYPE_CHECKING:
    from benchmarks import gym_agent

C_SOURCE = Path(__file__).with_name("learner.c")
C_FLAGS = ("-O3", "-march=native")

SENSORS_OF_SKILLS = ("skill_n_directions", "skill_n_distances")
"""Settings of a world that the loop alone knows."""

PYTHON_STEPS = 40_000
"""Steps after which the Python agent finishes its trial and stops: below a second."""
SHORT_RUNS = 5
"""Runs of the compiled loop over the Python agent's trials: each takes a millisecond."""


class Rates(TypedDict):
    """One learner's speed; a ratio above 1 means that the compiled loop is the faster."""

    steps_per_s: float
    ratio_to_c: float | None
    ratio_to_plain: float
    ratio_to_python: float | None


class Comparison(TypedDict):
    """What :func:`compare` finds."""

    learners: dict[str, Rates]
    notes: list[str]


class MismatchError(RuntimeError):
    """The C program did not do the same work as the compiled loop."""


class Work(NamedTuple):
    """What a run came to; equal for equal draws."""

    steps: int
    captures: int
    flights: int
    timeouts: int
    checksum: str
    """Of all values of the selection table, bit for bit."""


class Timed(NamedTuple):
    """A run and the processor time it took."""

    steps: int
    seconds: float

    @property
    def rate(self) -> float:
        """Steps per second."""
        return self.steps / self.seconds


def incomparable(spec: RunSpec) -> str | None:
    """What of a preset the programs beside the loop do not know, if anything, and what they do."""
    if not spec.world.shares_sensors:
        keys = " and ".join(f"world.{key}" for key in SENSORS_OF_SKILLS)
        return f"{keys}: skills see otherwise than the selection; allowed: null"
    learner, schedule = spec.learner, spec.schedule
    if learner.options == COMMANDS:
        return f"learner.options: value '{COMMANDS}'; allowed: {MOVES}, or skills"
    for key, value, known in (
        ("learner.local_rewards", learner.local_rewards, "signed"),
        ("learner.skills_that_learn", learner.skills_that_learn, "chosen"),
        ("learner.held", learner.held, None),
        ("learner.trace_decay", learner.trace_decay, None),
        ("learner.applicable", learner.applicable, None),
        ("schedule.teach", schedule.teach, None),
        ("schedule.pretrain", schedule.pretrain, 0),
    ):
        if value != known:
            given = value if isinstance(value, str | int | float) else "some"
            return f"{key}: value {given!r}; allowed: {'none' if known is None else known}"
    if any(schedule.rule_of(skill) is not None for skill in learner.skills):
        return "schedule.introduce: a rule by which skills join; allowed: none"
    if any(episode.where is not None for episode in schedule.episodes):
        return "schedule.episodes.where: states in which an episode acts; allowed: none"
    return None


def compare(
    presets: Mapping[str, RunSpec], repetitions: int, progress: Callable[[str], None]
) -> Comparison:
    """Time the compiled loop and its yardsticks on some presets, over all their trials.

    Args:
        presets: by name.
        repetitions: how often each is run, with a seed of its own each time.
        progress: is told what is being done.

    Raises:
        MismatchError: the C program and the loop learned different things from the same draws.
    """
    notes = [
        "Steps per second of processor time of one thread, the median of"
        f" {repetitions} repetitions over all trials of the preset; ratios are medians of the"
        " ratios of runs next to each other in time.",
    ]
    has_gymnasium = importlib.util.find_spec("gymnasium") is not None
    if has_gymnasium:
        notes.append(
            "The Python agent runs only the first trials of a preset, until it has made"
            f" {PYTHON_STEPS:,} steps; for its ratio the compiled loop runs the same trials."
        )
    else:
        notes.append("gymnasium is not installed: no comparison with a Python agent.")
    learners: dict[str, Rates] = {}
    with c_program(notes) as program:
        for name, spec in presets.items():
            progress(f"{name}: warming up")
            warm_up(spec)
            learners[name] = _rates(name, spec, program, repetitions, progress)
            if has_gymnasium:
                progress(f"{name}: the Python agent")
                learners[name]["ratio_to_python"] = ratio_to_python(spec)
    return {"learners": learners, "notes": notes}


def _rates(
    name: str,
    spec: RunSpec,
    program: Path | None,
    repetitions: int,
    progress: Callable[[str], None],
) -> Rates:
    rates: list[float] = []
    to_c: list[float] = []
    to_plain: list[float] = []
    for repetition in range(repetitions):
        progress(f"{name}: repetition {repetition + 1} of {repetitions}")
        ours, c, plain = _side_by_side(spec, program, repetition)
        rates.append(ours.rate)
        to_plain.append(ours.rate / plain.rate)
        if c is not None:
            to_c.append(ours.rate / c.rate)
    return {
        "steps_per_s": statistics.median(rates),
        "ratio_to_c": statistics.median(to_c) if to_c else None,
        "ratio_to_plain": statistics.median(to_plain),
        "ratio_to_python": None,
    }


def _side_by_side(
    spec: RunSpec, program: Path | None, seed: int
) -> tuple[Timed, Timed | None, Timed]:
    """One run of each, the loop between the two others, forwards and backwards by turns."""
    ours, c, plain = None, None, None
    for who in ("c", "ours", "plain") if seed % 2 == 0 else ("plain", "ours", "c"):
        if who == "ours":
            ours = time_kernel(spec, seed)
        elif who == "plain":
            plain = time_plain(spec, seed)
        elif program is not None:
            c = time_c(program, spec, seed)
    assert ours is not None
    assert plain is not None
    if c is not None:
        _check_same(ours[1], c[1], seed)
    return ours[0], None if c is None else c[0], plain


def _check_same(ours: Work, c: Work, seed: int) -> None:
    if ours != c:
        raise MismatchError(
            f"the C program and the compiled loop differ at seed {seed}: {c} and {ours}"
        )


def warm_up(spec: RunSpec) -> None:
    """Compile all that a preset needs, so that no compilation is timed."""
    short = spec.model_copy(update={"trials": 1})
    Run(short, 0).advance()
    PlainRun(short).run(0)


def time_kernel(spec: RunSpec, seed: int) -> tuple[Timed, Work]:
    """The compiled loop over all trials of a preset."""
    run = Run(spec, seed)
    start = time.thread_time()
    run.advance()
    seconds = time.thread_time() - start
    outcomes = run.state.log_outcome[: spec.trials]
    captures, flights, timeouts = (
        int(np.count_nonzero(outcomes == how)) for how in (CAPTURE, FLIGHT, TIMEOUT)
    )
    table = checksum(run.state, len(spec.learner.skills) or N_MOVES)
    work = Work(run.step, captures, flights, timeouts, table)
    return Timed(run.step, seconds), work


def time_plain(spec: RunSpec, seed: int) -> Timed:
    """The plain loop over all trials of a preset."""
    plain = PlainRun(spec)
    start = time.thread_time()
    steps = plain.run(seed).steps
    return Timed(steps, time.thread_time() - start)


def time_c(program: Path, spec: RunSpec, seed: int) -> tuple[Timed, Work]:
    """The C program over all trials of a preset, by its own clock."""
    command = [str(program), *c_arguments(spec, seed)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    result = json.loads(printed)
    seconds = result.pop("seconds")
    return Timed(result["steps"], seconds), Work(**result)


def checksum(state: LearnerState, n_options: int) -> str:
    """The C program's checksum of a selection table: the sum of mixes of place and value."""
    values = np.ascontiguousarray(rows.values(state.selection)[:, :n_options], np.float32)
    words = values.view(np.uint32).ravel().astype(np.uint64)
    place = np.arange(1, words.size + 1, dtype=np.uint64) * GAMMA
    mix_all: Any = getattr(mix, "py_func", mix)
    return f"{int(mix_all(place ^ words).sum(dtype=np.uint64)):016x}"


@contextmanager
def c_program(notes: list[str]) -> Iterator[Path | None]:
    """The C program, built into a temporary folder; None, and a note, if it cannot be built."""
    compiler = shlex.split(os.environ.get("CC", "")) or ["cc"]
    if shutil.which(compiler[0]) is None:
        notes.append(f"There is no C compiler ({compiler[0]}): no comparison with C.")
        yield None
        return
    with tempfile.TemporaryDirectory(prefix="pounce-bench-") as folder:
        program = Path(folder) / "learner"
        command = [*compiler, *C_FLAGS, "-o", str(program), str(C_SOURCE), "-lm"]
        built = subprocess.run(command, check=False, capture_output=True, text=True)
        if built.returncode != 0:
            reason = (built.stderr.strip().splitlines() or ["it gave no reason"])[0]
            notes.append(f"The C compiler failed ({reason}): no comparison with C.")
            yield None
        else:
            notes.append(f"C compiled by: {compiler[0]} {' '.join(C_FLAGS)}.")
            yield program


def c_arguments(spec: RunSpec, seed: int) -> list[str]:
    """A preset as the command line of the C program."""
    world, learner, schedule = spec.world, spec.learner, spec.schedule
    numbers: list[object] = ["--size", world.size, "--directions", world.n_directions]
    numbers += ["--distances", world.n_distances, "--ring-exponent", world.ring_exponent]
    numbers += ["--vision", world.vision_radius]
    numbers += ["--start", *world.start_radius, "--step-limit", world.step_limit]
    numbers += ["--capture", world.capture_reward, "--flight", world.flight_reward]
    numbers += ["--alpha", learner.alpha, "--skill-alpha", learner.skill_alpha]
    numbers += ["--gamma", learner.gamma, "--epsilon", learner.epsilon]
    numbers += ["--initial-q", learner.initial_q, "--seed", seed, "--trials", spec.trials]
    numbers += ["--safe-introduction", int(schedule.safe_introduction)]
    for skill in learner.skills:
        numbers += ["--skill", *learner.reward_of(skill)[:3]]
        numbers += [schedule.introduced_at(skill), schedule.freeze_of(skill)]
    for exploration in explorations(spec):
        numbers += ["--episode", *exploration]
    return [str(number) for number in numbers]


def ratio_to_python(spec: RunSpec) -> float:
    """How many times faster the loop is than the Python agent over the agent's trials."""
    python, trials = time_python(spec, seed=0)
    ours = []
    for seed in range(SHORT_RUNS):
        run = Run(spec, seed)
        start = time.thread_time()
        steps = run.advance(until_trial=trials)
        ours.append(Timed(steps, time.thread_time() - start).rate)
    return statistics.median(ours) / python.rate


def time_python(spec: RunSpec, seed: int) -> tuple[Timed, int]:
    """The Python agent over the first trials of a preset, and how many these were."""
    # Imported here because gymnasium is an extra.
    from benchmarks import gym_agent

    env = gym_agent.PredatorEnv(**spec.world.model_dump(exclude={*SENSORS_OF_SKILLS}))
    agent = python_agent(spec, seed)
    start = time.thread_time()
    steps, trials = gym_agent.train(env, agent, spec.trials, PYTHON_STEPS, seed)
    return Timed(steps, time.thread_time() - start), trials


def python_agent(spec: RunSpec, seed: int) -> "gym_agent.Agent":
    """The Python agent for a preset."""
    from benchmarks import gym_agent

    learner, schedule = spec.learner, spec.schedule
    if not learner.skills:
        return gym_agent.MoveAgent(
            learner.alpha, learner.gamma, learner.epsilon, learner.initial_q, seed
        )
    return gym_agent.SkillAgent(
        [
            gym_agent.Skill(
                *learner.reward_of(skill)[:3],
                introduced_at=schedule.introduced_at(skill),
                freeze_trials=schedule.freeze_of(skill),
            )
            for skill in learner.skills
        ],
        [gym_agent.Exploration(*exploration) for exploration in explorations(spec)],
        safe_introduction=schedule.safe_introduction,
        alpha=learner.alpha,
        skill_alpha=learner.skill_alpha,
        gamma=learner.gamma,
        epsilon=learner.epsilon,
        initial_q=learner.initial_q,
        seed=seed,
    )
