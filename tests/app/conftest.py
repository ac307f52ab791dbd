"""The page served with a stand-in for the model, a browser at it, and recordings to give it."""

from contextlib import ExitStack

import numpy as np
import pytest

from tests.app.fakes import FakeAnswerer


@pytest.fixture(scope="module")
def address():
    from app import ui

    page = ui.build(FakeAnswerer())
    yield ui.launch(page)
    page.close()


@pytest.fixture
def new_browser(tmp_path_factory):
    """Open a browser, of a size or with more flags; each is closed after the test."""
    from tests.app.browser import EXECUTABLE, Browser

    if EXECUTABLE is None:
        pytest.skip("needs a Chromium (Debian: apt-get install chromium)")
    with ExitStack() as opened:

        def start(*size, flags=()):
            browser = Browser(tmp_path_factory.mktemp("profile"), *size, flags=flags)
            opened.callback(browser.close)
            return browser

        yield start


@pytest.fixture
def browser(request, new_browser, address):
    """A browser at the page, as wide as a desk's unless a test gives another size."""
    browser = new_browser(getattr(request, "param", (1400, 1100)))
    browser.open(address)
    return browser


@pytest.fixture
def camera_browser(new_browser, tmp_path):
    """A browser whose camera shows white on the left, and no frame that is another."""
    grey = np.full((480, 640), 16, np.uint8)
    grey[:, :320] = 235
    colour = np.full((2, 240, 320), 128, np.uint8)
    with (tmp_path / "camera.y4m").open("wb") as video:
        video.write(b"YUV4MPEG2 W640 H480 F25:1 Ip A1:1 C420jpeg\n")
        for number in range(50):
            grey[:32, :320] = 180 + number
            video.write(b"FRAME\n" + grey.tobytes() + colour.tobytes())
    flags = ["--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"]
    flags.append(f"--use-file-for-fake-video-capture={tmp_path / 'camera.y4m'}")
    return new_browser(flags=flags)


@pytest.fixture
def recordings(tmp_path):
    """A bright clip, which the stand-in tells as going right, and a dark one, going left."""
    paths = {}
    for name, level in (("bright", 150), ("dark", 60)):
        paths[name] = tmp_path / f"{name}.npy"
        frames = np.full((4, 48, 64, 3), level, np.uint8)
        frames[1:, 10:30, 10:30] += 20
        np.save(paths[name], frames)
    return paths
