"""A made record, so that every cell of the page has a known place."""

import json

import pytest

from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.protocols import (
    ABLATED,
    BY_FRAMES,
    ablation_table,
    comparison_table,
    difference_table,
    fold_table,
    frames_table,
    object_table,
    protocol_tables,
    protocols_headline,
    protocols_page,
    row_table,
)
from geotlm_lm.reports.published import ROTATION, SLIDING

TURNS, SLIDES = ("clockwise", "counterclockwise"), ("left", "right", "up", "down")
ROWS = (
    "Curl + LR",
    "optical flow + rigid fit",
    "probe on c",
    "DGR, paper",
    "DGR, grounded",
    *(name for name in (*ABLATED, *BY_FRAMES) if name not in ("probe on c", "DGR, paper")),
)
MEANS = {name: 0.5 + number / 100 for number, name in enumerate(ROWS)}


def scores(name, classes, shift):
    mean = MEANS[name] + shift
    return {
        "accuracy": [mean, mean],
        "mean": mean,
        "sd": 0.012,
        "balanced_mean": mean - 0.1,
        "balanced_sd": 0.034,
        "recall": {motion: mean + 0.001 * n for n, motion in enumerate(classes)},
        "by_object": {"key": mean + 0.002, "coin": mean - 0.002},
        "interval": [mean - 0.2, mean + 0.2],
        "parameters": 1234,
        "best_epoch": [None, None] if name.startswith(("Curl", "optical")) else [9, 3, 12],
    }


def protocol(classes, shift):
    rows = {
        name: scores(name, classes, shift) for name in ROWS if len(classes) == 2 or name[0] != "C"
    }
    one = {"first": "DGR, paper", "second": "probe on c", "difference": 0.031, "low": -0.01}
    one |= {"high": 0.07, "p_value": 0.25, "mcnemar_p": 0.5}
    fold = {"train": ["nut"], "val": ["cap", "pen"], "test": ["key"], "clips": [40, 20, 10]}
    return {"rows": rows, "differences": [one], "folds": [fold]}


def task(classes, shift):
    return {
        "clips": 80,
        "truths": dict.fromkeys(classes, 40),
        "unreadable_left_out": 7,
        "seconds_from_nothing": 90.0,
        "protocols": {
            "five-fold": protocol(classes, shift),
            "leave-one-object-out": protocol(classes, shift + 0.2),
        },
    }


@pytest.fixture
def record():
    return RunRecord(
        name="protocols",
        command="geotlm-lm report protocols",
        seed=42,
        seconds=120.0,
        numbers={"tasks": {"rotation": task(TURNS, 0.0), "sliding": task(SLIDES, 0.05)}},
        config={
            "objects": ["key", "coin"],
            "backbone": "embedded",
            "backbone_digest": "0123456789ab",
            "epochs": 30,
            "tables": ["rotation", "sliding", "ablation", "frames"],
            "training": {"head_rate": 1e-3, "dgr_rate": 3e-4, "weight_decay": 0.01, "batch": 32},
        },
        commit="abc",
        machine={"cores": 2, "processor": "Slow 1"},
        made_utc="2026-01-02T03:04:05Z",
    )


def cells(line):
    return [cell.strip() for cell in line.strip("|").split("|")]


def line_of(table, start):
    (line,) = [line for line in table.splitlines() if line.startswith(f"| {start}")]
    return cells(line)


def test_ours_and_the_published_figures_stand_in_one_row_under_their_own_data(record):
    found = record.numbers["tasks"]["rotation"]
    table = comparison_table(found, ("Curl + LR", "probe on c"), "rotation", ROTATION)
    assert cells(table.splitlines()[0]) == [
        "rotation",
        "ours, five-fold",
        "recall",
        "ours, leave-one-object-out",
        "recall",
        "published, ToucHD-Sim, simulated, five-fold",
        "recall",
        "published, TactileTracking, real, five-fold",
        "recall",
        "published, TactileTracking, real, leave-one-object-out",
        "recall",
    ]
    assert line_of(table, "probe on c") == [
        "probe on c (paper: AnyTouch 2)",
        "0.520 ± 0.012",
        "0.520 / 0.521",
        "0.720 ± 0.012",
        "0.720 / 0.721",
        "0.876 ± 0.017",
        "0.872 / 0.879",
        "0.547 ± 0.024",
        "0.538 / 0.548",
        "0.513 ± 0.033",
        "0.440 / 0.599",
    ]
    assert line_of(table, "Curl + LR")[-2:] == ["-", "-"]


def test_recalls_stand_in_the_published_order_however_a_stored_record_is_sorted(record):
    found = record.numbers["tasks"]["sliding"]
    stored = json.loads(json.dumps(found, sort_keys=True))
    tables = [comparison_table(one, ("DGR, paper",), "sliding", SLIDING) for one in (found, stored)]
    assert tables[0] == tables[1]
    assert tables[0].endswith("Recalls: left / right / up / down.")
    assert line_of(tables[0], "DGR, paper")[6] == "0.991 / 0.985 / 0.988 / 0.990"


