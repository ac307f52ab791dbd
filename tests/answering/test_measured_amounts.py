"""Amounts in the unit that what is known of the recording allows."""

import re
from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.answering.answer import Encoded
from geotlm_lm.answering.measured_amounts import amount_along, measured_amount
from geotlm_lm.answering.model_query import ModelReply
from geotlm_lm.backbone.stem import ALIGNED_AT, PATCH_INPUT_DIM
from geotlm_lm.backbone.view import View
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.frame_spec import FrameSpec
from geotlm_lm.core.labels import Motion
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.language.parse_answer import Slots
from geotlm_lm.model import Perception
from geotlm_lm.odometry.odometer import AMOUNTS, amounts
from tests.answering.scripted import answerer_saying, measuring, recording

SLIDING = "An amount of sliding, as measured."
CAMERA = FrameSpec()


def encoded(rows, columns, right=1.0, down=0.0):
    """A clip whose whole imprint slides, laid on its first frame by the stem."""
    field = torch.zeros(1, 14, 14, 2)
    with torch.no_grad():
        geometry = DGR(4).pool(torch.zeros(1, 2, 14, 14, 2), field, torch.ones(1, 14, 14))
    token, inputs = torch.zeros(1, 4), torch.zeros(1, 2, 14, 14, PATCH_INPUT_DIM)
    inputs[..., :48] = 1.0
    inputs[:, 1, :, :, ALIGNED_AT : ALIGNED_AT + 2] = torch.tensor([right, down])
    frames = np.zeros((4, rows, columns, 3), np.uint8)
    clip = Clip(frames, background=frames[0])
    return Encoded(clip, Perception(token, geometry, token, (View(),), inputs), {})


def slide(bundle, clip, frame=CAMERA, px=14.0):
    """What is told of a slide by `px` pixels of the 224-pixel image."""
    model = answerer_saying(bundle, {}, measures={"px": px}).bundle
    return measured_amount(
        model, clip, ModelReply(Slots("magnitude", unit="px"), "", {"slide": 0.9}), frame
    )


@pytest.mark.parametrize(
    ("size", "way", "factor"),
    [
        ((224, 224), (1.0, 0.0), 1.0),
        ((480, 640), (1.0, 0.0), 640 / 224),
        ((480, 640), (0.0, -1.0), 480 / 224),
        ((480, 640), (0.6, 0.8), np.hypot(0.6 * 640, 0.8 * 480) / 224),
        # Idle gel fills up a square that a portrait picture leaves.
        ((320, 240), (1.0, 0.0), 240 / 126),
        ((320, 240), (0.0, 1.0), 320 / 224),
    ],
)
def test_without_a_scale_a_slide_is_told_in_the_recordings_own_pixels(bundle, size, way, factor):
    amount = slide(bundle, encoded(*size, *way))
    assert amount.unit == "px"
    assert amount.value == pytest.approx(14 * factor, rel=0.12)
    assert amount.probability == pytest.approx(0.9, abs=0.01)
    plain = slide(bundle, encoded(224, 224, *way))
    assert amount.value / plain.value == pytest.approx(factor, rel=0.08)


@pytest.mark.parametrize(
    ("size", "way", "mm_per_224_px"),
    [
        # A 224-pixel image was squashed from a camera of four to three: 10 of its pixels across are
        # as wide as 13.3 are high.
        ((224, 224), (1.0, 0.0), 0.1),
        ((224, 224), (0.0, 1.0), 0.075),
        ((240, 320), (1.0, 0.0), 0.1 * 320 / 224),
        ((240, 320), (0.0, 1.0), 0.1 * 240 / 224),
        ((400, 400), (0.0, 1.0), 0.1 * 400 / 224),
    ],
)
def test_with_a_scale_it_is_told_in_millimetres(bundle, size, way, mm_per_224_px):
    amount = slide(bundle, encoded(*size, *way), FrameSpec(mm_per_px=0.1), px=30.0)
    assert amount.unit == "mm"
    assert amount.value == pytest.approx(30 * mm_per_224_px, rel=0.12)


def test_turns_need_no_scale(bundle):
    model = answerer_saying(bundle, {}, measures={"deg": 20.0}).bundle
    heard = ModelReply(Slots("magnitude", unit="deg"), "", {"rotation": 1.0})
    for frame in (CAMERA, FrameSpec(mm_per_px=0.1)):
        amount = measured_amount(model, encoded(240, 320), heard, frame)
        assert (amount.unit, amount.value) == ("deg", pytest.approx(20, abs=2))


@pytest.mark.parametrize("slots", [None, Slots("magnitude")])
def test_what_goes_no_way_has_no_amount(bundle, slots):
    model = answerer_saying(bundle, {}).bundle
    assert measured_amount(model, encoded(64, 64), ModelReply(slots, "", {}), CAMERA) is None


