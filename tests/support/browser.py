"""Where the browser is, and how it is started."""

import os
import shutil

BROWSER_NAMES = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
)
"""Programs to look for, in this order, where the environment variable CHROMIUM names none."""

BROWSER_ARGS = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-quic",
    "--no-first-run",
    "--disable-component-update",
    "--disable-sync",
)
"""WebGL in software, and a browser that talks to nobody but the page."""


def find_browser() -> str | None:
    """Path of the browser to drive, None if there is none."""
    wanted = os.environ.get("CHROMIUM")
    names = (wanted,) if wanted else BROWSER_NAMES
    return next((path for name in names if (path := shutil.which(name))), None)


def advice() -> str:
    """How to get a browser."""
    wanted = os.environ.get("CHROMIUM")
    if wanted:
        return f"CHROMIUM is {wanted!r}, which is no program that can be run."
    return "No browser: install the package `chromium`, or set CHROMIUM to the path of one."
