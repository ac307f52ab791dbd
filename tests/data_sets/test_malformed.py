"""Malformed and hostile data sets: one sentence and exit code 3; nothing outside is touched."""

import json
import os
import re
import shutil

import numpy as np
import pytest

from geotlm_lm.core.errors import UnreadableClip, UsageError
from geotlm_lm.data_sets.labelling import Labelling, label_data_set
from geotlm_lm.data_sets.lerobot import episode_clip, read_data_set
from tests.cli import running
from tests.data_sets.lerobot_files import CAMERA, FPS, OTHER, turned, write_data_set

pyarrow = pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra lerobot")
parquet = pytest.importorskip("pyarrow.parquet", reason="needs pyarrow, of the extra lerobot")
pytest.importorskip("av", reason="needs av, of the extra lerobot")

CLIPS = [turned(20), turned(-15, 28)]

DATA, EPISODES = "data/chunk-000/file-000.parquet", "meta/episodes/chunk-000/file-000.parquet"
VIDEO = f"videos/{CAMERA}/chunk-000/file-000.mp4"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return write_data_set(tmp_path_factory.mktemp("sets") / "robot", CLIPS)


@pytest.fixture
def root(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "outer/robot")


def info(**values):
    """Return what changes `meta/info.json`; None leaves a value out."""

    def spoil(root):
        path = root / "meta/info.json"
        content = json.loads(path.read_text()) | values
        kept = {name: value for name, value in content.items() if value is not None}
        path.write_text(json.dumps(kept))

    return spoil


def column(file, name, change):
    """Return what changes a column of a table, given and returned as a list; None drops it."""

    def spoil(root):
        table = parquet.ParquetFile(root / file).read()
        number, values = table.column_names.index(name), change(table[name].to_pylist())
        table = table.remove_column(number)
        if values is not None:
            table = table.append_column(name, pyarrow.array(values))
        parquet.write_table(table, root / file)

    return spoil


def written(file, content):
    return lambda root: (root / file).write_bytes(content)


def piped(file):
    def spoil(root):
        (root / file).unlink()
        os.mkfifo(root / file)

    return spoil


def camera_called(name):
    def spoil(root):
        features = json.loads((root / "meta/info.json").read_text())["features"]
        info(features=features | {name: features[CAMERA]})(root)

    return spoil


def texts(values):
    return [str(value) for value in values]


def first(value):
    return lambda values: [value, *values[1:]]


def always(value):
    return lambda values: [value] * len(values)


OUTSIDE = "leads out of that folder"

INFOS = {
    "fps of 0": (info(fps=0), "fps is 0, expected a number above 0"),
    "fps as text": (info(fps="25"), "fps is '25', expected a number"),
    "fps not a number": (info(fps=float("nan")), "fps is nan, expected a number"),
    "fps huge": (info(fps=10**400), "fps is 1000"),
    "features a list": (info(features=[]), "features is a list, expected an object"),
    "a feature as text": (info(features={"a": "b"}), "the dtype of 'a' is missing"),
    "total as text": (info(total_episodes="2"), "total_episodes is '2', expected a whole"),
    "total huge": (info(total_episodes=10**12), "2 episodes were found, expected 1000000000000"),
    "another key": (info(data_path="data/{episode_chunk}"), "fills in 'episode_chunk'"),
    "an attribute": (info(data_path="data/{chunk_index.real}"), "fills in 'chunk_index.real'"),
    "a wide number": (info(data_path="data/{chunk_index:0999999999d}"), "in a form of its own"),
    "a conversion": (info(video_path="{video_key!r}/{file_index}"), "in a form of its own"),
    "an open brace": (info(data_path="data/{chunk_index"), "has wrong braces"),
    "a list for a path": (info(data_path=["data"]), "its data_path, a list, is no text"),
    "no video_path": (info(video_path=None), "its video_path, missing, is no text"),
    "data above": (info(data_path="../../evil.parquet"), OUTSIDE),
    "data above, backslashes": (info(data_path="..\\evil.parquet"), OUTSIDE),
    "data elsewhere": (info(data_path="/tmp/evil.parquet"), OUTSIDE),
    "data on a drive": (info(data_path="C:evil.parquet"), OUTSIDE),
    "data nowhere": (info(data_path=""), OUTSIDE),
    "video above": (info(video_path="../{video_key}.mp4"), OUTSIDE),
    "a NUL": (info(data_path="data/\0"), "holds characters that no path has"),
    "a camera above": (camera_called("../../evil"), "a camera's name is '../../evil'"),
    "a camera ..": (camera_called(".."), r"a camera's name is '\.\.'"),
    "nested JSON": (written("meta/info.json", b"[" * 200_000), "cannot be read"),
    "no JSON": (written("meta/info.json", b"\xff{"), "cannot be read"),
    "a JSON list": (written("meta/info.json", b"[]"), "expected a JSON object"),
    "info a pipe": (piped("meta/info.json"), "is no LeRobot data set"),
    "version a list": (info(codebase_version=[3]), "of version a list, expected v3"),
    "length as text": (column(EPISODES, "length", texts), "column length holds string values"),
    "length null": (column(EPISODES, "length", first(None)), "column length holds 1 empty cells"),
    "length of 0": (column(EPISODES, "length", first(0)), "a length of 0 frames"),
    "episode twice": (column(EPISODES, "episode_index", always(0)), "2 episodes were found"),
    "chunk below 0": (column(EPISODES, "data/chunk_index", first(-1)), "whole numbers from 0"),
    "no chunk": (column(EPISODES, "data/chunk_index", lambda _: None), "has no column data/chunk"),
    "video since never": (
        column(EPISODES, f"videos/{CAMERA}/from_timestamp", first(float("inf"))),
        "expected seconds from 0",
    ),
}

