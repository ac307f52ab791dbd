"""The protocols end to end at a size at which nothing is learned: folds, rows, resuming."""

import json

import numpy as np
import pytest

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import ROTATIONS, SLIDES
from geotlm_lm.experiments import protocol_folds
from geotlm_lm.experiments.protocol_rows import (
    CONTRASTS,
    CURL,
    FLOW,
    GROUNDED,
    NEITHER,
    NO_MASK,
    NO_REGIONS,
    OPERATORS,
    PAPER,
    PAPER_PAIR,
    PLAIN,
    PLAIN_PAIR,
    ROWS,
    TABLES,
    rows_of,
)
from geotlm_lm.experiments.protocols import (
    EPOCHS,
    FIVE_FOLD,
    LEAVE_ONE_OUT,
    SEED,
    SOURCES,
    ProtocolSizes,
    run_protocols,
    source_digest,
)
from geotlm_lm.reports import protocols as page
from tests.experiments.plain_backbone import PlainBackbone

OBJECTS = ("key", "cable", "hex_nut", "pen_clip", "bead")
SIZES = ProtocolSizes(OBJECTS, clips=4, epochs=2)


def run(folder, backbone=None, **more):
    return run_protocols(backbone or PlainBackbone(), SIZES, folder=folder, **more)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("protocols")
    return folder, run(folder, command="geotlm-lm report protocols")


def protocols_of(record):
    return [
        (task, protocol)
        for task, found in record.numbers["tasks"].items()
        for protocol in found["protocols"].values()
    ]


def test_every_row_of_every_table_is_scored_in_both_protocols(finished):
    tasks = finished[1].numbers["tasks"]
    rows = {
        "rotation": set(ROWS),
        "sliding": set(ROWS) - {CURL},
    }
    for task, found in tasks.items():
        assert set(found["protocols"]) == {FIVE_FOLD, LEAVE_ONE_OUT}
        for protocol in found["protocols"].values():
            assert set(protocol["rows"]) == rows[task]
    assert tasks["rotation"]["clips"] == 20
    assert list(tasks["sliding"]["truths"]) == [str(motion) for motion in SLIDES]
    assert sum(tasks["rotation"]["truths"].values()) == 20


def test_the_three_parts_of_a_fold_share_no_object(finished):
    for _, protocol in protocols_of(finished[1]):
        for fold in protocol["folds"]:
            parts = [set(fold[part]) for part in ("train", "val", "test")]
            assert all(parts)
            assert sum(len(part) for part in parts) == len(set.union(*parts)) == len(OBJECTS)
            assert fold["clips"] == [4 * len(part) for part in parts]
        tested = [name for fold in protocol["folds"] for name in fold["test"]]
        assert sorted(tested) == sorted(OBJECTS)


def test_leaving_one_out_holds_out_one_object_at_a_time(finished):
    protocol = finished[1].numbers["tasks"]["sliding"]["protocols"][LEAVE_ONE_OUT]
    assert [fold["test"] for fold in protocol["folds"]] == [[name] for name in OBJECTS]
    assert list(protocol["rows"][PLAIN]["by_object"]) == list(OBJECTS)
    assert protocol["rows"][PLAIN]["accuracy"] == list(
        protocol["rows"][PLAIN]["by_object"].values()
    )


@pytest.mark.parametrize(
    ("row", "count"),
    [
        # Patches of width 3, global tokens of width 6: W_s 8, W_m 4, W_o (dim + 1) x 6; the probe
        # of two turns 14.
        (FLOW, 0),
        (CURL, 2 * 6),
        (PLAIN, 14),
        (PLAIN_PAIR, 14),
        (PAPER, 14 + 8 + 4 + 15 * 6),
        (GROUNDED, 14 + 8 + 4 + 15 * 6),
        (PAPER_PAIR, 14 + 8 + 4 + 15 * 6),
        (NO_MASK, 14 + 8 + 15 * 6),
        (NO_REGIONS, 14 + 8 + 4 + 3 * 6),
        (NEITHER, 14 + 8 + 3 * 6),
        (OPERATORS, 14 + 8 + 4 + 43 * 6),
    ],
)
def test_a_row_is_made_of_the_parts_its_name_says(finished, row, count):
    rows = finished[1].numbers["tasks"]["rotation"]["protocols"][FIVE_FOLD]["rows"]
    assert rows[row]["parameters"] == count


