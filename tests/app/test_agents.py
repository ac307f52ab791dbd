"""The tools over the Model Context Protocol, called by a real client of it; and what it refuses."""

import base64
import json
import pickle
import sys
import zipfile

import cv2
import numpy as np
import pytest

gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from app import tools  # noqa: E402
from app.__main__ import serve  # noqa: E402
from geotlm_lm import __version__  # noqa: E402
from geotlm_lm.core.errors import MissingDependency  # noqa: E402
from tests.app.fakes import CAP, clip, in_message  # noqa: E402

TOOLS = {"recordings", "ask", "track", "wait_until", "compare", "simulate"} | {
    "evidence",
    "picture",
}


def assert_refused(answer, begins):
    (part,) = answer.content
    assert answer.isError
    assert part.text.startswith(begins)
    assert "\n" not in part.text
    assert "Traceback" not in part.text


def test_every_tool_is_typed_bounded_and_described_on_both_sides(talk):
    async def conversation(session, begun):
        return begun, (await session.list_tools()).tools

    begun, listed = talk(conversation)
    assert (begun.serverInfo.name, begun.serverInfo.version) == ("geotlm-lm", __version__)
    tools = {tool.name: tool for tool in listed}
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
    assert CAP in [example["name"] for example in listed["examples"]]
    lengths = {each["name"]: (each["frames"], each["fps"]) for each in listed["recordings"]}
    assert lengths == {"turn.npz": (105, 25.0), "day 1/dark.npy": (6, None)}
    assert all(example["frames"] >= 4 and example["fps"] == 25 for example in listed["examples"])
    (turn, back) = (one for one in track["events"] if one["event"] == "turn")
    assert (turn["way"], back["way"]) == ("clockwise", "counterclockwise")
    assert turn["low"] < 30 < turn["high"]
    assert track["totals"]["turn_in_all"]["amount"] > abs(track["totals"]["turn_net"]["amount"])
    assert (track["rows"], track["recording"]) == ([], "turn.npz")
    assert answers[0]["direction"] == turn["way"]
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
    way = {"recording": CAP, "question": "Which way does it go?", "details": True}
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


def test_an_answer_is_short_unless_details_are_asked_for(use):
    asked = {"recording": CAP, "question": "How far did it go?"}
    short, whole = use(("ask", asked), ("ask", asked | {"details": True}))
    names = {"text", "decided", "abstained", "confidence", "amount", "direction", "query"}
    assert set(short.structuredContent) == names
    assert set(whole.structuredContent) > names | {"evidence", "options", "notes", "frame"}
    same = {name: whole.structuredContent[name] for name in names}
    assert same == short.structuredContent


def test_what_is_mistyped_is_answered_with_the_nearest_name(use):
    answers = use(
        ("evidence", {"recording": "tunr.npz"}),
        ("evidence", {"recording": CAP.removeprefix("example:")}),
        ("evidence", {"recording": f"{CAP}s"}),
        ("track", {"recording": "turn.npz", "row": 3}),
        ("trakc", {"recording": "turn.npz"}),
    )
    nearest = ("turn.npz", CAP, CAP, "rows", "track")
    for answer, name in zip(answers, nearest, strict=True):
        assert answer.isError
        assert answer.content[0].text.endswith(f"; did you mean '{name}'?")


def test_confidence_is_defined_for_amounts_too(talk):
    async def conversation(session, _):
        return (await session.list_tools()).tools

    (ask,) = (tool for tool in talk(conversation) if tool.name == "ask")
    defined = ask.outputSchema["properties"]["confidence"]["description"]
    assert "An amount is right within its tolerance: 2 degrees, 0.2 mm, 2 px" in defined
    names = ["text", "decided", "abstained", "confidence", "amount", "direction", "query"]
    assert ask.outputSchema["required"] == names


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


def test_each_topic_of_a_bag_is_a_recording_of_its_own(use, bag):
    sent = in_message(bag.read_bytes())
    left, right = {"topic": "/left"}, {"topic": "/right"}
    way = {"recording": sent, "question": "Which way does it go?"}
    named = {"first": sent, "second": sent, "first_topic": "/left", "second_topic": "/right"}
    *asked, compared, none, unknown = use(
        ("ask", way | left),
        ("ask", way | right),
        ("ask", way | left),
        ("compare", named),
        ("track", {"recording": sent}),
        ("picture", {"recording": sent, "topic": "/up", "shows": "timeline"}),
    )
    ways = [one.structuredContent["direction"] for one in asked]
    assert ways == ["right", "left", "right"]
    assert compared.structuredContent["relation"] == "opposite"
    assert_refused(none, "clip.mcap: holds images on 2 topics, /left (4 images), /right (4 images)")
    assert_refused(unknown, "clip.mcap: holds no images on the topic /up, expected /left (4 ")


def test_a_client_that_wants_to_know_is_told_how_far_tracking_is(talk, folder, monkeypatch):
    for room in ("tools", "turns"):
        monkeypatch.setattr(f"app.{room}.REPORTED_EVERY_S", 0.0)
    (folder / "turn.npz").touch()  # so it is tracked anew
    told = []

    async def hear(*progress):
        told.append(progress)

    async def conversation(session, _):
        given = {"recording": "turn.npz"}
        return await session.call_tool("track", given, progress_callback=hear)

    assert not talk(conversation).isError
    done = [frames for frames, *_ in told]
    assert done == sorted(set(done))
    assert done
    assert {tuple(of_all) for _, *of_all in told} == {(105.0, "tracking")}


