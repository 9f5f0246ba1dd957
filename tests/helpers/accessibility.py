"""What axe-core finds on a page that a browser shows."""

from importlib.resources import files
from pathlib import Path

RUN = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")


def find_barriers(browser):
    """Return each violation of a rule of axe-core, with the element, once the page has answered to its size."""
    if not browser.execute_script("return 'axe' in window"):
        script = files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8")
        browser.execute_script(script)
    found = browser.execute_async_script(RUN)
    return found


def look(browser, width, scheme):
    """Show pages in a width (px) and in a colour scheme, ``"light"`` or ``"dark"``."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    feature = {"name": "prefers-color-scheme", "value": scheme}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
