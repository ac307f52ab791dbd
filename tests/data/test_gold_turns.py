import pytest

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.data.gold_turns import CurvePoint, Moment, Quality, read_gold_turns

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
        ("gold_turns.csv", "fair", "good", ":2: found the quality 'good', expected one of sure,"),
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
def test_a_bad_table_is_refused_in_one_sentence(folder, name, old, new, message):
    with pytest.raises(UnreadableClip, match=message) as refused:
        read_gold_turns(folder(name, old, new))
    assert str(refused.value).endswith(".")