def test_a_missing_package_is_told_before_the_model_is_loaded(monkeypatch):
    monkeypatch.setitem(sys.modules, "mcp", None)
    monkeypatch.setattr("geotlm_lm.Answerer.load", lambda: pytest.fail("it was loaded"))
    with pytest.raises(MissingDependency, match="mcp, which is not installed; run `pip install"):
        serve(mcp=True)


def test_a_package_this_server_is_not_written_for_is_told(monkeypatch):
    pytest.importorskip("mcp")
    monkeypatch.setattr(tools, "version", lambda _: "2.3.0")
    with pytest.raises(MissingDependency, match="below 2, found 2.3.0; run `pip install"):
        tools.require_mcp()


RECORDINGS = [
    ("../private.npy", "There is no recording "),
    ("/etc/passwd", "The recording is neither a name nor a data URI nor an upload; "),
    ("example:../private", "There is no example "),
    ("data:,plain", "The clip's data URI is not in base64; "),
    ("", "evidence: recording was ''"),
    (7, "evidence: recording was 7, and input should be a valid string; "),
]


def test_what_is_no_recording_of_ours_is_refused_in_one_sentence(use, folder):
    private = (str(folder / "turn.npz"), "The recording is neither a name nor ")
    given = [*RECORDINGS, private]
    answers = use(*(("evidence", {"recording": recording}) for recording, _ in given))
    for answer, (_, begins) in zip(answers, given, strict=True):
        assert_refused(answer, begins)


class Planted:
    def __reduce__(self):
        return pytest.fail, ("a pickle was opened",)


def bomb(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        header = b"{'descr': '|u1', 'fortran_order': False, 'shape': (900000, 900, 900, 3), }"
        header = header.ljust(117) + b"\n"
        lead = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little")
        archive.writestr("frames.npy", lead + header + bytes(10**6))


def test_an_agent_waits_for_a_condition_in_a_recording(use):
    conditions = "it has turned 20 degrees clockwise", "it has turned 300 degrees"
    calls = [("wait_until", {"recording": "turn.npz", "condition": each}) for each in conditions]
    calls += [("wait_until", calls[0][1] | {"most_s": 1.0})]
    calls += [("wait_until", {"recording": "turn.npz", "condition": "way all"})]
    reached, never, early, refused = use(*calls)
    # It turns by 30 degrees from frame 25 to 45, at 25 frames a second.
    assert reached.structuredContent["holds"]
    assert 38 <= reached.structuredContent["frame"] <= 45
    assert reached.structuredContent["read_as"] == "it turns clockwise by more than 20 degrees"
    for answer in (never, early):
        assert not answer.isError
        assert not answer.structuredContent["holds"]
        assert "frame" not in answer.structuredContent
    assert_refused(refused, "The condition 'way all' was read as which way it moves, expected")


def test_pickles_and_bombs_are_refused_in_one_sentence(use, tmp_path):
    np.save(tmp_path / "object.npy", np.array([Planted()], dtype=object), allow_pickle=True)
    (tmp_path / "plain.pkl").write_bytes(pickle.dumps(Planted()))
    bomb(tmp_path / "bomb.npz")
    for name in ("object.npy", "plain.pkl", "bomb.npz"):
        (told,) = use(("evidence", {"recording": in_message((tmp_path / name).read_bytes())}))
        assert_refused(told, "clip")


CALLS = [
    ("ask", {"question": "Way?"}, "ask: recording is missing; give recording and question."),
    ("ask", {"recording": CAP, "question": "x" * 2001}, "ask: question was 'xxx"),
    ("ask", {"recording": CAP, "question": " "}, "The question is empty; "),
    ("compare", {"path": "x"}, "compare: first is missing; "),
    ("recordings", {"path": "x"}, "recordings: there is no parameter 'path'; "),
    ("evidence", {"recording": CAP, "frames": [0]}, "evidence: frames was [0], and "),
    ("evidence", {"recording": CAP, "frames": [0, "b"]}, "evidence: frames.1 was 'b', and "),
    ("evidence", {"recording": CAP, "frames": [0, 99]}, "Frames 0:99 were "),
    ("track", {"recording": "turn.npz", "frames": [50, 950]}, "Frames 50:950 were "),
    ("track", {"recording": "turn.npz", "frames": [60, 50]}, "Frames 60:50 were "),
    ("track", {"recording": CAP, "turned": 45}, "track: turned was 45, and "),
    ("ask", {"recording": CAP, "question": "a", "mm_per_px": -1}, "ask: mm_per_px was -1, "),
    ("picture", {"recording": CAP, "shows": "all"}, "picture: shows was 'all', and "),
    ("simulate", {"object_name": "unicorn"}, "There is no shape 'unicorn'"),
    ("simulate", {"twist_deg": 1e9}, "simulate: twist_deg was 1000000000.0, and "),
    ("simulate", {"seed": 0.5}, "simulate: seed was 0.5, and "),
    ("nothing", {}, "There is no tool 'nothing'; "),
]


def test_a_wrong_call_is_refused_in_one_sentence(use):
    answers = use(*((tool, given) for tool, given, _ in CALLS))
    for answer, (*_, begins) in zip(answers, CALLS, strict=True):
        assert_refused(answer, begins)
