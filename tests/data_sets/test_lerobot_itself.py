"""LeRobot itself, where it is installed, loads what these tests write and what is written here."""

import json
import subprocess
import sys

import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.data_sets.labelling import Labelling, label_data_set
from tests.data_sets.lerobot_files import CAMERA, turned, write_data_set

parquet = pytest.importorskip("pyarrow.parquet", reason="needs pyarrow, of the extra lerobot")
pytest.importorskip("av", reason="needs av, of the extra lerobot")
pytest.importorskip("lerobot", reason="needs LeRobot, which no extra of ours brings")

CLIPS = [turned(20), turned(-15, 28), turned(10, 26)]

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
def test_the_data_set_before_and_with_its_labels(tmp_path, without_model, as_images):
    black = Clip(CLIPS[2].frames * 0, fps=CLIPS[2].fps)
    root = write_data_set(tmp_path / "robot", [*CLIPS[:2], black], as_images=as_images)
    before = loaded_by_lerobot(root, tmp_path / "home")
    label_data_set(Labelling(root, CAMERA), tmp_path / "out")
    after = loaded_by_lerobot(tmp_path / "out", tmp_path / "home")
    assert before["episodes"] == after["episodes"] == 3
    assert before["items"][1][CAMERA] == [3, *CLIPS[0].frames.shape[1:3]]
    assert [item["episode_index"] for item in after["items"]] == [0, 1, 2]
    paths = sorted((tmp_path / "out").glob("data/*/*.parquet"))
    rows = [row for path in paths for row in parquet.ParquetFile(path).read().to_pylist()]
    for number, old, new in zip((0, 30, 77), before["items"], after["items"], strict=True):
        assert old.items() <= new.items()
        added = {name: rows[number][name] for name in set(new) - set(old)}
        assert len(added) == 8
        assert {name: new[name] for name in added} == pytest.approx(added, nan_ok=True)
    assert set(added) <= set(after["statistics"])
