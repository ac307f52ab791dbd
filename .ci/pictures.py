"""Draws the pictures of the page for the documents: `PYTHONPATH=. python .ci/pictures.py docs`."""

import sys
import tempfile
import time
from pathlib import Path

from PIL import Image

from app import ui
from geotlm_lm import Answerer
from tests.app.browser import SHOWN, STAGE, Browser

QUESTIONS = ("How far did it turn?", "When did it slip?")
SIZE = (1400, 900)
SHOWN_S = 1.8
"""Moment of the recording at which it turns."""


def draw(folder: Path) -> None:
    """Write page_ask.png and page_simulate.png."""
    page = ui.build(Answerer.load())
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser(Path(profile), SIZE)
        try:
            browser.open(ui.launch(page))  # a recording is opened with it
            for question in QUESTIONS:
                browser.ask(question)
            _shoot(browser, folder / "page_ask.png")
            browser.click("Simulate", "button[role=tab]")
            browser.wait_for(SHOWN)
            _shoot(browser, folder / "page_simulate.png")
        finally:
            browser.close()
            page.close()


def _shoot(browser: Browser, path: Path) -> None:
    """Write what is seen in 256 colours, a third of the size."""
    browser.run(f"window.scrollTo(0, 0); {STAGE}.querySelector('[data-part=scrub]').focus()")
    browser.press("End", 35)
    browser.run(f"document.dispatchEvent(new CustomEvent('seek', {{detail: {SHOWN_S}}}))")
    browser.run("document.activeElement.blur()")
    time.sleep(1.5)
    browser.screenshot(path)
    with Image.open(path) as seen:
        reduced = seen.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    reduced.save(path, optimize=True)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
