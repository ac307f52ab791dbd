import numpy as np
import pytest
from sklearn import metrics

from geotlm_lm.evaluation.scores import (
    accuracy,
    balanced_accuracy,
    confusion,
    macro_accuracy,
    mean_by_group,
    recall_per_class,
)


@pytest.fixture
def random_labels():
    rng = np.random.default_rng(0)
    truths = rng.choice(list("abc"), 300, p=[0.7, 0.2, 0.1]).tolist()
    guesses = [t if rng.random() < 0.6 else rng.choice(list("abc")) for t in truths]
    return truths, [str(guess) for guess in guesses]


def test_scores_agree_with_scikit_learn(random_labels):
    truths, guesses = random_labels
    assert accuracy(truths, guesses) == pytest.approx(metrics.accuracy_score(truths, guesses))
    assert balanced_accuracy(truths, guesses) == pytest.approx(
        metrics.balanced_accuracy_score(truths, guesses)
    )
    recalls = recall_per_class(truths, guesses)
    expected = metrics.recall_score(truths, guesses, average=None, labels=list("abc"))
    assert [recalls[one] for one in "abc"] == pytest.approx(expected)
    assert (
        confusion(truths, guesses, "abc")[:, :3]
        == metrics.confusion_matrix(truths, guesses, labels=list("abc"))
    ).all()


def test_an_answerer_of_one_class_is_unmasked_by_balanced_accuracy():
    truths = ["cw"] * 9 + ["ccw"]
    assert accuracy(truths, ["cw"] * 10) == 0.9
    assert balanced_accuracy(truths, ["cw"] * 10) == 0.5


def test_a_missing_answer_is_wrong_and_has_its_own_column():
    truths, answers = ["cw", "cw", "ccw"], ["cw", None, "banana"]
    assert accuracy(truths, answers) == pytest.approx(1 / 3)
    assert confusion(truths, answers, ("cw", "ccw")).tolist() == [[1, 0, 1], [0, 0, 1]]


def test_macro_accuracy_weighs_objects_not_clips():
    truths, answers = ["x"] * 10, ["x"] * 9 + ["y"]
    objects = ["cap"] * 9 + ["key"]
    assert macro_accuracy(truths, answers, objects) == 0.5


def test_groups_keep_the_order_they_appear_in():
    assert list(mean_by_group(np.array([1.0, 0.0, 0.0]), ["z", "a", "z"]).items()) == [
        ("z", 0.5),
        ("a", 0.0),
    ]


@pytest.mark.parametrize(("truths", "answers"), [([], []), (["a"], ["a", "b"])])
def test_clips_and_answers_must_match(truths, answers):
    with pytest.raises(ValueError, match="at least one"):
        accuracy(truths, answers)


def test_a_truth_outside_the_labels_is_refused():
    with pytest.raises(ValueError, match="outside the given labels: b"):
        confusion(["b"], ["a"], ["a"])
