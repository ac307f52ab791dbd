"""The page on a phone, used by fingers alone; and lengths told in mm as soon as they can be."""

import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from tests.app.browser import NAME, SHOWN, STAGE  # noqa: E402
from tests.app.test_browser_stage import FRAME, TEXT, box, recording  # noqa: E402, F401


@pytest.fixture
def phone(new_browser, address):
    """A browser as wide as a phone's that tells of fingers and not of a mouse."""
    browser = new_browser((500, 844))
    metrics = {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True}
    browser.call("Emulation.setDeviceMetricsOverride", **metrics)
    browser.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=1)
    browser.open(address)
    assert browser.run("navigator.maxTouchPoints") == 1
    return browser


def touch(browser, *places):
    """Put a finger down at the first place, move it over the others, and lift it."""
    for kind, (x, y) in zip(["touchStart"] + ["touchMove"] * len(places), places, strict=False):
        browser.call("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y}])
    browser.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])


def tap(browser, kind, text):
    """Tap the middle of the first element that is seen of a kind and holds a text."""
    find = (
        f"[...document.querySelectorAll({kind!r})].find("
        f"one => one.offsetParent && one.innerText.includes({text!r}))"
    )
    browser.wait_for(f"Boolean({find})")
    browser.run(f"{find}.scrollIntoView({{block: 'center', inline: 'center'}})")
    place = browser.run(f"{find}.getBoundingClientRect().toJSON()")
    touch(browser, (place["x"] + place["width"] / 2, place["y"] + place["height"] / 2))


def test_a_finger_opens_an_example_asks_and_scrubs(phone, recording):  # noqa: F811
    tap(phone, "button.example", "bead")
    phone.wait_for(f"{SHOWN} && {NAME}.innerText == 'bead'")
    tap(phone, ".chips button", "Which way is it moving?")
    phone.wait_for(f"{TEXT}.includes('% sure)')")
    phone.upload("Recording", recording)
    phone.wait_for(f"{SHOWN} && {NAME}.innerText == 'touch.npz'")
    phone.run(f"{STAGE}.scrollIntoView(); {STAGE}.querySelector('[data-part=play]').click()")
    line = box(phone, ".stage-time svg")
    places = [line["left"] + 46 + share * (line["width"] - 56) for share in (0.2, 0.4, 0.6, 0.75)]
    touch(phone, *((x, line["top"] + 60) for x in places))
    assert phone.run(FRAME) == pytest.approx(0.75 * 39, abs=1)


def test_a_pixels_size_that_is_given_afterwards_redraws_the_timeline_in_mm(
    browser,
    recording,  # noqa: F811
):
    browser.upload("Recording", recording)
    browser.wait_for(f"{SHOWN} && {NAME}.innerText == 'touch.npz'")
    browser.click("Frame of reference", "button")
    panel = f"{STAGE}.querySelector('.stage-time').textContent"
    assert "travel in px" in browser.run(panel)
    field = (
        "[...document.querySelectorAll('label')].find(one => one.offsetParent && "
        "one.innerText.startsWith('Millimetres')).querySelector('input')"
    )
    for size, unit in (("0.05", "mm"), ("0", "px")):
        browser.run(f"{field}.focus()")
        browser.fill("Millimetres per pixel", size)
        browser.run(f"{field}.blur()")
        browser.wait_for(f"{panel}.includes('travel in {unit}')", seconds=60)
    browser.run(f"{field}.focus()")
    browser.fill("Millimetres per pixel", "60")
    browser.run(f"{field}.blur()")
    browser.wait_for(f"{TEXT}.includes('A pixel of 60 mm was given, expected')", seconds=60)
