"""What the stage is given: pictures small enough, curves and events of a track, a clip's step."""

import base64
import json

import cv2
import numpy as np
import pytest

from app import stage
from app.clips import load_clip, perceive
from app.sources import EXAMPLES
from geotlm_lm import FrameSpec, Units
from geotlm_lm.core.clip import Clip
from tests.app.fakes import FakeAnswerer


def clip_of(count, rows=48, columns=64, fps=None):
    frames = np.full((count, rows, columns, 3), 150, np.uint8)
    frames[1:, 10:30, 10:30] += 20
    return Clip(frames, fps=fps, background=frames[0])


@pytest.fixture(scope="module")
def tracked(frames):
    return perceive(FakeAnswerer(), Clip(np.stack(frames), fps=25.0))


def decoded(address):
    content = base64.b64decode(address.split(",")[1])
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


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
    sent = decoded(told["frames"][2])
    assert sent.shape == (224, 224, 3)
    assert np.abs(sent.astype(int) - clip.frames[2]).mean() < 2
    assert decoded(told["idle"]).shape == (224, 224, 3)
    large = stage.opening(clip_of(4, 480, 640), "cap")
    assert decoded(large["frames"][0]).shape == (336, 448, 3)


def test_a_long_recording_stays_below_three_megabytes():
    rng = np.random.default_rng(0)
    frames = rng.integers(0, 256, (400, 240, 320, 3), np.uint8)  # the worst there is
    told = stage.opening(Clip(frames, fps=25.0), "noise")
    assert len(told["frames"]) == stage.MOST_FRAMES
    assert len(json.dumps(told)) < 3.2e6
    assert told["x"][-1] == pytest.approx(399 / 25, abs=0.001)


def test_curves_are_those_of_the_track_with_nine_tenths_inside(tracked):
    track = tracked.encoded.track
    told = stage.stage_of(tracked, "cap", FrameSpec(mm_per_px=0.1))["timeline"]
    turn, travel, contact = told["panels"]
    assert turn["curves"][0]["mean"] == pytest.approx(track.path_from_start[:, 0], abs=1e-3)
    assert turn["curves"][0]["spread"] == pytest.approx(
        1.645 * track.path_deviations[:, 0], abs=1e-3
    )
    right, _ = Units((120, 160), 0.1).travelled(track.path_from_start[:, 1], 0)
    assert travel["unit"] == "mm"
    assert travel["curves"][0]["mean"] == pytest.approx(right, abs=1e-3)
    assert contact["curves"][0]["mean"] == pytest.approx(track.contact, abs=1e-3)


def test_events_are_told_with_their_times(tracked):
    told = stage.stage_of(tracked, "cap")["timeline"]["events"]
    assert [one["kind"] for one in told] == [one.kind.value for one in tracked.encoded.track.events]
    touch = next(one for one in told if one["kind"] == "touch")
    assert 0.4 < touch["begin"] < 0.6
    assert touch["begin"] == touch["end"]


def test_a_short_clips_motion_is_one_step_with_its_amount():
    shown = perceive(FakeAnswerer(), clip_of(4))
    rows = {row["name"]: row for row in stage.stage_of(shown, "cap")["step"]["rows"]}
    assert rows["slide"]["text"].startswith("right ")
    assert " px (" in rows["slide"]["text"]
    assert rows["turn"] == {"name": "turn", "moves": False, "text": "none, 100 % sure"}
    in_mm = stage.stage_of(shown, "cap", FrameSpec(mm_per_px=0.1))["step"]["rows"][1]
    assert " mm (" in in_mm["text"]


def test_arrows_lie_where_it_touches_and_have_a_scale():
    overlays = stage.stage_of(perceive(FakeAnswerer(), clip_of(4)), "cap")["overlays"]
    (field,) = overlays["fields"]
    tails, tips = np.array(field["ends"]).transpose(1, 0, 2)
    assert tails[:, 0].max() < 0.5  # the stand-in sees contact in the left half
    assert np.all(tips[:, 0] > tails[:, 0])
    assert field["legend"]["text"] == "5 learned shear (no unit)"
    assert field["legend"]["length"] == pytest.approx(5 * 4 / 224)
    assert np.shape(overlays["contact"]["mask"]) == (14, 14)


@pytest.mark.parametrize(
    ("name", "has_arrows"), [("key_none", False), ("screw_head_down", True), ("bead_right", True)]
)
def test_arrows_are_drawn_of_what_touches_alone(answerer, name, has_arrows):
    told = stage.stage_of(load_clip(answerer, str(EXAMPLES[f"example:{name}"])), name)
    (field,) = told["overlays"]["fields"]
    assert bool(field["ends"]) is has_arrows
    assert bool(told["step"]["rows"]) is has_arrows
