"""Pages of an audience in a real browser, each as on a device of its own."""

from typing import Final

from playwright.sync_api import Browser, BrowserContext, Page, ViewportSize

from app.audience.audience import Audience
from tests.support.live import PATIENCE_S

PHONE: Final[ViewportSize] = {"width": 390, "height": 844}


class Phones:
    """Those who look at one audience's page."""

    def __init__(self, browser: Browser, audience: Audience) -> None:
        self._browser, self._audience = browser, audience
        self._contexts: list[BrowserContext] = []
        self.complaints: list[str] = []
        """What went wrong in their scripts, of all that there were."""

    def open(
        self, viewport: ViewportSize = PHONE, dark: bool = False, address: str | None = None
    ) -> Page:
        """One more that looks, at the audience's address unless another one is given."""
        context = self._browser.new_context(
            viewport=viewport,
            color_scheme="dark" if dark else "light",
            has_touch=viewport == PHONE,
            # Colours that are on their way to others would be judged by a checker.
            reduced_motion="reduce",
            device_scale_factor=2 if viewport == PHONE else 1,
        )
        self._contexts.append(context)
        context.set_default_timeout(PATIENCE_S * 1000)
        page = context.new_page()
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on(
            "console",
            lambda told: self.complaints.append(told.text) if told.type == "error" else None,
        )
        page.goto(address or self._audience.addresses[0])
        return page

    def close(self) -> None:
        """All of them go."""
        while self._contexts:
            self._contexts.pop().close()