def test_rows_read_the_frames_and_losses_they_say():
    assert {name for name, row in ROWS.items() if row.frames == 2} == {PLAIN_PAIR, PAPER_PAIR}
    modes = {name: row.recipe.mode for name, row in ROWS.items() if row.recipe}
    assert [name for name, mode in modes.items() if mode == "grounded"] == [GROUNDED]
    assert (SEED, EPOCHS) == (42, 30)  # paper, implementation details


def test_training_is_seeded_by_the_seed_and_the_folds_number(tmp_path, finished, monkeypatch):
    seeds, train = [], protocol_folds.train_on_fold

    def noted(*arguments, seed, **more):
        seeds.append(seed)
        return train(*arguments, seed=seed, **more)

    monkeypatch.setattr(protocol_folds, "train_on_fold", noted)
    _copy_tokens(finished[0], tmp_path)
    run(tmp_path, tables=("frames",))
    per_protocol = [42 + number for number in range(5) for _ in TABLES["frames"]]
    assert seeds == per_protocol * 4  # two tasks, two protocols of five folds


def test_a_second_run_encodes_and_trains_nothing_and_says_the_same(finished, monkeypatch):
    folder, first = finished
    monkeypatch.setattr(protocol_folds, "train_on_fold", None)
    backbone = PlainBackbone()
    again = run(folder, backbone)
    assert backbone.encoded == 0
    assert again.numbers == first.numbers


def test_a_run_stopped_while_training_continues_to_the_same_numbers(
    finished, tmp_path, monkeypatch
):
    _copy_tokens(finished[0], tmp_path)
    trained, train = [], protocol_folds.train_on_fold

    def interrupted(*arguments, **more):
        if len(trained) == 7:
            raise KeyboardInterrupt
        trained.append(1)
        return train(*arguments, **more)

    with monkeypatch.context() as patch:
        patch.setattr(protocol_folds, "train_on_fold", interrupted)
        with pytest.raises(KeyboardInterrupt):
            run(tmp_path, tables=("ablation",))
    monkeypatch.setattr(
        protocol_folds, "train_on_fold", lambda *a, **m: trained.append(1) or train(*a, **m)
    )
    resumed = run(tmp_path, tables=("ablation",))
    assert len(trained) == len(TABLES["ablation"]) * 5 * 4  # no fold of a row is trained twice
    for task, found in resumed.numbers["tasks"].items():
        for name, protocol in found["protocols"].items():
            whole = finished[1].numbers["tasks"][task]["protocols"][name]["rows"]
            assert protocol["rows"] == {row: whole[row] for row in protocol["rows"]}


def test_one_table_runs_its_own_rows_and_tasks_only(finished):
    record = run(finished[0], tables=("sliding",))
    (found,) = record.numbers["tasks"].values()
    assert set(found["protocols"][FIVE_FOLD]["rows"]) == set(TABLES["sliding"])
    assert record.config["tables"] == ["sliding"]


def test_other_epochs_are_other_folds_of_the_same_tokens(finished, monkeypatch):
    backbone = PlainBackbone()
    more = ProtocolSizes(OBJECTS, clips=4, epochs=3)
    (kept,) = finished[0].iterdir()
    before = set(kept.glob("folds-*"))
    record = run_protocols(backbone, more, folder=finished[0], tables=("frames",))
    assert backbone.encoded == 0
    assert len(set(kept.glob("folds-*")) - before) == 1
    assert record.config["epochs"] == 3


