"""All experiments of the replication, run one after the other into folders side by side."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from app.documents import experiments
from app.experiments.crews import Crew
from app.experiments.runner import Outcome, Progress, run_experiment
from app.experiments.store import Folder
from app.experiments.task import prepare


class Made(NamedTuple):
    """What running them all took, those runs aside that were there before."""

    runs: int
    steps: int
    seconds: float
    failed: int


def make_all(
    names: Sequence[str],
    out: Path,
    crew_of: Callable[[], Crew],
    n_seeds: int | None = None,
    force: bool = False,
    tell: Callable[[str, Progress], object] = lambda _, __: None,
) -> Made:
    """Make all runs that are not there yet.

    Args:
        names: shipped experiments.
        out: the folder that holds a folder of results for each.
        crew_of: makes a crew for one experiment.
        n_seeds: of each variant, in the place of those that its experiment names.
        force: begin again where there are results, and not go on with them.
        tell: called now and then with the name of an experiment and how far it has come.

    Raises:
        FolderError: a folder holds other results, or cannot be written.
    """
    outcomes: list[Outcome] = []
    for name in names:
        experiment = experiments.load(name, n_seeds)
        prepare(experiment.metrics)
        path = out / name

        def told(progress: Progress, name: str = name) -> None:
            tell(name, progress)

        with Folder(path, experiment, resume=path.is_dir() and not force, force=force) as folder:
            outcomes.append(run_experiment(experiment, folder, crew_of(), told))
    return Made(
        sum(outcome.done for outcome in outcomes),
        sum(outcome.steps for outcome in outcomes),
        sum(outcome.seconds for outcome in outcomes),
        sum(outcome.failed for outcome in outcomes),
    )
