"""`geotlm-lm batch`: what is read, written and refused; the rows: tests/answering."""

import json

import numpy as np
import pytest

from geotlm_lm.answering.answerer import loaded
from geotlm_lm.cli.batch import read_questions
from geotlm_lm.core.errors import UsageError
from geotlm_lm.runs.run import ALONE
from tests.answering.scripted import feeling, recording
from tests.cli.running import run
from tests.data_sets.lerobot_files import CAMERA, OTHER, turned, write_data_set
from tests.tiny_bundle import tiny_bundle


@pytest.fixture
def invoke(capsys, tmp_path, monkeypatch):
    (tmp_path / "clips").mkdir()
    np.save(tmp_path / "clips" / "cap.npy", recording().frames)
    (tmp_path / "questions.txt").write_text("Which way?\nHow far?\n")
    answerer = feeling(tiny_bundle(), "up")
    models = []

    def load(folder):
        models.append(folder)
        return answerer

    monkeypatch.setattr("geotlm_lm.answering.Answerer.load", load)
    monkeypatch.setattr("geotlm_lm.cli.batch.Workers", lambda *_: ALONE)
    loaded.cache_clear()
    named = {"--clips": "clips", "--questions": "questions.txt", "--out": "deep/answers.jsonl"}
    places = [word for name, path in named.items() for word in (name, tmp_path / path)]

    def call(*arguments):
        return run(capsys, "batch", *places, *arguments)

    call.models = models
    yield call
    loaded.cache_clear()


def written(tmp_path):
    return list(map(json.loads, (tmp_path / "deep" / "answers.jsonl").read_text().splitlines()))


def test_rows_are_written_and_counted(invoke, tmp_path):
    code, told, err = invoke()
    assert (code, told) == (0, f"{tmp_path}/deep/answers.jsonl: 2 rows, 0 of them errors\n")
    assert "answered: 1 of 1 clips" in err
    rows = written(tmp_path)
    assert rows[0]["answer"]["direction"] == "up"
    assert rows[1]["answer"]["amount"]["unit"] == "px"


def test_what_is_no_recording_is_named(invoke, tmp_path):
    folder = tmp_path / "clips"
    assert "skipped" not in invoke()[2]
    (folder / "foil.heic").write_bytes(b"ftyp")
    (folder / ".hidden").write_bytes(b"")
    own = folder / "rows.jsonl"
    for _ in range(2):  # the second time the first one's rows lie there
        assert (
            "note: skipped as no recording (.npy, .npz, .mp4, .m4v, .avi, .mov, .mkv, .webm, .gif, "
            ".tif, .tiff, .mcap, .db3, .bag or folders of images): foil.heic\n"
            in invoke("--out", own)[2]
        )
    for name in "abcdef":
        (folder / f"{name}.txt").write_bytes(b"")
    assert ": a.txt, b.txt, c.txt, d.txt, e.txt and 2 more\n" in invoke("--out", own)[2]


def test_questions_are_lines_without_blanks_comments_and_repetitions(tmp_path):
    path = tmp_path / "q.txt"
    path.write_text("# about caps\nWhich way?\n\n  Is it still? \nWhich way?\n", encoding="utf-8")
    assert read_questions(path) == ["Which way?", "Is it still?"]


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"# nothing\n", "{}: holds no question; write one a line."),
        (b"which \xff way", "{}: is no UTF-8 text; save the questions as UTF-8."),
        (None, "{}: cannot be read (No such file or directory); give a text file of questions."),
    ],
)
def test_a_file_without_questions_is_refused(tmp_path, content, sentence):
    path = tmp_path / "q.txt"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(UsageError) as error:
        read_questions(path)
    assert str(error.value) == sentence.format(path)


@pytest.mark.parametrize("name", ["questions.txt", "clips/cap.npy", "clips/frames/0.png"])
def test_rows_never_replace_what_is_read(invoke, tmp_path, name):
    (tmp_path / "clips" / "frames").mkdir()
    (tmp_path / "clips" / "frames" / "0.png").write_bytes(b"a picture")
    own = (tmp_path / name).read_bytes()
    assert invoke("--out", tmp_path / name) == (
        2,
        "",
        f"--out: {tmp_path / name} is read by this command and would be replaced, expected the "
        f"name of another file; give one.\n",
    )
    assert (tmp_path / name).read_bytes() == own


def test_the_size_of_a_pixel_stands_in_every_row(invoke, tmp_path):
    invoke("--mm-per-px", "0.06")
    assert {row["answer"]["frame"]["mm_per_px"] for row in written(tmp_path)} == {0.06}
    assert invoke("--mm-per-px", "9")[0] == 2


