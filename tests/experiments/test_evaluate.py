import json
from dataclasses import asdict

import cv2
import numpy as np
import pytest
import torch

from geotlm_lm.core.errors import UnreadableClip
from geotlm_lm.core.labels import Motion
from geotlm_lm.experiments import methods
from geotlm_lm.experiments.evaluate import evaluate, minimum_accuracy, one_thread
from tests.experiments.fakes import ALL, FakeAnswerer


@pytest.fixture
def folder(tmp_path):
    """Two recordings whose last pixel names the motion that is shown, at every frame."""
    rng = np.random.default_rng(0)
    (tmp_path / "clips").mkdir()
    rows = ["clip,first_frame,last_frame,direction"]
    for direction in ("clockwise", "counterclockwise"):
        frames = rng.integers(100, 120, (12, 32, 32, 3)).astype(np.uint8)
        frames[:, -1, -1] = ALL.index(Motion(direction))
        np.save(tmp_path / "clips" / f"{direction}.npy", frames)
        rows.append(f"{direction}.npy,2,9,{direction}")
    rows.append("clockwise.npy,2,9,up-left")
    (tmp_path / "windows.csv").write_text("\n".join(rows) + "\n")
    return tmp_path


def run(folder, **options):
    return evaluate(FakeAnswerer(), clips_per_task=0, seed=1, real_folder=folder, **options)


def test_real_recordings_are_judged_both_ways_and_both_cuts(folder):
    tables = run(folder).numbers["tables"]
    name = folder.name
    assert list(tables) == [
        f"real {name}, four frames",
        f"real {name}, four frames, forwards",
        f"real {name}, four frames, backwards",
        f"real {name}, pairs",
        f"real {name}, pairs, forwards",
        f"real {name}, pairs, backwards",
        f"real {name}, no idle frame",
        f"real {name}, turned by a quarter",
    ]
    # The fake reads the forward label off every frame, so it is right forwards and wrong backwards;
    # it does not see that a clip was turned.
    words = [table["methods"][methods.GENERATED]["accuracy"] for table in tables.values()]
    assert words == [0.5, 1.0, 0.0, 0.5, 1.0, 0.0, 0.5, 0.0]


def test_labels_left_out_are_in_the_record(folder):
    tables = run(folder).numbers["tables"]
    assert tables[f"real {folder.name}, pairs"]["rows_left_out"] == {"up-left": 1}


def test_the_record_survives_json(folder):
    record = run(folder, model_name="fake", command="geotlm-lm evaluate")
    again = json.loads(json.dumps(asdict(record)))
    assert again["numbers"] == record.numbers
    assert (again["config"]["model"], again["seed"]) == ("fake", 1)
    assert again["config"]["model_digest"] == "0123456789ab"


def test_every_contrast_is_reported(folder):
    table = run(folder).numbers["tables"][f"real {folder.name}, four frames"]
    assert [(one["first"], one["second"]) for one in table["differences"]] == list(
        methods.CONTRASTS
    )


def test_the_minimum_is_the_worst_table_of_the_models_own_words(folder):
    assert run(folder).numbers["minimum"] == 0.0
    assert minimum_accuracy({}) is None


def test_progress_names_the_folder_and_reaches_its_end(folder):
    seen = []
    run(folder, progress=lambda *told: seen.append(told))
    assert (f"real {folder.name}", 8, 8) in seen
    assert (f"real {folder.name}, no idle frame", 4, 4) in seen
    assert seen[-1] == (f"real {folder.name}, turned by a quarter", 4, 4)


def test_the_simulated_tasks_report_what_was_left_out(monkeypatch):
    from geotlm_lm.experiments import cases

    def three(self):
        self.unreadable = 2
        for motion in self.among[:3]:
            from tests.experiments.test_methods import clip_of

            yield cases.Case(clip_of(motion), motion, motion.value, motion.value, {})

    monkeypatch.setattr(cases.SimulatedCases, "__iter__", three)
    record = evaluate(FakeAnswerer(), clips_per_task=3, seed=0)
    tables = record.numbers["tables"]
    assert list(tables) == [
        f"simulated {task}{hand}"
        for task in ("rotation", "sliding", "all")
        for hand in ("", ", unsteady hand")
    ]
    assert tables["simulated all"]["unreadable_left_out"] == 2
    assert record.numbers["minimum"] == 1.0


def test_clips_that_do_not_tell_their_motion_stay_out_of_the_scores(monkeypatch):
    from geotlm_lm.experiments import cases
    from tests.experiments.test_methods import clip_of

    def right_and_wrong(self):
        motion, other = self.among[:2]
        yield cases.Case(clip_of(motion), motion, "a", "a", {})
        for said in (motion, other, motion):
            self.unreadable += 1
            yield cases.Case(clip_of(said), motion, "a", "a", cases.UNREADABLE)

    monkeypatch.setattr(cases.SimulatedCases, "__iter__", right_and_wrong)
    table = evaluate(FakeAnswerer(), clips_per_task=1, seed=0).numbers["tables"]["simulated all"]
    assert (table["clips"], table["unreadable_left_out"], table["unreadable_right"]) == (1, 3, 2)


