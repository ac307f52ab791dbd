"""What is told of small motions and of none: shares by hand, and every row in one table."""

import pytest

from geotlm_lm.benchmarks.candidates import CANDIDATES, METHODS, TOLD, Leanings, ways_of
from geotlm_lm.benchmarks.detection import (
    DETECTION,
    case_of,
    moved_rows,
    surviving_rows,
    unmoved_rows,
)
from geotlm_lm.benchmarks.imprints import MovedImprint
from geotlm_lm.benchmarks.rendering import tables
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component
from tests.answering.scripted import believed


def seen(told, turn=0.0, right=0.0):
    path = (turn, right, 0.0)
    ways = dict.fromkeys(METHODS, ways_of(*path))
    return Leanings(believed(told), ways, dict.fromkeys(CANDIDATES, path))


def moved(way, path_px=0.0):
    return MovedImprint(None, way, path_px, "dots", "cap", "cap", "four")


def test_what_is_told_rightly_wrongly_or_not_at_all_stands_apart_from_the_leaning():
    own = moved(Motion.CLOCKWISE, 0.3)
    clips = [
        (own, seen("clockwise", turn=0.3)),
        (own, seen("counterclockwise", turn=-0.2)),
        (own, seen("still", turn=0.1)),
        (own, Leanings()),  # refused
    ]
    rows = {row.variant: row for row in moved_rows(f"{case_of(own)}, tune", clips, 0)}
    told = rows[TOLD]
    assert (told.right, told.detail["claimed"], told.detail["wrong_way"]) == (0.25, 0.5, 0.25)
    assert told.detail["refused"] == 1
    assert {rows[name].right for name in METHODS} == {0.5}
    assert rows["green_chained"].detail["turn_px_95"] == pytest.approx(0.29)
    shown = "\n".join(tables(DETECTION, list(rows.values())))
    assert "dots, turns by 0.3 px, four frames, tune" in shown


@pytest.mark.parametrize("way", [Motion.STILL, Motion.PRESS, Motion.NONE])
def test_where_nothing_turns_or_slides_nothing_may_be_told(way):
    own = moved(way)
    clips = [(own, seen("still", right=0.05)), (own, seen("left", right=-0.4)), (own, Leanings())]
    told, *others = unmoved_rows(f"{case_of(own)}, tune", clips, 0)
    assert told.right == pytest.approx(2 / 3)
    assert told.detail[Component.SLIDE] == pytest.approx(1 / 3)
    assert told.detail[Component.TURN] == 0
    assert len(others) == (len(CANDIDATES) if way is Motion.STILL else 0)
    shown = "\n".join(tables(DETECTION, [told, *others]))
    assert shown.count(told.case) == 1 + len(others)


def test_a_turn_of_a_press_survives_where_it_turns_round_with_the_clip():
    press, lift = moved(Motion.PRESS), moved(Motion.RELEASE)
    pressed = [(press, seen(way)) for way in ("clockwise", "clockwise", "still")]
    backwards = [(lift, seen(way)) for way in ("counterclockwise", "clockwise", "left")]
    (row,) = surviving_rows("here", pressed, backwards, 0)
    assert (row.count, row.right) == (2, 0.5)
    assert not list(surviving_rows("here", pressed[2:], backwards[2:], 0))
