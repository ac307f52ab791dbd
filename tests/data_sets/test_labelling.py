"""Labels beside a data set: what is expected is the track of the same recording, and the original.

A tracker that measures stands in for the model, but where processes start their own.
"""

import json
import multiprocessing
import os
import signal
import subprocess
import sys
from dataclasses import fields

import cv2
import numpy as np
import pytest

from geotlm_lm.answering.answerer import loaded
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.errors import Unwritten, UsageError
from geotlm_lm.data_sets import labelling as labelling_module
from geotlm_lm.data_sets.labelling import Labelling, label_data_set
from geotlm_lm.data_sets.lerobot import LeRobotDataSet, read_data_set
from geotlm_lm.recordings import policy
from geotlm_lm.runs.run import LOST, Workers
from geotlm_lm.track.tracker import track_of
from tests.cli.recorded_touch import Measuring
from tests.data_sets.lerobot_files import CAMERA, FPS, KINDS, turned, write_data_set
from tests.full_disk import full_disk
from tests.track import stream as simulated

parquet = pytest.importorskip("pyarrow.parquet", reason="needs pyarrow, of the extra lerobot")
pytest.importorskip("av", reason="needs av, of the extra lerobot")

CLIPS = [turned(20), turned(-15, 28), turned(10, 26)]

NAMES = tuple(
    f"tactile.{name}{suffix}"
    for name in ("turn_deg_s", "right_px_s", "down_px_s", "contact")
    for suffix in ("", "_deviation")
)


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    return write_data_set(tmp_path_factory.mktemp("sets") / "robot", CLIPS)


@pytest.fixture(scope="module")
def labelled(root, tmp_path_factory):
    """The data set with its labels."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("geotlm_lm.answering.Answerer.load", lambda *_, **__: Measuring())
        loaded.cache_clear()
        label_data_set(Labelling(root, CAMERA), out := tmp_path_factory.mktemp("sets") / "labelled")
        loaded.cache_clear()
    return out


def files_of(folder):
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def rows(folder):
    paths = sorted(folder.glob("data/*/*.parquet"))
    return [row for path in paths for row in parquet.ParquetFile(path).read().to_pylist()]


def small(clip):
    """Return a clip in a camera's shape, 160 x 120."""
    frames = [cv2.resize(frame, (160, 120), interpolation=cv2.INTER_AREA) for frame in clip.frames]
    return Clip(np.stack(frames), fps=FPS)


def test_a_simulated_recording_is_labelled_as_its_array_is_and_spans_hold_the_truth(
    tmp_path, without_model
):
    clip = small(simulated.stream())
    root = write_data_set(tmp_path / "robot", [clip, clip.select(range(60))])
    label_data_set(Labelling(root, CAMERA), tmp_path / "out")
    told = [row for row in rows(tmp_path / "out") if row["episode_index"] == 0]
    turning = np.array([row["tactile.turn_deg_s"] for row in told])
    deviations = np.array([row["tactile.turn_deg_s_deviation"] for row in told])
    track = track_of(clip, idle=clip.frames[0])
    of_array = track.rates()[0][:, 0]
    # What a codec changes of a rate is well below what is doubted of it.
    moving = np.abs(of_array) > 10
    assert np.sqrt(np.mean((turning - of_array)[moving] ** 2)) < 0.5 * deviations[moving].mean()
    touched = deviations > 0
    off = np.abs(turning - simulated_turn_deg_s(track.times_s))[touched]
    assert (off < 1.645 * deviations[touched]).mean() >= 0.9
    contact = np.array([row["tactile.contact"] for row in told])
    assert np.abs(contact - track.contact).mean() < 0.1
    assert all(row[name] == 0 for row in told[:4] for name in NAMES[:6])


def simulated_turn_deg_s(times_s):
    """Return the true rate over the time that a rate is measured over."""
    stops = np.array([simulated.TURN, simulated.TURN_END, simulated.BACK, simulated.BACK_END])
    turn, back = simulated.TURN_DEG, simulated.BACK_DEG
    way = [np.interp(times_s + off, stops / FPS, [0, turn, turn, turn - back])
           for off in (-2 / FPS, 2 / FPS)]  # fmt: skip
    return (way[1] - way[0]) * FPS / 4


