"""Scores of rows and groups written down by hand; expected values are counted."""

import pytest

from geotlm_lm.experiments.language_asking import Row
from geotlm_lm.experiments.language_groups import Group
from geotlm_lm.experiments.language_scores import (
    amount_scores,
    confidence_scores,
    differences,
    group_scores,
    summarise_talk,
    type_scores,
)


def row(type_id="T1", right=True, *, clip=0, truth="left", **values):
    rights = {"words": right} | values.pop("others", {})
    said = values.pop("said", "left")
    fault = values.pop("fault", "" if right else "wrong")
    confidence = values.pop("confidence", 0.9)
    family = values.pop("family", f"cap {clip}")
    told_by = values.pop("told_by", "model")
    return Row(type_id, clip, family, rights, truth, fault, confidence, said, told_by, **values)


def test_a_method_is_scored_where_it_could_be_right_only():
    rows = [row(others={"probe": True}), row(right=False, clip=1)]
    scores = type_scores(rows, 0)
    assert scores["methods"]["words"]["accuracy"] == 0.5
    assert (scores["methods"]["probe"]["questions"], scores["methods"]["probe"]["accuracy"]) == (
        1,
        1.0,
    )
    assert "flow" not in scores["methods"]


def test_the_commonest_answer_and_who_tells_are_shares():
    rows = [row(), row(clip=1), row(clip=2, truth="up", told_by="rule")]
    scores = type_scores(rows, 0)
    assert scores["commonest"] == pytest.approx(2 / 3)
    assert scores["told_by_model"] == pytest.approx(2 / 3)


def test_recall_is_told_by_the_right_answer():
    rows = [row(), row(right=False, clip=1), row(clip=2, truth="up")]
    assert type_scores(rows, 0)["recall"] == {"left": 0.5, "up": 1.0}


def test_by_answer_a_constant_answer_gets_its_share_alone():
    rows = [row(clip=i, truth="yes") for i in range(9)]
    rows.append(row(right=False, clip=9, truth="no"))
    words = type_scores(rows, 0)["methods"]["words"]
    assert (words["accuracy"], words["by_answer"]) == (0.9, 0.5)


def test_differences_are_paired_by_question():
    rows = [row(others={"blind": False}, clip=i) for i in range(3)]
    rows.append(row(clip=3))  # the blind model was not asked
    (difference,) = differences(rows, 0)
    assert (difference["second"], difference["questions"]) == ("blind", 3)
    assert difference["difference"] == 1.0


def test_a_withheld_answer_counts_where_coverage_is_counted_not_where_confidence_is():
    rows = [row(), row(right=False, said=None, confidence=0.0, fault="withheld", clip=1)]
    scores = confidence_scores(rows)
    assert (scores["answered"], scores["asked"]) == (1, 2)
    assert scores["accuracy"] == 1.0
    assert scores["coverage_at_99"] == 0.5


def test_what_is_rightly_declined_states_no_confidence():
    assert confidence_scores([row("T17", truth="declined", said=None)]) is None


def test_amounts_are_off_by_their_median_and_unstated_ones_are_out_of_tolerance():
    rows = [
        row("T7", clip=i, truth="some deg", unit="deg", amount_error=error)
        for i, error in enumerate((0.1, 0.2, 0.3))
    ]
    rows.append(row("T7", False, clip=3, truth="some deg", unit="deg", said=None))
    scores = amount_scores(rows, "deg")
    assert (scores["asked"], scores["stated"]) == (4, 3)
    assert scores["median_relative_error"] == 0.2
    assert scores["in_tolerance"] == 0.75
    assert amount_scores(rows, "px")["in_tolerance"] is None


def test_a_group_is_right_as_a_whole_or_not():
    groups = [
        Group("pair", "cap", (True, True), ("yes", "it is")),
        Group("pair", "key", (True, False), ("yes", "yes")),
    ]
    scores = group_scores(groups, 0)
    assert (scores["all_right"], scores["one_right"], scores["differing"]) == (0.5, 0.75, 0.5)
    assert scores["by_place"] == [1.0, 0.5]


@pytest.fixture
def summary():
    rows = [
        row("T2", said="yes", truth="yes"),
        row("T2", False, clip=1, said="yes", truth="no"),
        row("T2", clip=2, said="no", truth="no"),
        row("T10", claims=(True, False), own_claims=(True, True)),
        row("T17", truth="declined", said=None, confidence=0.0),
        row("T17", False, clip=1, truth="declined", said="left"),
        row("T1", False, clip=2, fault="refused", said=None, confidence=0.0),
        row("T1", clip=3),
    ]
    return summarise_talk(rows, [Group("pair", "cap", (True,), ("yes",))], 0)


def test_the_yes_ratio_is_that_of_what_is_said(summary):
    assert summary["yes"] == {"questions": 3, "said": 2 / 3, "true": 1 / 3}


def test_refusals_are_recalled_and_false_ones_counted(summary):
    assert summary["unanswerable"] == {"recall": 0.5, "false_refusals": 1 / 6}


def test_faults_are_shares_of_all_questions(summary):
    assert summary["faults"] == {"refused": 1 / 8, "wrong": 2 / 8}


def test_claims_are_counted_one_by_one_and_all_together(summary):
    evidence = summary["evidence"]["with the true field"]
    assert evidence == {"answers": 1, "claims": 2, "claims_right": 0.5, "all_right": 0.0}


def test_directions_are_pooled_apart(summary):
    assert summary["pooled"]["all directions"]["questions"] == 5
    assert summary["pooled"]["all types"]["questions"] == 8
    assert list(summary["types"]) == ["T1", "T2", "T10", "T17"]
