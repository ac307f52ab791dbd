"""Data sets survive kills, are equal whoever writes them, and are read by their libraries."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from geotlm_lm.core.errors import MissingDependency, UsageError
from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.runs.run import Workers
from geotlm_lm.simulation import dataset
from geotlm_lm.simulation.dataset import write_dataset
from tests.process_groups import in_proc, members

GIVEN = {"seed": 1, "objects": ("block", "cloth_coarse"), "preset": "draft"}


@pytest.fixture(autouse=True)
def _small_shards(monkeypatch):
    monkeypatch.setattr(dataset, "SHARD_CLIPS", 3)


def contents(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def read_shard(path):
    with np.load(path, allow_pickle=False) as stored:
        return dict(stored)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Seven clips of draft quality, in shards of three."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dataset, "SHARD_CLIPS", 3)
        return write_dataset(tmp_path_factory.mktemp("whole"), 7, **GIVEN)


def test_shards_hold_every_clip_once_with_its_truth(whole):
    shards = [read_shard(path) for path in sorted(whole.glob("shard-*.npz"))]
    assert np.concatenate([arrays["index"] for arrays in shards]).tolist() == list(range(7))
    assert shards[0]["frames"].shape == (3, 4, 224, 224, 3)
    assert shards[0]["displacement_px"].shape == (3, 4, 14, 14, 2)
    assert len(json.loads(str(shards[0]["labels"]))) == 3
    assert "7 clips of 2 bodies" in (whole / "README.md").read_text()


def test_a_broken_off_grown_or_damaged_data_set_ends_with_the_same_bytes(whole, tmp_path):
    class Killed(Exception):
        pass

    reports = []

    def stop(what, done, total):
        reports.append((what, done, total))
        if done >= 3:
            raise Killed

    with pytest.raises(Killed):
        write_dataset(tmp_path, 5, progress=stop, **GIVEN)
    kept = (tmp_path / "shard-00000.npz").stat().st_mtime_ns
    (tmp_path / "shard-00001.npz").write_bytes(b"half a shard")
    write_dataset(tmp_path, 7, **GIVEN)
    assert reports == [("simulated", 3, 5)]
    assert (tmp_path / "shard-00000.npz").stat().st_mtime_ns == kept
    assert contents(tmp_path) == contents(whole)


def test_a_folder_that_says_nothing_of_mixed_clips_has_none_and_is_continued(tmp_path):
    write_dataset(tmp_path, 1, **GIVEN)
    before, asked = contents(tmp_path), tmp_path / "dataset.json"
    about = json.loads(asked.read_text())
    asked.write_text(json.dumps({name: about[name] for name in about if name != "mixed_share"}))
    write_dataset(tmp_path, 1, **GIVEN)
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    ("other", "says"),
    [
        ({"seed": 2}, "holds another data set .* other objects or settings"),
        ({"with_frames": False}, "holds another data set .* other objects or settings"),
        ({"form": "huggingface"}, "holds another data set .* other objects or settings"),
        ({"count": 2}, "was made for 7 clips, 2 were asked for; ask for at least as many, or"),
        ({"objects": ()}, "found 7 clips of 0 objects; ask for some"),
    ],
)
def test_a_folder_of_another_data_set_is_refused_and_kept(whole, other, says):
    before = contents(whole)
    with pytest.raises(UsageError, match=says):
        write_dataset(whole, **{"count": 7, **GIVEN, **other})
    assert contents(whole) == before


@pytest.mark.parametrize("content", ["{", "[]", '{"seed": 1}'])
def test_a_folder_that_does_not_say_what_it_holds_is_refused(tmp_path, content):
    (tmp_path / "dataset.json").write_text(content)
    with pytest.raises(UsageError, match="does not say what the folder holds"):
        write_dataset(tmp_path, 2, **GIVEN)


@pytest.mark.slow
def test_the_number_of_workers_does_not_change_a_byte(whole, tmp_path):
    assert contents(write_dataset(tmp_path, 7, workers=Workers(2), **GIVEN)) == contents(whole)


def test_labels_only_are_those_of_the_whole_data_set_without_its_pictures(whole, tmp_path):
    write_dataset(tmp_path, 3, with_frames=False, **GIVEN)
    pictured, bare = (read_shard(folder / "shard-00000.npz") for folder in (whole, tmp_path))
    assert set(pictured) - set(bare) == {"frames", "backgrounds"}
    assert all(np.array_equal(bare[name], pictured[name]) for name in set(bare) - {"labels"})
    card = (tmp_path / "README.md").read_text()
    assert "No picture was made" in card
    assert "`frames`" not in card


def test_datasets_reads_every_clip_of_a_table_as_the_archive_holds_it(whole, tmp_path):
    pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra track")
    datasets = pytest.importorskip("datasets", reason="needs datasets, of the extra dev")
    out = write_dataset(tmp_path / "out", 3, form="huggingface", **GIVEN)
    arrays = read_shard(whole / "shard-00000.npz")
    labels = json.loads(str(arrays["labels"]))
    clips = datasets.load_dataset(str(out), split="train", cache_dir=str(tmp_path / "cache"))
    for place, clip in enumerate(clips):
        frames = np.stack([np.asarray(clip[f"frame_{number}"]) for number in range(4)])
        assert np.array_equal(frames, arrays["frames"][place])
        assert np.array_equal(clip["contact"], arrays["contact"][place])
        assert clip["rotation_deg"] == pytest.approx(labels[place]["rotation_deg"])
        label = MotionLabel.from_dict(json.loads(clip["label"]))
        assert label == MotionLabel.from_dict(labels[place])
    assert 'data_files: "shard-*.parquet"' in (out / "README.md").read_text()
    before, table = contents(out), out / "shard-00000.parquet"
    table.write_bytes(table.read_bytes()[:5000])
    assert contents(write_dataset(out, 3, form="huggingface", **GIVEN)) == before


def test_without_pyarrow_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(dataset, "find_spec", lambda name: None)
    with pytest.raises(MissingDependency, match=r"written with pyarrow, .*'geotlm-lm\[track\]'"):
        write_dataset(tmp_path, 1, form="huggingface", **GIVEN)


WRITER = """
import sys
from pathlib import Path
from geotlm_lm.simulation import dataset
from geotlm_lm.runs.run import Workers

