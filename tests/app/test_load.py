"""Many visitors at once: none holds up another, each gets its own answers, in its own order."""

import time
from threading import Event

import numpy as np
import pytest

gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from gradio_client import Client, handle_file  # noqa: E402

from app import ui  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402


class Slow(FakeAnswerer):
    """Takes as long as it is made to over a recording that is not dark, and lets others in."""

    def __init__(self):
        super().__init__()
        self.began, self.may_end = Event(), Event()

    def encode(self, clip, *, progress, **named):
        if clip.frames.mean() > 100:
            self.began.set()
            while not self.may_end.is_set():
                progress("tracking", 1, 2)
                time.sleep(0.005)
        return super().encode(clip, progress=progress, **named)


@pytest.fixture(scope="module")
def slow():
    return Slow()


@pytest.fixture(scope="module")
def address(slow):
    page = ui.build(slow)
    yield ui.launch(page)
    slow.may_end.set()
    page.close()


def saved(path, level):
    frames = np.full((6, 48, 64, 3), level, np.uint8)
    frames[3:, 20:30, 20:30] += 9
    np.save(path, frames)
    return handle_file(path)


def test_a_long_recording_holds_up_its_own_visitor_and_nobody_else(address, slow, tmp_path):
    bright, dark = saved(tmp_path / "bright.npy", 150), saved(tmp_path / "dark.npy", 60)
    mine, other = (Client(address, verbose=False) for _ in range(2))
    long = mine.submit(bright, "Which way does it go?", api_name="/ask")
    assert slow.began.wait(60)
    next_of_mine = mine.submit(dark, "Which way does it go?", api_name="/ask")
    told = [other.predict(dark, "Which way does it go?", api_name="/ask") for _ in range(3)]
    assert {one["direction"] for one in told} == {"left"}
    assert not long.done()
    assert not next_of_mine.done()
    slow.may_end.set()
    assert long.result(60)["direction"] == "right"
    assert next_of_mine.result(60)["direction"] == "left"
