import json

import cv2
import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, Motion
from geotlm_lm.data.manifest import (
    ACTIONS,
    FOUND,
    GIVEN,
    NONE,
    ManifestRow,
    make_manifest,
    read_manifest,
    write_manifest,
)
from geotlm_lm.probe.rigid_flow import RigidFlow
from tests.data.action_clips import write_actions, write_image

HEADER = "clip_id,object_id,sensor,action,frames,background,fps\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    root = tmp_path_factory.mktemp("touchd")
    write_actions(root)
    rows = [
        f"{action},letter_l,gsmini,{action},letter_l/gsmini/{action}-0/[0-9]*.png,"
        f"letter_l/gsmini/{action}-0/bg.png,18"
        for action in ACTIONS
    ]
    (root / "clips.csv").write_text(HEADER + "\n".join(rows) + "\n")
    return root


def manifest(folder, *rows, header=HEADER, name="clips.csv"):
    (folder / name).write_text(header + "\n".join(rows) + "\n")
    return folder / name


def grey_frames(folder, count, *, side=16, first=20):
    """Frames whose grey levels tell their order."""
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(count):
        write_image(folder / f"{number}.png", np.full((side, side, 3), first + number, np.uint8))


def read_one(path):
    found = read_manifest(path)
    clips = list(found.clips(DIRECTED))
    return found, clips


def test_flow_reads_every_action_off_its_clip(folder):
    flow, found = RigidFlow(), read_manifest(folder / "clips.csv")
    motions = {row.clip_id: flow.predict(clip, DIRECTED) for row, clip in found.clips(DIRECTED)}
    assert motions == ACTIONS
    assert found.backgrounds == {GIVEN: 6}


def test_a_pattern_gives_frames_in_natural_order(folder):
    (_, clip), (row, _) = read_manifest(folder / "clips.csv").clips(ROTATIONS)
    assert row.motion in ROTATIONS  # the motions wanted alone are read
    direct = [folder / "letter_l" / "gsmini" / "rotate_cw-0" / f"{n}.png" for n in (8, 9, 10, 11)]
    again = read_manifest(manifest_of(folder, direct))
    (_, expected), *_ = again.clips(ROTATIONS)
    assert np.array_equal(clip.frames, expected.frames)
    assert clip.fps == 18


def manifest_of(folder, paths):
    names = ";".join(path.relative_to(folder).as_posix() for path in paths)
    return manifest(folder, f"direct,letter_l,,rotate_cw,{names},,", name="direct.csv")


def test_a_pattern_may_be_absolute_and_the_folder_hold_signs_of_one(tmp_path):
    root = tmp_path / "set [1]"
    grey_frames(root / "a", 3)
    rows = ["1,cap,,slide_up,a/*.png,,", f"2,cap,,slide_up,{tmp_path}/*/a/*.png,,"]
    found, clips = read_one(manifest(root, *rows))
    assert found.left_out == {}
    assert [len(clip) for _, clip in clips] == [3, 3]


def test_a_folder_stands_for_its_images_but_the_one_named_background(tmp_path):
    grey_frames(tmp_path / "a", 11)
    write_image(tmp_path / "a" / "background.png", np.full((16, 16, 3), 7, np.uint8))
    found, ((_, clip),) = read_one(manifest(tmp_path, "1,cap,,slide_up,a,,"))
    assert clip.frames[:, 0, 0, 0].tolist() == list(range(20, 31))
    assert clip.background[0, 0, 0] == 7
    assert found.backgrounds == {GIVEN: 1}


def test_a_recording_of_any_kind_may_stand_for_its_frames(tmp_path):
    np.save(tmp_path / "a.npy", np.zeros((5, 16, 16, 3), np.uint8))
    _, ((row, clip),) = read_one(manifest(tmp_path, "1,cap,,slide_up,a.npy,,30"))
    assert (len(clip), clip.fps, clip.name, row.object_id) == (5, 30, "1", "cap")


def test_a_tiff_of_several_pages_stands_for_its_frames_and_single_pages_are_images(tmp_path):
    pages = [np.full((16, 16, 3), grey, np.uint8) for grey in (20, 21, 22)]
    assert cv2.imwritemulti(str(tmp_path / "a.tif"), pages)
    _, ((_, clip),) = read_one(manifest(tmp_path, "1,cap,,slide_up,a.tif,,"))
    assert clip.frames[:, 0, 0, 0].tolist() == [20, 21, 22]
    (tmp_path / "b").mkdir()
    for place, page in enumerate(pages):
        write_image(tmp_path / "b" / f"{place}.tif", page)
    _, ((_, single),) = read_one(manifest(tmp_path, "1,cap,,slide_up,b,,"))
    assert np.array_equal(single.frames, clip.frames)