@pytest.mark.parametrize(
    "content",
    [
        b"\xff\xfe",
        b"[1, 2]\n",
        b'{"clip": "a.npy"}\n',
        b'{"clip": "a", "question": "b", "answer": null, "error": "c"}\nand a note\n',
    ],
)
def test_rows_never_replace_what_no_batch_wrote(invoke, tmp_path, content):
    out = tmp_path / "precious.txt"
    out.write_bytes(content)
    code, _, err = invoke("--out", out)
    assert (code, err.splitlines()[-1]) == (
        2,
        f"--out: {out} holds something else than a batch's rows and would be replaced, expected a "
        f"new file or an earlier batch's; give another name.",
    )
    assert out.read_bytes() == content
    assert invoke.models == []  # told before the model is loaded


def test_rows_replace_an_empty_file_and_those_of_an_earlier_run(invoke, tmp_path):
    out = tmp_path / "rows.jsonl"
    out.touch()
    for _ in range(2):
        assert invoke("--out", out)[0] == 0
        assert len(out.read_text().splitlines()) == 2


def test_grey_arrays_are_read_with_their_layout_and_a_senseless_rate_is_refused(invoke, tmp_path):
    grey = recording().frames.mean(axis=-1).astype(np.uint8)
    np.save(tmp_path / "clips" / "cap.npy", grey)
    assert invoke()[1].endswith("2 rows, 2 of them errors\n")
    assert invoke("--layout", "THW")[1].endswith("2 rows, 0 of them errors\n")
    assert invoke("--layout", "HW")[0] == invoke("--fps", "-3")[0] == 2


def test_square_pixels_are_told_to_the_reader_of_every_clip(invoke, tmp_path):
    np.save(tmp_path / "clips" / "cap.npy", recording(size=(224, 224)).frames)
    notes = []
    for options in ((), ("--square-pixels",)):
        assert invoke(*options)[0] == 0
        notes.append(" ".join(written(tmp_path)[0]["answer"]["notes"]))
    assert "squashed to a square" in notes[0]
    assert "as asked" in notes[1]


@pytest.fixture
def robot(tmp_path):
    """A data set of three episodes in two files, the second file's video damaged."""
    pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra lerobot")
    pytest.importorskip("av", reason="needs av, of the extra lerobot")
    root = write_data_set(tmp_path / "robot", [turned(degrees) for degrees in (20, -15, 10)])
    (root / f"videos/{CAMERA}/chunk-000/file-001.mp4").write_bytes(b"no video")
    return root


def test_each_episode_of_a_data_set_is_asked_about(invoke, tmp_path, robot):
    code, told, _ = invoke("--clips", robot, "--camera", CAMERA)
    assert (code, told) == (0, f"{tmp_path}/deep/answers.jsonl: 6 rows, 2 of them errors\n")
    rows = written(tmp_path)
    assert [row["clip"] for row in rows[::2]] == [f"episode-00000{n}" for n in range(3)]
    assert [row["answer"]["direction"] for row in rows[:4:2]] == ["up", "up"]
    assert "cannot be decoded" in rows[4]["error"]


def test_a_damaged_table_is_an_error_of_its_episodes_and_a_path_outside_one_of_all(
    invoke, tmp_path, robot
):
    (robot / "data/chunk-000/file-000.parquet").write_bytes(b"no table")
    code, told, _ = invoke("--clips", robot, "--camera", CAMERA)
    assert (code, told) == (0, f"{tmp_path}/deep/answers.jsonl: 6 rows, 6 of them errors\n")
    assert "file-000.parquet: cannot be read" in written(tmp_path)[0]["error"]
    content = json.loads((robot / "meta/info.json").read_text()) | {"data_path": "../evil.parquet"}
    (robot / "meta/info.json").write_text(json.dumps(content))
    code, _, err = invoke("--clips", robot, "--camera", CAMERA)
    assert (code, err.count("\n")) == (3, 1)
    assert "its data_path, '../evil.parquet', leads out of that folder" in err


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "{root}: has 2 cameras: {other}, {camera}; give the touch sensor's by --camera."),
        (
            ["--camera", CAMERA, "--layout", "THWC"],
            "--layout is of files, and {root} is a LeRobot data set, which tells its own; leave "
            "it out.",
        ),
        (
            ["--camera", CAMERA, "--out", "{root}/rows.jsonl"],
            "--out: {root}/rows.jsonl lies in the data set that is read, expected a file beside "
            "it; give another place.",
        ),
        (
            ["--clips", "{root}/..", "--camera", CAMERA],
            "--camera is of a LeRobot data set, and {root}/.. is none; leave it out.",
        ),
    ],
)
def test_what_does_not_go_with_a_data_set_is_refused(invoke, robot, arguments, sentence):
    given = [word.format(root=robot) for word in arguments]
    code, _, err = invoke("--clips", robot, *given)
    told = sentence.format(root=robot, camera=CAMERA, other=OTHER)
    assert (code, err.splitlines()[-1]) == (2, told)
    assert invoke.models == []
