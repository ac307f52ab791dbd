"""What is withheld for want of contact, of an idle gel or of anything that touches it."""

import re
from dataclasses import replace

import numpy as np
import pytest

from geotlm_lm.answering import Answerer
from geotlm_lm.answering.encoded import FAINT_DOUBT
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.query.phrases import replies
from geotlm_lm.recordings.idle import CONTACT_UNKNOWN
from tests.answering.scripted import believed, feeling, recording
from tests.recordings.dotted import dotted, dotted_recording

REFERENCE = replies()["missing"]["reference"]

IDLE = np.add.outer(np.linspace(90, 140, 120), np.zeros((160, 3))).astype(np.uint8)


def faintly_touched(background=IDLE, grey=2.4):
    rows, columns = np.mgrid[:120, :160]
    imprint = grey * np.exp(-((rows - 60) ** 2 + (columns - 80) ** 2) / (2 * 10**2))
    touched = np.rint(IDLE + imprint[..., None]).astype(np.uint8)
    return Clip(np.stack([touched, IDLE, touched, touched]), background=background)


def untouched(seed=0):
    noise = np.random.default_rng(seed).integers(-1, 2, (4, *IDLE.shape))
    frames = np.clip(IDLE.astype(int) + noise, 0, 255).astype(np.uint8)
    return Clip(frames, background=IDLE)


def test_an_open_question_is_answered_where_nothing_touches(bundle):
    answerer = feeling(bundle, "none")
    answer = answerer.ask(answerer.encode(untouched()), "Which way is it turning?")
    assert answer.direction is Motion.NONE
    assert answer.confidence > 0.97
    assert not answer.abstained
    mirrored = answerer.ask(answerer.encode(untouched()), "mirror way all")
    assert mirrored.text == "Nothing touches the gel."


def test_how_faint_a_touch_may_go_unseen_is_said(bundle):
    answerer = feeling(bundle, "press")
    note = answerer.ask(answerer.encode(untouched()), "Which way?").notes[-1]
    assert re.fullmatch(
        r"No frame differs from the idle gel by more than \d\.\d grey levels; "
        r"a touch fainter than 1\.5 is not seen\.",
        note,
    )
    assert not any("idle gel by" in note for note in answerer.encode(recording()).clip.notes)


def test_noise_is_not_perceived(bundle):
    answerer = Answerer(bundle)
    one, other = (answerer.encode(untouched(seed)) for seed in (1, 2))
    assert one.is_untouched
    assert one.perception.fused_token.equal(other.perception.fused_token)
    assert not np.array_equal(one.clip.frames, other.clip.frames)  # shown as they were recorded


@pytest.mark.parametrize("question", ["way all", "mirror way all", "kind", "touch", "none"])
def test_nothing_touches_is_not_claimed_of_a_gel_that_changed(bundle, question):
    answerer = feeling(bundle, "none", belief=believed("none"))
    encoded = answerer.encode(faintly_touched())
    assert encoded.is_changed
    assert not encoded.is_untouched
    answer = answerer.ask(encoded, question)
    assert answer.text == replies()["missing"]["unrecognised"]
    assert answer.abstained
    assert (answer.direction, answer.confidence) == (None, 0.0)


def test_what_an_idle_gel_may_do_now_and_then_is_doubtful(bundle):
    encoded = Answerer(bundle).encode(faintly_touched(grey=1.5))
    assert (encoded.is_faint, encoded.is_changed, encoded.is_untouched) == (True, False, False)
    assert encoded.doubt == FAINT_DOUBT
    assert not encoded.is_cut_off
    sure = replace(encoded, is_faint=False).belief
    spread = encoded.belief.deviation(Component.TURN) / sure.deviation(Component.TURN)
    assert spread == pytest.approx(FAINT_DOUBT)


