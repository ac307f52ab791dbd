"""Who does the parts of a run: as many processes as asked for, else one per core."""

import multiprocessing
import os
import pickle
import signal
import socket

import pytest

from geotlm_lm import __version__, local_pool
from geotlm_lm import workers as workers_module
from geotlm_lm.cluster import _Worker
from geotlm_lm.core.errors import MissingDependency, UsageError
from geotlm_lm.workers import ALONE, Workers


def test_parts_are_done_in_this_process_by_one_worker():
    assert list(ALONE.each_done(abs, [-1, 2, -3])) == [1, 2, 3]


def test_all_usable_cores_work_unless_told_otherwise(monkeypatch):
    asked = []
    monkeypatch.setattr(local_pool, "each_done", lambda *given, is_here: asked.append(given[2]))
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0, 2, 5}, raising=False)
    Workers().each_done(abs, [1])
    Workers(2).each_done(abs, [1])
    monkeypatch.delattr("os.sched_getaffinity")
    monkeypatch.setattr("os.cpu_count", lambda: 7)
    Workers().each_done(abs, [1])
    assert asked == [3, 2, 7]


def halved(number):
    if number == 1:
        os.kill(os.getpid(), signal.SIGSEGV)  # as a broken decoder
    return number // 2


def end_once(path):
    if not path.exists():
        path.touch()
        os.kill(os.getpid(), signal.SIGKILL)  # as the system, for want of memory
    return path.name


@pytest.mark.skipif(os.name == "nt", reason="a process is ended there in other ways")
def test_a_part_that_ends_its_process_is_lost_alone_though_one_works():
    done = list(Workers(1).each_done(halved, [0, 1, 2], lost=str))
    assert done == [0, 1, "1"]
    assert multiprocessing.active_children() == []


@pytest.mark.skipif(os.name == "nt", reason="a process is ended there in other ways")
def test_a_part_that_was_only_beside_another_is_done_again(tmp_path):
    parts = [tmp_path / "a", tmp_path / "b"]
    assert sorted(Workers(2).each_done(end_once, parts)) == ["a", "b"]


def test_a_cluster_without_ray_is_told_before_any_work(monkeypatch):
    monkeypatch.setattr(workers_module, "find_spec", lambda _: None)
    with pytest.raises(MissingDependency) as error:
        Workers(cluster="local")
    assert str(error.value) == (
        "--cluster needs Ray, which is not installed; run `pip install 'geotlm-lm[ray]'`."
    )


def test_a_machine_that_shares_no_folder_with_the_command_says_so_and_does_nothing(
    tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)

    def told(folder, seen):
        worker = _Worker(abs, str(folder), __version__, [tmp_path / name for name in seen])
        return pickle.loads(worker._done(pickle.dumps(-1)))

    (tmp_path / "there").touch()
    assert told(tmp_path, ["there"]) == (1, None)
    for folder, seen, sentence in (
        (
            tmp_path,
            ["there", "dataset.json"],
            f"has no {tmp_path}/dataset.json, expected what the command sees; keep what is read "
            f"and written in a folder that all machines of the cluster share.",
        ),
        (
            tmp_path / "gone",
            [],
            f"has no folder {tmp_path}/gone, expected what the command sees; run it in a folder "
            f"that all machines of the cluster share.",
        ),
    ):
        done, error = told(folder, seen)
        assert (done, type(error)) == (None, UsageError)
        assert str(error) == f"{socket.gethostname()}: {sentence}"
