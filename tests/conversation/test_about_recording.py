"""Who asks about the recording itself is told so; who asks about a motion never is."""

import numpy as np
import pytest

from geotlm_lm.conversation.about_recording import (
    asked_of_recording,
    told_of_recording,
)
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.data.questions import questions_for
from geotlm_lm.data.templates import load_templates

TEMPLATES = load_templates()


@pytest.mark.parametrize(
    ("text", "topic"),
    [
        ("What is the resolution?", "size"),
        ("How large are the frames?", "size"),
        ("How many pixels wide is the image?", "size"),
        ("what's the size of the video", "size"),
        ("How many pixels does the image have?", "size"),
        ("Number of pixels in the image?", "size"),
        ("What is the number of frames?", "frames"),
        ("What are the dimensions of the frames?", "size"),
        ("What is the frame rate?", "rate"),
        ("How many frames per second?", "rate"),
        ("At what frame rate was it recorded?", "rate"),
        ("fps?", "rate"),
        ("How many frames are there?", "frames"),
        ("How many frames are in the clip?", "frames"),
        ("how many frames does the recording have", "frames"),
        ("How many frames did you use?", "frames"),
        ("Which frames did you look at?", "frames"),
        ("How long is the recording?", "duration"),
        ("Duration of the slip?", "duration"),
        ("How long does it slide?", "duration"),
        ("How much time passes between the first and the last used frame?", "duration"),
        ("How long did the turn take?", "duration"),
        ("What is the duration of the clip?", "duration"),
        ("What's the time between frames?", "interval"),
        ("What is the interval between two frames?", "interval"),
    ],
)
def test_a_question_about_the_recording_is_known_by_its_words(text, topic):
    assert asked_of_recording(text) == topic


@pytest.mark.parametrize(
    "text",
    [
        "How many pixels did it move?",
        "How many pixels per frame?",
        "Number of pixels?",
        "How many frames does it turn?",
        "How long does it turn clockwise?",
        "How long is the cap?",
        "How long will it turn?",
        "How far between two frames?",
        "How large is the turn?",
        "How large is it?",
        "What is the size of the motion?",
        "How many pixels wide is the contact?",
        "At what rate does it turn?",
        "What is the rate?",
        "How far does the image move?",
        "Which way does the frame move?",
    ],
)
def test_a_question_about_a_motion_is_none(text):
    assert asked_of_recording(text) is None


@pytest.mark.parametrize("wordings", ["seen", "held_out"])
@pytest.mark.parametrize("type_id", TEMPLATES.types)
def test_no_template_asks_about_the_recording(type_id, wordings):
    rng = np.random.default_rng(5)
    asked = [
        one.question
        for motion in Motion
        for one in questions_for(
            MotionLabel(motion), rng, types=[type_id], wordings=wordings, per_type=4
        )
    ]
    assert [text for text in asked if asked_of_recording(text)] == []


@pytest.mark.parametrize(
    ("topic", "fps", "text"),
    [
        ("size", None, "The frames are 64 px wide and 48 px high."),
        ("rate", 25.0, "The recording has 25 frames per second."),
        ("rate", None, "The recording gives no frame rate; give it by fps."),
        (
            "frames",
            None,
            "I look at few frames of a recording, here at 3, 5, 7, counted from 0; "
            "`geotlm-lm info` tells how many it has.",
        ),
    ],
)
def test_the_recording_is_told_in_a_sentence(topic, fps, text):
    assert told_of_recording(topic, (48, 64), fps, (3, 5, 5, 7)) == text


def test_times_are_told_of_the_frames_used():
    told = told_of_recording("duration", (10, 10), 25.0, (3, 5, 9, 13))
    assert told.startswith("From frame 3 to frame 13, the first and the last used, 0.4 s pass;")
    told = told_of_recording("interval", (10, 10), 25.0, (3, 5, 9, 13))
    assert told == "At 25 frames per second, 0.04 s from one frame to the next."
    assert "give it by fps" in told_of_recording("duration", (10, 10), None, (3, 5))
