"""What the stage is given: pictures small enough, curves and events of a track, a clip's step."""

import json
import re
import struct
from dataclasses import replace

import cv2
import numpy as np
import pytest

from app import stage
from app.clips import perceive, read_named
from app.sources import EXAMPLES, RECORDING_FOLDER
from geotlm_lm import Exported, Units
from geotlm_lm.core.clip import Clip
from tests.app.fakes import FakeAnswerer, load_clip


def clip_of(count, rows=48, columns=64, fps=None):
    frames = np.full((count, rows, columns, 3), 150, np.uint8)
    frames[1:, 10:30, 10:30] += 20
    return Clip(frames, fps=fps, background=frames[0])


@pytest.fixture(scope="module")
def tracked(frames):
    return perceive(FakeAnswerer(), Clip(np.stack(frames), fps=25.0))


def pictures(told):
    """Return the pictures that the browser would fetch, frames before the idle gel."""
    content = stage.PACKS.content(told["pack"].split("/")[-1])
    (count,) = struct.unpack_from("<I", content)
    ends = np.cumsum([4 * count + 4, *struct.unpack_from(f"<{count}I", content, 4)])
    files = [content[a:b] for a, b in zip(ends[:-1], ends[1:], strict=True)]
    return [cv2.imdecode(np.frombuffer(file, np.uint8), 1)[..., ::-1] for file in files]


def test_a_clip_of_four_frames_plays_in_a_loop_at_ten_a_second():
    told = stage.stage_of(perceive(FakeAnswerer(), clip_of(4, fps=25.0)), "cap")
    assert (told["rate"], told["loops"], told["unit"]) == (10.0, True, "frame")
    assert (told["name"], told["about"], told["x"]) == ("cap", "4 frames", [0, 1, 2, 3])
    assert "timeline" not in told


def test_a_recording_plays_at_its_own_rate(tracked):
    told = stage.stage_of(tracked, "cap")
    assert (told["rate"], told["loops"], told["unit"]) == (25.0, False, "s")
    assert told["about"] == "1.6 s, 40 frames"
    assert told["x"][25] == 1.0


def test_frames_without_a_rate_are_shown_over_their_numbers():
    told = stage.opening(clip_of(10), "cap")
    assert (told["unit"], told["x"][-1], told["rate"], told["pending"]) == ("frame", 9, 25.0, True)


def test_a_picture_is_sent_as_it_is_and_in_the_shape_of_the_camera():
    clip = clip_of(4, 224, 224)
    told = stage.opening(clip, "cap")
    assert told["aspect"] == pytest.approx(4 / 3)  # squashed to our square
    sent = pictures(told)[2]
    assert sent.shape == (224, 224, 3)
    assert np.abs(sent.astype(int) - clip.frames[2]).mean() < 2
    assert (told["count"], told["has_idle"], len(pictures(told))) == (4, True, 5)
    large = stage.opening(clip_of(4, 480, 640), "cap")
    assert pictures(large)[0].shape == (336, 448, 3)


def test_a_long_recording_stays_below_three_megabytes_and_none_of_it_is_in_the_value():
    rng = np.random.default_rng(0)
    frames = rng.integers(0, 256, (400, 240, 320, 3), np.uint8)  # the worst there is
    told = stage.opening(Clip(frames, fps=25.0), "noise")
    assert told["count"] == stage.MOST_FRAMES
    assert len(stage.PACKS.content(told["pack"].split("/")[-1])) < 3.2e6
    assert len(json.dumps(told)) < 1e4
    assert told["x"][-1] == pytest.approx(399 / 25, abs=0.001)


def test_curves_are_those_of_the_track_with_nine_tenths_inside(tracked):
    track = tracked.encoded.track
    told = stage.stage_of(tracked, "cap", 0.1)["timeline"]
    contact, turn, travel, rest = told["lanes"]
    assert turn["curves"][0]["mean"] == pytest.approx(track.path_from_start[:, 0], abs=1e-3)
    assert turn["curves"][0]["spread"] == pytest.approx(
        1.645 * track.path_deviations[:, 0], abs=1e-3
    )
    right, _ = Units((120, 160), 0.1).travelled(track.path_from_start[:, 1], 0)
    assert travel["unit"] == "mm"
    assert travel["curves"][0]["mean"] == pytest.approx(right, abs=1e-3)
    assert contact["curves"][0]["mean"] == pytest.approx(track.contact, abs=1e-3)
    assert rest["curves"] == []


def test_contact_without_an_idle_frame_is_not_known_and_has_no_curve(tracked):
    track = replace(tracked.encoded.track, is_contact_known=False)
    shown = replace(tracked, encoded=replace(tracked.encoded, track=track))
    lanes = stage.stage_of(shown, "cap")["timeline"]["lanes"]
    assert [lane["is_known"] for lane in lanes] == [False, True, True, False]
    assert [bool(lane["curves"]) for lane in lanes] == [False, True, True, False]


def test_a_row_knows_what_is_too_small_to_detect(tracked):
    _, turn, slide, _ = stage.stage_of(tracked, "cap")["timeline"]["lanes"]
    totals = Exported(tracked.encoded.track).totals()
    assert (turn["limit"], slide["limit"]) == (totals["turn_limit"], totals["slide_limit"])