def test_thread_counts_come_back():
    before = (torch.get_num_threads(), cv2.getNumThreads())
    with one_thread():
        assert torch.get_num_threads() == 1
    assert (torch.get_num_threads(), cv2.getNumThreads()) == before


def test_clips_that_start_in_contact_are_judged_without_their_idle_gel(folder, monkeypatch):
    answerer = FakeAnswerer()
    seen = []
    original = answerer.encode
    monkeypatch.setattr(answerer, "encode", lambda clip: seen.append(clip) or original(clip))
    tables = evaluate(answerer, clips_per_task=0, seed=1, real_folder=folder).numbers["tables"]
    assert [clip.background is None for clip in seen] == [False] * 8 + [True] * 4 + [False] * 4
    assert tables[f"real {folder.name}, no idle frame"]["clips"] == 4


def test_turns_and_slides_of_one_folder_are_asked_as_tasks(folder):
    frames = np.load(folder / "clips" / "clockwise.npy")
    frames[:, -1, -1] = ALL.index(Motion.LEFT)
    np.save(folder / "clips" / "left.npy", frames)
    with (folder / "windows.csv").open("a") as table:
        table.write("left.npy,2,9,left\n")
    tables = run(folder).numbers["tables"]
    name = folder.name
    turns = tables[f"real {name} rotation, four frames"]
    slides = tables[f"real {name} sliding, four frames"]
    assert turns["truths"] == {"clockwise": 2, "counterclockwise": 2}
    assert slides["truths"] == {"left": 1, "right": 1}
    # Asked as a task, a method that chooses among the task's motions never leaves it.
    assert set(slides["methods"][methods.PROBE]["confusion"]["labels"]) <= {"left", "right"}


def test_objects_of_real_recordings_are_given_one_by_one(folder):
    table = run(folder).numbers["tables"][f"real {folder.name}, four frames"]
    assert set(table["by_object"]) == {"clockwise", "counterclockwise"}
    assert table["by_object"]["clockwise"]["clips"] == 2
    assert set(table["by_object"]["clockwise"]) == {"clips", *methods.BY_OBJECT}


def touch_table(folder):
    """A press of three frames before its turn, and a recording of three seconds without contact."""
    frames = np.full((30, 32, 32, 3), 100, np.uint8)
    frames[8:, 8:20, 8:20] += 40
    np.save(folder / "clips" / "cap.npy", frames)
    np.save(folder / "clips" / "sponge.npy", np.full((39, 32, 32, 3), 100, np.uint8))
    np.save(folder / "clips" / "short.npy", np.full((9, 32, 32, 3), 100, np.uint8))
    (folder / "clips.csv").write_text(
        "clip,object,fps,contact_start,contact_end,rotation_start\n"
        "clips/cap.npy,cap,10,8,28,14\n"
        "clips/sponge.npy,sponge,10,,,\n"
        "clips/short.npy,sponge,10,,,\n"
    )


def test_clips_without_a_direction_get_tables_of_their_own(folder):
    touch_table(folder)
    tables = run(folder).numbers["tables"]
    name = folder.name
    untouched = tables[f"real {name}, no visible contact"]
    assert (untouched["truths"], untouched["too_short_left_out"]) == ({"none": 3}, 1)
    assert tables[f"real {name}, pressed in"]["truths"] == {"press": 1}
    held = tables[f"semi-real {name}, held or pressed"]
    assert held["truths"] == {"press": 1, "release": 1, "still": 1}
    assert all(
        one["methods"][methods.FLOW]["false_claim_rate"] is not None for one in (untouched, held)
    )


def test_data_sets_are_judged_and_said_about(folder, tmp_path):
    listed = tmp_path / "listed.csv"
    listed.write_text(
        "clip_id,object_id,action,frames\n"
        "1,cap,rotate_cw,clips/clockwise.npy\n"
        "2,cap,rotate_ccw,clips/gone.npy\n"
    )
    record = evaluate(FakeAnswerer(), clips_per_task=0, seed=1, data_paths=[listed])
    assert list(record.numbers["tables"]) == ["manifest listed, rotation"]
    assert record.numbers["data_sets"]["manifest listed"]["left_out"]["count"] == 1


def test_a_run_without_a_single_clip_is_refused_with_the_first_reason(tmp_path):
    listed = tmp_path / "listed.csv"
    listed.write_text("clip_id,object_id,action,frames\n1,cap,rotate_cw,gone.npy\n")
    with pytest.raises(UnreadableClip) as caught:
        evaluate(FakeAnswerer(), clips_per_task=0, seed=1, data_paths=[listed])
    assert str(caught.value) == (
        f"no clip could be judged (1 left out of manifest listed; {tmp_path / 'gone.npy'}: no such "
        f"file or folder; check the path.); give other data."
    )