def test_the_new_data_set_is_the_old_one_with_columns(root, labelled):
    data_set, original = read_data_set(labelled), read_data_set(root)
    assert data_set.episodes == original.episodes
    added = {name: data_set.features[name] for name in NAMES}
    content = original.info
    assert data_set.info == content | {"features": original.features | added}
    assert set(map(json.dumps, added.values())) == {
        '{"dtype": "float32", "shape": [1], "names": null}'
    }
    plain = [{k: v for k, v in row.items() if k not in NAMES} for row in rows(labelled)]
    assert plain == rows(root)
    before, after = (
        parquet.ParquetFile(folder / "data/chunk-000/file-000.parquet")
        for folder in (root, labelled)
    )
    assert after.num_row_groups == before.num_row_groups == 2
    assert after.schema_arrow.metadata == before.schema_arrow.metadata
    assert {str(after.schema_arrow.field(name).type) for name in NAMES} == {"float"}
    kept = ("README.md", "meta/tasks.parquet")
    assert all((labelled / name).read_bytes() == (root / name).read_bytes() for name in kept)


def test_videos_are_the_same_files_and_where_that_cannot_be_equal_ones(
    root, labelled, tmp_path, monkeypatch, without_model
):
    name = f"videos/{CAMERA}/chunk-000/file-001.mp4"
    assert (labelled / name).samefile(root / name)

    def unlinked(*_):
        raise OSError("another disk")

    monkeypatch.setattr("os.link", unlinked)
    label_data_set(Labelling(root, CAMERA), tmp_path / "copied")
    assert not (tmp_path / "copied" / name).samefile(root / name)
    assert files_of(tmp_path / "copied") == files_of(labelled)


def test_statistics_are_those_of_the_columns(root, labelled):
    told = json.loads((labelled / "meta/stats.json").read_text())
    values = np.array([row["tactile.turn_deg_s"] for row in rows(labelled)])
    assert set(told["tactile.turn_deg_s"]) == set(KINDS)
    assert told["tactile.turn_deg_s"]["mean"] == pytest.approx([values.mean()])
    assert told["tactile.turn_deg_s"]["q90"] == pytest.approx([np.quantile(values, 0.9)])
    assert told["tactile.turn_deg_s"]["count"] == [78]
    assert told["index"] == json.loads((root / "meta/stats.json").read_text())["index"]
    table = parquet.ParquetFile(labelled / "meta/episodes/chunk-000/file-000.parquet").read()
    kept = table["stats/timestamp/max"].type
    assert table["stats/tactile.contact/max"].type == kept
    assert table["stats/tactile.contact/count"].to_pylist() == [[24], [28], [26]]
    least = table["stats/tactile.turn_deg_s/min"].to_pylist()
    assert least[1] == pytest.approx([values[24:52].min()])


def test_events_are_a_table_with_their_episode(root, tmp_path, without_model):
    label_data_set(Labelling(root, CAMERA, mm_per_px=0.06), tmp_path / "out")
    table = parquet.ParquetFile(tmp_path / "out/meta/tactile_events.parquet").read()
    turns = [one for one in table.to_pylist() if one["event"] == "turn"]
    assert [(one["episode_index"], one["way"]) for one in turns] == [
        (0, "clockwise"),
        (1, "counterclockwise"),
        (2, "clockwise"),
    ]
    assert [one["amount"] for one in turns] == pytest.approx([20, -15, 10], rel=0.25)
    made_by = json.loads(table.schema.metadata[b"geotlm_lm"])
    assert (made_by["model"], made_by["mm_per_px"]) == ("measured", 0.06)
    assert "tactile.right_mm_s" in read_data_set(tmp_path / "out").features


