import contextlib
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from geotlm_lm.core.errors import UsageError
from geotlm_lm.runs.run import Workers
from geotlm_lm.simulation import dataset
from geotlm_lm.simulation.dataset import read_shard, write_dataset
from tests.process_groups import in_proc, members

OBJECTS = ("block", "cloth_coarse")


@pytest.fixture(autouse=True)
def _small_shards(monkeypatch):
    monkeypatch.setattr(dataset, "SHARD_CLIPS", 3)


def contents(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def test_shards_hold_every_clip_once_with_its_truth(tmp_path):
    seen = []
    write_dataset(tmp_path, 7, seed=1, objects=OBJECTS, progress=lambda *p: seen.append(p))
    shards = [read_shard(path) for path in sorted(tmp_path.glob("shard-*.npz"))]
    assert np.concatenate([arrays["index"] for arrays, _ in shards]).tolist() == list(range(7))
    arrays, labels = shards[0]
    assert arrays["frames"].shape == (3, 4, 224, 224, 3)
    assert arrays["displacement_px"].shape == (3, 4, 14, 14, 2)
    assert len(labels) == 3
    assert seen == [("simulated", 3, 7), ("simulated", 6, 7), ("simulated", 7, 7)]
    card = (tmp_path / "README.md").read_text()
    assert "7 clips of 2 bodies" in card


def test_a_killed_run_resumes_to_the_same_bytes(tmp_path):
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    write_dataset(whole, 7, seed=1, objects=OBJECTS)

    class Killed(Exception):
        pass

    def stop(what, done, total):
        if done >= 3:
            raise Killed

    with pytest.raises(Killed):
        write_dataset(killed, 7, seed=1, objects=OBJECTS, progress=stop)
    kept = (killed / "shard-00000.npz").stat().st_mtime_ns
    (killed / "shard-00001.npz").write_bytes(b"half a shard")
    write_dataset(killed, 7, seed=1, objects=OBJECTS)
    assert (killed / "shard-00000.npz").stat().st_mtime_ns == kept
    assert contents(killed) == contents(whole)


def test_a_grown_data_set_keeps_its_clips_and_equals_one_written_at_once(tmp_path):
    grown, whole = tmp_path / "grown", tmp_path / "whole"
    write_dataset(grown, 4, seed=1, objects=OBJECTS)
    write_dataset(grown, 7, seed=1, objects=OBJECTS)
    write_dataset(whole, 7, seed=1, objects=OBJECTS)
    assert contents(grown) == contents(whole)


def test_a_folder_that_says_nothing_of_mixed_clips_has_none_and_is_continued(tmp_path):
    write_dataset(tmp_path, 1, seed=1, objects=OBJECTS, preset="draft")
    before, told = contents(tmp_path), tmp_path / "dataset.json"
    about = json.loads(told.read_text())
    told.write_text(json.dumps({name: about[name] for name in about if name != "mixed_share"}))
    write_dataset(tmp_path, 1, seed=1, objects=OBJECTS, preset="draft")
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    "other", [{"seed": 2}, {"preset": "good"}, {"marker_share": 1.0}, {"mixed_share": 0.5}]
)
def test_a_folder_of_another_seed_or_setting_is_refused_and_kept(tmp_path, other):
    given = {"seed": 1, "objects": OBJECTS, "preset": "draft"}
    write_dataset(tmp_path, 1, **given)
    before = contents(tmp_path)
    with pytest.raises(UsageError, match="holds another data set"):
        write_dataset(tmp_path, 1, **given | other)
    assert contents(tmp_path) == before


def test_a_smaller_data_set_is_refused_and_no_clip_is_lost(tmp_path):
    write_dataset(tmp_path, 4, seed=1, objects=OBJECTS)
    before = contents(tmp_path)
    with pytest.raises(UsageError) as caught:
        write_dataset(tmp_path, 2, seed=1, objects=OBJECTS)
    assert str(caught.value) == (
        f"{tmp_path} was made for 4 clips, 2 were asked for; ask for at least as many, or choose "
        f"an empty folder."
    )
    assert contents(tmp_path) == before


