"""Two clips: how their motions relate, and that only like amounts are compared."""

from dataclasses import replace

import pytest

from geotlm_lm.core.edit import MIRRORED, opposite
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.query.decision import Evidence
from geotlm_lm.query.execute import decide
from geotlm_lm.query.forms import as_json, decided, in_form
from geotlm_lm.query.tell import tell
from geotlm_lm.query.text import read
from geotlm_lm.query.types import FORMS
from tests.answering.scripted import believed
from tests.query.test_execute import FRAME, RECORDING, certain, whole

WAYS = (*DIRECTED, Motion.PRESS, Motion.RELEASE)
OTHER_SIZE = replace(RECORDING, columns=640, rows=480)


def compared(text, one, other, recording=RECORDING):
    second = Evidence(believed(other), recording=recording)
    evidence = Evidence(believed(one), second, recording=RECORDING)
    return decide(read(text).parts[0], evidence, FRAME)


@pytest.mark.parametrize("one", WAYS)
def test_two_ways_are_the_same_different_opposite_or_mirrored(one):
    for other in WAYS:
        related = {
            relation: compared(f"compare {relation} way", one, other).verdict
            for relation in ("same", "different", "opposite", "mirrored")
        }
        assert related == {
            "same": one is other,
            "different": one is not other,
            "opposite": other is opposite(one),
            "mirrored": other is MIRRORED.of_way(one),
        }


@pytest.mark.parametrize(
    ("text", "one", "other", "recording", "missing"),
    [
        ("compare which-more", "clockwise", "left", RECORDING, "comparable"),
        ("compare which-more", "left", "press", RECORDING, "comparable"),
        ("compare which-more turn", "clockwise", "left", RECORDING, None),
        ("compare which-more", "left", "left", OTHER_SIZE, "comparable"),
        ("compare which-more", "clockwise", "clockwise", OTHER_SIZE, None),
    ],
)
def test_amounts_of_different_things_are_not_compared(text, one, other, recording, missing):
    assert compared(text, one, other, recording).missing == missing


@pytest.mark.parametrize(
    ("text", "one", "other", "options", "verdict"),
    [
        ("compare which-more turn", "clockwise", "clockwise", (), None),
        ("compare which-more turn", "left", "clockwise", (1,), None),
        ("compare which-more turn", "left", "right", (), None),
        ("compare more turn", "clockwise", "clockwise", (), False),
        ("compare same amount", "clockwise", "clockwise", (), True),
        ("compare opposite", "still", "still", (), False),
    ],
)
def test_what_is_alike_is_neither_more_nor_opposite(text, one, other, options, verdict):
    found = compared(text, one, other)
    assert (found.options, found.verdict) == (options, verdict)


def test_which_goes_further_is_as_sure_as_their_spreads_are_apart():
    part, sure = read("compare which-more turn").parts[0], []
    for spread in (0.05, 0.3, 1.0):
        near = Evidence(believed("clockwise", deg=12, spread=spread), recording=RECORDING)
        far = believed("clockwise", deg=20, spread=spread)
        found = decide(part, Evidence(far, near, recording=RECORDING), FRAME)
        assert found.options == (0,)
        sure.append(found.probability)
    assert sure == sorted(sure, reverse=True)
    assert sure[0] > 0.9 > 0.7 > sure[-1]


def of_two_recordings(text):
    """The first turns, slides and is let go; of the second, at 50 Hz, only the touch is kept."""
    track = whole()
    held = replace(track, events=track.events[:2])
    faster = replace(RECORDING, rate_hz=50.0, frames=51)
    second = Evidence(certain(), recording=faster, track=held)
    evidence = Evidence(certain(turn=20, right=-30), second, RECORDING, track)
    return decide(read(text).parts[0], evidence, FRAME)


@pytest.mark.parametrize(
    ("text", "first", "second"),
    [
        ("of-each > how-often turn", "1 turn: it turns", "no turns"),
        ("of-each > how-long turn", "for 1.0 s: it turns", "it does not turn"),
        ("of-both > when turn begin", "at 1.0 s: it turns", "it does not turn"),
        ("of-both > order", "it touches at 0.0 s", "it touches at 0.0 s"),
        ("of-each > recording frames", "100 frames", "51 frames"),
        ("of-both > how-sure", "about", "about"),
    ],
)
def test_times_and_files_of_two_are_told_of_each_by_itself(text, first, second):
    found = of_two_recordings(text)
    told = tell(found, RECORDING)
    assert told.startswith(f"The first: {first}")
    assert f"; the second: {second}" in told
    assert all(in_form([found], form, RECORDING) for form in FORMS)


def test_counts_of_two_are_given_one_by_one_and_of_the_one_that_is_named_alone():
    found = of_two_recordings("of-each > how-often turn")
    assert decided(found, RECORDING) == "1; 0"
    assert tell(of_two_recordings("of-second > recording frames"), RECORDING) == "51 frames."
    assert [one["count"] for one in as_json([found], RECORDING, 1.0)["each"]] == [1, 0]


@pytest.mark.parametrize("ask", ["help", "not-understood", "talk thanks", "setup frame"])
def test_what_no_clip_answers_is_the_same_of_both(ask):
    found = compared(f"of-both > {ask}", "left", "left")
    assert tell(found) == tell(compared(ask, "left", "left"))