def test_a_backbone_without_a_view_has_no_grounded_row(tmp_path):
    record = run(tmp_path, PlainBackbone(has_view=False), tables=("rotation",))
    (found,) = record.numbers["tasks"].values()
    assert set(found["protocols"][FIVE_FOLD]["rows"]) == set(TABLES["rotation"]) - {GROUNDED}
    assert "DGR, grounded" not in page.protocol_tables(record).split("## Rotation, object")[0]


def test_optical_flow_is_scored_on_the_same_clips_in_both_protocols(finished):
    for _, protocol in protocols_of(finished[1]):
        rows = protocol["rows"][FLOW]
        right = sum(4 * share for share in rows["by_object"].values())
        sizes = [fold["clips"][2] for fold in protocol["folds"]]
        assert right == pytest.approx(np.dot(sizes, rows["accuracy"]))


def test_every_contrast_is_of_rows_there_are(finished):
    assert {name for pair in CONTRASTS for name in pair} == set(ROWS)
    for task, protocol in protocols_of(finished[1]):
        pairs = [(one["first"], one["second"]) for one in protocol["differences"]]
        assert pairs == [pair for pair in CONTRASTS if task == "rotation" or CURL not in pair]


def test_a_difference_is_that_of_the_two_accuracies(finished):
    protocol = finished[1].numbers["tasks"]["rotation"]["protocols"][LEAVE_ONE_OUT]
    one = protocol["differences"][0]
    rows = protocol["rows"]
    # Objects have equally many clips, so that means over folds are means over clips.
    expected = rows[one["first"]]["mean"] - rows[one["second"]]["mean"]
    assert one["difference"] == pytest.approx(expected)


def test_the_record_says_what_shaped_it(finished):
    config = finished[1].config
    assert config["training"] == {
        "head_rate": 1e-3,
        "dgr_rate": 3e-4,
        "weight_decay": 0.01,
        "batch": 32,
    }
    assert config["objects"] == list(OBJECTS)
    assert (config["clips"], config["epochs"], config["seed"]) == (4, 2, 42)
    json.dumps(finished[1].numbers)


def test_the_page_of_a_real_record_holds_every_row(finished):
    text = page.protocols_page(finished[1])
    for name in ROWS:
        assert f"| {name} " in text
    for motion in (*ROTATIONS, *SLIDES):
        assert motion.value in text
    assert (page.FIVE_FOLD, page.LEAVE_ONE_OUT) == (FIVE_FOLD, LEAVE_ONE_OUT)


def test_tables_hold_known_rows_and_the_grounded_one_needs_truth():
    assert {row for rows in TABLES.values() for row in rows} == set(ROWS)
    every = rows_of(tuple(TABLES), "rotation", has_truth=True)
    assert len(every) == len(set(every)) == len(ROWS)
    assert set(every) - set(rows_of(tuple(TABLES), "rotation", has_truth=False)) == {GROUNDED}


def test_the_sources_of_a_fold_exist():
    for part in SOURCES:
        assert source_digest(part) != source_digest()


@pytest.mark.parametrize(
    ("sizes", "tables", "sentence"),
    [
        (
            ProtocolSizes(OBJECTS[:4], clips=4),
            ("rotation",),
            "4 objects were given, expected at least 5; give one for each fold.",
        ),
        (
            SIZES,
            ("curl",),
            "there is no table 'curl'; choose one of rotation, sliding, ablation, frames.",
        ),
    ],
)
def test_what_cannot_be_run_is_refused_before_anything_is_encoded(
    tmp_path, sizes, tables, sentence
):
    backbone = PlainBackbone()
    with pytest.raises(UsageError) as caught:
        run_protocols(backbone, sizes, folder=tmp_path, tables=tables)
    assert str(caught.value) == sentence
    assert backbone.encoded == 0


def _copy_tokens(source, target):
    """Copy the tokens of a finished run, and none of its folds."""
    for path in source.glob("tokens-*/*.npz"):
        copied = target / path.parent.name / path.name
        copied.parent.mkdir(parents=True, exist_ok=True)
        copied.write_bytes(path.read_bytes())
