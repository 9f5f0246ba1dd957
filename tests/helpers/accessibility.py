"""What axe-core finds on a page that a browser shows."""

from importlib.resources import files
from typing import Any

RUN = """
const done = arguments[0], drawn = () => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve, 50)));
const settled = () => Promise.allSettled(
  document.getAnimations().filter((a) => a instanceof CSSTransition).map((a) => a.finished));
const search = () => axe.run(document, { resultTypes: ["violations"] });
drawn().then(drawn).then(settled).then(search).then(({ violations }) => done(violations.flatMap(
  ({ id, nodes }) => nodes.map(({ target, html }) => `${id} at ${target.join(" ")}: ${html.slice(0, 100)}`))));
"""


def find_barriers(browser: Any) -> list[str]:
    """Return each violation of a rule of axe-core, with the element, once the page has answered to its size."""
    if not browser.execute_script("return 'axe' in window"):
        script = files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8")
        browser.execute_script(script)
    found: list[str] = browser.execute_async_script(RUN)
    return found


def look(browser: Any, width: int, scheme: str) -> None:
    """Show pages in a width (px) and in a colour scheme, ``"light"`` or ``"dark"``."""
    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    feature = {"name": "prefers-color-scheme", "value": scheme}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})