def test_a_stopped_run_keeps_what_is_done_and_ends_with_the_same_bytes(
    root, labelled, tmp_path, monkeypatch, without_model
):
    out = tmp_path / "out"
    tracked, track = [], labelling_module._track

    def stopping(data_set, episode, labelling):
        if len(tracked) == 2:
            raise KeyboardInterrupt
        tracked.append(episode.index)
        return track(data_set, episode, labelling)

    monkeypatch.setattr(labelling_module, "_track", stopping)
    with pytest.raises(KeyboardInterrupt):
        label_data_set(Labelling(root, CAMERA), out)
    assert not out.exists()
    with pytest.raises(UsageError, match="belongs to a run of other data set, camera or facts"):
        label_data_set(Labelling(root, CAMERA, mm_per_px=0.1), out)
    (tmp_path / "out.part/episode-000001.npz").write_bytes(b"half of it")
    tracked.clear()
    assert label_data_set(Labelling(root, CAMERA), out).continued == 1
    assert tracked == [1, 2]
    assert files_of(out) == files_of(labelled)
    assert not (tmp_path / "out.part").exists()


def test_nothing_is_replaced_and_nothing_labelled_twice(root, labelled, tmp_path, without_model):
    with pytest.raises(UsageError, match="is there already and would be replaced"):
        label_data_set(Labelling(root, CAMERA), labelled)
    with pytest.raises(UsageError, match=r"has a column tactile\.turn_deg_s already"):
        label_data_set(Labelling(labelled, CAMERA), tmp_path / "twice")
    with pytest.raises(UsageError, match="lies in the data set that is read"):
        label_data_set(Labelling(root, CAMERA), root / "labelled")


def test_an_episode_without_a_picture_has_no_labels_and_the_others_have(tmp_path, without_model):
    black = Clip(np.zeros_like(CLIPS[0].frames), fps=FPS)
    root = write_data_set(tmp_path / "robot", [CLIPS[0], black])
    result = label_data_set(Labelling(root, CAMERA), tmp_path / "out")
    assert list(result.refused) == [1]
    assert "is black, expected at most" in result.refused[1]
    turning = np.array([row["tactile.turn_deg_s"] for row in rows(tmp_path / "out")])
    assert np.isfinite(turning[:24]).all()
    assert np.isnan(turning[24:]).all()
    told = json.loads((tmp_path / "out/meta/stats.json").read_text())
    assert np.isfinite(told["tactile.turn_deg_s"]["mean"]).all()


def test_an_episode_that_does_not_fit_into_memory_is_tracked_frame_by_frame(
    root, labelled, tmp_path, monkeypatch, without_model
):
    monkeypatch.setattr(policy, "KEPT_BYTES", 10 * CLIPS[0].frames[0].nbytes)
    label_data_set(Labelling(root, CAMERA), tmp_path / "out")
    assert rows(tmp_path / "out") == rows(labelled)


@pytest.mark.slow
def test_as_many_processes_as_there_are_write_the_same_bytes(root, tmp_path, answerer):
    loaded.cache_clear()
    for workers in (1, 2):
        label_data_set(Labelling(root, CAMERA), tmp_path / f"by{workers}", workers=Workers(workers))
    assert files_of(tmp_path / "by1") == files_of(tmp_path / "by2")


class Deadly(LeRobotDataSet):
    """A data set whose second episode ends the process that decodes it."""

    def video_of(self, episode, camera):
        if episode.index == 1 and multiprocessing.parent_process():
            os.kill(os.getpid(), signal.SIGKILL)
        return super().video_of(episode, camera)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="a process is ended there in other ways")
def test_an_episode_that_ends_its_process_has_no_labels_and_the_others_have(
    root, tmp_path, answerer, monkeypatch
):
    def deadly(folder):
        found = read_data_set(folder)
        return Deadly(**{one.name: getattr(found, one.name) for one in fields(found)})

    monkeypatch.setattr(labelling_module, "read_data_set", deadly)
    result = label_data_set(Labelling(root, CAMERA), tmp_path / "out", workers=Workers(1))
    assert result.refused == {1: f"{root} episode 1: {LOST}"}
    known = [row["episode_index"] for row in rows(tmp_path / "out") if row[NAMES[0]] is not None]
    assert result.episodes == 3
    assert {0, 2} <= set(known)


