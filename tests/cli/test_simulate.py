"""`simulate` writes clips that `info` and `answer` read back."""

import json

import numpy as np
import pytest

from geotlm_lm.recordings.read import read_clip
from geotlm_lm.runs.run import Workers
from geotlm_lm.simulation import dataset
from tests.cli import running


@pytest.fixture
def run(capsys):
    """Run `simulate` with some options."""
    return lambda *options: running.run(capsys, "simulate", *options)


def test_a_simulated_clip_is_a_readable_recording_with_its_label(tmp_path, run):
    path = tmp_path / "folder" / "clip.npz"
    options = ("--motion", "left", "--object", "key", "--seed", 3)
    assert run("--clip", path, *options)[:2] == (0, f"{path}\n")
    clip = read_clip(path)
    assert clip.frames.shape == (4, 224, 224, 3)
    assert clip.background is not None
    assert not [note for note in clip.notes if "squashed" in note]  # it knows its own camera
    label = json.loads(str(np.load(path)["label"]))
    assert label["motion"] == "left"
    assert label["object"] == "key"


def test_one_clip_turns_slides_and_presses_at_once_by_as_much_as_was_asked_for(tmp_path, run):
    moves = ("--turn", 20, "--slide-right", 0.8, "--slide-down", -0.2, "--press", 0.1)
    assert run("--clip", tmp_path / "a.npz", *moves)[0] == 0
    pivot = ("--turn", -20, "--pivot-right", 3, "--depth", 0.8, "--markers", "--object", "coin")
    assert run("--clip", tmp_path / "b.npz", *pivot)[0] == 0
    labels = [json.loads(str(np.load(tmp_path / name)["label"])) for name in ("a.npz", "b.npz")]
    twists = [
        (
            label["rotation_deg"],
            *np.multiply(label["travel_px"], label["mm_per_px"]),
            label["depth_change_mm"],
        )
        for label in labels
    ]
    assert twists[0] == pytest.approx((20, 0.8, -0.2, 0.1), abs=0.02)
    # Counterclockwise about an axis to its right, level with it in the end: down and to the left.
    angle = np.radians(20)
    expected = (-20, 3 * np.cos(angle) - 3, 3 * np.sin(angle), 0)
    assert twists[1] == pytest.approx(expected, abs=0.03)


@pytest.fixture
def refused(run):
    """Run what is refused as a wrong call; return what is told."""

    def told(*options):
        code, _, err = run(*options)
        assert code == 2
        return err

    return told


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--turn", 20, "--motion", "left"), "--turn cannot go with --motion; leave out"),
        (("--turn", 61), "--turn is 61, expected -60 to 60."),
        (("--turn", "nan"), "--turn is nan, expected -60 to 60."),
        (("--slide-down", -5.5), "--slide-down is -5.5, expected -5 to 5."),
        (("--press", 2, "--depth", 1), "A press by 2 mm about a depth of 1 mm goes from 0 to 2 mm"),
        (("--pivot-down", 1, "--press", 0.3), "--pivot-right and --pivot-down say where the axis"),
        (("--mixed", 0.5), "--mixed cannot go with --clip; leave out one of them."),
    ],
)
def test_a_movement_that_cannot_be_made_is_told_in_a_sentence(tmp_path, refused, options, sentence):
    told = refused("--clip", tmp_path / "a.npz", *options)
    assert told.startswith(sentence)
    assert told.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_data_set_of_mixed_clips_says_what_counts_in_them(tmp_path, run, refused):
    asked = ("--out", tmp_path, "--count", 12, "--preset", "draft", "--labels-only")
    assert run(*asked, "--mixed", 1, "--workers", 1)[0] == 0
    assert json.loads((tmp_path / "dataset.json").read_text())["mixed_share"] == 1
    card = (tmp_path / "README.md").read_text()
    rows = [line.split(" | ") for line in card.splitlines()]
    told = {row[0].strip("| "): row[1:4] for row in rows if len(row) == 5}
    for component in ("turn", "slide", "press"):
        assert sum(map(int, told[component])) == 12
    assert int(told["turn"][0]) > 2
    assert "holds another data set" in refused(*asked)
    assert "--turn cannot go with --out" in refused("--out", tmp_path, "--turn", 3)


@pytest.mark.parametrize("name", ["unicorn", ""])
def test_an_unknown_shape_is_refused_with_the_known_ones(tmp_path, refused, name):
    sentence = refused("--clip", tmp_path / "new" / "a.npz", "--object", name)
    assert list(tmp_path.iterdir()) == []
    assert sentence.startswith(f"There is no shape '{name}', expected one of ")
    assert " key," in sentence
    assert sentence.count("\n") == 1


