"""What is told of the recording itself."""

import pytest

from geotlm_lm.conversation.recording_questions import recording_sentence


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
    assert recording_sentence(topic, (48, 64), fps, (3, 5, 5, 7)) == text


def test_all_frames_of_a_tracked_recording_are_told():
    told = recording_sentence("frames", (48, 64), None, tuple(range(3, 103)))
    assert told == "I track 100 frames, from 3 to 102."


def test_times_are_told_of_the_frames_used():
    told = recording_sentence("duration", (10, 10), 25.0, (3, 5, 9, 13))
    assert told.startswith("From frame 3 to frame 13, the first and the last used, 0.4 s pass;")
    told = recording_sentence("interval", (10, 10), 25.0, (3, 5, 9, 13))
    assert told == "At 25 frames per second, 0.04 s from one frame to the next."
    assert "give it by fps" in recording_sentence("duration", (10, 10), None, (3, 5))
