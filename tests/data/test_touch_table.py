import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.data.touch_table import read_touch_table

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
