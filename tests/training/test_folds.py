"""Expected values: tokens that carry a known shear linearly; leak laws of standardisation."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.geometry import FLOW_SCALE_PX
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES
from geotlm_lm.dgr.ablations import AblatedDGR, DGRParts
from geotlm_lm.training import folds
from geotlm_lm.training.folds import Recipe, standardise_fold, train_on_fold
from geotlm_lm.training.geometry import ALL_MOTIONS
from geotlm_lm.training.least_squares_start import initialise_from_truth
from geotlm_lm.training.object_folds import Fold
from tests.training.moving_tokens import token_set

FOLD = Fold(np.arange(0, 120), np.arange(120, 160), np.arange(160, 240), ("x",))
DATA = token_set(240, 0)
TRUTH = [ALL_MOTIONS[index] for index in DATA.motions[160:]]


def right(outcome, truth=TRUTH):
    return np.mean([a == b for a, b in zip(outcome.predictions, truth, strict=True)])


def trained(recipe, *, data=DATA, labels=DIRECTED, epochs=10, seed=42):
    return train_on_fold(standardise_fold(data, FOLD), labels, recipe, epochs=epochs, seed=seed)


@pytest.fixture
def fast(monkeypatch):
    # The tokens are noise-free: thirty times the paper's rate gets there in 40 steps.
    monkeypatch.setattr(folds, "DGR_RATE", 1e-2)
    monkeypatch.setattr(folds, "HEAD_RATE", 1e-2)


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


def test_statistics_are_of_the_training_rows_whatever_the_others_hold():
    tokens = DATA.tokens
    strange = Tokens(tokens.global_token.clone(), tokens.patches.clone())
    strange.global_token[120:] += 50
    strange.patches[120:] *= 9
    own, other = (standardise_fold(data, FOLD) for data in (DATA, replace(DATA, tokens=strange)))
    for part in ("global_standardiser", "patch_standardiser"):
        for name in ("mean", "scale"):
            assert torch.equal(
                getattr(getattr(own, part), name), getattr(getattr(other, part), name)
            )
    assert torch.equal(own.train.tokens.patches, other.train.tokens.patches)
    assert not torch.equal(own.test.tokens.patches, other.test.tokens.patches)
    torch.testing.assert_close(own.train.tokens.global_token.mean(dim=0), torch.zeros(6))


def test_what_is_trained_does_not_depend_on_the_test_rows():
    tokens = DATA.tokens
    shuffled = Tokens(tokens.global_token.clone(), tokens.patches.clone())
    shuffled.patches[160:] = tokens.patches[160:].flip(0)
    own = trained(Recipe(DGRParts()), epochs=2)
    other = trained(Recipe(DGRParts()), data=replace(DATA, tokens=shuffled), epochs=2)
    assert own.best_epoch == other.best_epoch
    assert own.validation_accuracy == other.validation_accuracy


def test_the_best_validation_epoch_is_kept_and_not_the_last(monkeypatch):
    scores = iter([(0.5, -1.0), (0.9, -2.0), (0.9, -1.5), (0.9, -1.7), (0.8, -0.1)])
    monkeypatch.setattr(folds._Reader, "score", lambda self, part: next(scores))
    outcome = trained(Recipe(DGRParts()), epochs=5)
    assert (outcome.best_epoch, outcome.validation_accuracy) == (3, 0.9)
    monkeypatch.setattr(folds._Reader, "score", lambda self, part: (1.0, 0.0))
    three = trained(Recipe(DGRParts()), epochs=3)
    assert three.best_epoch == 1


def test_parameters_count_the_probe_and_the_parts_there_are():
    # Width 6: W_s 14, W_m 7, W_o 15 x 6, probe 7 x 6.
    assert trained(Recipe(), epochs=1).parameters == 42
    assert trained(Recipe(DGRParts()), epochs=1).parameters == 42 + 14 + 7 + 90
    assert trained(Recipe(DGRParts(mask=False)), epochs=1).parameters == 42 + 14 + 90


def test_the_seed_decides_and_a_row_of_four_motions_names_only_those():
    slides = token_set(240, 3, among=SLIDES)
    runs = [
        trained(Recipe(DGRParts()), data=slides, labels=SLIDES, epochs=2, seed=seed)
        for seed in (42, 42, 43)
    ]
    assert runs[0] == runs[1]
    assert runs[0] != runs[2]
    assert set(runs[0].predictions) <= set(SLIDES)


def test_read_outs_of_the_truth_give_displacement_and_contact_back():
    fold = standardise_fold(DATA, FOLD)
    dgr = AblatedDGR(6, 6, DGRParts())
    initialise_from_truth(dgr, fold.train)
    with torch.no_grad():
        found = dgr(fold.test.tokens.patches)
    touched = fold.test.contact > 0
    told = (found.shear_change * FLOW_SCALE_PX)[touched]
    true = fold.test.shear_change[touched]
    # The displacement of the early bin is noise of a tenth, which the difference carries twice.
    assert (told - true).square().mean().sqrt() < 0.25 * true.square().mean().sqrt()
    assert found.mask[touched].min() > 0.8
    assert found.mask[~touched].max() < 0.2


def test_patches_without_contact_do_not_shape_the_shear():
    fold = standardise_fold(DATA, FOLD)
    loud = fold.train.shear_change + 99.0 * (fold.train.contact == 0)[..., None]
    own, other = (AblatedDGR(6, 6, DGRParts()) for _ in range(2))
    initialise_from_truth(own, fold.train)
    initialise_from_truth(other, replace(fold.train, shear_change=loud))
    assert torch.equal(own.to_shear.weight, other.to_shear.weight)


@pytest.mark.usefixtures("fast")
def test_dgr_adds_to_what_the_global_token_carries_and_takes_nothing_away():
    noise = torch.Generator().manual_seed(1)
    told = torch.randn(DATA.tokens.global_token.shape, generator=noise) * 0.1
    for row, index in enumerate(DATA.motions.tolist()):
        told[row, DIRECTED.index(ALL_MOTIONS[index])] += 2
    dumb = Tokens(told, torch.randn(DATA.tokens.patches.shape, generator=noise))
    data = replace(DATA, tokens=dumb)
    assert right(trained(Recipe(DGRParts()), data=data, epochs=25)) > 0.9


def test_the_kept_weights_are_those_of_the_best_epoch(monkeypatch):
    monkeypatch.setattr(folds._Reader, "score", lambda self, part: (1.0, 0.0))
    assert trained(Recipe(), epochs=9) == trained(Recipe(), epochs=1)


def test_rates_are_the_papers():
    part = standardise_fold(DATA, FOLD).train.tokens
    reader = folds._Reader(part, DIRECTED, Recipe(DGRParts()), 0)
    assert [group["lr"] for group in reader.rates()] == [1e-3, 3e-4]
    assert (folds.WEIGHT_DECAY, folds.BATCH) == (0.01, 32)
    grouped = sum(len(group["params"]) for group in reader.rates())
    assert grouped == len(list(reader.parameters()))
