"""Long runs: every part once, each result kept, whatever ends on the way."""

import multiprocessing
import os
import pickle
import shutil
import signal
import socket
import time

import pytest

from geotlm_lm import __version__
from geotlm_lm.core.errors import GeoTLMError, MissingDependency, UsageError
from geotlm_lm.runs import processes
from geotlm_lm.runs import run as run_module
from geotlm_lm.runs.cluster import _Worker
from geotlm_lm.runs.run import (
    ALONE,
    Workers,
    do_parts,
    holds_json,
    load_json,
    run_folder,
    save_json,
)

needs_kills = pytest.mark.skipif(os.name == "nt", reason="a process is ended there in other ways")

SETTINGS = {"seed": 1}


def halved(number):
    if number == 1:
        os.kill(os.getpid(), signal.SIGSEGV)  # as a broken decoder
    return number // 2


def end_once(path):
    if not path.exists():
        path.touch()
        os.kill(os.getpid(), signal.SIGKILL)  # as the system, for want of memory
    return path.name


def test_a_single_worker_is_this_process():
    parts = ALONE.map(lambda part: (part, os.getpid()), [1, 2])
    assert list(parts) == [(1, (1, os.getpid())), (2, (2, os.getpid()))]


def test_all_usable_cores_work_unless_fewer_are_asked_for(monkeypatch):
    counts = []
    monkeypatch.setattr(
        processes, "map_by_processes", lambda *given, is_here: counts.append(given[2])
    )
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0, 2, 5}, raising=False)
    Workers().map(abs, [1])
    Workers(2).map(abs, [1])
    monkeypatch.delattr("os.sched_getaffinity")
    monkeypatch.setattr("os.cpu_count", lambda: 7)
    Workers().map(abs, [1])
    assert counts == [3, 2, 7]


@pytest.mark.slow
@needs_kills
def test_a_part_that_ends_its_process_is_lost_alone_though_only_one_works(tmp_path):
    jobs = [(number, tmp_path / f"{number}.json") for number in (0, 1, 2)]
    do_parts("halve", halved, jobs, save_json, workers=Workers(1), lost=str)
    assert [load_json(path) for _, path in jobs] == [0, "1", 1]
    assert multiprocessing.active_children() == []
    with pytest.raises(GeoTLMError, match="^A worker was ended from outside"):
        dict(Workers(2).map(halved, [0, 1]))


@pytest.mark.slow
@needs_kills
def test_a_part_that_was_only_beside_another_is_done_again(tmp_path):
    parts = [tmp_path / "a", tmp_path / "b"]
    assert dict(Workers(2).map(end_once, parts)) == {path: path.name for path in parts}


def test_a_run_that_is_broken_off_ends_its_workers_and_not_its_callers_processes(tmp_path):
    mine = multiprocessing.get_context("spawn").Process(target=time.sleep, args=(60,))

    def start_and_fail(what, done, total):
        mine.start()
        raise ZeroDivisionError

    jobs = [(number, tmp_path / str(number)) for number in range(60)]
    with pytest.raises(ZeroDivisionError) as error:  # whose traceback holds the run's frames
        do_parts("", abs, jobs, save_json, workers=Workers(2), progress=start_and_fail)
    try:
        assert error is not None
        assert multiprocessing.active_children() == [mine]
    finally:
        mine.kill()
        mine.join()


class Stopped(BaseException):
    """A run ended from outside, as by Ctrl-C."""


def squares(folder, numbers, stop_at=None):
    """Run over numbers and return the squares, those done now, how many were kept, and calls."""
    done, calls = [], []

    def square(number):
        if number == stop_at:
            raise Stopped
        done.append(number)
        return number**2

    jobs = [(number, folder / f"{number}.json") for number in numbers]
    with run_folder(folder, SETTINGS, "numbers"):
        kept = do_parts(
            "square",
            square,
            jobs,
            save_json,
            is_kept=holds_json,
            size=lambda number: 10,
            progress=lambda *call: calls.append(call),
        )
    return [load_json(path) for _, path in jobs], done, kept, calls


@pytest.mark.parametrize("half", [b"", b"4", b"[", b"[" * 100_000, b"\xff\xfe"])
def test_a_stopped_run_goes_on_with_what_is_missing_or_damaged(tmp_path, half):
    folder = tmp_path / "run"
    with pytest.raises(Stopped):
        squares(folder, range(4), stop_at=3)
    (folder / "1.json").write_bytes(half)
    is_whole = half == b"4"
    values, done, kept, calls = squares(folder, range(4))
    assert values == [0, 4 if is_whole else 1, 4, 9]
    assert (done, kept) == (([3], 3) if is_whole else ([1, 3], 2))
    assert calls[-1] == ("square", 40, 40)
    assert [call[1] for call in calls] == ([40] if is_whole else [30, 40])


