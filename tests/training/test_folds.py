"""Expected values: tokens that carry a known shear linearly; leak laws of standardisation."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.geometry import FLOW_SCALE_PX
from geotlm_lm.core.labels import DIRECTED, ROTATIONS
from geotlm_lm.dgr.ablations import AblatedDGR, DGRParts
from geotlm_lm.training import folds, geometry
from geotlm_lm.training.folds import (
    Fold,
    Recipe,
    initialise_from_truth,
    leave_one_object_out,
    object_folds,
    train_on_fold,
)
from geotlm_lm.training.geometry import ALL_MOTIONS, TokenReader
from tests.training.moving_tokens import token_set

FOLD = Fold(np.arange(0, 120), np.arange(120, 160), np.arange(160, 240), ("x",))
DATA = token_set(240, 0)
TRUTH = [ALL_MOTIONS[index] for index in DATA.motions[160:]]


def right(outcome, truth=TRUTH):
    return np.mean([a == b for a, b in zip(outcome.predictions, truth, strict=True)])


def trained(recipe, *, data=DATA, labels=DIRECTED, epochs=10, seed=42):
    return train_on_fold(data, FOLD, labels, recipe, epochs=epochs, seed=seed)


@pytest.fixture
def fast(monkeypatch):
    # The tokens are noise-free: thirty times the paper's rate gets there in 40 steps.
    monkeypatch.setattr(geometry, "DGR_RATE", 1e-2)
    monkeypatch.setattr(geometry, "HEAD_RATE", 1e-2)


@pytest.mark.usefixtures("fast")
@pytest.mark.parametrize("mode", ["paper", "grounded"])
def test_dgr_reads_the_direction_that_the_global_token_does_not_carry(mode):
    assert right(trained(Recipe(DGRParts(), mode), epochs=25)) > 0.9
    assert right(trained(Recipe())) < 0.4


@pytest.mark.usefixtures("fast")
def test_without_regions_a_turn_that_only_halves_show_is_not_read():
    # A turn's mean over the whole grid is zero, here by construction.
    turns = token_set(240, 0, among=ROTATIONS)
    truth = [ALL_MOTIONS[index] for index in turns.motions[160:]]
    whole = trained(Recipe(DGRParts(regions=False)), data=turns, labels=ROTATIONS)
    halves = trained(Recipe(DGRParts()), data=turns, labels=ROTATIONS)
    assert right(halves, truth) > 0.95
    assert right(whole, truth) < 0.75


def reader_of(data, dgr=None):
    return TokenReader(data, DIRECTED, dgr, torch.Generator())


def test_statistics_are_of_the_training_rows():
    train = DATA.only(FOLD.train)
    reader = reader_of(train, AblatedDGR(6, 6, DGRParts()))
    tokens = reader.global_standardiser.apply(train.tokens.global_token)
    torch.testing.assert_close(tokens.mean(dim=0), torch.zeros(6))
    patches = reader.patch_standardiser.apply(train.tokens.patches).flatten(0, -2)
    torch.testing.assert_close(patches.std(dim=0, correction=0), torch.ones(6))


def test_what_is_trained_does_not_depend_on_the_test_rows():
    tokens = DATA.tokens
    shuffled = Tokens(tokens.global_token.clone(), tokens.patches.clone())
    shuffled.patches[160:] = 9 * tokens.patches[160:].flip(0)
    shuffled.global_token[160:] += 50
    own = trained(Recipe(DGRParts()), epochs=2)
    other = trained(Recipe(DGRParts()), data=replace(DATA, tokens=shuffled), epochs=2)
    assert own.best_epoch == other.best_epoch
    assert own.validation_accuracy == other.validation_accuracy


def test_the_best_validation_epoch_is_kept_and_not_the_last(monkeypatch):
    scores = iter([(0.5, -1.0), (0.9, -2.0), (0.9, -1.5), (0.9, -1.7), (0.8, -0.1)])
    monkeypatch.setattr(folds, "score", lambda reader, part: next(scores))
    outcome = trained(Recipe(DGRParts()), epochs=5)
    assert (outcome.best_epoch, outcome.validation_accuracy) == (3, 0.9)
    monkeypatch.setattr(folds, "score", lambda reader, part: (1.0, 0.0))
    three = trained(Recipe(DGRParts()), epochs=3)
    assert three.best_epoch == 1


def test_read_outs_of_the_truth_give_displacement_and_contact_back():
    train, test = DATA.only(FOLD.train), DATA.only(FOLD.test)
    reader = reader_of(train, AblatedDGR(6, 6, DGRParts()))
    initialise_from_truth(reader, train)
    with torch.no_grad():
        _, found = reader(test, slice(None))
    touched = test.contact > 0
    told = (found.shear_change * FLOW_SCALE_PX)[touched]
    true = test.shear_change[touched]
    # The displacement of the early bin is noise of a tenth, which the difference carries twice.
    assert (told - true).square().mean().sqrt() < 0.25 * true.square().mean().sqrt()
    assert found.mask[touched].min() > 0.8
    assert found.mask[~touched].max() < 0.2


OBJECTS = [f"object {number % 11}" for number in range(130)]


@pytest.mark.parametrize(
    "folds", [object_folds(OBJECTS, 5, seed=3), leave_one_object_out(OBJECTS, seed=3)]
)
def test_no_object_stands_in_two_parts_of_a_fold_and_each_row_is_tested_once(folds):
    for fold in folds:
        parts = [{OBJECTS[row] for row in rows} for rows in (fold.train, fold.val, fold.test)]
        assert all(parts)
        assert sum(map(len, parts)) == len(set.union(*parts)) == 11
        assert parts[2] == set(fold.held_out)
        assert sorted([*fold.train, *fold.val, *fold.test]) == list(range(len(OBJECTS)))
    assert sorted(np.concatenate([fold.test for fold in folds])) == list(range(len(OBJECTS)))