@pytest.mark.parametrize("content", ["{", "[]", '{"seed": 1}'])
def test_a_folder_that_does_not_say_what_it_holds_is_refused(tmp_path, content):
    (tmp_path / "dataset.json").write_text(content)
    with pytest.raises(UsageError, match="does not say what the folder holds"):
        write_dataset(tmp_path, 2, seed=1, objects=OBJECTS)


@pytest.mark.slow
def test_the_number_of_workers_does_not_change_a_byte(tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    for folder, workers in ((one, 1), (two, 2)):
        write_dataset(folder, 6, seed=1, objects=OBJECTS, preset="draft", workers=Workers(workers))
    assert contents(one) == contents(two)


def test_drift_is_kept_where_it_was_asked_for(tmp_path):
    write_dataset(tmp_path, 2, seed=1, objects=OBJECTS, preset="draft", with_drift=True)
    arrays, _ = read_shard(tmp_path / "shard-00000.npz")
    assert arrays["drift_px"].shape == (2, 4, 14, 14, 2)
    assert "preset\ndraft" in (tmp_path / "README.md").read_text()
    about = json.loads((tmp_path / "dataset.json").read_text())
    assert (about["preset"], about["with_drift"]) == ("draft", True)


def test_labels_only_are_those_of_the_whole_data_set_without_its_pictures(tmp_path):
    whole, bare = tmp_path / "whole", tmp_path / "bare"
    for folder, wanted in ((whole, True), (bare, False)):
        write_dataset(folder, 2, seed=1, objects=OBJECTS, preset="draft", with_frames=wanted)
    (seen, _), (told, labels) = (read_shard(one / "shard-00000.npz") for one in (whole, bare))
    assert set(seen) - set(told) == {"frames", "backgrounds"}
    assert all(np.array_equal(values, seen[name]) for name, values in told.items())
    assert len(labels) == 2
    assert "No picture was made" in (bare / "README.md").read_text()
    assert "`frames`" not in (bare / "README.md").read_text()
    with pytest.raises(UsageError, match="other objects or settings"):
        write_dataset(bare, 2, seed=1, objects=OBJECTS, preset="draft")


WRITER = """
import sys
from pathlib import Path
from geotlm_lm.simulation import dataset
from geotlm_lm.runs.run import Workers
from tests.process_groups import in_proc, members

if __name__ == "__main__":
    dataset.SHARD_CLIPS = 3
    out, workers = Path(sys.argv[1]), Workers(int(sys.argv[2]))
    objects = ("block", "cloth_coarse")
    dataset.write_dataset(out, 18, seed=1, objects=objects, workers=workers, preset="draft")
"""


@pytest.mark.slow
def test_after_kill_9_a_resumed_run_has_lost_and_repeated_nothing(tmp_path):
    program, whole, killed = tmp_path / "writer.py", tmp_path / "whole", tmp_path / "killed"
    program.write_text(WRITER)
    command = [sys.executable, str(program), str(killed), "2"]
    write_dataset(whole, 18, seed=1, objects=OBJECTS, preset="draft")
    run = subprocess.Popen(command)
    while not list(killed.glob("shard-*.npz")) and run.poll() is None:
        time.sleep(0.002)
    run.send_signal(signal.SIGKILL)
    run.wait()
    kept = {path: path.stat().st_mtime_ns for path in killed.glob("shard-*.npz")}
    assert 0 < len(kept) < 6
    assert subprocess.run(command).returncode == 0
    # A worker whose parent was killed ends within a moment; what it had begun has another name.
    finished = {path: path.stat().st_mtime_ns for path in kept}
    assert finished == kept
    shards = sorted(killed.glob("shard-*.npz"))
    indices = np.concatenate([read_shard(path)[0]["index"] for path in shards])
    assert indices.tolist() == list(range(18))
    for path in [*shards, killed / "README.md", killed / "dataset.json"]:
        assert path.read_bytes() == (whole / path.name).read_bytes()


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
            _, told = run.communicate(timeout=8)  # until no worker holds its end of the pipe
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(run.pid, signal.SIGKILL)
    assert run.returncode == (130 if number == signal.SIGINT else -number)
    assert told == "Stopped; files already complete are kept.\n"
    assert [path.name for path in (tmp_path / "set").iterdir()] == ["dataset.json"]
