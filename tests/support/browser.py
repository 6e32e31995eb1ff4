"""Where the browser is, and how it is started."""

import os

from app.util.web_browser import CHROMIUM_ADVICE

# This takes the place of Playwright's own list of features to do without, so it has those, too.
_WITHOUT = (
    "AimEnabled",
    "AvoidCorsURLLoaderRestartOnRedirect",
    "AvoidUnnecessaryBeforeUnloadCheckSync",
    "DestroyProfileOnBrowserClose",
    "HttpsFirstBalancedModeAutoEnable",
    "HttpsUpgrades",
    "LensOverlay",
    "MediaRouter",
    "NetworkTimeServiceQuerying",
    "OptimizationHints",
    "PaintHolding",
    "PreconnectToSearch",
    "ThirdPartyStoragePartitioning",
    # Pages of the browser's own for its address bar: each profile would load them, though nobody
    # types there, in a quarter of the time of the lab's page.
    "WebUIOmniboxAimPopup",
    "WebUIOmniboxPopup",
)

BROWSER_ARGS = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",
    "--disable-background-networking",
    "--disable-quic",
    "--no-first-run",
    "--disable-component-update",
    "--disable-sync",
    f"--disable-features={','.join(_WITHOUT)}",
)
"""WebGL in software, and a browser that talks to nobody but the page.

Only the board is drawn by WebGL: where there is no graphics card, what stands round it is drawn
faster without it, in half the time of a page that opens.
"""
TEST_ARGS = (*BROWSER_ARGS, "--webgl-antialiasing-mode=none")
"""Likewise for tests, whose pictures nobody looks at.

Smooth edges of lines would make each picture of the board half as dear again; without them no cell
has another colour.
"""


def advice() -> str:
    """How to get a browser."""
    wanted = os.environ.get("CHROMIUM")
    if wanted:
        return f"CHROMIUM is {wanted!r}, which is no program that can be run."
    return f"No browser: {CHROMIUM_ADVICE}."
