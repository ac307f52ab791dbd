import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.data.manifest import GIVEN, read_manifest
from geotlm_lm.data.manifest_maker import make_manifest
from geotlm_lm.data.manifest_rows import write_manifest
from tests.data.action_clips import write_actions, write_image

PATTERN = (
    r"(?P<object>[^/]+)/(?P<sensor>[^/]+)/(?P<action>[a-z_]+)-(?P<trial>\d+)/(?P<frame>\w+)[.]png"
)


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    folder = tmp_path_factory.mktemp("touchd")
    write_actions(folder, actions=("rotate_cw", "slide_left"))
    write_actions(folder, body="key", sensor="digit", actions=("slide_left",))
    return folder


def touch(root, *names):
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        write_image(root / name, np.zeros((16, 16, 3), np.uint8))


def test_frames_are_gathered_into_clips_in_natural_order(root):
    made = make_manifest(root, PATTERN, background_frame="bg")
    told = {(row.object_id, row.sensor, row.motion) for row in made.rows}
    assert told == {
        ("letter_l", "gsmini", Motion.CLOCKWISE),
        ("letter_l", "gsmini", Motion.LEFT),
        ("key", "digit", Motion.LEFT),
    }
    clockwise = next(row for row in made.rows if row.motion == Motion.CLOCKWISE)
    assert clockwise.clip_id == "letter_l/gsmini/rotate_cw/0"
    folder = "letter_l/gsmini/rotate_cw-0"
    assert clockwise.frames == tuple(f"{folder}/{number}.png" for number in (8, 9, 10, 11))
    assert clockwise.background == f"{folder}/bg.png"


def test_without_a_background_frame_every_picture_is_a_frame(root):
    assert {len(row.frames) for row in make_manifest(root, PATTERN).rows} == {5}


@pytest.mark.parametrize("place", ["", "elsewhere/deep"])
def test_the_written_manifest_reads_wherever_it_lies(root, tmp_path, place):
    (tmp_path / place).mkdir(parents=True, exist_ok=True)
    out = tmp_path / place / "clips.jsonl"
    made = make_manifest(root, PATTERN, relative_to=out.parent, background_frame="bg", fps=18.0)
    write_manifest(out, made.rows)
    read = read_manifest(out)
    clips = list(read.clips(DIRECTED))
    assert len(clips) == 3
    assert read.left_out == {}
    assert read.backgrounds == {GIVEN: 3}
    assert {clip.fps for _, clip in clips} == {18}


def test_other_words_for_actions_are_said(tmp_path):
    touch(tmp_path, "cap/twist/1.png", "cap/twist/2.png")
    pattern = r"(?P<object>\w+)/(?P<action>\w+)/(?P<frame>\d+)"
    (row,) = make_manifest(tmp_path, pattern, actions={"twist": "rotate_ccw"}).rows
    assert row.motion == Motion.COUNTERCLOCKWISE


def test_an_unknown_action_is_refused_with_its_count(tmp_path):
    touch(tmp_path, "cap/press/1.png", "cap/press/2.png", "cap/slide_up/1.png")
    with pytest.raises(UsageError) as caught:
        make_manifest(tmp_path, r"(?P<object>\w+)/(?P<action>\w+)/(?P<frame>\d+)")
    assert str(caught.value) == (
        "found the actions 'press' (2 images), expected rotate_cw, rotate_ccw, slide_left, "
        "slide_right, slide_up, slide_down; say what they mean with --action WORD=ACTION, or "
        "narrow the pattern."
    )


def test_a_meaning_that_is_no_action_is_refused(tmp_path):
    with pytest.raises(UsageError, match="'twist' is to mean 'turn', expected one of rotate_cw"):
        make_manifest(tmp_path, r"(?P<object>\w+)(?P<action>\w+)", actions={"twist": "turn"})


def test_clips_of_one_frame_and_unmatched_images_are_counted(tmp_path):
    touch(tmp_path, "cap/slide_up/1.png", "key/slide_up/1.png", "key/slide_up/2.png", "notes.png")
    made = make_manifest(tmp_path, r"(?P<object>\w+)/(?P<action>\w+)/(?P<frame>\d+)")
    assert [row.object_id for row in made.rows] == ["key"]
    assert made.too_short == ("cap/slide_up",)
    assert [path.name for path in made.unmatched] == ["notes.png"]


def test_without_a_frame_group_the_path_gives_the_order(tmp_path):
    touch(tmp_path, *(f"cap/slide_up/{number}.png" for number in (2, 10, 9)))
    (row,) = make_manifest(tmp_path, r"(?P<object>\w+)/(?P<action>\w+)/").rows
    assert [name.rsplit("/")[-1] for name in row.frames] == ["2.png", "9.png", "10.png"]


def test_hidden_copies_are_passed_over(tmp_path):
    touch(tmp_path, "cap/slide_up/1.png", "cap/slide_up/2.png", "cap/slide_up/._1.png")
    (row,) = make_manifest(tmp_path, r"(?P<object>\w+)/(?P<action>\w+)/").rows
    assert len(row.frames) == 2


@pytest.mark.parametrize(
    ("pattern", "said"),
    [
        ("(?P<object>", "is no regular expression"),
        (r"(?P<object>\w+)", "lacks the group action"),
        (r"(?P<object>\w+)(?P<action>\w+)(?P<light>\w+)", "has the group light"),
    ],
)
def test_an_unusable_pattern_is_refused(tmp_path, pattern, said):
    with pytest.raises(UsageError, match=said):
        make_manifest(tmp_path, pattern)


def test_a_background_frame_needs_frames_with_names(tmp_path):
    with pytest.raises(UsageError, match="lacks the group frame"):
        make_manifest(tmp_path, r"(?P<object>\w+)(?P<action>\w+)", background_frame="0")


def test_a_pattern_that_fits_nothing_is_refused_with_a_path(tmp_path):
    touch(tmp_path, "some/1.png")
    with pytest.raises(UnreadableClip, match="fits none of 1 images, the first of them some/1.png"):
        make_manifest(tmp_path, r"(?P<object>\w+)-(?P<action>\w+)")


def test_a_missing_folder_is_refused(tmp_path):
    with pytest.raises(UnreadableClip, match="no such folder"):
        make_manifest(tmp_path / "gone", r"(?P<object>\w+)(?P<action>\w+)")
