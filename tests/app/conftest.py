"""The page served with a stand-in for the model, a browser at it, and recordings to give it."""

import asyncio
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from tests.app.fakes import FakeAnswerer, clip
from tests.track.recordings import there_and_back
from tests.track.test_idle_tracker import gel, touched

HERE = Path(__file__).parent

collect_ignore_glob = [] if find_spec("gradio") else ["test_*.py"]
"""Without the toolkit (extra: app) there is no page to be tested."""


def pytest_collection_modifyitems(items):
    """Mark the tests of this folder, which need the page's extras."""
    for item in items:
        if item.path.parent == HERE:
            item.add_marker("page")


@pytest.fixture(scope="module")
def fake():
    return FakeAnswerer()


@pytest.fixture(scope="module")
def page(fake, tmp_path_factory):
    """The page, served with a folder of its own for what is uploaded."""
    from app import ui

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GRADIO_TEMP_DIR", str(tmp_path_factory.mktemp("uploads")))
        page = ui.build(fake)
        page.address = ui.launch(page)
        yield page
        page.close()


@pytest.fixture(scope="module")
def address(page):
    return page.address


@pytest.fixture(scope="module")
def chromium(request, tmp_path_factory):
    """One browser for all tests of a module, which may state FLAGS for it."""
    from tests.app.browser import EXECUTABLE, Browser

    if EXECUTABLE is None:
        pytest.skip("needs a Chromium (Debian: apt-get install chromium)")
    flags = getattr(request.module, "flags", lambda folder: ())(tmp_path_factory.mktemp("flags"))
    browser = Browser(tmp_path_factory.mktemp("profile"), flags=flags)
    yield browser
    browser.close()


@pytest.fixture
def empty(request, chromium):
    """The browser with nothing open, as wide as a desk's unless a test gives another size."""
    chromium.renew(getattr(request, "param", (1400, 1100)))
    return chromium


@pytest.fixture
def browser(empty, address):
    """The browser at the page."""
    empty.open(address)
    return empty


@pytest.fixture
def path(tmp_path):
    np.save(tmp_path / "clip.npy", clip(90))
    return str(tmp_path / "clip.npy")


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


@pytest.fixture(scope="session")
def frames():
    """A gel that is touched after half a second of 25 frames a second."""
    plain = gel()
    return [next(plain) for _ in range(12)] + [touched(next(plain)) for _ in range(28)]


@pytest.fixture
def touch_path(frames, tmp_path):
    np.savez(tmp_path / "touch.npz", frames=np.stack(frames), fps=25.0)
    return tmp_path / "touch.npz"


@pytest.fixture
def long_recording(tmp_path):
    """A touch that comes and goes, watched for a good many seconds."""
    plain = gel()
    frames = [next(plain) for _ in range(12)]
    for _ in range(40):
        frames += [touched(next(plain)) for _ in range(20)] + [next(plain) for _ in range(15)]
    np.savez(tmp_path / "long.npz", frames=np.stack(frames), fps=25.0)
    return tmp_path / "long.npz"


@pytest.fixture
def bag(tmp_path):
    """A bag with two cameras: what is left of them goes right for the stand-in, the other left."""
    bags = pytest.importorskip("tests.recordings.bag_files", reason="needs the extra ros")
    topics = {
        f"/{side}": [bags.raw(*one) for one in zip(clip(level)[:4], bags.even_ns(4), strict=True)]
        for side, level in (("left", 150), ("right", 60))
    }
    (path,) = bags.write_bag(tmp_path / "run", topics).glob("*.mcap")
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Recordings, one of them long, and what tries to lead out of the folder."""
    home = tmp_path_factory.mktemp("home")
    served = home / "recordings"
    (served / "day 1").mkdir(parents=True)
    whole = there_and_back()
    np.savez(served / "turn.npz", frames=whole.frames, fps=whole.fps)
    np.save(served / "day 1" / "dark.npy", clip(60))
    np.save(home / "private.npy", clip(150))
    (served / "link.npy").symlink_to(home / "private.npy")
    (served / "up").symlink_to(home)
    return served


@pytest.fixture(scope="module")
def uploads(tmp_path_factory):
    return tmp_path_factory.mktemp("uploads")


@pytest.fixture(scope="module")
def agents_address(folder, uploads):
    pytest.importorskip("mcp", reason="serving agents needs mcp (extra: mcp)")
    from app import ui

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GRADIO_TEMP_DIR", str(uploads))
        page = ui.build(FakeAnswerer(), folder)
        yield ui.launch(page, mcp=True)
        page.close()


@pytest.fixture
def talk(agents_address):
    """Return a function that hands a session to a conversation and returns what comes of it."""
    from mcp import ClientSession
    from mcp.client.streamable_http import streamable_http_client

    from app import ui

    async def held(conversation):
        async with (
            streamable_http_client(f"{agents_address}{ui.PATH}") as (read, write, _),
            ClientSession(read, write) as session,
        ):
            return await conversation(session, await session.initialize())

    return lambda conversation: asyncio.run(held(conversation))


@pytest.fixture
def use(talk):
    """Return a function that calls tools in one session and returns their results."""

    def called(*calls):
        async def conversation(session, _):
            return [await session.call_tool(name, given) for name, given in calls]

        return talk(conversation)

    return called