def test_a_stop_that_comes_while_a_result_is_written_waits_for_the_whole_of_it(tmp_path):
    def save(stream, value):
        signal.raise_signal(signal.SIGTERM)
        save_json(stream, value)

    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            do_parts("count", abs, [(-1, tmp_path / "a"), (-2, tmp_path / "b")], save)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert [(path.name, load_json(path)) for path in tmp_path.iterdir()] == [("a", 1)]


def test_a_part_that_another_machine_had_finished_is_not_done_again(tmp_path):
    save_json((path := tmp_path / "a").open("wb"), 7)
    run_module._keep(pytest.fail, save_json, holds_json, (1, path))


def begin(folder, settings=SETTINGS, **options):
    with run_folder(folder, settings, "numbers", **options):
        pass


def foreign(folder):
    (folder / "settings.json").unlink()
    (folder / "notes.txt").write_text("mine")


def as_a_file(folder):
    shutil.rmtree(folder)
    folder.write_text("rows of an older version")


def as_a_link(folder):
    folder.rename(folder.with_name("elsewhere"))
    folder.symlink_to(folder.with_name("elsewhere"))


@pytest.mark.parametrize(
    "change",
    [
        lambda folder: (folder / "settings.json").write_text('{"seed": 2}'),
        lambda folder: (folder / "settings.json").write_text("[" * 100_000),
        foreign,
        as_a_file,
        as_a_link,
    ],
    ids=["other", "damaged", "foreign", "a file", "a link"],
)
def test_what_is_not_this_run_is_refused_and_left(tmp_path, change):
    folder = tmp_path / "run"
    begin(folder)
    change(folder)
    before = {path: path.is_file() and path.read_bytes() for path in tmp_path.rglob("*")}
    with pytest.raises(UsageError) as error:
        begin(folder)
    assert str(error.value) == (
        f"{folder}: belongs to a run of other numbers, or of another model or version, expected "
        f"this one's; delete it to begin anew, or give another --out."
    )
    assert {path: path.is_file() and path.read_bytes() for path in tmp_path.rglob("*")} == before


def test_a_run_that_may_be_replaced_is_but_nothing_else(tmp_path):
    folder = tmp_path / "run"
    squares(folder, range(2))
    begin(folder, is_replaced=True)
    assert (folder / "1.json").exists()
    begin(folder, {"seed": 2}, is_replaced=True)
    assert [path.name for path in folder.iterdir()] == ["settings.json"]
    foreign(folder)
    with pytest.raises(UsageError, match="belongs to a run of other numbers"):
        begin(folder, is_replaced=True)


def test_two_runs_do_not_write_the_same_folder(tmp_path):
    folder = tmp_path / "run"
    with run_folder(folder, SETTINGS, "numbers"), pytest.raises(UsageError) as error:
        begin(folder)
    assert str(error.value) == (
        f"{folder}: another run is writing it, expected one at a time; wait for it, or give "
        f"another --out."
    )
    begin(folder)  # the claim is gone


def test_a_cluster_without_ray_is_refused_before_any_work(monkeypatch):
    monkeypatch.setattr(run_module, "find_spec", lambda _: None)
    with pytest.raises(MissingDependency) as error:
        Workers(cluster="local")
    assert str(error.value) == (
        "--cluster needs Ray, which is not installed; run `pip install 'geotlm-lm[ray]'`."
    )


def test_a_machine_that_shares_no_folder_with_the_command_says_so_and_does_nothing(
    tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)

    def done(folder, seen):
        worker = _Worker(abs, str(folder), __version__, [tmp_path / name for name in seen])
        return pickle.loads(worker._done(-1))

    (tmp_path / "there").touch()
    assert done(tmp_path, ["there"]) == (-1, 1, None)
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
        part, result, error = done(folder, seen)
        assert (part, result, type(error)) == (-1, None, UsageError)
        assert str(error) == f"{socket.gethostname()}: {sentence}"


def test_thread_counts_come_back():
    import cv2
    import torch

    before = (torch.get_num_threads(), cv2.getNumThreads())
    with processes.one_thread():
        assert torch.get_num_threads() == 1
    assert (torch.get_num_threads(), cv2.getNumThreads()) == before
