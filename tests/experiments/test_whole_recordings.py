"""Whole recordings are judged on the frames that an answer would be given of."""

import numpy as np
import pytest

from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion
from geotlm_lm.data.touch_table import DirectedRow, read_directed
from geotlm_lm.experiments import methods
from geotlm_lm.experiments.compare import Reply
from geotlm_lm.experiments.evaluate import evaluate
from geotlm_lm.experiments.folder_tables import judge_whole
from geotlm_lm.experiments.whole_recordings import WholeRecordings
from geotlm_lm.recordings.choose import choose_frames
from geotlm_lm.recordings.read import read_clip
from tests.experiments.fakes import ALL, FakeAnswerer

SHOWN = ("clockwise", "counterclockwise")
LABELS = """clip,object,fps,contact_start,contact_end,direction,tier
clips/clockwise.npy,cap,10,8,11,clockwise,A
clips/counterclockwise.npy,cap,10,8,11,clockwise,B
clips/counterclockwise.npy,cap,10,8,11,clockwise,C
"""


@pytest.fixture
def folder(tmp_path):
    """Two recordings whose last pixel names a motion; one is labelled the other way round."""
    rng = np.random.default_rng(0)
    (tmp_path / "clips").mkdir()
    for shown in SHOWN:
        frames = rng.integers(100, 120, (12, 32, 32, 3)).astype(np.uint8)
        frames[:, -1, -1] = ALL.index(Motion(shown))
        np.save(tmp_path / "clips" / f"{shown}.npy", frames)
    (tmp_path / "clips.csv").write_text(LABELS)
    return tmp_path


def test_every_method_sees_the_frames_an_answer_would_take(folder):
    seen = {name: [] for name in methods.all_methods(FakeAnswerer(), 0)}

    def watching(name):
        def method(clip, among):
            seen[name].append(clip.frame_numbers)
            return Reply(Motion.CLOCKWISE, 1.0)

        return method

    rows = read_directed(folder / "clips.csv")
    judge_whole({name: watching(name) for name in seen}, "here", rows, 0, lambda *_: None)
    chosen = [choose_frames(read_clip(row.path)).frame_numbers for row in rows]
    assert len(chosen) == 2
    assert all(numbers == chosen for numbers in seen.values())


def test_the_evaluation_has_a_table_of_the_sure_recordings(folder):
    (folder / "windows.csv").write_text(
        "clip,first_frame,last_frame,direction\nclockwise.npy,2,9,clockwise\n"
    )
    record = evaluate(FakeAnswerer(), clips_per_task=0, seed=1, real_folder=folder)
    table = record.numbers["tables"][f"real {folder.name}, whole recordings"]
    assert (table["clips"], table["truths"]) == (2, {"clockwise": 2})
    assert table["methods"][methods.GENERATED]["accuracy"] == 0.5


@pytest.mark.parametrize(
    ("motions", "among"),
    [
        ((Motion.CLOCKWISE, Motion.CLOCKWISE), ROTATIONS),
        ((Motion.LEFT,), SLIDES),
        ((Motion.LEFT, Motion.CLOCKWISE), DIRECTED),
    ],
)
def test_methods_choose_among_the_smallest_task_that_holds_every_label(tmp_path, motions, among):
    rows = [DirectedRow(tmp_path / "any.mp4", motion, "cap", "cap") for motion in motions]
    assert WholeRecordings(rows).among == among