@pytest.mark.parametrize("room", [600, 4000])
def test_a_full_disk_is_told_by_the_file_that_is_written(
    root, labelled, tmp_path, without_model, room
):
    out = tmp_path / "out"
    with full_disk(room), pytest.raises(Unwritten, match=rf"^{out}\.part/.*: cannot be written"):
        label_data_set(Labelling(root, CAMERA), out)
    assert not out.exists()
    label_data_set(Labelling(root, CAMERA), out)
    assert files_of(out) == files_of(labelled)


def test_rerun_reads_the_new_data_set_as_one_of_version_3(labelled):
    rerun = pytest.importorskip("rerun.experimental", reason="needs rerun-sdk, of the extra rerun")
    reader = rerun.LeRobotReader(labelled)
    assert (reader.version, list(reader.episodes())) == ("v3", [0, 1, 2])


def test_datasets_reads_the_new_tables_by_their_features_as_lerobot_does(labelled, tmp_path):
    datasets = pytest.importorskip("datasets", reason="needs datasets, of the extra dev")
    kinds = {
        name: datasets.Value(feature["dtype"])
        if feature["shape"] == [1]
        else datasets.Sequence(datasets.Value(feature["dtype"]), length=feature["shape"][0])
        for name, feature in read_data_set(labelled).features.items()
        if feature["dtype"] != "video"
    }
    for folder, features in (("data", datasets.Features(kinds)), ("meta/episodes", None)):
        paths = [str(path) for path in sorted((labelled / folder).glob("*/*.parquet"))]
        found = datasets.Dataset.from_parquet(
            paths, features=features, cache_dir=str(tmp_path / "cache")
        )
        assert len(found) == {"data": 78, "meta/episodes": 3}[folder]
    assert found[1]["stats/tactile.contact/count"] == [28]


LOADING = """
import json, sys
from lerobot.datasets.lerobot_dataset import LeRobotDataset
loaded = LeRobotDataset("local/drawn", root=sys.argv[1], video_backend="pyav")
items = [{name: value.tolist() if value.numel() == 1 else list(value.shape)
          for name, value in loaded[n].items() if hasattr(value, "numel")} | {
          "task": loaded[n]["task"]} for n in (0, 30, 77)]
print(json.dumps({"episodes": loaded.num_episodes, "items": items,
                  "statistics": sorted(loaded.meta.stats)}))
"""


def loaded_by_lerobot(root, folder):
    """Return what a process of its own, without the network, reads of three frames."""
    paths = {"PATH": "/usr/bin:/bin", "HOME": str(folder), "HF_HOME": str(folder)}
    run = subprocess.run(
        [sys.executable, "-c", LOADING, root],
        env=paths | {"HF_HUB_OFFLINE": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout.splitlines()[-1])


@pytest.mark.parametrize("as_images", [False, True])
def test_lerobot_itself_loads_the_data_set_before_and_with_its_labels(
    tmp_path, without_model, as_images
):
    pytest.importorskip("lerobot", reason="needs LeRobot, which no extra of ours brings")
    black = Clip(CLIPS[2].frames * 0, fps=CLIPS[2].fps)
    root = write_data_set(tmp_path / "robot", [*CLIPS[:2], black], as_images=as_images)
    before = loaded_by_lerobot(root, tmp_path / "home")
    label_data_set(Labelling(root, CAMERA), tmp_path / "out")
    after = loaded_by_lerobot(tmp_path / "out", tmp_path / "home")
    assert before["episodes"] == after["episodes"] == 3
    assert before["items"][1][CAMERA] == [3, *CLIPS[0].frames.shape[1:3]]
    assert [item["episode_index"] for item in after["items"]] == [0, 1, 2]
    told = rows(tmp_path / "out")
    for number, old, new in zip((0, 30, 77), before["items"], after["items"], strict=True):
        assert old.items() <= new.items()
        added = {name: told[number][name] for name in set(new) - set(old)}
        assert len(added) == 8
        assert {name: new[name] for name in added} == pytest.approx(added, nan_ok=True)
    assert set(added) <= set(after["statistics"])