def test_an_imprint_that_the_border_cuts_off_is_told_with_less_certainty(bundle):
    answerer, clip = feeling(bundle, "press"), recording()
    frames = np.stack([clip.frames[0]] * 4)
    frames[1:, :, : clip.frames.shape[2] // 12] //= 2
    note = "The border of the image cuts the imprint off: answers are less sure."
    assert note in answerer.ask(answerer.encode(replace(clip, frames=frames)), "way all").notes
    assert note not in answerer.ask(answerer.encode(clip), "way all").notes


def test_any_other_claim_about_a_faint_touch_is_told(bundle):
    answerer = feeling(bundle, "press")
    answer = answerer.ask(answerer.encode(faintly_touched()), "Which way is it moving?")
    assert answer.direction is Motion.PRESS
    assert not answer.abstained


def test_against_a_guessed_background_no_change_is_beyond_noise(bundle):
    answerer = feeling(bundle, "none")
    encoded = answerer.encode(faintly_touched(background=None))
    assert not encoded.is_changed
    assert not encoded.is_contact_known
    assert answerer.ask(encoded, "Which way is it moving?").text == REFERENCE


@pytest.mark.parametrize("felt", ["still", "none"])
@pytest.mark.parametrize("question", ["way all", "touch", "kind"])
def test_contact_is_not_judged_where_nothing_shows_the_untouched_gel(bundle, question, felt):
    shown = recording().frames[0]
    answerer = feeling(bundle, felt)
    unknown = answerer.encode(Clip(np.stack([shown] * 4)))
    answer = answerer.ask(unknown, question)
    assert answer.abstained
    assert answer.text == REFERENCE
    known = answerer.encode(Clip(np.stack([shown] * 4), background=recording(seed=5).frames[0]))
    assert answerer.ask(known, question).text != answer.text
    if felt == "still":
        moving = answerer.ask(unknown, "Is it moving?")
        assert (moving.decided, moving.abstained) == ("no", False)


@pytest.mark.parametrize("question", ["in", "none", "place", "way press"])
def test_contact_is_not_told_of_a_gel_with_dots_without_its_idle_frame(bundle, question):
    answerer = feeling(bundle, "clockwise")
    for strengths in ([0] * 4, [40] * 4, [20, 25, 30, 35]):
        unknown = answerer.encode(dotted_recording(strengths))
        assert not unknown.is_contact_known
        answer = answerer.ask(unknown, question)
        assert (answer.text, answer.abstained) == (CONTACT_UNKNOWN, True)
        assert answerer.ask(unknown, "way all").direction is Motion.CLOCKWISE
        assert answerer.ask(unknown, "touch").decided == "yes"  # what turns touches
    known = replace(dotted_recording([40] * 4), background=dotted(0))
    assert answerer.ask(answerer.encode(known), question).text != CONTACT_UNKNOWN


@pytest.mark.parametrize("count", [4, 8])
def test_a_belief_against_a_guessed_gel_with_dots_knows_no_press(bundle, count):
    encoded = Answerer(bundle).encode(dotted_recording(np.linspace(10, 40, count)))
    assert not encoded.belief.is_contact_known
    assert encoded.belief.moves(Component.PRESS) == 0


def test_nothing_is_supposed_of_a_thread_where_the_turn_is_withheld_or_a_guess(bundle):
    sure = feeling(bundle, "clockwise")
    text = sure.ask(sure.encode(recording()), "tighten").text
    assert text.startswith("If it is an ordinary right-hand thread seen from its head, yes")
    faint = feeling(bundle, "clockwise", contact_threshold=1.0)
    withheld = faint.ask(faint.encode(recording()), "tighten").text
    assert withheld.startswith(replies()["missing"]["mask"])
    doubted = believed("clockwise")
    even = dict.fromkeys((Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE), 0.45)
    guessing = feeling(bundle, belief=replace(doubted, ways=doubted.ways | even))
    guessed = guessing.ask(guessing.encode(recording()), "choose tighten | loosen").text
    assert guessed == replies()["missing"]["thread"]
