"""A run on a cluster of two nodes: what is expected are the bytes that one process writes.

Ray starts in some ten seconds, so that one test takes a run through all that can happen to it.
"""

import pytest

from geotlm_lm.data_sets.labelling import Labelling, label_data_set
from geotlm_lm.workers import Workers
from tests.data_sets.lerobot_files import CAMERA, turned, write_data_set

pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra lerobot")
pytest.importorskip("av", reason="needs av, of the extra lerobot")
pytest.importorskip("ray.data", reason="needs ray, of the extra ray")


class Stopped(BaseException):
    """A run ended from outside, as by Ctrl-C."""


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


def test_a_stopped_run_and_a_killed_node_lose_and_repeat_nothing_and_change_no_byte(
    cluster, tmp_path, answerer
):
    clips = [turned(degrees) for degrees in (20, -15, 10, -20, 15, -10)]
    root = write_data_set(tmp_path / "robot", clips)
    label_data_set(Labelling(root, CAMERA), tmp_path / "whole")
    out, by = tmp_path / "out", Workers(cluster=cluster.address)

    def written():
        paths = (tmp_path / "out.part").glob("episode-*.npz")
        return {path.name: path.stat().st_mtime_ns for path in paths}

    def stop(what, done, total):
        raise Stopped

    with pytest.raises(Stopped):
        label_data_set(Labelling(root, CAMERA), out, workers=by, progress=stop)
    assert not out.exists()
    kept, last = written(), {}
    assert 0 < len(kept) < len(clips)

    def kill_a_node_at_once(what, done, total):
        if not last:
            cluster.remove_node(cluster.second, allow_graceful=False)
        last.update(written())

    result = label_data_set(Labelling(root, CAMERA), out, workers=by, progress=kill_a_node_at_once)
    assert result.continued == len(kept)
    assert kept.items() <= last.items()
    assert files_of(out) == files_of(tmp_path / "whole")
