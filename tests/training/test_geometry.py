"""Expected values: tokens that carry a known shear linearly; leak laws of standardisation."""

from dataclasses import replace
from functools import partial

import pytest
import torch

from geotlm_lm.training import geometry
from geotlm_lm.training.geometry import better_mode, train_geometry, train_global_probe
from geotlm_lm.training.pretraining import DenseHeads
from tests.training.moving_tokens import token_set

torch.manual_seed(0)
READ_OUTS = DenseHeads(6)
trained = partial(train_geometry, read_outs=READ_OUTS)


@pytest.fixture(scope="module")
def grounded(tmp_path_factory):
    path = tmp_path_factory.mktemp("dgr") / "grounded.pt"
    with pytest.MonkeyPatch.context() as patch:
        # The tokens are noise-free: thirty times the paper's rate gets there in 80 steps.
        patch.setattr(geometry, "DGR_RATE", 1e-2)
        patch.setattr(geometry, "HEAD_RATE", 1e-2)
        return trained(
            token_set(240, 0), token_set(120, 1), mode="grounded", epochs=10, seed=0, path=path
        )


def test_grounded_dgr_learns_the_direction_that_the_global_token_does_not_carry(grounded):
    train, validation = token_set(240, 0), token_set(120, 1)
    (grounded, accuracy), plain = grounded, train_global_probe(train, validation, epochs=3, seed=0)
    tokens = grounded.global_standardiser.apply(validation.tokens.global_token)
    chance = plain.probabilities(tokens).argmax(-1).eq(validation.motions).float().mean()
    assert accuracy > 0.9
    assert chance < 0.4


def test_grounded_shear_change_follows_the_true_displacement_change(grounded):
    data = token_set(60, 2)
    with torch.no_grad():
        _, geometry = grounded[0](data, slice(None))
    touched = data.contact > 0
    both = torch.stack([geometry.shear_change[touched], data.shear_change[touched]])
    for axis in range(2):
        assert torch.corrcoef(both[..., axis])[0, 1] > 0.8


@pytest.mark.parametrize("mode", ["paper", "grounded"])
def test_a_batch_without_a_readable_clip_leaves_finite_weights(tmp_path, mode):
    train = replace(token_set(33, 0), is_readable=torch.arange(33) < 1)
    path = tmp_path / "dgr.pt"
    reader, _ = trained(train, token_set(12, 1), mode=mode, epochs=1, seed=0, path=path)
    probe = train_global_probe(train, train, epochs=1, seed=0)
    for module in (reader, probe):
        assert all(bool(torch.isfinite(value).all()) for value in module.parameters())


def test_the_same_seed_gives_the_same_geometry_and_resumes_to_it(tmp_path):
    train, validation = token_set(96, 0), token_set(30, 1)

    def run(path, epochs):
        return trained(train, validation, mode="paper", epochs=epochs, seed=3, path=path)

    straight, accuracy = run(tmp_path / "straight.pt", 4)
    run(tmp_path / "resumed.pt", 2)
    resumed, again = run(tmp_path / "resumed.pt", 4)
    assert accuracy == again
    for name, value in straight.dgr.state_dict().items():
        assert torch.equal(value, resumed.dgr.state_dict()[name])


def test_grounded_training_starts_from_the_read_outs_on_raw_tokens(tmp_path):
    train = token_set(24, 0)
    model, _ = trained(train, train, mode="grounded", epochs=1, seed=0, path=tmp_path / "a.pt")
    geometry._start_from(READ_OUTS, model)
    with torch.no_grad():
        _, found = model(train, slice(None))
        expected = READ_OUTS.patch(train.tokens.patches)
    torch.testing.assert_close(found.shear, expected[..., :2], atol=1e-4, rtol=1e-4)
    mask = torch.sigmoid(expected[..., 2]).mean(dim=1)
    torch.testing.assert_close(found.mask, mask, atol=1e-4, rtol=1e-4)


def test_the_physical_shear_is_kept_unless_the_other_answers_better():
    assert better_mode({"paper": 0.970, "grounded": 0.968}) == "grounded"
    assert better_mode({"paper": 0.960, "grounded": 0.968}) == "grounded"
    assert better_mode({"paper": 0.985, "grounded": 0.968}) == "paper"
