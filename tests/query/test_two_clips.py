"""Two clips: how their motions relate, and that only like amounts are compared."""

from dataclasses import replace

import pytest

from geotlm_lm.core.labels import DIRECTED, Motion, mirror, reverse
from geotlm_lm.query.decision import Evidence
from geotlm_lm.query.execute import decide
from geotlm_lm.query.text import read
from tests.answering.scripted import believed
from tests.query.test_execute import FRAME, RECORDING

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
            "opposite": other is reverse(one),
            "mirrored": other is mirror(one),
        }


@pytest.mark.parametrize(
    ("text", "one", "other", "recording", "missing"),
    [
        ("compare which-more", "clockwise", "left", RECORDING, "comparable"),
        ("compare which-more", "left", "press", RECORDING, "comparable"),
        ("compare which-more turn", "clockwise", "left", RECORDING, None),
        ("compare which-more", "left", "left", OTHER_SIZE, "comparable"),
        ("compare which-more", "clockwise", "clockwise", OTHER_SIZE, None),
        ("compare which-more", "press", "press", OTHER_SIZE, None),
    ],
)
def test_amounts_of_different_things_are_not_compared(text, one, other, recording, missing):
    assert compared(text, one, other, recording).missing == missing


@pytest.mark.parametrize(
    ("text", "one", "other", "options", "verdict"),
    [
        ("compare which-more turn", "clockwise", "clockwise", (), None),
        ("compare which-more turn", "left", "clockwise", (1,), None),
        ("compare which-less turn", "left", "clockwise", (0,), None),
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
