"""The tools over the Model Context Protocol, called by a real client of it."""

import asyncio
import base64
import json
import pickle
import sys
import zipfile
from http.client import HTTPConnection
from urllib.parse import urlsplit

import cv2
import numpy as np
import pytest

gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import agents, ui  # noqa: E402
from app.__main__ import serve  # noqa: E402
from geotlm_lm import __version__  # noqa: E402
from geotlm_lm.core.errors import MissingDependency  # noqa: E402
from tests.app.fakes import FakeAnswerer  # noqa: E402
from tests.track.recordings import there_and_back  # noqa: E402

MISSING = "--mcp needs the package mcp, which is not installed; run `pip install 'geotlm-lm[mcp]'`."
CAP = "example:bottle_cap_clockwise"
TOOLS = {"recordings", "ask", "track", "compare", "simulate", "evidence", "picture"}


def test_a_missing_package_is_told_before_the_model_is_loaded(monkeypatch):
    monkeypatch.setitem(sys.modules, "mcp", None)
    monkeypatch.setattr("geotlm_lm.Answerer.load", lambda: pytest.fail("it was loaded"))
    with pytest.raises(MissingDependency) as caught:
        serve(mcp=True)
    assert str(caught.value) == MISSING


def test_a_package_this_server_is_not_written_for_is_told(monkeypatch):
    pytest.importorskip("mcp", reason="serving agents needs mcp (extra: mcp)")
    monkeypatch.setattr(agents, "version", lambda _: "2.3.0")
    with pytest.raises(MissingDependency, match="below 2, found 2.3.0; run `pip install"):
        agents.require_mcp()


def clip(level):
    frames = np.full((6, 48, 64, 3), level, np.uint8)
    frames[3:, 20:30, 20:30] += 9
    return frames


def in_message(stored):
    return "data:;base64," + base64.b64encode(stored).decode()


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
def address(folder, uploads):
    pytest.importorskip("mcp", reason="serving agents needs mcp (extra: mcp)")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GRADIO_TEMP_DIR", str(uploads))
        page = ui.build(FakeAnswerer(), folder)
        yield ui.launch(page, mcp=True)
        page.close()


