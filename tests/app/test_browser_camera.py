"""The page in a real browser with a camera: what it shows arrives as it is, and leaves no files."""

import os
import time
from itertools import dropwhile
from pathlib import Path

import numpy as np
import pytest

from app import live_tab, sessions
from tests.app.browser import NOTHING_SHOWN, STAGE, TEXT

pytestmark = pytest.mark.slow


def flags(folder):
    """A camera that shows white on the left, and no frame that is another."""
    grey = np.full((480, 640), 16, np.uint8)
    grey[:, :320] = 235
    colour = np.full((2, 240, 320), 128, np.uint8)
    with (folder / "camera.y4m").open("wb") as video:
        video.write(b"YUV4MPEG2 W640 H480 F25:1 Ip A1:1 C420jpeg\n")
        for number in range(50):
            grey[:32, :320] = 180 + number
            video.write(b"FRAME\n" + grey.tobytes() + colour.tobytes())
    file = f"--use-file-for-fake-video-capture={folder / 'camera.y4m'}"
    return ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream", file]


VIDEO = "document.querySelector('.live-camera video')"

STATES = "String(window.tracks.map((one) => one.readyState))"
"""Of the camera's tracks, as they were before everything was stopped."""

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
    browser.wait_for(f"/· [1-9][0-9]* frames/.test({TEXT})", seconds=60)


def test_what_is_left_in_the_camera_is_left_for_the_model(browser, monkeypatch):
    received, follow = [], live_tab.follow_camera

    def followed(answerer, frame, *kept):
        received.extend([] if frame is None else [frame])
        return follow(answerer, frame, *kept)

    monkeypatch.setattr(live_tab, "follow_camera", followed)
    start_camera(browser)
    browser.wait_for(f"/· [1-9][0-9] frames/.test({TEXT})", seconds=60)
    shown = browser.run(COLUMNS)
    assert shown[0] > 200 > 50 > shown[1]
    assert not browser.run(f"{STAGE}.querySelector('[data-part=live]').hidden")
    assert len(received) >= 10
    for frame in dropwhile(lambda frame: not frame.any(), received):
        left, right = np.split(frame.mean(axis=(0, 2)), 2)
        assert left.mean() > 200 > 50 > right.mean()


def test_the_camera_is_turned_off_with_everything_and_can_be_started_again(browser):
    for _ in range(2):
        start_camera(browser)
        browser.run(f"window.tracks = {VIDEO}.srcObject.getTracks(); 1")
        assert browser.run(f"{STATES} == 'live'")
        browser.click("Stop and clear")
        browser.wait_for(f"{STATES} == 'ended'", seconds=20)
        browser.wait_for(f"{TEXT}.includes('Click to Access Webcam')", seconds=20)
        assert not browser.run(f"Boolean({VIDEO} && {VIDEO}.srcObject)")


def test_a_camera_that_stalls_is_told(browser):
    start_camera(browser)
    browser.run(f"{VIDEO}.pause()")  # the last picture is sent over and over
    browser.wait_for(f"{TEXT}.includes('frames have been all the same for ')", seconds=30)
    browser.run("HTMLCanvasElement.prototype.toDataURL = () => { throw new Error('none'); }; 1")
    browser.wait_for(f"{TEXT}.includes('No picture has come for 3 s')", seconds=30)
    assert browser.run(f"{STAGE}.querySelector('[data-part=live]').hidden")


def test_a_camera_that_is_stopped_by_hand_is_not_called_stalled_and_can_be_cleared(browser):
    browser.click("Live", "button[role=tab]")
    assert "press Record" in browser.run(f"{STAGE}.innerText")
    browser.fill("Mark the moment", "it has turned 300 degrees")
    browser.click("Mark")
    start_camera(browser)
    browser.wait_for(f"{TEXT}.includes('Waiting for this: it turns by more than 300 degrees')")
    browser.click("Stop", ".live-camera button")
    browser.wait_for(f"{STAGE}.querySelector('[data-part=live]').hidden", seconds=30)
    assert "No picture has come" not in browser.run(TEXT)
    assert "Waiting for this" not in browser.run(TEXT)
    assert "Did not hold so far: it turns by more than 300 degrees" in browser.run(TEXT)
    browser.click("Stop and clear")
    browser.wait_for(f"{NOTHING_SHOWN} && !{TEXT}.includes('Did not hold')")


def files_in(page):
    folder = Path(page.GRADIO_CACHE)
    return [Path(home) / name for home, _, names in os.walk(folder) for name in names]


def test_an_upload_is_gone_when_its_page_was_closed(browser, page, recordings):
    browser.open_recording(recordings["dark"])
    assert [path.name for path in files_in(page)].count("dark.npy") == 1
    browser.call("Page.navigate", url="about:blank")
    until = time.monotonic() + 60
    while any(path.name == "dark.npy" for path in files_in(page)):
        assert time.monotonic() < until, "the upload is still there"
        time.sleep(0.1)


def test_live_pictures_do_not_pile_up(browser, page, monkeypatch):
    monkeypatch.setattr(sessions, "SHOWN_S", 0.5)
    before = len(files_in(page))
    start_camera(browser)
    browser.wait_for(f"/· [4-9][0-9] frames/.test({TEXT})", seconds=120)
    assert len(files_in(page)) - before < 15
