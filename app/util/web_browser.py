"""Shows an address in the user's browser, without waiting for it and never in the terminal."""

import os
import shutil
import subprocess
import sys
import threading
import webbrowser
from typing import Final

TEXT_BROWSERS: Final = frozenset(
    {"www-browser", "w3m", "lynx", "links", "links2", "elinks", "edbrowse", "browsh", "carbonyl"}
)
"""Programs that would take the terminal which the lab was started in."""

CHROMIUMS: Final = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
)
"""Programs to look for, in this order."""
CHROMIUM_ADVICE: Final = "install the package `chromium`, or set CHROMIUM to the path of one"

_OPEN: Final = "import sys, webbrowser; webbrowser.get(sys.argv[1] or None).open(sys.argv[2])"


def chosen_browser() -> str | None:
    """Name of the browser to use, empty for that of the system; None if there is none with windows.

    `BROWSER` may name several, of which Python takes the first that there is.
    """
    for name in (*filter(None, os.environ.get("BROWSER", "").split(os.pathsep)), ""):
        try:
            program = getattr(webbrowser.get(name or None), "name", "")
        except webbrowser.Error:
            continue
        words = program.split()
        if not words or os.path.basename(words[0]) not in TEXT_BROWSERS:
            return name
    return None


def find_chromium() -> str | None:
    """Path of the browser that a program can drive, as the tests do; None if there is none.

    `CHROMIUM` may name one; then no other will do.
    """
    wanted = os.environ.get("CHROMIUM")
    names = (wanted,) if wanted else CHROMIUMS
    return next((path for name in names if (path := shutil.which(name))), None)


def open_in_browser(url: str) -> bool:
    """Whether a browser is being started for this address.

    That is done by a process of its own, since some stay in the foreground until they are closed.
    It has no terminal to write to, and goes on when the lab ends.
    """
    name = chosen_browser()
    if name is None:
        return False
    opening = subprocess.Popen(
        [sys.executable, "-c", _OPEN, name, url],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    threading.Thread(target=opening.wait, name="browser", daemon=True).start()
    return True
