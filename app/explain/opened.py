"""What is said of a session from elsewhere that was opened: what is in it, and whether it is so."""

from app import __version__
from app.live.made_again import Remade
from app.live.shared import Contents
from app.words.numbers import counted

SAME = "Digest as recorded: same."


def contents_in_words(contents: Contents) -> str:
    """What is in a session: preset, seed, commands, how far it goes, and who wrote it."""
    n_lines = contents.n_lines
    lines = "" if n_lines == 1 else f"{counted(n_lines, 'line')}, the live one "
    return (
        f"{contents.preset}, seed {contents.seed}; {counted(contents.n_commands, 'command')};"
        f" {lines}up to trial {contents.trial:,}; written by pounce {contents.version}."
    )


def verdict_in_words(remade: Remade, contents: Contents) -> str:
    """Whether the tables made here have the digests that were recorded, and what if not."""
    if not remade.n_compared:
        return "No digest was recorded, so there is nothing to compare it with."
    if not remade.differ:
        return SAME
    which = "" if contents.n_lines == 1 else f" ({', '.join(remade.differ)})"
    return f"Digest as recorded: differs{which}. {_advice(contents.version)}"


def _advice(version: str) -> str:
    """Why it may differ, and what to do."""
    if version == __version__:
        return (
            "The same version wrote it, so the file was changed, or this machine computes"
            " otherwise. What is on the board is what the commands lead to here; pounce replay FILE"
            " says at which step it parts from what was recorded."
        )
    return (
        f"Pounce {__version__}, which is here, learns otherwise than {version}. What is on the"
        f" board is what the same commands lead to here; to see what was recorded, open it with"
        f" pounce {version}. pounce replay FILE says at which step they part."
    )