def test_an_untouched_start_becomes_the_background_and_is_counted(tmp_path):
    rng = np.random.default_rng(0)
    frames = np.full((9, 48, 64, 3), 120.0) + rng.normal(0, 0.5, (9, 48, 64, 3))
    frames[4:, 16:32, 20:40] += 40
    np.save(tmp_path / "a.npy", frames.astype(np.uint8))
    found, ((_, clip),) = read_one(manifest(tmp_path, "1,cap,,slide_up,a.npy,,"))
    assert found.backgrounds == {FOUND: 1}
    assert np.abs(clip.background.astype(int) - 120).max() <= 3


def test_a_clip_without_untouched_frames_gets_no_background(tmp_path):
    grey_frames(tmp_path / "a", 4)
    found, ((_, clip),) = read_one(manifest(tmp_path, "1,cap,,slide_up,a,,"))
    assert clip.background is None
    assert found.backgrounds == {NONE: 1}


ROWS = (
    ManifestRow("1", "cap", "gsmini", Motion.LEFT, ("a/1.png", "a/2.png"), "a/bg.png", 18.0),
    ManifestRow("2", "key", "", Motion.CLOCKWISE, ("b.npy",)),
)


@pytest.mark.parametrize("name", ["out.csv", "out.jsonl"])
def test_what_is_written_is_read_back(tmp_path, name):
    write_manifest(tmp_path / name, ROWS)
    assert read_manifest(tmp_path / name).rows == ROWS


def test_a_path_that_a_csv_would_part_is_refused(tmp_path):
    row = ManifestRow("1", "cap", "", Motion.LEFT, ("a;b/1.png", "a;b/2.png"))
    with pytest.raises(UsageError, match=r"a;b/1.png: a path with ';' cannot stand in a CSV"):
        write_manifest(tmp_path / "out.csv", [row])
    write_manifest(tmp_path / "out.jsonl", [row])
    assert read_manifest(tmp_path / "out.jsonl").rows == (row,)


@pytest.mark.parametrize(
    ("frames", "background", "said"),
    [
        ("**a/gone*.png", "", "bad: its frames name 0 files, expected 2 or more images"),
        ("a" * 300, "", "File name too long"),
        ("a/0.png", "", "bad: its frames name 1 file, expected 2 or more images"),
        ("a/0.png;a/gone.png", "", "gone.png: cannot be opened (No such file or directory)"),
        ("a/0.png;b/0.png", "", "b/0.png: is 24x24 pixels, 0.png is 16x16"),
        ("a/0.png;a.npy", "", "bad: its frames name 2 files, expected 2 or more images, or one"),
        ("gone.npy", "", "gone.npy: no such file or folder"),
        ("a", "gone.png", "gone.png: no such file or folder"),
        ("a", "b/0.png", "the background has shape (24, 24, 3)"),
    ],
)
def test_a_clip_that_cannot_be_read_is_left_out_and_named(tmp_path, frames, background, said):
    grey_frames(tmp_path / "a", 4)
    grey_frames(tmp_path / "b", 1, side=24)
    rows = ["good,cap,,slide_up,a,,", f"bad,cap,,slide_up,{frames},{background},"]
    found, clips = read_one(manifest(tmp_path, *rows))
    assert [row.clip_id for row, _ in clips] == ["good"]
    assert list(found.left_out) == ["bad"]
    assert said in found.left_out["bad"]


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("1,cap,,press,a,,", "clips.csv:2: the action 'press' is not known; choose one of"),
        ("1,cap,,slide_up,,,", "clips.csv:2: clip_id, object_id or frames is empty"),
        ("1,cap,,slide_up,a,,nan", "clips.csv:2: 'nan' frames per second, expected a number"),
        ("1,cap,,slide_up,a,,-3", "clips.csv:2: '-3' frames per second, expected a number"),
        ("1,cap,,slide_up,a\0b,,", "clips.csv:2: a path holds a zero byte, expected text"),
        ("1,cap,,slide_up", "clips.csv:2: clip_id, object_id or frames is empty"),
        (f"1,cap,,slide_up,{'a' * 200_000},,", "is no table (field larger than field limit"),
        ("1,cap,,slide_up,a,,\n1,cap,,slide_up,a,,", "the clip '1' stands in it more than once"),
        ("", "holds no row"),
    ],
)
def test_an_unusable_row_is_refused_with_its_line(tmp_path, row, said):
    with pytest.raises(UnreadableClip) as caught:
        read_manifest(manifest(tmp_path, row))
    assert said in str(caught.value)


def test_missing_columns_are_named(tmp_path):
    with pytest.raises(
        UnreadableClip, match="lacks the columns object_id, frames, expected clip_id"
    ):
        read_manifest(manifest(tmp_path, header="clip_id,action\n"))


@pytest.mark.parametrize("line", ["[1]", "{", "[" * 100_000, json.dumps({"clip_id": "1"})])
def test_a_broken_line_of_json_is_refused_with_its_number(tmp_path, line):
    path = manifest(tmp_path, "", line, header="", name="clips.jsonl")
    with pytest.raises(UnreadableClip, match=r"clips.jsonl:2: is no JSON object with clip_id"):
        read_manifest(path)