@pytest.mark.parametrize(("size", "px"), [((24, 32), 1.0), ((8, 8), 2.0), ((48, 64), 0.9)])
def test_small_frames_get_fractions_of_a_pixel(bundle, size, px):
    amount = slide(bundle, encoded(*size), px=px)
    assert amount.value == pytest.approx(px * size[1] / 224, abs=2 * size[1] / 224)
    assert amount.low <= amount.value <= amount.high
    assert amount.probability == pytest.approx(0.9, abs=0.01)


def test_a_doubtful_clip_spreads_the_span_and_lowers_the_probability(bundle):
    model = answerer_saying(bundle, {}).bundle
    shares = torch.softmax(-((torch.arange(AMOUNTS) - 20.0) ** 2) / 8, dim=0)[None]
    model.odometer.read = lambda movement, unit: shares
    heard, clip = (
        ModelReply(Slots("magnitude", unit="deg"), "", {"rotation": 1.0}),
        encoded(240, 320),
    )
    sure, unsure = (
        measured_amount(model, one, heard, CAMERA) for one in (clip, replace(clip, is_cut_off=True))
    )
    assert unsure.probability < sure.probability
    assert unsure.high - unsure.low > sure.high - sure.low


def test_the_stems_inputs_are_made_again_where_a_backbone_has_none(bundle):
    answerer = answerer_saying(bundle, {"*": SLIDING})
    whole = answerer.encode(recording())
    bare = replace(whole, perception=replace(whole.perception, inputs=None))
    first, again = (answerer.ask(one, "How far?") for one in (whole, bare))
    assert first.amount == again.amount


def test_pixels_are_named_and_what_millimetres_take(bundle):
    answerer = answerer_saying(bundle, {"*": SLIDING})
    seen = answerer.encode(recording())
    answer = answerer.ask(seen, "How far?")
    assert answer.text.startswith("About ")
    assert "pixels of sliding" in answer.text
    assert any("64x48 frames" in note and "mm per pixel" in note for note in answer.notes)
    asked_for = answerer.ask(seen, "How many mm did it go?")
    assert asked_for.text.endswith(" In millimetres only if you tell me the size of a pixel.")
    told = answerer.ask(seen, "0.06 mm per pixel. How many mm did it go?")
    assert told.amount.unit == "mm"
    assert not any("pixel" in note for note in told.notes)


@pytest.mark.parametrize(
    ("motion", "way", "went"),
    [
        (Motion.CLOCKWISE, (1.0, 0.0), (12.0, 0.0, 0.0)),
        (Motion.COUNTERCLOCKWISE, (1.0, 0.0), (-12.0, 0.0, 0.0)),
        (Motion.RIGHT, (1.0, 0.0), (0.0, 14.0 * 320 / 224, 0.0)),
        (Motion.UP, (0.0, -1.0), (0.0, 0.0, -14.0 * 240 / 224)),
    ],
)
def test_how_far_a_named_motion_went_has_its_sign_and_way(bundle, motion, way, went):
    model = answerer_saying(bundle, {}).bundle
    found = amount_along(model, encoded(240, 320, *way), motion)
    assert found == pytest.approx(went, rel=0.07, abs=1e-6)


@pytest.mark.parametrize("motion", [Motion.PRESS, Motion.RELEASE, Motion.STILL, Motion.NONE])
def test_what_goes_no_way_has_not_travelled(bundle, motion):
    assert amount_along(answerer_saying(bundle, {}).bundle, encoded(64, 64), motion) is None


def test_how_far_is_the_geometric_mean_of_what_is_probable(bundle):
    model = answerer_saying(bundle, {}).bundle
    shares = torch.zeros(1, AMOUNTS)
    shares[0, [10, 20]] = 0.5
    model.odometer.read = lambda movement, unit: shares
    first, second = amounts("deg")[[10, 20]].tolist()
    turned, *_ = amount_along(model, encoded(240, 320), Motion.CLOCKWISE)
    assert turned == pytest.approx((first * second) ** 0.5)


def test_a_speed_is_told_by_the_frame_as_its_amount_is(bundle):
    answerer = measuring(bundle, Motion.CLOCKWISE, "deg", deg=30.0)
    for fps in (2.0, 50.0):
        seen = answerer.encode(recording(fps=fps))
        texts = [answerer.ask(seen, asked).text for asked in ("How far per frame?", "How fast?")]
        texts.append(answerer.ask(seen, "How fast, in degrees per frame?").text)
        far, fast, by_frame = (
            float(re.findall(r"(?:About|That is) ([\d.]+)", t)[-1]) for t in texts
        )
        assert by_frame == pytest.approx(fast / fps, rel=0.05)
        assert by_frame == pytest.approx(far, rel=0.1)
