"""Draws the pictures of the page that the documents show: `python -m tests.app.pictures docs`."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from urllib.error import URLError
from urllib.request import urlopen

from PIL import Image

from tests.app.browser import Browser

PORT = 7899
QUESTION = "Which way is the cap turning, and how far?"
SIZE = (1280, 1000)
START_S = 120.0


def draw(folder: Path) -> None:
    """Write page_ask.png and page_simulate.png."""
    command = [sys.executable, "-m", "geotlm_lm", "app", "--port", str(PORT)]
    server = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    address = f"http://127.0.0.1:{PORT}/"
    try:
        _wait_until_served(address)
        with tempfile.TemporaryDirectory() as profile:
            browser = Browser(Path(profile), SIZE)
            try:
                browser.open(address)
                _ask(browser)
                _shoot(browser, folder / "page_ask.png")
                _simulate(browser)
                _shoot(browser, folder / "page_simulate.png")
            finally:
                browser.close()
    finally:
        server.terminate()
        server.wait()


def _wait_until_served(address: str) -> None:
    began = time.monotonic()
    while time.monotonic() - began < START_S:
        try:
            with urlopen(address, timeout=10) as reply:
                if reply.status == 200:
                    return
        except (URLError, OSError):
            time.sleep(0.2)
    raise TimeoutError(f"{address} did not answer within {START_S:g} s")


def _ask(browser: Browser) -> None:
    """Open the example of a bottle cap and ask."""
    browser.run(
        "[...document.querySelectorAll('.thumbnail-item')].find("
        "one => one.innerText.includes('cap') || one.querySelector('[alt*=cap]')).click()"
    )
    browser.wait_for("[...document.images].some(i => i.offsetParent && i.naturalWidth == 448)")
    browser.fill("Question", QUESTION)
    browser.click("Ask", "button.primary")
    browser.wait_for("document.body.innerText.includes('optical flow')")
    time.sleep(1.0)


def _simulate(browser: Browser) -> None:
    browser.click("Simulate", "button[role=tab]")
    browser.click("Simulate and ask", "button.primary")
    browser.wait_for(
        "[...document.images].filter(i => i.offsetParent && i.naturalWidth == 448).length >= 3"
    )
    time.sleep(1.0)


def _shoot(browser: Browser, path: Path) -> None:
    """Write what is seen in 256 colours, a third of the size."""
    browser.run("window.scrollTo(0, 0)")
    time.sleep(0.5)
    browser.screenshot(path)
    with Image.open(path) as seen:
        reduced = seen.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    reduced.save(path, optimize=True)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
