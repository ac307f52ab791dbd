import numpy as np
import pytest

from geotlm_lm.training.object_folds import leave_one_object_out, object_folds

OBJECTS = [f"object {number % 11}" for number in range(130)]


def objects_of(rows):
    return {OBJECTS[row] for row in rows}


@pytest.fixture(params=["folds", "leave one out"])
def folds(request):
    if request.param == "folds":
        return object_folds(OBJECTS, 5, seed=3)
    return leave_one_object_out(OBJECTS, seed=3)


def test_no_object_stands_in_two_parts_of_a_fold(folds):
    for fold in folds:
        train, val, test = (objects_of(part) for part in (fold.train, fold.val, fold.test))
        assert not (train & val)
        assert not (train & test)
        assert not (val & test)
        assert train
        assert val
        assert test == set(fold.held_out)


def test_every_row_is_used_once_in_each_fold(folds):
    for fold in folds:
        rows = np.concatenate([fold.train, fold.val, fold.test])
        assert sorted(rows) == list(range(len(OBJECTS)))


def test_every_row_is_tested_exactly_once_over_the_folds(folds):
    assert sorted(np.concatenate([fold.test for fold in folds])) == list(range(len(OBJECTS)))
