"""The page in a real browser with a camera: what the camera shows arrives as it shows it."""

import numpy as np
import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import live_tab, ui  # noqa: E402
from tests.app.browser import STAGE  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402


def test_the_camera_is_not_mirrored():
    page = ui.build(FakeAnswerer())
    (camera,) = (one for one in page.blocks.values() if getattr(one, "streaming", False))
    assert camera.sources == ["webcam"]
    assert camera.get_config()["webcam_options"]["mirror"] is False


def test_what_is_left_in_the_camera_is_left_for_the_model(camera_browser, monkeypatch):
    browser = camera_browser
    received, follow = [], live_tab.follow_camera

    def followed(answerer, frame, *kept):
        received.extend([] if frame is None else [frame])
        return follow(answerer, frame, *kept)

    monkeypatch.setattr(live_tab, "follow_camera", followed)
    page = ui.build(FakeAnswerer())
    try:
        browser.open(ui.launch(page))
        start_camera(browser)
        browser.wait_for(f"/· [1-9][0-9] frames/.test({TEXT})", seconds=60)
        shown = browser.run(COLUMNS)
        assert shown[0] > 200 > 50 > shown[1]
        assert not browser.run(f"{STAGE}.querySelector('[data-part=live]').hidden")
    finally:
        page.close()
    assert len(received) >= 10
    for frame in received:
        left, right = np.split(frame.mean(axis=(0, 2)), 2)
        assert left.mean() > 200 > 50 > right.mean()


def test_the_camera_is_turned_off_with_everything_and_can_be_started_again(camera_browser):
    browser, page = camera_browser, ui.build(FakeAnswerer())
    try:
        browser.open(ui.launch(page))
        for _ in range(2):
            start_camera(browser)
            browser.wait_for(f"/· [1-9][0-9]* frames/.test({TEXT})", seconds=60)
            browser.run(f"window.tracks = {VIDEO}.srcObject.getTracks(); 1")
            assert browser.run(f"{STATES} == 'live'")
            browser.click("Stop and clear")
            browser.wait_for(f"{STATES} == 'ended'", seconds=20)
            browser.wait_for(f"{TEXT}.includes('Click to Access Webcam')", seconds=20)
            assert not browser.run(f"Boolean({VIDEO} && {VIDEO}.srcObject)")
    finally:
        page.close()


def test_a_camera_that_stalls_is_told(camera_browser):
    browser, page = camera_browser, ui.build(FakeAnswerer())
    try:
        browser.open(ui.launch(page))
        start_camera(browser)
        browser.wait_for(f"/· [1-9][0-9]* frames/.test({TEXT})", seconds=60)
        browser.run(f"{VIDEO}.pause()")  # the last picture is sent over and over
        browser.wait_for(f"{TEXT}.includes('frames have been all the same for ')", seconds=30)
        browser.run("HTMLCanvasElement.prototype.toDataURL = () => { throw new Error('none'); }; 1")
        browser.wait_for(f"{TEXT}.includes('No picture has come for 3 s')", seconds=30)
        assert browser.run(f"{STAGE}.querySelector('[data-part=live]').hidden")
    finally:
        page.close()


VIDEO = "document.querySelector('.live-camera video')"

STATES = "String(window.tracks.map((one) => one.readyState))"
"""Of the camera's tracks, as they were before everything was stopped."""

TEXT = "document.body.innerText"
COLUMNS = (
    f"(() => {{ const seen = {STAGE}.querySelector('canvas'), at = (x) => seen.getContext('2d')"
    ".getImageData(x * seen.width, seen.height / 2, 1, 1).data[0]; return [at(0.25), at(0.9)]; })()"
)
"""Grey levels on the left and on the right of the stage."""


def start_camera(browser):
    """Show the Live tab and let its camera run."""
    browser.click("Live", "button[role=tab]")
    browser.click("Click to Access Webcam")
    browser.click("Record")