def test_published_rows_without_a_counterpart_stand_below_ours(record):
    found = record.numbers["tasks"]["sliding"]
    table = comparison_table(found, ("probe on c", "DGR, paper"), "sliding", SLIDING)
    names = [cells(line)[0] for line in table.splitlines()[2:-2]]
    assert names == [
        "probe on c (paper: AnyTouch 2)",
        "DGR, paper (paper: GeoTLM)",
        "paper: Sparsh V-JEPA",
        "paper: InternViT-300M",
        "paper: T3",
        "paper: AnyTouch (v1)",
        "paper: UniT",
    ]
    assert line_of(table, "paper: T3")[1:7] == [
        *("-",) * 4,
        "0.857 ± 0.023",
        "0.844 / 0.880 / 0.849 / 0.857",
    ]
    assert table.endswith("Recalls: left / right / up / down.")


def test_a_row_of_ours_without_a_published_one_says_so(record):
    found = record.numbers["tasks"]["rotation"]
    table = comparison_table(found, ("optical flow + rigid fit",), "rotation", ROTATION)
    assert line_of(table, "optical")[5:] == ["-"] * 6


def test_the_ablation_says_which_parts_there_are_and_what_the_paper_found(record):
    table = ablation_table(record.numbers["tasks"])
    header = cells(table.splitlines()[0])
    assert header[3:5] == ["ours, five-fold, rotation", "ours, leave-one-object-out, rotation"]
    row = line_of(table, "DGR, region pool only")
    assert row[0] == "DGR, region pool only (paper: DGR - contact mask)"
    assert row[1:3] == ["yes", "no"]
    mean = MEANS["DGR, region pool only"]
    assert row[3:7] == [f"{mean + shift:.3f} ± 0.012" for shift in (0.0, 0.2, 0.05, 0.25)]
    assert row[7:] == ["0.946 ± 0.014", "0.768 ± 0.064"]
    assert line_of(table, "DGR, neither")[-2:] == ["-", "-"]
    assert line_of(table, "DGR, contact mask only")[1:3] == ["no", "yes"]


def test_two_frames_stand_beside_four(record):
    table = frames_table(record.numbers["tasks"])
    assert [cells(line)[1] for line in table.splitlines()[2:]] == ["2", "4", "2", "4"]
    assert line_of(table, "DGR, paper, 2 frames")[-1] == "0.902 ± 0.025"


def test_every_object_has_a_line(record):
    table = object_table(record.numbers["tasks"]["rotation"])
    assert cells(table.splitlines()[0])[0] == "held out"
    assert line_of(table, "coin")[1] == f"{MEANS['Curl + LR'] + 0.2 - 0.002:.3f}"


def test_a_row_in_detail(record):
    table = row_table(record.numbers["tasks"]["rotation"]["protocols"]["five-fold"])
    assert line_of(table, "probe on c ") == [
        "probe on c",
        "0.520 ± 0.012",
        "0.420 ± 0.034",
        "0.320-0.720",
        "0.518 (coin)",
        "1,234",
        "9",
    ]
    assert line_of(table, "Curl")[-1] == "-"


def test_differences_carry_their_interval_and_p(record):
    table = difference_table(record.numbers["tasks"]["rotation"])
    assert line_of(table, "DGR, paper less probe on c") == [
        "DGR, paper less probe on c",
        *("+0.031 (-0.010 to +0.070)", "0.250") * 2,
    ]


def test_folds_name_who_is_tested_and_who_validates(record):
    table = fold_table(record.numbers["tasks"])
    assert line_of(table, "five-fold 0") == ["five-fold 0", "key", "cap, pen", "40 / 20 / 10"]


def test_the_headline_holds_the_main_tables_and_where_they_are_from(record):
    text = protocols_headline(record)
    tables = text.split("\n\n")
    assert tables[0] in protocol_tables(record)
    assert tables[0].startswith("| rotation ")
    assert not any(name in text for name in ("region pool only", "object by object"))
    assert "`geotlm-lm report protocols" in tables[-1]


def test_the_page_says_that_the_data_differ_and_how_to_get_it_again(record):
    text = protocols_page(record)
    assert text.startswith("# The paper's protocols\n")
    assert "They\nshare a protocol, not data" in text
    assert "embedded (0123456789ab), frozen" in text
    assert "AdamW, 0.001 for the\n  head and 0.0003 for DGR" in text
    assert protocol_tables(record) in text
    assert "7 left out, their images do not show the motion" in text
    assert text.endswith(
        "2026-01-02. Simulating, encoding and training took 3.0 min in all, in this run and those "
        "it continued.\n"
    )


def test_a_record_of_one_table_has_no_other(record):
    record.config["tables"] = ["frames"]
    text = protocol_tables(record)
    assert "## Frames" in text
    assert "## Ablation" not in text
    assert "published, ToucHD-Sim" in text
