"""What the run on the board is called, wherever it is named."""

from app.live.status import Status


def run_on_board(status: Status) -> str:
    """A name for the run that is shown: "your run, timed, seed 8" or "figure_4_1: timed, seed 3".

    The first is of runs that began in this lab, the second of one that was made again from results.
    """
    snapshot = status.snapshot
    name = f"{snapshot.preset}, seed {snapshot.seed}"
    return f"your run, {name}" if status.is_own else name
