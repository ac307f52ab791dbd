"""A run on a cluster of two nodes: what is expected are the bytes that one process writes.

Ray starts in some ten seconds, so that one test takes a run through all that can happen to it.
"""

import subprocess
import sys
import time
from pathlib import Path

import pytest

from geotlm_lm.data_sets.labelling import Labelling, label_data_set
from geotlm_lm.runs.run import Workers
from tests.data_sets.lerobot_files import CAMERA, turned, write_data_set

pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra lerobot")
pytest.importorskip("av", reason="needs av, of the extra lerobot")
pytest.importorskip("ray.data", reason="needs ray, of the extra ray")

ROOT = Path(__file__).resolve().parents[2]

SETTLED_S = 3
"""In which a cluster ends the actors of a command that is gone."""


@pytest.fixture
def cluster(monkeypatch):
    """A head and a second node of one core each, on this machine."""
    from ray.cluster_utils import Cluster

    monkeypatch.setenv("RAY_worker_niceness", "0")
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    small = {"num_cpus": 1, "object_store_memory": 100 * 2**20}
    made = Cluster(initialize_head=True, head_node_args=small | {"include_dashboard": False})
    made.second = made.add_node(**small)
    yield made
    made.shutdown()


def files_of(folder):
    paths = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def kill_when(count, root, out, address):
    """Label by the command and kill it as soon as so many episodes are done; return which are."""
    command = [sys.executable, "-m", "geotlm_lm", "label", root, "--camera", CAMERA]
    command += ["--out", out, "--cluster", address]
    with subprocess.Popen(list(map(str, command)), cwd=ROOT, stderr=subprocess.DEVNULL) as running:
        while len(written(out)) < count and running.poll() is None:
            time.sleep(0.005)
        running.kill()
    time.sleep(SETTLED_S)
    return written(out)


def written(out):
    paths = out.with_name(f"{out.name}.part").glob("episode-*.npz")
    return {path.name: path.stat().st_mtime_ns for path in paths}


def test_a_run_killed_twice_and_a_killed_node_lose_and_repeat_nothing_and_change_no_byte(
    cluster, tmp_path, answerer
):
    clips = [turned(degrees) for degrees in (20, -15, 10, -20, 15, -10) * 4]
    root = write_data_set(tmp_path / "robot", clips)
    label_data_set(Labelling(root, CAMERA), tmp_path / "whole")
    out, last = tmp_path / "out", {}
    once = kill_when(len(clips) // 4, root, out, cluster.address)
    twice = kill_when(len(once) + 4, root, out, cluster.address)
    assert not out.exists()
    assert once.items() <= twice.items()
    assert 0 < len(once) < len(twice) < len(clips)

    def kill_a_node_at_once(what, done, total):
        if not last:
            cluster.remove_node(cluster.second, allow_graceful=False)
        last.update(written(out))

    by = Workers(cluster=cluster.address)
    result = label_data_set(Labelling(root, CAMERA), out, workers=by, progress=kill_a_node_at_once)
    assert result.continued == len(twice)
    assert twice.items() <= last.items()
    assert files_of(out) == files_of(tmp_path / "whole")
