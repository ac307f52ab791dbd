"""The page in a real browser with a camera: what the camera shows arrives as it shows it."""

import numpy as np
import pytest

pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import live_tab, ui  # noqa: E402
from tests.app.browser import EXECUTABLE, Browser  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402

ROWS, COLUMNS = 480, 640


def test_the_camera_is_not_mirrored():
    page = ui.build(FakeAnswerer())
    (camera,) = (one for one in page.blocks.values() if getattr(one, "streaming", False))
    assert camera.sources == ["webcam"]
    assert camera.get_config()["webcam_options"]["mirror"] is False


def white_on_the_left(path):
    """Write an uncompressed video, which the browser plays as its camera: no frame is another."""
    grey = np.full((ROWS, COLUMNS), 16, np.uint8)
    grey[:, : COLUMNS // 2] = 235
    colour = np.full((2, ROWS // 2, COLUMNS // 2), 128, np.uint8)
    with path.open("wb") as video:
        video.write(f"YUV4MPEG2 W{COLUMNS} H{ROWS} F25:1 Ip A1:1 C420jpeg\n".encode())
        for number in range(50):
            grey[:32, : COLUMNS // 2] = 180 + number
            video.write(b"FRAME\n" + grey.tobytes() + colour.tobytes())
    return path


@pytest.fixture
def browser(tmp_path):
    video = white_on_the_left(tmp_path / "camera.y4m")
    flags = ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"]
    flags.append(f"--use-file-for-fake-video-capture={video}")
    browser = Browser(tmp_path / "profile", flags=flags)
    yield browser
    browser.close()


@pytest.mark.skipif(EXECUTABLE is None, reason="needs a Chromium (Debian: apt install chromium)")
def test_what_is_left_in_the_camera_is_left_for_the_model(browser, monkeypatch):
    received, follow = [], live_tab.process_frame

    def followed(answerer, frame, *kept):
        received.extend([] if frame is None else [frame])
        return follow(answerer, frame, *kept)

    monkeypatch.setattr(live_tab, "process_frame", followed)
    page = ui.build(FakeAnswerer())
    try:
        browser.open(ui.launch(page))
        start_camera(browser)
        browser.wait_for(f"/· [1-9][0-9] frames/.test({TEXT})", seconds=60)
    finally:
        page.close()
    assert len(received) >= 10
    for frame in received:
        left, right = np.split(frame.mean(axis=(0, 2)), 2)
        assert left.mean() > 200 > 50 > right.mean()


TEXT = "document.body.innerText"


def start_camera(browser):
    """Show the Live tab and let its camera run."""
    browser.click("Live", "button[role=tab]")
    browser.click("Click to Access Webcam")
    browser.click("Record")
