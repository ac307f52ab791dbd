"""A walk through the page in a real browser: how long a person waits, and what they see.

Starts the page as `geotlm-lm app` does, in a process of its own; needs a Chromium.
"""

from __future__ import annotations

import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.error import URLError
from urllib.request import urlopen

from geotlm_lm import GeoTLMError
from geotlm_lm.core.errors import MissingDependency

from . import handlers
from .browser import EXECUTABLE, Browser

START_S = 300.0
"""For the server to answer, on the slowest machine."""

ASKED_TIMES = 5
VISITS = 3
USERS = 20

SIZE = (1280, 1000)
"""Of the pictures, pixels."""

QUESTION = "Which way is it turning?"

TEXT = "document.body.innerText"

LISTEN = """
(() => {
  const question = QUESTION;
  const parts = () =>
    document.querySelector('[aria-label="chatbot conversation"]').textContent.split(question);
  const before = parts().length;
  const started = performance.now();
  window.waited = {};
  const look = () => {
    const told = parts();
    const text = told.length > before ? told.at(-1).trim() : '';
    if (text && !window.waited.first) window.waited.first = performance.now() - started;
    if (text.includes('% sure)') && !window.waited.last)
      window.waited.last = performance.now() - started;
  };
  if (window.looking) window.looking.disconnect();
  window.looking = new MutationObserver(look);
  window.looking.observe(document.body, {subtree: true, childList: true, characterData: true});
  [...document.querySelectorAll('button.primary')].find(
    one => one.offsetParent && one.innerText.trim() == 'Ask').click();
})()
"""
"""Clicks *Ask* and notes in the page itself when the first and the last word of an answer stand.

`textContent` costs no layout; `innerText` lays the page out at every look."""


def tour(pictures: Path | None = None) -> dict[str, Any]:
    """Return how long a person waits for each thing, seconds; draw pictures on the way.

    Args:
        pictures: Folder for `page_ask.png` and `page_simulate.png`; None for none.

    Returns:
        server_s, from the command to the first reply; model_s, from the command to the first answer
        a program gets, for which the model has to be loaded; page_s, from the address to a page
        whose examples stand; first_word_s and last_word_s of answers, from the click; all sorted;
        and users, what as many programs at once got.

    Raises:
        MissingDependency: If there is no browser.
        GeoTLMError: If the page does not start.
    """
    if EXECUTABLE is None:
        raise MissingDependency(
            "A tour of the page needs a Chromium, which was not found; on Debian run "
            "`apt-get install chromium`."
        )
    with _served() as (address, began, server_s), tempfile.TemporaryDirectory() as profile:
        _first_answer(address)
        model_s = time.perf_counter() - began
        browser = Browser(Path(profile), SIZE)
        try:
            visits = [_timed(lambda: browser.open(address)) for _ in range(VISITS)]
            waits = _ask(browser)
            if pictures is not None:
                pictures.mkdir(parents=True, exist_ok=True)
                _picture(browser, pictures / "page_ask.png")
                _simulate(browser)
                _picture(browser, pictures / "page_simulate.png")
        finally:
            browser.close()
        users = crowd(address)
    return {
        "server_s": [server_s],
        "model_s": [model_s],
        "page_s": sorted(visits),
        "first_word_s": sorted(one["first"] / 1e3 for one in waits),
        "last_word_s": sorted(one["last"] / 1e3 for one in waits),
        "users": users,
    }


def crowd(address: str, users: int = USERS) -> dict[str, Any]:
    """Have several programs ask at once, each about its own example, and check every answer.

    Args:
        address: Of the page.
        users: How many.

    Returns:
        users, seconds until the last was answered, median_s of one answer, and how many were wrong:
        another question's, or not what the example's own answer is when nobody else asks.
    """
    from gradio_client import Client, handle_file

    clips = [handlers.EXAMPLE_CLIPS[place % len(handlers.EXAMPLE_CLIPS)] for place in range(users)]
    alone = Client(address, verbose=False)
    question = handlers.DIRECTION_QUESTION
    right = {
        clip: alone.predict(handle_file(clip), question, api_name="/ask")["text"]
        for clip in handlers.EXAMPLE_CLIPS
    }
    clients = [Client(address, verbose=False) for _ in clips]

    def ask(place: int) -> tuple[float, bool]:
        clip = handle_file(clips[place])
        began = time.perf_counter()
        answer = clients[place].predict(clip, question, api_name="/ask")
        return time.perf_counter() - began, answer["text"] == right[clips[place]]

    began = time.perf_counter()
    with ThreadPoolExecutor(users) as pool:
        told = list(pool.map(ask, range(users)))
    return {
        "users": users,
        "all_s": time.perf_counter() - began,
        "median_s": statistics.median(seconds for seconds, _ in told),
        "wrong": sum(not is_right for _, is_right in told),
    }


def _first_answer(address: str) -> None:
    """Ask as a program does, as soon as the server replies."""
    from gradio_client import Client, handle_file

    clip = handle_file(handlers.EXAMPLE_CLIPS[0])
    Client(address, verbose=False).predict(clip, handlers.DIRECTION_QUESTION, api_name="/ask")


def _ask(browser: Browser) -> list[dict[str, float]]:
    """Open the first example and ask about it again and again; the first time warms up."""
    browser.run("document.querySelector('.thumbnail-item').click()")
    browser.wait_for("[...document.images].some(i => i.offsetParent && i.naturalWidth == 448)")
    waits = []
    for _ in range(ASKED_TIMES + 1):
        browser.fill("Question", QUESTION)
        browser.run(LISTEN.replace("QUESTION", repr(QUESTION)))
        waits.append(browser.wait_for("window.waited.last && window.waited"))
        browser.wait_for(f"{TEXT}.includes('optical flow')")
        time.sleep(1.0)  # until what stands beside the answer is drawn too
    return waits[1:]


def _simulate(browser: Browser) -> None:
    browser.click("Simulate", "button[role=tab]")
    browser.click("Simulate and ask", "button.primary")
    browser.wait_for(
        "[...document.images].filter(i => i.offsetParent && i.naturalWidth == 448).length >= 3"
    )
    time.sleep(1.0)


def _picture(browser: Browser, path: Path) -> None:
    """Write what is seen as a .png of 256 colours, a third of the size."""
    from PIL import Image

    browser.run("window.scrollTo(0, 0)")
    time.sleep(0.5)
    browser.screenshot(path)
    with Image.open(path) as seen:
        reduced = seen.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    reduced.save(path, optimize=True)


@contextmanager
def _served() -> Iterator[tuple[str, float, float]]:
    """Start the page in another process; give its address, when, and the seconds until a reply."""
    port = _free_port()
    began = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "geotlm_lm", "app", "--port", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    address = f"http://127.0.0.1:{port}/"
    try:
        while not _replies(address):
            if process.poll() is not None or time.perf_counter() - began > START_S:
                process.kill()
                said = (process.communicate()[1].strip().splitlines() or ["no reason"])[-1]
                raise GeoTLMError(f"The page did not start ({said}); run `geotlm-lm app` to see.")
            time.sleep(0.05)
        yield address, began, time.perf_counter() - began
    finally:
        process.terminate()
        process.communicate()


def _replies(address: str) -> bool:
    try:
        with urlopen(address, timeout=10) as reply:
            return reply.status == 200
    except (URLError, OSError):
        return False


def _free_port() -> int:
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        return listening.getsockname()[1]


def _timed(act: Callable[[], None]) -> float:
    began = time.perf_counter()
    act()
    return time.perf_counter() - began
