import json
import os

import numpy as np
import pytest

from geotlm_lm.core.errors import GeoTLMError, UsageError
from geotlm_lm.simulation import dataset
from geotlm_lm.simulation.dataset import read_shard, write_dataset

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
    assert seen == [(3, 7), (6, 7), (7, 7)]
    card = (tmp_path / "README.md").read_text()
    assert "7 clips of 2 bodies" in card


def test_a_killed_run_resumes_to_the_same_bytes(tmp_path):
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    write_dataset(whole, 7, seed=1, objects=OBJECTS)

    class Killed(Exception):
        pass

    def stop(done, _):
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


def test_a_folder_of_another_seed_is_refused_and_kept(tmp_path):
    write_dataset(tmp_path, 1, seed=1, objects=OBJECTS)
    before = contents(tmp_path)
    with pytest.raises(UsageError, match="holds another data set"):
        write_dataset(tmp_path, 1, seed=2, objects=OBJECTS)
    assert contents(tmp_path) == before
    assert json.loads(before["dataset.json"])["seed"] == 1


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
    write_dataset(one, 6, seed=1, objects=OBJECTS, workers=1)
    write_dataset(two, 6, seed=1, objects=OBJECTS, workers=2)
    assert contents(one) == contents(two)


def _die(shard):
    os._exit(9)


@pytest.mark.slow
def test_a_killed_worker_is_told_instead_of_waited_for(tmp_path, monkeypatch):
    monkeypatch.setattr(dataset, "_write_shard", _die)
    with pytest.raises(GeoTLMError, match="^A worker was ended from outside"):
        write_dataset(tmp_path, 6, seed=1, objects=OBJECTS, workers=2)


def test_drift_is_kept_where_it_was_asked_for(tmp_path):
    write_dataset(tmp_path, 2, seed=1, objects=OBJECTS, preset="draft", with_drift=True)
    arrays, _ = read_shard(tmp_path / "shard-00000.npz")
    assert arrays["drift_px"].shape == (2, 4, 14, 14, 2)
    assert "preset\ndraft" in (tmp_path / "README.md").read_text()
    about = json.loads((tmp_path / "dataset.json").read_text())
    assert (about["preset"], about["with_drift"]) == ("draft", True)


def test_a_folder_of_another_preset_is_not_mixed_up(tmp_path):
    write_dataset(tmp_path, 2, seed=1, objects=OBJECTS)
    before = contents(tmp_path)
    with pytest.raises(UsageError, match="or other objects or settings"):
        write_dataset(tmp_path, 2, seed=1, objects=OBJECTS, preset="good")
    assert contents(tmp_path) == before
