import numpy as np
import pytest

from geotlm_lm.data.manifest import read_manifest
from tests.cli.running import run
from tests.data.action_clips import write_image

PATTERN = r"(?P<object>\w+)/(?P<action>\w+)/(?P<frame>\w+)[.]png"


@pytest.fixture
def root(tmp_path):
    up, twist = "cap/slide_up", "key/twist"
    for name in (f"{up}/0", f"{up}/1", f"{up}/bg", f"{twist}/0", f"{twist}/1"):
        path = tmp_path / "data" / f"{name}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        write_image(path, np.zeros((16, 16, 3), np.uint8))
    return tmp_path / "data"


@pytest.fixture
def invoke(capsys, root):
    words = ["--root", root, "--pattern", PATTERN]
    return lambda *more: run(capsys, "manifest", *words, *more)


def test_a_manifest_is_written_and_summed_up(invoke, tmp_path):
    out = tmp_path / "lists" / "touchd.csv"
    told = ("--action", "twist=rotate_ccw", "--background-frame", "bg", "--fps", 18)
    summary = f"{out}: clips: 2, objects: 2, sensors: 1; 1 counterclockwise, 1 up\n"
    assert invoke("--out", out, *told) == (0, summary, "")
    rows = read_manifest(out).rows
    assert [row.background for row in rows] == ["../data/cap/slide_up/bg.png", None]
    assert {row.fps for row in rows} == {18}


def test_what_was_passed_over_is_told(invoke, root, tmp_path):
    write_image(root / "notes.png", np.zeros((16, 16, 3), np.uint8))
    (root / "key" / "twist" / "1.png").unlink()
    err = invoke("--out", tmp_path / "a.csv", "--action", "twist=rotate_ccw")[2]
    assert f"do not fit the pattern: 1, the first {root / 'notes.png'}" in err
    assert "clips of less than two frames, left out: 1, the first key/twist" in err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--out", "a.txt"], "--out a.txt was given, expected a name that ends in .csv or .jsonl."),
        (
            ["--out", "a.csv", "--action", "twist"],
            "--action 'twist' was given, expected WORD=ACTION.",
        ),
    ],
)
def test_a_wrong_call_is_refused_in_one_sentence(invoke, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    code, _, err = invoke(*words)
    assert (code, err.startswith(said)) == (2, True)
    assert not (tmp_path / "a.csv").exists()


def test_what_is_refused_leaves_no_folder_behind(invoke, tmp_path):
    assert invoke("--out", tmp_path / "new" / "a.csv")[0] == 2
    assert not (tmp_path / "new").exists()


def test_a_manifest_replaces_no_other_file_unless_that_is_asked_for(invoke, tmp_path):
    out = tmp_path / "mine.csv"
    out.write_text("my own table")
    words = ["--out", out, "--action", "twist=rotate_ccw"]
    assert invoke(*words)[0] == 2
    assert out.read_text() == "my own table"
    assert invoke(*words, "--force")[0] == 0
    assert len(read_manifest(out).rows) == 2
