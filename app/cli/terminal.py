"""What a command shows on a terminal while it works; nothing where there is none.

Like the command line, it imports what takes long only once it is needed.
"""

import contextlib
import sys
from collections.abc import Callable, Iterator

Show = Callable[[float, str, str], None]
"""Takes how far the work has come, which runs are done, and how fast that goes."""


@contextlib.contextmanager
def progress_bar(total: float, n_runs: int, with_time_left: bool = False) -> Iterator[Show]:
    """A bar that grows up to ``total``, with a text on either side; it is gone in the end."""
    if not sys.stderr.isatty():
        yield lambda done, runs, rate: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = [
        TextColumn("{task.fields[runs]}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[rate]}"),
    ]
    if with_time_left:
        columns.append(TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=total, runs=f"0/{n_runs} runs", rate="")

        def show(done: float, runs: str, rate: str) -> None:
            bar.update(task, completed=done, runs=runs, rate=rate)

        yield show


@contextlib.contextmanager
def status() -> Iterator[Callable[[str], None]]:
    """A line that says what is being done."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console

    with Console(stderr=True).status("") as line:
        yield line.update