@pytest.fixture
def talk(address):
    """Return a function that hands a session to a conversation and returns what comes of it."""
    from mcp import ClientSession
    from mcp.client.streamable_http import streamable_http_client

    async def held(conversation):
        async with (
            streamable_http_client(f"{address}{agents.PATH}") as (read, write, _),
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


def test_the_server_tells_its_own_name_version_and_limits(talk):
    async def conversation(_, begun):
        return begun

    begun = talk(conversation)
    assert (begun.serverInfo.name, begun.serverInfo.version) == ("geotlm-lm", __version__)
    assert "2000 characters" in begun.instructions


def test_every_tool_is_typed_bounded_and_described_on_both_sides(talk):
    async def conversation(session, _):
        return (await session.list_tools()).tools

    tools = {tool.name: tool for tool in talk(conversation)}
    assert set(tools) == TOOLS
    for tool in tools.values():
        assert tool.inputSchema["additionalProperties"] is False
        assert all(one["description"] for one in tool.inputSchema["properties"].values())
        assert tool.outputSchema["required"]
    asked = tools["ask"].inputSchema
    assert asked["required"] == ["recording", "question"]
    assert asked["properties"]["question"]["maxLength"] == 2000
    assert asked["properties"]["turned"]["enum"] == [0, 90, 180, 270]


def test_an_agent_lists_recordings_tracks_one_asks_three_questions_and_looks(talk):
    async def conversation(session, _):
        async def use(tool, **given):
            return await session.call_tool(tool, given)

        listed = (await use("recordings")).structuredContent
        (name, *_) = (one["name"] for one in listed["recordings"] if one["kind"] == "npz")
        track = (await use("track", recording=name)).structuredContent
        questions = ("Which way does it go?", "How far did it go?", "What is the direction?")
        answers = [await use("ask", recording=name, question=one) for one in questions]
        pictures = [
            await use("picture", recording=name, shows=one) for one in ("overlay", "timeline")
        ]
        return listed, track, [one.structuredContent for one in answers], pictures

    listed, track, answers, pictures = talk(conversation)
    assert [one["name"] for one in listed["recordings"]] == ["turn.npz", "day 1/dark.npy"]
    assert CAP in listed["examples"]
    (turn, back) = (one for one in track["events"] if one["event"] == "turn")
    assert (turn["way"], back["way"]) == ("clockwise", "counterclockwise")
    assert turn["low"] < 30 < turn["high"]
    assert track["totals"]["turn_in_all"]["amount"] > abs(track["totals"]["turn_net"]["amount"])
    assert (track["rows"], track["recording"]) == ([], "turn.npz")
    assert all(one["direction"] in ("left", "right") for one in answers[:1])
    for result in pictures:
        told, image = result.content
        assert json.loads(told.text) == result.structuredContent
        drawn = cv2.imdecode(
            np.frombuffer(base64.b64decode(image.data), np.uint8), cv2.IMREAD_COLOR
        )
        assert drawn.shape[:2] == tuple(
            result.structuredContent[side] for side in ("height_px", "width_px")
        )


def test_frames_facts_and_the_size_of_a_pixel_hold_for_the_answer(use):
    way = {"recording": CAP, "question": "Which way does it go?"}
    plain, behind, sized = use(
        ("ask", way),
        ("ask", way | {"viewpoint": "object", "frames": [0, 2]}),
        ("ask", way | {"mm_per_px": 0.1}),
    )
    told = [one.structuredContent["direction"] for one in (plain, behind)]
    assert sorted(told) == ["left", "right"]
    assert behind.structuredContent["frames_used"][-1] <= 2
    assert sized.structuredContent["frame"]["mm_per_px"] == 0.1
    assert sized.structuredContent["amount"]["unit"] == "mm"


def test_rows_of_a_track_are_told_where_they_are_asked_for_and_no_more(use):
    (told,) = use(("track", {"recording": "turn.npz", "rows": 10, "frames": [10, 60]}))
    rows = told.structuredContent["rows"]
    assert (len(rows), rows[0]["frame"], rows[-1]["frame"]) == (10, 10, 60)


def test_two_recordings_are_compared_and_a_touch_is_simulated(use, tmp_path):
    np.save(tmp_path / "bright.npy", clip(150))
    sent = in_message((tmp_path / "bright.npy").read_bytes())
    compared, simulated, evidence = use(
        ("compare", {"first": sent, "second": "day 1/dark.npy"}),
        ("simulate", {"object_name": "key", "slide_x_mm": 1.0, "seed": 1}),
        ("evidence", {"recording": sent}),
    )
    assert compared.structuredContent["relation"] == "opposite"
    assert simulated.structuredContent["true_motion"] == "right"
    assert np.shape(evidence.structuredContent["contact_mask"]) == (14, 14)


UNKNOWN = "There is no recording "
NEITHER = "The recording is neither a name nor a data URI nor an upload; "


@pytest.mark.parametrize(
    ("recording", "begins"),
    [
        ("../private.npy", UNKNOWN),
        ("day 1/../../private.npy", UNKNOWN),
        ("./turn.npz", UNKNOWN),
        ("link.npy", UNKNOWN),
        ("up/private.npy", UNKNOWN),
        ("up/recordings/turn.npz", UNKNOWN),
        ("day 1", UNKNOWN),
        ("turn.npz\0.npy", UNKNOWN),
        ("..\\private.npy", UNKNOWN),
        ("~/private.npy", UNKNOWN),
        ("/etc/passwd", NEITHER),
        ("file:///etc/passwd", NEITHER),
        ("http://127.0.0.1:9/clip.npz", NEITHER),
        ("x" * 5000, NEITHER),
        ("example:../private", "There is no example "),
        ("data:,plain", "The clip's data URI is not in base64; "),
        ("data:;base64,UEsD*", "The clip's data URI is cut off or no base64; "),
        ("", "evidence: recording was ''"),
        (7, "evidence: recording was 7, and input should be a valid string; "),
        (
            ["turn.npz"],
            "evidence: recording was ['turn.npz'], and input should be a valid string; ",
        ),
        (None, "evidence: recording was None, and input should be a valid string; "),
    ],
    ids=lambda one: repr(one)[:30],
)
def test_what_is_no_recording_of_ours_is_refused_in_one_sentence(use, recording, begins):
    (told,) = use(("evidence", {"recording": recording}))
    assert_refused(told, begins)


def test_the_folders_own_path_is_no_name(use, folder):
    (told,) = use(("evidence", {"recording": str(folder / "turn.npz")}))
    assert_refused(told, NEITHER)


def assert_refused(told, begins):
    (part,) = told.content
    assert told.isError
    assert part.text.startswith(begins)
    assert "\n" not in part.text
    assert "Traceback" not in part.text


class Planted:
    def __reduce__(self):
        return pytest.fail, ("a pickle was opened",)


def bomb(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        header = b"{'descr': '|u1', 'fortran_order': False, 'shape': (900000, 900, 900, 3), }"
        header = header.ljust(117) + b"\n"
        lead = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little")
        archive.writestr("frames.npy", lead + header + bytes(10**6))


def test_pickles_and_bombs_are_refused_in_one_sentence(use, tmp_path):
    np.save(tmp_path / "object.npy", np.array([Planted()], dtype=object), allow_pickle=True)
    (tmp_path / "plain.pkl").write_bytes(pickle.dumps(Planted()))
    bomb(tmp_path / "bomb.npz")
    for name in ("object.npy", "plain.pkl", "bomb.npz"):
        (told,) = use(("evidence", {"recording": in_message((tmp_path / name).read_bytes())}))
        assert_refused(told, "clip")


def test_a_message_longer_than_two_recordings_is_refused_unread(address):
    connection = HTTPConnection(urlsplit(address).netloc, timeout=30)
    connection.putrequest("POST", f"/{agents.PATH}")
    connection.putheader("Content-Type", "application/json")
    connection.putheader("Accept", "application/json, text/event-stream")
    connection.putheader("Content-Length", str(10**10))
    connection.endheaders()
    assert connection.getresponse().status == 413
    connection.close()


@pytest.mark.parametrize(
    ("tool", "given", "begins"),
    [
        (
            "ask",
            {"question": "Which way?"},
            "ask: recording is missing; give recording and question.",
        ),
        ("ask", {"recording": CAP, "question": "x" * 2001}, "ask: question was 'xxx"),
        ("ask", {"recording": CAP, "question": " "}, "The question is empty; "),
        ("ask", {"clip": CAP}, "ask: recording is missing; "),
        (
            "evidence",
            {"recording": CAP, "path": "x"},
            "evidence: there is no parameter 'path'; it takes recording, frames.",
        ),
        ("evidence", {"recording": CAP, "frames": [0]}, "evidence: frames was [0], and "),
        ("evidence", {"recording": CAP, "frames": [0, "b"]}, "evidence: frames.1 was 'b', and "),
        ("evidence", {"recording": CAP, "frames": [0, 99]}, "Frames 0:99 were "),
        ("track", {"recording": "turn.npz", "frames": [900, 950]}, "Frames 900:950 were "),
        ("track", {"recording": CAP, "rows": 501}, "track: rows was 501, and "),
        ("track", {"recording": CAP, "turned": 45}, "track: turned was 45, and "),
        ("ask", {"recording": CAP, "question": "a", "mm_per_px": -1}, "ask: mm_per_px was -1, "),
        ("picture", {"recording": CAP, "shows": "all"}, "picture: shows was 'all', and "),
        ("simulate", {"object_name": "unicorn"}, "There is no shape 'unicorn'"),
        ("simulate", {"twist_deg": 1e9}, "simulate: twist_deg was 1000000000.0, and "),
        ("simulate", {"seed": 0.5}, "simulate: seed was 0.5, and "),
        ("nothing", {}, "There is no tool 'nothing'; "),
    ],
    ids=lambda one: repr(one)[:30],
)
def test_a_wrong_call_is_told_in_one_sentence(use, tool, given, begins):
    (told,) = use((tool, given))
    assert_refused(told, begins)


def test_nothing_that_came_inside_a_message_is_left_on_disk(use, uploads, tmp_path):
    np.save(tmp_path / "clip.npy", clip(90))
    sent = in_message((tmp_path / "clip.npy").read_bytes())
    use(("evidence", {"recording": sent}), ("evidence", {"recording": sent[:-4000]}))
    assert list(uploads.rglob("message-*")) == []
    assert list(uploads.rglob("*.npy")) == []