FRAMES = {
    "length huge": (column(EPISODES, "length", first(10**9)), "holds 24 rows of episode 0"),
    "time null": (column(DATA, "timestamp", first(None)), "timestamp holds 1 empty cells"),
    "time as text": (column(DATA, "timestamp", texts), "timestamp holds string values"),
    "time huge": (column(DATA, "timestamp", first(1e300)), "expected seconds from 0 to 1e"),
    "time not a number": (column(DATA, "timestamp", first(float("nan"))), "seconds from 0"),
    "times all 0": (column(DATA, "timestamp", always(0.0)), "does not rise"),
    "frames shifted": (
        column(DATA, "frame_index", lambda values: [value + 1 for value in values]),
        "frame_index of episode 0 goes from 1 to 24 in 24 rows, expected each of 0 to 23 once",
    ),
    "frames all 0": (column(DATA, "frame_index", always(0)), "goes from 0 to 0 in 24 rows"),
    "rows of no episode": (column(DATA, "episode_index", first(99)), "holds 23 rows of episode 0"),
    "no table": (lambda root: (root / DATA).unlink(), "cannot be read"),
    "a pipe": (piped(DATA), "cannot be read"),
    "a column's name no text": (
        lambda root: written(DATA, (root / DATA).read_bytes().replace(b"task_index", b"\xff" * 10))(
            root
        ),
        "cannot be read",
    ),
}


@pytest.mark.parametrize("case", [*INFOS, *FRAMES])
def test_what_cannot_be_is_a_sentence_of_label_and_of_reading(
    capsys, root, case, tmp_path, without_model
):
    spoil, phrase = (INFOS | FRAMES)[case]
    spoil(root)
    beside = sorted(tmp_path.rglob("*"))
    asked = ("label", root, "--camera", CAMERA, "--out", tmp_path / "outer/o/lab")
    code, out, err = running.run(capsys, *asked, "--workers", 1)
    assert (code, out, len(err.splitlines())) == (3, "", 1)
    assert re.search(phrase, err)
    assert sorted(set(tmp_path.rglob("*")) - {tmp_path / "outer/o"}) == beside
    with pytest.raises(UnreadableClip, match=phrase):
        read_first(root, CAMERA)


def read_first(root, camera):
    data_set = read_data_set(root)
    return episode_clip(data_set, data_set.episode(0), camera)


def one_more_row(root):
    table = parquet.ParquetFile(root / DATA).read()
    last = table.slice(len(table) - 1)
    number = table.column_names.index("episode_index")
    last = last.set_column(number, "episode_index", pyarrow.array([7], pyarrow.int64()))
    parquet.write_table(pyarrow.concat_tables([table, last]), root / DATA)


@pytest.mark.parametrize(
    ("spoil", "phrase"),
    [
        (one_more_row, "holds rows of episode 7, expected those of the episodes"),
        (written("meta/stats.json", b"{"), "cannot be read"),
        (lambda root: linked_folder(root, "videos"), "is a link to a folder"),
    ],
)
def test_what_no_labelled_copy_can_be_written_of_is_refused_before_any_work(
    root, tmp_path, without_model, spoil, phrase
):
    spoil(root)
    with pytest.raises(UnreadableClip, match=phrase):
        label_data_set(Labelling(root, OTHER), tmp_path / "out")
    assert not (tmp_path / "out.part").exists()


