"""`simulate` and `simulate-clip` write what `info` and `answer` read back."""

import json

import numpy as np
import pytest

from geotlm_lm.recordings.read import read_clip
from tests.cli import running


@pytest.fixture
def run(capsys):
    """Run `simulate` with some options."""
    return lambda *options: running.run(capsys, "simulate", *options)


@pytest.fixture
def run_clip(capsys):
    """Run `simulate-clip` with a file and some options."""
    return lambda *options: running.run(capsys, "simulate-clip", *options)


def label_in(path):
    with np.load(path) as stored:
        return json.loads(str(stored["label"]))


def twist_in(path):
    label = label_in(path)
    travel_mm = np.multiply(label["travel_px"], label["mm_per_px"])
    return label["rotation_deg"], *travel_mm, label["depth_change_mm"]


def test_a_simulated_clip_is_a_readable_recording_with_its_label(tmp_path, run, run_clip):
    path, again = tmp_path / "folder" / "clip.npz", tmp_path / "again.npz"
    options = ("--motion", "left", "--object", "key", "--seed", 3)
    assert run_clip(path, *options)[:2] == (0, f"{path}\n")
    clip = read_clip(path)
    assert clip.frames.shape == (4, 224, 224, 3)
    assert clip.background is not None
    assert not [note for note in clip.notes if "squashed" in note]  # it knows its own camera
    assert (label_in(path)["motion"], label_in(path)["object"]) == ("left", "key")
    # The wording of before the two commands were apart.
    assert run("--clip", again, *options)[0] == run(f"--clip={again}", *options, "--force")[0] == 0
    assert again.read_bytes() == path.read_bytes()


def test_a_clip_turns_slides_and_presses_at_once_by_as_much_as_was_asked_for(tmp_path, run_clip):
    moves = ("--turn", 20, "--slide-right", 0.8, "--slide-down", -0.2, "--press", 0.1)
    assert run_clip(tmp_path / "a.npz", *moves)[0] == 0
    pivot = ("--turn", -20, "--pivot-right", 3, "--depth", 0.8, "--markers", "--object", "coin")
    assert run_clip(tmp_path / "b.npz", *pivot)[0] == 0
    plain, marked = (np.load(tmp_path / name)["background"] for name in ("a.npz", "b.npz"))
    assert (marked < plain).mean() > 0.03
    assert twist_in(tmp_path / "a.npz") == pytest.approx((20, 0.8, -0.2, 0.1), abs=0.02)
    # Counterclockwise about an axis to its right, level with it in the end: down and to the left.
    angle = np.radians(20)
    expected = (-20, 3 * np.cos(angle) - 3, 3 * np.sin(angle), 0)
    assert twist_in(tmp_path / "b.npz") == pytest.approx(expected, abs=0.03)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--turn", 20, "--motion", "left"), "--turn cannot go with --motion; leave out"),
        (("--turn", 61), "--turn is 61, expected -60 to 60."),
        (("--press", 2, "--depth", 1), "A press by 2 mm about a depth of 1 mm goes from 0 to 2 mm"),
        (("--pivot-down", 1, "--press", 0.3), "--pivot-right and --pivot-down say where the axis"),
        (("--mixed", 0.5), "No such option: --mixed"),
        (("--object", "unicorn"), "There is no shape 'unicorn'; did you mean 'corner'?"),
        (("--object", ""), "There is no shape ''; choose one of arc, "),
        (("--mm-per-px", 0.1), "--mm-per-px and --relief-mm say how to read a --height-map"),
        (("--height-map", "star.npy"), "--height-map needs --mm-per-px"),
        (
            ("--height-map", "star.npy", "--mm-per-px", 0.1, "--object", "key"),
            "--object and --height-map both name the object",
        ),
    ],
)
def test_what_cannot_be_simulated_is_one_sentence(tmp_path, run_clip, options, sentence):
    code, _, printed = run_clip(tmp_path / "new" / "a.npz", *options)
    assert code == 2
    assert printed.startswith(sentence)
    assert printed.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_no_file_is_replaced_unless_that_is_asked_for(tmp_path, run_clip):
    path = tmp_path / "clip.npz"
    draft = (path, "--preset", "draft")
    assert run_clip(*draft)[0] == 0
    simulated = path.read_bytes()
    np.savez(path, frames=np.zeros((4, 32, 32, 3), np.uint8))
    own = path.read_bytes()
    assert run_clip(*draft) == (
        2,
        "",
        f"OUT: {path} is there already and would be replaced, expected a new name; give one, or "
        f"--force to replace the file.\n",
    )
    assert path.read_bytes() == own
    assert run_clip(*draft, "--force")[0] == 0
    assert path.read_bytes() == simulated


def test_a_height_map_of_ones_own_is_pressed(tmp_path, run_clip):
    axis = (np.arange(60) - 29.5) * 0.1
    np.save(tmp_path / "star.npy", 0.5 * np.cos(3 * np.arctan2(*np.meshgrid(axis, axis))))
    path, mine = tmp_path / "clip.npz", ("--height-map", tmp_path / "star.npy")
    assert run_clip(path, *mine, "--mm-per-px", 0.1, "--drift")[0] == 0
    assert label_in(path)["object"] == "star"
    assert np.abs(np.load(path)["drift_px"]).max() > 1


def test_a_data_set_is_written_with_its_card_and_progress_on_the_side(tmp_path, run):
    folder = tmp_path / "set"
    options = ("--out", folder, "--count", 2, "--preset", "draft")
    code, out, err = run(*options, "--objects", "everyday", "--markers")
    assert (code, out) == (0, f"{folder}\n")
    assert err.splitlines()[-1] == "simulated: 2 of 2 clips"
    assert (folder / "README.md").exists()
    assert json.loads((folder / "dataset.json").read_text())["marker_share"] == 1
    assert "holds another data set" in run(*options, "--objects", "everyday")[2]


def test_a_data_set_of_mixed_clips_says_what_counts_in_them(tmp_path, run):
    asked = ("--out", tmp_path, "--count", 12, "--preset", "draft", "--labels-only")
    assert run(*asked, "--mixed", 1, "--workers", 1)[0] == 0
    rows = [line.split(" | ") for line in (tmp_path / "README.md").read_text().splitlines()]
    counted = {row[0].strip("| "): row[1:4] for row in rows if len(row) == 5}
    for component in ("turn", "slide", "press"):
        assert sum(map(int, counted[component])) == 12
    assert int(counted["turn"][0]) > 2
    with np.load(tmp_path / "shard-00000.npz") as stored:
        assert "frames" not in stored


def test_the_card_of_a_data_set_replaces_no_other_file(tmp_path, run):
    (tmp_path / "README.md").write_text("about my project")
    code, _, printed = run("--out", tmp_path, "--count", 1, "--preset", "draft")
    assert code == 2
    assert "has a README.md of something else" in printed
    assert (tmp_path / "README.md").read_text() == "about my project"
