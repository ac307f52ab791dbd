"""Behaviour of the seam, with a bundle of random weights and a scripted speaker."""

import json
from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.answering import Answerer
from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.recordings import policy
from geotlm_lm.recordings.read import read_clip
from tests.answering import scripted
from tests.answering.scripted import believed, feeling


def recording(frames=4):
    """One without a background."""
    return replace(scripted.recording(frames), background=None)


def ask(answerer, question):
    return answerer.ask(answerer.encode(recording()), question)


def test_the_time_of_a_recording_read_at_a_stride_is_its_own(bundle, tmp_path, monkeypatch):
    frames = recording(24).frames
    np.savez(tmp_path / "clip.npz", frames=frames, fps=25.0)
    monkeypatch.setattr(policy, "KEPT_BYTES", 8 * frames[0].nbytes)
    encoded = Answerer(bundle).encode(read_clip(tmp_path / "clip.npz"), span=(0, 21))
    assert encoded.track.seconds == pytest.approx(21 / 25)


def test_of_four_frames_one_lit_unlike_is_left_out_and_another_stands_for_it(bundle):
    clip = recording()
    frames = clip.frames.copy()
    third = frames.shape[2] // 3
    frames[3, :, :third] = np.clip(frames[3, :, :third].astype(int) + 100, 0, 250)
    encoded = Answerer(bundle).encode(replace(clip, frames=frames))
    assert len(encoded.clip) == 4
    assert any("no picture of the gel" in note for note in encoded.clip.notes)


@pytest.mark.parametrize("question", ["", "   ", "\n\t"])
def test_an_empty_question_is_refused(bundle, question):
    with pytest.raises(UsageError, match="The question is empty; ask something like"):
        ask(feeling(bundle, "clockwise"), question)


def test_an_endless_question_is_refused(bundle):
    with pytest.raises(UsageError, match="characters, expected at most about"):
        ask(Answerer(bundle), "which " * 1000)


def test_an_answer_carries_direction_frame_options_evidence_and_timing(bundle):
    answer = ask(feeling(bundle, "clockwise"), "Which way?")
    assert answer.direction is Motion.CLOCKWISE
    assert not answer.abstained
    assert set(answer.options) == {motion.value for motion in Motion}
    assert answer.confidence == pytest.approx(0.98 * 0.97)
    assert answer.motion.to_dict()["turn"]["way"] == "clockwise"
    assert set(answer.timing_ms) == {"choose", "touch", "encode", "read", "answer", "total"}
    assert set(answer.evidence["regions"]) >= {"upper_minus_lower", "left_minus_right"}
    required = {"text", "direction", "confidence", "abstained", "frame", "options", "timing_ms"}
    assert required <= set(json.loads(json.dumps(answer.to_dict())))


def test_an_answer_that_is_likelier_wrong_than_right_is_withheld_and_told_as_a_guess(bundle):
    belief = believed("clockwise", share=0.51)
    belief.ways[Motion.CLOCKWISE], belief.ways[Motion.COUNTERCLOCKWISE] = 0.4, 0.3
    answer = ask(feeling(bundle, "clockwise", belief=belief), "Which way?")
    assert answer.text == (
        "I cannot tell for sure, 40%: it turns clockwise, about 11 degrees, in the camera image."
    )
    assert (answer.direction, answer.decided, answer.confidence) == (None, None, 0.0)
    assert answer.abstained
    likelier = believed("clockwise", share=0.55, contact=1.0)
    assert not ask(feeling(bundle, "clockwise", belief=likelier), "Which way?").abstained


def test_an_amount_that_is_likelier_wrong_than_right_is_a_guess_with_its_span(bundle):
    belief = believed("clockwise", spread=1.0)
    answer = ask(feeling(bundle, "clockwise", belief=belief), "How far did it turn?")
    assert answer.text.startswith("I cannot tell for sure, ")
    assert answer.amount.span[0] < answer.amount.value < answer.amount.span[1]
    assert (answer.abstained, answer.decided, answer.confidence) == (True, None, 0.0)


def test_a_direction_without_contact_becomes_an_abstention(bundle):
    answer = ask(feeling(bundle, "clockwise", contact_threshold=1.1), "Which way is it turning?")
    assert answer.abstained
    assert answer.direction is None
    assert answer.text.startswith("I cannot name a direction: I see next to no contact")
    assert answer.confidence == 0.0


def test_a_choice_weighs_only_the_letters_offered(bundle):
    answer = ask(feeling(bundle, "left"), "choose A right | B left")
    assert (answer.direction, answer.decided) == (Motion.LEFT, "B")
    assert set(answer.options) == {"A", "B"}


def test_an_unknown_background_is_estimated_and_said_and_one_frame_is_too_few(bundle):
    answerer = feeling(bundle, "clockwise")
    encoded = answerer.encode(recording())
    assert encoded.clip.background is not None
    assert any("estimated" in note for note in encoded.clip.notes)
    with pytest.raises(UnreadableClip, match="only 1 frame"):
        answerer.encode(recording(1))