def linked_folder(root, name):
    """Put a folder elsewhere and a link to it in its place."""
    (root / name).rename(root.parent / "elsewhere")
    (root / name).symlink_to(root.parent / "elsewhere")


@pytest.mark.parametrize(("name", "camera"), [("data", OTHER), (f"videos/{CAMERA}", CAMERA)])
def test_a_link_of_a_folder_leads_to_no_file_outside(root, name, camera):
    linked_folder(root, name)
    with pytest.raises(UnreadableClip, match="a link leads out of the data set's folder"):
        read_first(root, camera)


def test_a_set_of_links_into_a_cache_is_read_and_labelled_and_the_cache_stays(
    root, tmp_path, without_model
):
    cache = root.parent / "blobs"
    cache.mkdir()
    for number, path in enumerate([path for path in root.rglob("*") if path.is_file()]):
        path.rename(cache / f"{number}")
        path.symlink_to(f"{os.path.relpath(cache, path.parent)}/{number}")
    before = {path: path.read_bytes() for path in cache.iterdir()}
    result = label_data_set(Labelling(root, CAMERA), tmp_path / "out")
    assert (result.frames, result.refused) == (52, {})
    assert not [path for path in (tmp_path / "out").rglob("*") if path.is_symlink()]
    assert {path: path.read_bytes() for path in cache.iterdir()} == before


@pytest.mark.parametrize("name", ["out", "out.part", "out.part/data_set"])
def test_nothing_is_written_through_a_link(root, tmp_path, without_model, name):
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / "else").mkdir()
    (tmp_path / name).symlink_to(tmp_path / "else")
    with pytest.raises(UsageError, match="is a link, through which something else would be"):
        label_data_set(Labelling(root, CAMERA), tmp_path / "out")
    assert list((tmp_path / "else").iterdir()) == []


def test_a_table_is_not_linked_as_a_video_is_and_the_original_stays(root, tmp_path, without_model):
    info(data_path="data/./chunk-{chunk_index:03d}//file-{file_index:03d}.mp4")(root)
    table = (root / DATA).rename((root / DATA).with_suffix(".mp4"))
    before = table.read_bytes()
    label_data_set(Labelling(root, CAMERA), tmp_path / "out")
    names = parquet.ParquetFile(tmp_path / "out" / table.relative_to(root)).schema_arrow.names
    assert len([name for name in names if name.startswith("tactile.")]) == 8
    assert table.read_bytes() == before


def test_a_playlist_in_a_videos_place_leads_to_no_other_file(root):
    shutil.move(root / VIDEO, root.parent / "secret.mp4")
    (root / VIDEO).with_name("linked").symlink_to(root.parent)
    (root / VIDEO).write_text("ffconcat version 1.0\nfile linked/secret.mp4\n")
    with pytest.raises(UnreadableClip, match="cannot be decoded"):
        read_first(root, CAMERA)


@pytest.mark.parametrize(
    "cell", [b"", b"\x89PNG\r\n\x1a\n" + b"x" * 30, "text", None, np.zeros(3, np.uint8).tobytes()]
)
def test_a_picture_in_a_table_that_is_none_is_refused(tmp_path, cell):
    root = write_data_set(tmp_path / "robot", [CLIPS[0]], as_images=True)
    column(DATA, CAMERA, always({"bytes": cell, "path": "/etc/hostname"}))(root)
    with pytest.raises(UnreadableClip, match=f"column {CAMERA} row 0: is cut off or is no image"):
        read_first(root, CAMERA)


def test_a_planted_bug_keeps_its_trace(root, monkeypatch):
    def planted(*_):
        raise TypeError("planted")

    monkeypatch.setattr("geotlm_lm.data_sets.lerobot.column_of", planted)
    with pytest.raises(TypeError, match="planted"):
        read_data_set(root)


def test_a_set_of_version_2_1_is_told_the_command_that_converts_it(tmp_path):
    root = tmp_path / "old set"
    (root / "meta").mkdir(parents=True)
    paths = {"data_path": "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet"}
    content = {"codebase_version": "v2.1", "fps": FPS, "features": {}, "total_episodes": 1} | paths
    (root / "meta/info.json").write_text(json.dumps(content))
    with pytest.raises(UnreadableClip) as told:
        read_data_set(root)
    assert str(told.value) == (
        f"{root}: is a LeRobot data set of version 'v2.1', expected v3.x; convert it in place, "
        f"with Python 3.12 or newer, by `pip install 'lerobot[dataset]>=0.6'` and `python -m "
        f"lerobot.scripts.convert_dataset_v21_to_v30 --repo-id=local/converted --root='{root}' "
        f"--push-to-hub=false`."
    )