def test_outlines_are_drawn_while_it_touches_and_around_what_has_changed(frames):
    recording = Clip(np.stack(frames), fps=25.0, background=frames[0])
    outlines = stage.stage_of(perceive(FakeAnswerer(), recording), "cap")["outlines"]
    assert len(outlines) == 40
    assert [bool(polygons) for polygons in outlines[:10]] == [False] * 10
    (polygon,) = outlines[30]
    change = np.abs(frames[30].astype(float) - frames[0]).mean(axis=2)
    rows, columns = np.nonzero(change > 0.5 * change.max())
    middle = (np.median(columns) / change.shape[1], np.median(rows) / change.shape[0])
    low, high = np.min(polygon, axis=0), np.max(polygon, axis=0)
    assert (low + high) / 2 == pytest.approx(middle, abs=0.08)


def test_an_outline_follows_its_mask():
    mask = np.zeros((24, 32))
    mask[6:18, 8:24] = 1
    (polygon,) = stage.outline(mask)
    assert np.min(polygon, axis=0) == pytest.approx([0.25, 0.25], abs=0.02)
    assert np.max(polygon, axis=0) == pytest.approx([0.75, 0.75], abs=0.02)
    assert stage.outline(0 * mask) == []


def test_events_are_told_with_their_times(tracked):
    lanes = stage.stage_of(tracked, "cap")["timeline"]["lanes"]
    told = [event for lane in lanes for event in lane["events"]]
    kinds = [event.kind.value for event in tracked.encoded.track.events]
    assert sorted(event["kind"] for event in told) == sorted(kinds)
    touch = next(event for event in told if event["kind"] == "touch")
    assert 0.4 < touch["begin"] < 0.6
    assert touch["begin"] == touch["end"]


def test_a_short_clips_motion_is_one_step_with_its_amount():
    shown = perceive(FakeAnswerer(), clip_of(4))
    step = stage.stage_of(shown, "cap")["step"]
    rows = {row["name"]: row for row in step["rows"]}
    assert step["text"] == rows["slide"]["text"]
    assert re.fullmatch(r"[0-9.]+ px right, [0-9.]+ to [0-9.]+ px", rows["slide"]["text"])
    assert rows["slide"]["low"] < rows["slide"]["mean"] < rows["slide"]["high"]
    assert rows["turn"] == {"name": "turn", "moves": False, "text": "none"}
    in_mm = stage.stage_of(shown, "cap", 0.1)["step"]["rows"][1]
    assert " mm right, " in in_mm["text"]


def test_the_rows_of_a_clip_say_what_its_words_say(answerer):
    shown = load_clip(answerer, str(EXAMPLES["example:bottle_cap_clockwise"]))
    words = shown.session.ask("Which way is it moving?")
    (value,) = words.values
    told = {movement.way.value: movement for movement in value.movements}
    rows = [row for row in stage.stage_of(shown, "cap")["step"]["rows"] if row["moves"]]
    assert len(rows) == len(told)
    for row in rows:
        way = next(way for way in told if way in row["text"])
        assert row["mean"] == told[way].amount.mean
        assert row["sure"] == round(100 * told[way].chance)


def test_motion_is_drawn_in_shares_of_the_picture():
    told = stage.stage_of(perceive(FakeAnswerer(), clip_of(4)), "cap")
    assert told["motion"]["turn"] == 0
    assert told["motion"]["travel"] == pytest.approx([14.2 / 224, 0], abs=0.02)
    tails, tips = np.array(told["shear"]).transpose(1, 0, 2)
    assert tails[:, 0].max() < 0.5  # the stand-in sees contact in the left half
    assert np.all(tips[:, 0] > tails[:, 0])


@pytest.mark.parametrize(
    ("name", "moves"), [("key_none", False), ("screw_head_down", True), ("bead_right", True)]
)
def test_motion_is_drawn_of_what_touches_alone(answerer, name, moves):
    told = stage.stage_of(load_clip(answerer, str(EXAMPLES[f"example:{name}"])), name)
    assert bool(told["motion"]) is moves
    assert bool(told["step"]["rows"]) is moves
    assert any(told["outlines"]) is moves


def test_a_still_clip_has_a_limit_and_no_arrows(answerer):
    told = stage.stage_of(load_clip(answerer, str(EXAMPLES["example:key_still"])), "key")
    assert told["motion"] is None
    assert told["step"]["text"] == "does not move"
    assert all(row["text"].startswith("none beyond ") for row in told["step"]["rows"])


def test_the_timeline_grows_while_a_recording_is_tracked(answerer, monkeypatch):
    monkeypatch.setattr(stage, "GROWS_EVERY_S", 0.0)
    recording = read_named(str(RECORDING_FOLDER / "key.mov"))
    growing, ends = stage.GrowingTimeline("s", recording.frames.shape[1:3]), []
    assert growing.values == {}

    def follow(tracker):
        growing.follow(tracker)
        ends.append(growing.values.get("timeline", {"x": [0.0]})["x"][-1])

    shown = perceive(answerer, recording, follow=follow)
    assert len(ends) == len(recording)
    assert ends == sorted(ends)
    assert ends[-1] > 0.8 * shown.encoded.track.times_s[-1]
    turns = next(lane for lane in growing.values["timeline"]["lanes"] if lane["name"] == "turn")
    assert len(turns["events"]) == 2
