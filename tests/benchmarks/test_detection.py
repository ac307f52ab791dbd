"""What is told of small motions, of none and of contact: shares by hand, rows in their tables."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from geotlm_lm.benchmarks.candidates import CANDIDATES, METHODS, TOLD, Leanings, ways_of
from geotlm_lm.benchmarks.cases import HALVES
from geotlm_lm.benchmarks.detection import (
    CONTACT,
    DETECTION,
    NEVER,
    Recording,
    case_of,
    contact_grades,
    contact_recordings,
    moved_rows,
    surviving_rows,
    unmoved_rows,
)
from geotlm_lm.benchmarks.harness import Run
from geotlm_lm.benchmarks.imprints import GRIPS, RELEASES, MovedImprint
from geotlm_lm.benchmarks.rendering import tables
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.twist import Component
from geotlm_lm.track.events import EventKind
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


def graded(begin, touched, kinds=(), is_known=True, only_presses=True):
    clip = Clip(np.zeros((len(touched), 8, 8, 3), np.uint8))
    recording = Recording(clip, clip.frames[0], "dots", "cap", begin, only_presses)
    track = SimpleNamespace(
        numbers=np.arange(len(touched)),
        is_touched=np.array(list(touched)) == "x",
        events=[SimpleNamespace(kind=kind) for kind in kinds],
    )
    belief = SimpleNamespace(is_contact_known=is_known)
    found = contact_grades(recording, SimpleNamespace(track=track, belief=belief))
    return {what: right for what, right in found if not right}


@pytest.mark.parametrize(
    ("begin", "touched", "options", "wrong"),
    [
        (8, "." * 10 + "x" * 10, {}, []),
        (8, "." * 14 + "x" * 6, {}, ["begins within 3 frames"]),
        (8, "x" * 20, {}, ["no touch told before it", "begins within 3 frames"]),
        (8, "x" * 20, {"is_known": False}, ["contact known", "begins within 3 frames"]),
        (8, "." * 8 + "x" * 8, {"kinds": [EventKind.RELEASE]}, ["press not told as release"]),
        (NEVER, "....x", {}, ["no touch told"]),
        (NEVER, "....x", {"is_known": False}, ["contact known"]),
        (0, "xxx..", {"kinds": [EventKind.RELEASE], "only_presses": False}, []),
        (0, "x....", {}, ["touch told"]),
    ],
)
def test_a_recording_is_wrong_for_its_own_reason(begin, touched, options, wrong):
    assert list(graded(begin, touched, **options)) == wrong


def test_what_is_refused_tells_nothing():
    clip = Clip(np.zeros((20, 8, 8, 3), np.uint8))
    recording = Recording(clip, clip.frames[0], "dots", "cap", 8)
    wrong = [what for what, right in contact_grades(recording, None) if not right]
    assert wrong == ["contact known", "begins within 3 frames"]


@pytest.fixture
def folder(tmp_path):
    """Two releases and an untouched grip of ten frames, and no other set."""
    rng = np.random.default_rng(0)
    own = tmp_path / RELEASES
    lines = ["name,label"]
    for name, label in (
        ("empty_tr_1", "no contact"),
        ("gel_tr_1", "release (grip opens)"),
        ("hard_rubber_tr_1", "release (grip opens)"),
    ):
        (own / name).mkdir(parents=True)
        for number in range(10):
            frame = rng.integers(100, 110, (48, 64, 3)).astype(np.uint8)
            frame[16:32, 20:40] += 0 if label == "no contact" else 60
            cv2.imwrite(str(own / name / f"{number:02d}.png"), frame)
        lines.append(f"{name},{label}")
    cv2.imwrite(str(own / "idle.png"), np.full((48, 64, 3), 105, np.uint8))
    (own / "labels.csv").write_text("\n".join(lines) + "\n")
    assert not (tmp_path / GRIPS).exists()
    return tmp_path


def test_grips_are_shown_opening_closing_and_after_an_untouched_gel(folder):
    kinds = {half: [(r.kind, r.begin) for r in contact_recordings(folder, half)] for half in HALVES}
    of_one = [
        ("letac, touched throughout", 0),
        ("letac, played backwards", 0),
        ("letac, begins untouched", 10),
    ]
    assert kinds["report"] == of_one
    assert kinds["tune"] == [("letac, nothing touches", NEVER), *of_one]


def test_each_half_is_shown_with_and_without_its_idle_gel(folder, tiny_answerer):
    rows = list(CONTACT.run(Run(is_quick=True, real=folder, answerer_given=tiny_answerer)))
    assert {row.variant for row in rows} == {"idle gel found", "idle gel given"}
    assert {row.case.split(":")[0].rpartition(", ")[2] for row in rows} == set(HALVES)