if __name__ == "__main__":
    dataset.SHARD_CLIPS = 3
    objects = ("block", "cloth_coarse")
    options = {"seed": 1, "objects": objects, "preset": "draft", "workers": Workers(2)}
    dataset.write_dataset(Path(sys.argv[1]), 18, **options)
"""


@pytest.mark.slow
def test_after_kill_9_a_resumed_run_has_lost_and_repeated_nothing(tmp_path):
    program, killed = tmp_path / "writer.py", tmp_path / "killed"
    program.write_text(WRITER)
    command = [sys.executable, str(program), str(killed)]
    once = write_dataset(tmp_path / "whole", 18, **GIVEN)
    run = subprocess.Popen(command)
    while not list(killed.glob("shard-*.npz")) and run.poll() is None:
        time.sleep(0.002)
    run.send_signal(signal.SIGKILL)
    run.wait()
    kept = {path: path.stat().st_mtime_ns for path in killed.glob("shard-*.npz")}
    assert 0 < len(kept) < 6
    assert subprocess.run(command).returncode == 0
    # A worker whose parent was killed ends within a moment; what it had begun has another name.
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    assert contents(once).items() <= contents(killed).items()


@pytest.mark.slow
@in_proc
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_request_to_end_does_not_wait_for_shards_and_leaves_no_part_of_one(tmp_path, number):
    # Shards of reference clips with friction take minutes.
    options = ["--count", "200", "--preset", "reference", "--drift", "--workers", "2"]
    with subprocess.Popen(
        [sys.executable, "-m", "geotlm_lm", "simulate", "--out", str(tmp_path / "set"), *options],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as run:
        while not (tmp_path / "set" / "dataset.json").exists() or members(run.pid) < 4:
            assert run.poll() is None
            time.sleep(0.02)
        if number == signal.SIGINT:
            os.killpg(run.pid, number)  # as a terminal does: to every process
        else:
            run.send_signal(number)
        try:
            _, printed = run.communicate(timeout=8)  # until no worker holds its end of the pipe
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(run.pid, signal.SIGKILL)
    assert run.returncode == (130 if number == signal.SIGINT else -number)
    assert printed == "Stopped; files already complete are kept.\n"
    assert [path.name for path in (tmp_path / "set").iterdir()] == ["dataset.json"]
