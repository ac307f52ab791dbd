"""The page served with a stand-in for the model, a browser at it, and recordings to give it."""

import asyncio
from contextlib import ExitStack

import numpy as np
import pytest

from tests.app.agent_calls import clip
from tests.app.fakes import FakeAnswerer
from tests.track.recordings import there_and_back
from tests.track.test_idle_tracker import gel, touched


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
        f"/{side}": [bags.raw(*one) for one in zip(clip(level), bags.even_ns(6), strict=True)]
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

    from app import agents

    async def held(conversation):
        async with (
            streamable_http_client(f"{agents_address}{agents.PATH}") as (read, write, _),
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
