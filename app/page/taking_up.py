"""Taking up a session that is made again, be it one that was kept here or one from elsewhere."""

import contextlib
from collections.abc import Callable, Sequence
from functools import partial
from typing import Final, NamedTuple

import viser

from app.live.journal import Journal
from app.live.made_again import Remade, Renumbered
from app.live.requests import TakeUp
from app.live.session import Session
from app.live.worker import Reply
from app.page.inbox import Work

_APART: Final = 1_000
"""Numbers that runs may have had by the time that a session is taken up, before it is refused."""
_PATIENCE_S: Final = 60.0

Submit = Callable[[TakeUp, Reply], object]


class Taken(NamedTuple):
    """A session made again, and where what is done in it from here on is written down."""

    remade: Remade
    journal: Journal | None
    is_shared: bool = False
    """Whether it is from elsewhere."""


def take_up(
    client: viser.ClientHandle,
    session: Session,
    submit: Submit,
    work: Work,
    make: Callable[[int], Taken | str],
    then: Callable[[Taken | str], object],
) -> None:
    """Have a session made again, and show it in the place of what there is.

    Args:
        client: the browser that asks for it.
        session: that it is taken up in.
        submit: asks that.
        work: has something made in another thread.
        make: makes it, given the first number of its runs; or says why that cannot be.
        then: called in the page's loop once it is on the board, or with the reason why it is not.
    """
    first_number = session.n_runs + _APART

    def made(found: Taken | str) -> None:
        if isinstance(found, str):
            then(found)
            return
        reasons: list[str] = []
        kept = None if found.journal is None else Renumbered(found.journal, first_number)
        submit(TakeUp(found.remade.made, kept, found.is_shared), reasons.append)
        work(client, partial(_answered, session, found, reasons), then)

    work(client, partial(make, first_number), made)


def _answered(session: Session, found: Taken, reasons: Sequence[str]) -> Taken | str:
    """Wait until what was made is on the board, and what was there closed; or is refused."""
    live = found.remade.made.family.live.number
    with contextlib.suppress(TimeoutError):
        session.wait_for(
            lambda status: bool(reasons) or status.snapshot.generation == live, _PATIENCE_S
        )
    if not reasons:
        return found
    if found.journal is not None:
        found.journal.close()
    return reasons[0]
