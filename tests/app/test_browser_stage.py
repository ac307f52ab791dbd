"""The stage in a real browser: it plays, is scrubbed by hand and by keys, and fits the screen."""

import shutil
import time

import numpy as np
import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from tests.app.browser import NAME, SHOWN  # noqa: E402
from tests.app.test_browser import ask_until  # noqa: E402
from tests.track.test_idle_tracker import gel, touched  # noqa: E402

TEXT = "document.body.innerText"
FRAME = "document.querySelector('.stage [data-part=scrub]').valueAsNumber"
CANVAS = "document.querySelector('.stage canvas').toDataURL()"
PARTS = (".stage-screen", ".stage-time", ".chat", ".chips", ".question")


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A recording whose gel is touched after half a second."""
    plain, path = gel(), tmp_path_factory.mktemp("recording") / "touch.npz"
    frames = [next(plain) for _ in range(12)] + [touched(next(plain)) for _ in range(28)]
    np.savez(path, frames=np.stack(frames), fps=25.0)
    return path


def box(browser, selector):
    script = f"document.querySelector({selector!r}).getBoundingClientRect().toJSON()"
    return browser.run(script)


def click_at(browser, x, y):
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
    for kind in ("mousePressed", "mouseReleased"):
        browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)


@pytest.mark.parametrize("browser", [(1400, 900)], indirect=True)
def test_an_example_plays_on_load_and_all_is_seen_without_scrolling(browser):
    assert browser.run(f"{NAME}.innerText") == "bottle cap"
    before = browser.run(FRAME)
    browser.wait_for(f"{FRAME} != {before}")
    assert browser.run("window.innerHeight") <= 900
    for part in PARTS:
        assert box(browser, part)["bottom"] <= browser.run("window.innerHeight"), part
    assert "clockwise" not in browser.run("document.querySelector('.examples').innerText")


@pytest.mark.parametrize("browser", [(500, 844)], indirect=True)
def test_on_a_phone_the_picture_comes_first_and_the_question_within_a_screen_and_a_half(browser):
    metrics = {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True}
    browser.call("Emulation.setDeviceMetricsOverride", **metrics)
    browser.wait_for("document.querySelector('.stage-screen').clientWidth < 390")
    places = [box(browser, part) for part in (".stage-screen", ".stage-time", ".chat", ".question")]
    tops = [one["top"] for one in places]
    assert tops == sorted(tops)
    assert places[-1]["bottom"] < 1.5 * 844
    last = "[...document.querySelectorAll('.ask-line button')].find(e => e.innerText == 'Retry')"
    assert browser.run(f"{last}.getBoundingClientRect().right") <= 390
    assert browser.run("document.documentElement.scrollWidth") <= 390


def test_the_picture_is_played_and_scrubbed_by_keys(browser):
    browser.run("document.querySelector('.stage [data-part=scrub]').focus()")
    browser.press("Home", 36)
    assert browser.run(FRAME) == 0
    browser.press("ArrowRight", 39)
    browser.press("ArrowRight", 39)
    assert browser.run(FRAME) == 2
    browser.press("ArrowLeft", 37)
    assert browser.run(FRAME) == 1
    time.sleep(0.6)
    assert browser.run(FRAME) == 1  # it stands
    browser.press(" ", 32)
    browser.wait_for(f"{FRAME} != 1")


def test_what_lies_over_the_picture_is_switched(browser):
    browser.run("document.querySelector('.stage [data-part=scrub]').focus()")
    browser.press("End", 35)
    seen = {browser.run(CANVAS)}
    for layer in ("Arrows", "Contact", "Difference"):
        browser.click(layer, ".stage-layers button")
        seen.add(browser.run(CANVAS))
    assert len(seen) == 4


def test_a_click_on_the_timeline_shows_that_moment(browser, recording):
    browser.upload("Recording", recording)
    browser.wait_for(f"{SHOWN} && {NAME}.innerText == 'touch.npz'")
    line = box(browser, ".stage-time svg")
    browser.run("document.querySelector('.stage [data-part=play]').click()")
    for share in (0.3, 0.8):
        click_at(browser, line["left"] + 46 + share * (line["width"] - 56), line["top"] + 60)
        assert browser.run(FRAME) == pytest.approx(share * 39, abs=1)
    clock = browser.run("document.querySelector('.stage [data-part=clock]').innerText")
    assert 1.1 < float(clock.removesuffix(" s")) < 1.4
    told = browser.run("document.querySelector('.stage-tip').innerText")
    assert "turn 0" in told
    assert "contact 100 %" in told
    assert "When did it stop?" in browser.run("document.querySelector('.chips').innerText")


def test_a_link_opens_its_example_and_asks_its_question(new_browser, address):
    browser = new_browser((1400, 900))
    browser.open(f"{address}?example=coin&q=Which%20way%20does%20it%20go%3F")
    assert browser.run(f"{NAME}.innerText") == "coin"
    browser.wait_for(f"{TEXT}.includes('It slides ')")
    browser.click("Copy this as code", "button")
    browser.wait_for(f"{TEXT}.includes('geotlm-lm answer --clip app/examples/coin_press.npz')")


@pytest.mark.parametrize("name", ["no_such", "../../etc/passwd", "<img src=x>"])
def test_a_link_to_what_is_no_example_opens_the_first_one(new_browser, address, name):
    browser = new_browser((1400, 900))
    browser.open(f"{address}?example={name}")
    assert browser.run(f"{NAME}.innerText") == "bottle cap"


def test_a_recordings_name_is_shown_and_never_run(browser, recordings, tmp_path):
    name = "${document.title='run'} {{value}} <b>x<b>.npy"
    shutil.copy(recordings["dark"], tmp_path / name)
    browser.upload("Recording", tmp_path / name)
    browser.wait_for(f"{SHOWN} && {NAME}.innerText.includes('.npy')")
    assert browser.run("document.title") != "run"
    assert browser.run(f"{NAME}.children.length") == 0


def test_a_mistake_stands_beside_the_field_and_the_conversation_stays(browser):
    browser.fill("Question", "Which way does it go?")
    browser.click("Ask", "button.primary")
    browser.wait_for(f"{TEXT}.includes('It slides ')")
    ask_until(browser, "document.querySelector('.complaint').innerText.trim().length > 10", " ")
    assert "It slides " in browser.run("document.querySelector('.chat').innerText")
    below = box(browser, ".complaint")["top"] - box(browser, ".question")["bottom"]
    assert 0 <= below < 60
