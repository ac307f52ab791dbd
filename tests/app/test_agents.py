"""The tools over the Model Context Protocol, called by a real client of it."""

import base64
import json

import cv2
import numpy as np
import pytest

gradio = pytest.importorskip("gradio", reason="serving the page needs gradio (extra: app)")

from geotlm_lm import __version__  # noqa: E402
from tests.app.agent_calls import CAP, assert_refused, clip, in_message  # noqa: E402

TOOLS = {"recordings", "ask", "track", "compare", "simulate", "evidence", "picture"}


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
    assert_refused(none, "clip.mcap: holds images on 2 topics, /left (6 images), /right (6 images)")
    assert_refused(unknown, "clip.mcap: holds no images on the topic /up, expected /left (6 ")


def test_a_client_that_wants_to_know_is_told_how_far_tracking_is(talk, folder, monkeypatch):
    monkeypatch.setattr("app.turns.TOLD_EVERY_S", 0.0)
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
