import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.data.touch_table import (
    CurvePoint,
    Moment,
    Quality,
    read_gold_turns,
    read_touch_table,
)

HEADER = "clip,object,object_family,fps,contact_start,contact_end\n"


@pytest.fixture
def table(tmp_path):
    def write(text):
        path = tmp_path / "clips.csv"
        path.write_text(text)
        return path

    return write


def test_touched_recordings_are_read_and_untouched_ones_left_out(table):
    path = table(HEADER + "clips/a.mov,cap,caps,25.0,20,40\nclips/b.mov,key,keys,25.0,,\n")
    (row,) = read_touch_table(path)
    assert row.path == path.parent / "clips/a.mov"
    assert (row.fps, row.contact_start, row.contact_end) == (25.0, 20, 40)
    assert (row.object_id, row.object_family) == ("cap", "caps")
    (silent,) = read_touch_table(table("clip,fps,contact_start,contact_end\nx/cup_1.mov,25,5,9\n"))
    assert (silent.object_id, silent.object_family) == ("cup_1", "cup_1")
    assert read_touch_table(path.parent / "gone.csv") == []


def test_the_idle_frames_end_before_the_touch_and_leave_the_first_out(table):
    (row,) = read_touch_table(table(HEADER + "a.mov,,,10,20,40\n"))
    assert row.idle == range(1, 17)
    assert row.surely_idle == range(1, 6)
    (row,) = read_touch_table(table(HEADER + "a.mov,,,10,3,40\n"))
    assert len(row.idle) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("clip,fps\na.mov,25\n", "found the columns clip, fps, expected clip, fps, contact_start"),
        (HEADER + "a.mov,,,25,9,5\n", "a.mov is touched from frame '9' to '5', expected two"),
        (HEADER + "a.mov,,,25,1,5\n", "the first above 1: idle frames come before it"),
        (HEADER + "x" * 200_000, "is no table .field larger than field limit"),
        (HEADER + "a.mov,,,fast,5,9\n", "a.mov has 'fast' frames per second"),
    ],
)
def test_a_bad_table_is_refused_in_one_sentence(table, text, message):
    with pytest.raises(UnreadableClip, match=message):
        read_touch_table(table(text))


def test_a_recording_that_ends_too_early_is_refused(table):
    (row,) = read_touch_table(table(HEADER + "a.mov,,,25,5,9\n"))
    row.check_length(10)
    with pytest.raises(UnreadableClip, match="names frame 9, the recording holds frames 0 to 8"):
        row.check_length(9)


TABLES = {
    "clips.csv": "clip,object_family,fps,contact_start,contact_end\nclips/a.mov,caps,25,9,40\n",
    "gold_turns.csv": (
        "clip,first_frame,last_frame,turn_deg_cw,half_width_deg,quality,turn_begin,turn_end,note\n"
        "clips/a.mov,10,30,-62,3.5,fair,12,33,bends; soft\n"
    ),
    "gold_curves.csv": "clip,frame,turn_deg_cw,half_width_deg\nclips/a.mov,20,-31,2\n",
    "gold_moments.csv": (
        "clip,half_turn_frame,plus_minus,frame_30deg,plus_minus_30\nclips/a.mov,19.7,0.5,,\n"
    ),
}


@pytest.fixture
def folder(tmp_path):
    def write(name="", old="", new=""):
        for table, text in TABLES.items():
            assert table != name or old in text
            (tmp_path / table).write_text(text.replace(old, new) if table == name else text)
        return tmp_path

    return write


def test_a_turn_is_read_with_its_course(folder):
    (turn,) = read_gold_turns(folder())
    assert (turn.recording.path.name, turn.object_family) == ("a.mov", "caps")
    assert (turn.first_frame, turn.last_frame, turn.turning) == (10, 30, (12, 33))
    assert (turn.turn_deg, turn.half_width_deg, turn.quality) == (-62.0, 3.5, Quality.FAIR)
    assert (turn.slack_deg, turn.note) == (3.5, "bends; soft")
    assert turn.curve == (CurvePoint(20, -31.0, 2.0),)
    assert (turn.half_turn, turn.past_30_deg) == (Moment(19.7, 0.5), None)


def test_what_is_not_there_is_not_read(folder):
    own = folder()
    for name in ("gold_curves.csv", "gold_moments.csv"):
        (own / name).unlink()
    (turn,) = read_gold_turns(own)
    assert (turn.curve, turn.half_turn, turn.past_30_deg) == ((), None, None)
    (own / "gold_turns.csv").unlink()
    assert read_gold_turns(own) == []


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("gold_turns.csv", "quality,", "", "found the columns clip, .* expected clip, .*quality"),
        ("gold_turns.csv", "fair", "good", ":2: found the quality 'good'; choose one of sure,"),
        ("gold_turns.csv", "10,30", "30,10", "'30' as first_frame and '10' as last_frame, exp"),
        ("gold_turns.csv", "12,33", ",33", "found '' as turn_begin and '33' as turn_end"),
        ("gold_turns.csv", "-62", "much", "found 'much' as turn_deg_cw, expected a number; corr"),
        ("gold_turns.csv", "-62", "0", "found a turn of 0 degrees, expected one way"),
        ("gold_turns.csv", "3.5", "-3.5", "'-3.5' as half_width_deg, expected a number of 0 or m"),
        ("clips.csv", "9,40", ",", "found 'clips/a.mov', expected a touched recording of clips.c"),
        ("gold_curves.csv", "a.mov", "b.mov", "'clips/b.mov', expected a recording of gold_turns"),
        ("gold_curves.csv", "20,", "31,", "found '31' as frame, expected one of 10 to 30"),
        ("gold_moments.csv", "0.5", "", "found '' as plus_minus, expected a number of 0 or more"),
    ],
)
def test_a_bad_table_of_turns_is_refused_in_one_sentence(folder, name, old, new, message):
    with pytest.raises(UnreadableClip, match=message) as refused:
        read_gold_turns(folder(name, old, new))
    assert str(refused.value).endswith(".")
