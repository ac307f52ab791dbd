"""The page served with a stand-in for the model, a browser at it, and recordings to give it."""

import numpy as np
import pytest

from tests.app.fakes import FakeAnswerer


@pytest.fixture(scope="module")
def address():
    from app import ui

    page = ui.build(FakeAnswerer())
    yield ui.launch(page)
    page.close()


@pytest.fixture(params=[(1400, 1100), (390, 844)], ids=["wide", "phone"])
def browser(request, tmp_path, address):
    from tests.app.browser import Browser

    browser = Browser(tmp_path / "profile", request.param)
    browser.open(address)
    yield browser
    browser.close()


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
