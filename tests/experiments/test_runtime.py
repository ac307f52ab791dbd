"""Error against run time on a few clips and random weights: what is counted, in which order."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from geotlm_lm.answering import Answerer
from geotlm_lm.checkpoint import save_bundle
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.evaluation.uncertainty import wilson_interval
from geotlm_lm.experiments import model_omissions, runtime_processes
from geotlm_lm.experiments.model_omissions import omission_rows
from geotlm_lm.experiments.runtime import SIZES, RuntimeSizes, method_rows, runtime, spread
from geotlm_lm.experiments.runtime_batches import batch_rows
from geotlm_lm.experiments.runtime_clips import KnownClip, _known, simulated_clips, turning_clips
from geotlm_lm.experiments.runtime_memory import peak_megabytes
from geotlm_lm.experiments.runtime_methods import (
    CURL,
    FLOWS,
    PROBE_C,
    PROBE_Z,
    SCORED,
    WHY,
    WORDS,
    Timed,
    flow_group,
    model_groups,
)
from geotlm_lm.experiments.runtime_processes import (
    CommandFailed,
    command_rows,
    import_seconds,
    memory_rows,
)
from geotlm_lm.experiments.runtime_stages import stage_rows
from geotlm_lm.probe.curl import CurlRegression
from geotlm_lm.reports.runtime import runtime_page
from tests.tiny_bundle import tiny_bundle


def quiet(what, done, total):
    pass


@pytest.fixture(scope="module")
def answerer():
    return Answerer(tiny_bundle())


@pytest.fixture(scope="module")
def clips():
    return list(simulated_clips(1, 0))


def test_clips_come_in_four_frames_and_two_with_what_is_true_of_them(clips):
    assert [(one.source, one.frames, len(one.clip)) for one in clips] == [
        ("simulated rotation", 4, 4),
        ("simulated rotation", 2, 2),
        ("simulated sliding", 4, 4),
        ("simulated sliding", 2, 2),
    ]
    turn, slide = clips[0], clips[2]
    assert turn.motion in ROTATIONS
    assert (turn.turn_deg > 0) == (turn.motion is Motion.CLOCKWISE)
    assert turn.slide_px is None
    assert slide.motion in SLIDES
    across, down = slide.slide_px
    named = (Motion.RIGHT, Motion.LEFT) if abs(across) > abs(down) else (Motion.DOWN, Motion.UP)
    assert slide.motion is named[(across if abs(across) > abs(down) else down) < 0]


class Scripted:
    """A group of one method, which is right about turns and takes 1 ms, then 2 ms, and so on."""

    def __init__(self, log, name):
        self.log, self.name, self.calls = log, name, 0

    def __call__(self, clip, among):
        self.calls += 1
        self.log.append(self.name)
        motion = Motion.CLOCKWISE
        return {self.name: Timed(motion, float(self.calls), 10.0, (3.0, 4.0))}


def known(motion, **truth):
    clip = Clip(np.zeros((4, 16, 16, 3), np.uint8))
    return KnownClip(clip, motion, (motion,), "here", 4, **truth)


def test_methods_are_asked_in_turn_and_the_first_round_is_not_timed():
    log = []
    groups = {name: Scripted(log, name) for name in ("a", "b")}
    cases = [known(Motion.CLOCKWISE, turn_deg=12.0), known(Motion.LEFT, slide_px=(0.0, 0.0))]
    rows = {row["method"]: row for row in method_rows(groups, cases, repeats=2)}
    # Two clips in each of three rounds; another method begins with each clip.
    assert log == list("abba" + "baab" + "abba")
    assert rows["a"]["clips"] == 2
    assert rows["a"]["error"] == 0.5
    assert rows["a"]["ms_median"] == np.median([3, 4, 5, 6])  # 1 and 2 warmed up
    assert rows["a"]["turn_error_deg"] == pytest.approx(2.0)
    assert rows["a"]["slide_error_px"] == pytest.approx(5.0)
    low, high = rows["a"]["error_interval"]
    assert low < 0.5 < high


def test_the_interval_of_an_error_is_that_of_what_is_wrong():
    cases = [known(Motion.CLOCKWISE, turn_deg=12.0)] * 9 + [known(Motion.LEFT)]
    (row,) = method_rows({"a": Scripted([], "a")}, cases, repeats=1)
    assert row["error"] == pytest.approx(0.1)
    assert row["error_interval"] == pytest.approx(wilson_interval(0.1, 10))


def test_what_is_right_only_now_and_then_is_an_error():
    said = itertools.cycle(Motion)
    wavering = {"a": lambda clip, among: {"a": Timed(next(said), 1.0)}}
    (row,) = method_rows(wavering, [known(Motion.COUNTERCLOCKWISE)], repeats=3)
    assert row["error"] == 1.0


def test_a_known_slide_is_in_pixels_of_the_picture():
    label = MotionLabel(Motion.DOWN, slide_x_mm=-0.3, slide_y_mm=0.4)
    made = SimpleNamespace(clip=None, label=label, mm_per_px=(0.1, 0.05))
    assert _known(made, SLIDES, "here").slide_px == pytest.approx((-3.0, 8.0))


def test_a_spread_is_told_by_quantiles():
    assert spread([1.0, 2.0, 3.0, 4.0, 100.0]) == {
        "ms_q25": 2.0,
        "ms_median": 3.0,
        "ms_q75": 4.0,
        "ms_p95": pytest.approx(80.8),
    }


def test_every_method_answers_for_every_source_it_can(answerer, clips):
    curl = CurlRegression.fit(*turning_clips(6, 0))
    groups = {"classical": flow_group(curl), **model_groups(answerer, ("float32", "int8"))}
    rows = method_rows(groups, clips, repeats=1)
    found = {(row["method"], row["source"], row["frames"]) for row in rows}
    own = (PROBE_C, PROBE_Z, SCORED, WORDS)
    everywhere = {*FLOWS, *own, *(f"{name}, int8" for name in own), WHY}
    for source in ("simulated rotation", "simulated sliding"):
        for frames in (4, 2):
            assert {m for m, s, f in found if (s, f) == (source, frames)} - {CURL} == everywhere
    assert {source for method, source, _ in found if method == CURL} == {"simulated rotation"}
    assert all(0 <= row["error"] <= 1 and row["ms_median"] > 0 for row in rows)
    flow = next(row for row in rows if row["method"] in FLOWS)
    assert flow["turn_error_deg"] is not None


def test_stages_are_those_of_an_answer(answerer, clips):
    rows = {row["stage"]: row["ms_median"] for row in stage_rows(answerer, clips[0].clip, 1)}
    assert list(rows)[:2] == ["read 4 frames, .npz", "choose 4 of 125 frames"]
    assert {"backbone", "DGR and fused token", "LM: prompt read", "LM: one token"} <= set(rows)
    assert min(rows.values()) > 0


def test_batches_cover_works_threads_and_sizes(answerer, clips):
    sizes = RuntimeSizes(precisions=("float32",), batches=(1, 3), batch_repeats=1, threads=(1, 2))
    rows = batch_rows(answerer, [clips[0].clip], sizes, quiet)
    works = {"perceive", "probe on z", "LM generated", "LM scored", "flow + fit, fast"}
    assert {(row["work"], row["threads"], row["batch"]) for row in rows} == {
        (work, threads, batch) for work in works for threads in (1, 2) for batch in (1, 3)
    }


def test_what_is_left_out_is_timed_both_ways(answerer, clips):
    rows = {row["omission"]: row for row in omission_rows(answerer, clips[0].clip, 2)}
    assert {"encoding again", "the language model", "gradients"} <= set(rows)
    assert all(len(row["full_ms"]) == len(row["lean_ms"]) == 2 for row in rows.values())
    # Milliseconds of a model against a regular expression.
    row = rows["the language model"]
    assert min(row["full_ms"]) > min(row["lean_ms"])


ACCOUNT = """\
import time: self [us] | cumulative | imported package
import time:       100 |        100 |   _io
import time:      2000 |       2500 | torch
import time:       500 |        500 |   torch.nn
import time:        40 |         40 | geotlm_lm.core.clip
"""


def test_import_times_are_summed_by_package():
    assert import_seconds(ACCOUNT) == {
        "torch": pytest.approx(0.0025),
        "other": pytest.approx(0.0001),
        "geotlm_lm": pytest.approx(0.00004),
    }


def test_a_cold_start_is_told_with_its_imports():
    (row,) = command_rows(1, None, quiet, asked=["--version"])
    assert len(row["seconds"]) == 1
    assert 0 < row["import_s"] < 60
    assert "torch" not in row["packages_s"]


def test_a_command_that_fails_says_which_and_why(tmp_path):
    with pytest.raises(CommandFailed, match=r"exited with 4 .*found no model bundle"):
        command_rows(1, tmp_path, quiet, asked=["answer"])


@pytest.mark.slow
def test_memory_is_of_fresh_processes(tmp_path):
    save_bundle(tmp_path, tiny_bundle())
    rows = {row["way"]: row["megabytes"] for row in memory_rows(tmp_path, quiet)}
    assert 0 < rows["flow + fit"] < rows["LM generated"]  # the flow needs no torch


def test_an_unknown_way_to_answer_is_refused(tmp_path):
    with pytest.raises(ValueError, match="found way 'guessing'"):
        peak_megabytes("guessing", tmp_path)


def test_the_tiny_size_is_smaller_in_every_way():
    default, tiny = SIZES["default"], SIZES["tiny"]
    assert tiny.clips * tiny.repeats < default.clips * default.repeats / 10
    assert max(tiny.batches) < max(default.batches)


def test_a_whole_run_has_every_part_and_makes_a_page(tmp_path, monkeypatch):
    save_bundle(tmp_path, tiny_bundle())
    # One command, one way and no import: the fresh processes have tests of their own.
    monkeypatch.setattr(runtime_processes, "WAYS", runtime_processes.WAYS[:1])
    shown = [runtime_processes.Started("--version", ("--version",))]
    monkeypatch.setattr(runtime_processes, "_commands", lambda folder, model: shown)
    monkeypatch.setattr(model_omissions, "import_rows", lambda runs: [])
    record = runtime(Answerer.load(tmp_path), sizes=SIZES["tiny"], seed=3, model=tmp_path)
    assert {"methods", "stages", "omissions", "batches", "memory", "commands"} == set(
        record.numbers
    )
    assert record.config["left_out"] == []
    assert record.seed == 3
    page = runtime_page(record)
    assert "### simulated sliding, 2 frames, 2 clips" in page
    assert page.count("| Curl + LR") == 2  # turns in four frames and in two