def test_a_data_set_is_written_with_its_card_and_progress_on_the_side(tmp_path, run):
    folder = tmp_path / "set"
    code, out, err = run("--out", folder, "--count", 2, "--objects", "everyday")
    assert (code, out) == (0, f"{folder}\n")
    assert err.splitlines()[-1] == "simulated: 2 of 2 clips"
    assert (folder / "README.md").exists()


def test_no_file_is_replaced_unless_that_is_asked_for(tmp_path, run):
    path, frames = tmp_path / "clip.npz", np.zeros((4, 32, 32, 3), np.uint8)
    draft = ("--clip", path, "--preset", "draft")
    assert run(*draft)[0] == 0
    simulated = path.read_bytes()
    assert run(*draft, "--seed", 1)[0] == 2
    assert path.read_bytes() == simulated
    for content in ({"frames": frames}, {"frames": frames, "label": 1, "mine": 2}):
        np.savez(path, **content)
        own = path.read_bytes()
        assert run(*draft) == (
            2,
            "",
            f"--clip: {path} is there already and would be replaced, expected a new name; give "
            f"one, or --force to replace the file.\n",
        )
        assert path.read_bytes() == own
    assert run(*draft, "--force")[0] == 0
    assert path.read_bytes() == simulated


def test_the_card_of_a_data_set_replaces_no_other_file(tmp_path, refused):
    (tmp_path / "README.md").write_text("about my project")
    assert "has a README.md of something else" in refused(
        "--out", tmp_path, "--count", 1, "--preset", "draft"
    )
    assert (tmp_path / "README.md").read_text() == "about my project"


def test_a_height_map_of_ones_own_is_pressed(tmp_path, run, refused):
    axis = (np.arange(60) - 29.5) * 0.1
    np.save(tmp_path / "star.npy", 0.5 * np.cos(3 * np.arctan2(*np.meshgrid(axis, axis))))
    path, mine = tmp_path / "clip.npz", ("--height-map", tmp_path / "star.npy")
    assert run("--clip", path, *mine, "--mm-per-px", 0.1, "--drift")[0] == 0
    with np.load(path) as stored:
        assert json.loads(str(stored["label"]))["object"] == "star"
        assert stored["drift_px"].shape == (4, 14, 14, 2)
    assert "--height-map needs --mm-per-px" in refused("--clip", path, *mine)
    assert "both name the object" in refused(
        "--clip", path, *mine, "--mm-per-px", 0.1, "--object", "key"
    )
    assert "--height-map" in refused("--clip", path, "--mm-per-px", 0.1)
    assert run("--out", tmp_path / "set", *mine)[0] == 2


def test_markers_are_printed_on_the_same_touch(tmp_path, run):
    for name, options in (("bare.npz", ()), ("marked.npz", ("--markers",))):
        run("--clip", tmp_path / name, "--preset", "draft", "--drift", *options)
    bare, marked = (np.load(tmp_path / name) for name in ("bare.npz", "marked.npz"))
    assert str(bare["label"]) == str(marked["label"])
    assert (marked["background"] < bare["background"]).mean() > 0.03


def test_a_data_set_says_that_its_gels_are_marked_and_is_not_continued_without(
    tmp_path, run, refused
):
    asked = ("--out", tmp_path / "set", "--count", 1, "--preset", "draft")
    assert run(*asked, "--markers")[0] == 0
    assert json.loads((tmp_path / "set" / "dataset.json").read_text())["marker_share"] == 1
    assert "holds another data set" in refused(*asked)


def test_labels_only_writes_no_pictures_and_goes_with_a_data_set_only(tmp_path, run, refused):
    folder = tmp_path / "set"
    options = ("--count", 2, "--objects", "everyday", "--preset", "draft", "--labels-only")
    assert run("--out", folder, *options)[0] == 0
    with np.load(folder / "shard-00000.npz") as stored:
        assert "labels" in stored
        assert "frames" not in stored
    assert "--labels-only cannot go with --clip" in refused(
        "--clip", tmp_path / "a.npz", "--labels-only"
    )


def test_who_simulates_is_handed_on(tmp_path, run, monkeypatch):
    asked = []

    def write_dataset(out, count, *, workers, **_):
        asked.append(workers)

    monkeypatch.setattr(dataset, "write_dataset", write_dataset)
    run("--out", tmp_path)
    run("--out", tmp_path, "--workers", 2)
    assert asked == [Workers(None), Workers(2)]
