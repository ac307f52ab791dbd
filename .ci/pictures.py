"""Draws the pictures of the page for the documents: `PYTHONPATH=. python .ci/pictures.py docs`."""

import sys
import tempfile
import time
from pathlib import Path

from PIL import Image

from app import ui
from geotlm_lm import Answerer
from tests.app.browser import SHOWN, STAGE, Browser

QUESTION = "Which way is the cap turning?"
SIZE = (1400, 900)
HELD = (("Home", 36), ("End", 35))
"""Keys that hold the picture at its last frame."""


def draw(folder: Path) -> None:
    """Write page_ask.png and page_simulate.png."""
    page = ui.build(Answerer.load())
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser(Path(profile), SIZE)
        try:
            browser.open(ui.launch(page))  # the bottle cap is opened with it
            browser.fill("Question", QUESTION)
            browser.click("Ask", "button.primary")
            browser.wait_for("document.body.innerText.includes('% sure)')")
            _shoot(browser, folder / "page_ask.png")
            browser.click("Simulate", "button[role=tab]")
            browser.click("Simulate and ask", "button.primary")
            browser.wait_for(SHOWN)
            _shoot(browser, folder / "page_simulate.png")
        finally:
            browser.close()
            page.close()


def _shoot(browser: Browser, path: Path) -> None:
    """Write what is seen in 256 colours, a third of the size."""
    browser.run(f"window.scrollTo(0, 0); {STAGE}.querySelector('[data-part=scrub]').focus()")
    for key in HELD:
        browser.press(*key)
    time.sleep(1.5)
    browser.screenshot(path)
    with Image.open(path) as seen:
        reduced = seen.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    reduced.save(path, optimize=True)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
