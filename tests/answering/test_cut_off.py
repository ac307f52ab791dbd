"""An imprint that the border of the image cuts through is told with less certainty."""

from dataclasses import replace

from tests.answering.scripted import feeling, recording

QUESTION = "Which way is it moving?"


def test_it_is_said_that_the_imprint_is_cut_off(bundle):
    answerer = feeling(bundle, "press")
    clip = recording()
    columns = clip.frames.shape[2]
    frames = clip.frames.copy()
    frames[:] = clip.frames[0]
    frames[1:, :, : columns // 12] //= 2
    note = "The border of the image cuts the imprint off: answers are less sure."
    assert note in answerer.ask(answerer.encode(replace(clip, frames=frames)), QUESTION).notes
    assert note not in answerer.ask(answerer.encode(clip), QUESTION).notes