@pytest.mark.parametrize("name", ["gone.csv", "notes.txt"])
def test_something_else_is_no_manifest(tmp_path, name):
    (tmp_path / "notes.txt").write_text("hello")
    with pytest.raises(UnreadableClip, match="is no manifest, expected a .csv or .jsonl file"):
        read_manifest(tmp_path / name)


ANY = r"(?P<object>\w+)/(?P<action>\w+)/(?P<frame>\d+)"
PATTERN = (
    r"(?P<object>[^/]+)/(?P<sensor>[^/]+)/(?P<action>[a-z_]+)-(?P<trial>\d+)/(?P<frame>\w+)[.]png"
)


@pytest.fixture(scope="module")
def actions_root(tmp_path_factory):
    folder = tmp_path_factory.mktemp("touchd")
    write_actions(folder, actions=("rotate_cw", "slide_left"))
    write_actions(folder, body="key", sensor="digit", actions=("slide_left",))
    return folder


def touch(root, *names):
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        write_image(root / name, np.zeros((16, 16, 3), np.uint8))


def test_frames_are_gathered_into_clips_in_natural_order(actions_root):
    made = make_manifest(actions_root, PATTERN, background_frame="bg")
    clips = {(row.object_id, row.sensor, row.motion) for row in made.rows}
    assert clips == {
        ("letter_l", "gsmini", Motion.CLOCKWISE),
        ("letter_l", "gsmini", Motion.LEFT),
        ("key", "digit", Motion.LEFT),
    }
    clockwise = next(row for row in made.rows if row.motion == Motion.CLOCKWISE)
    assert clockwise.clip_id == "letter_l/gsmini/rotate_cw/0"
    folder = "letter_l/gsmini/rotate_cw-0"
    assert clockwise.frames == tuple(f"{folder}/{number}.png" for number in (8, 9, 10, 11))
    assert clockwise.background == f"{folder}/bg.png"
    assert {len(row.frames) for row in make_manifest(actions_root, PATTERN).rows} == {5}


@pytest.mark.parametrize("place", ["", "elsewhere/deep"])
def test_the_written_manifest_reads_wherever_it_lies(actions_root, tmp_path, place):
    (tmp_path / place).mkdir(parents=True, exist_ok=True)
    out = tmp_path / place / "clips.jsonl"
    made = make_manifest(
        actions_root, PATTERN, relative_to=out.parent, background_frame="bg", fps=18.0
    )
    write_manifest(out, made.rows)
    read = read_manifest(out)
    clips = list(read.clips(DIRECTED))
    assert len(clips) == 3
    assert read.left_out == {}
    assert read.backgrounds == {GIVEN: 3}
    assert {clip.fps for _, clip in clips} == {18}


def test_an_unknown_action_is_refused_with_its_count(tmp_path):
    touch(tmp_path, "cap/press/1.png", "cap/press/2.png", "cap/slide_up/1.png")
    with pytest.raises(UsageError) as caught:
        make_manifest(tmp_path, ANY)
    assert str(caught.value) == (
        "found the actions 'press' (2 images), expected rotate_cw, rotate_ccw, slide_left, "
        "slide_right, slide_up, slide_down; say what they mean with --action WORD=ACTION, or "
        "narrow the pattern."
    )


def test_without_a_frame_group_the_path_gives_the_order_and_hidden_copies_are_none(tmp_path):
    touch(tmp_path, *(f"cap/slide_up/{name}.png" for name in ("2", "10", "9", "._9")))
    (row,) = make_manifest(tmp_path, r"(?P<object>\w+)/(?P<action>\w+)/").rows
    assert [name.rsplit("/")[-1] for name in row.frames] == ["2.png", "9.png", "10.png"]


@pytest.mark.parametrize(
    ("pattern", "said"),
    [
        ("(?P<object>", "is no regular expression"),
        (r"(?P<object>\w+)", "lacks the group action"),
        (r"(?P<object>\w+)(?P<action>\w+)", "lacks the group frame"),
        (r"(?P<object>\w+)(?P<action>\w+)(?P<light>\w+)", "has the group light"),
    ],
)
def test_an_unusable_pattern_or_meaning_is_refused(tmp_path, pattern, said):
    with pytest.raises(UsageError, match=said):
        make_manifest(tmp_path, pattern, background_frame="0" if "frame" in said else None)
    with pytest.raises(UsageError, match="'twist' is to mean 'turn'; choose one of rotate_cw"):
        make_manifest(tmp_path, ANY, actions={"twist": "turn"})


def test_a_pattern_that_fits_nothing_is_refused_with_a_path(tmp_path):
    touch(tmp_path, "some/1.png")
    with pytest.raises(UnreadableClip, match="fits none of 1 images, the first of them some/1.png"):
        make_manifest(tmp_path, r"(?P<object>\w+)-(?P<action>\w+)")
    with pytest.raises(UnreadableClip, match="no such folder"):
        make_manifest(tmp_path / "gone", ANY)
