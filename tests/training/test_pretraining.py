"""Laws: an interrupted run ends where an unbroken one does; what the loss must not look at."""

import math
from dataclasses import replace

import pytest
import torch

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionClass, MotionLabel
from geotlm_lm.training import pretraining
from geotlm_lm.training.config import SMOKE
from geotlm_lm.training.pretraining import DenseHeads, DenseTruth, dense_loss, pretrain

TINY = replace(SMOKE, backbone_width=8, backbone_depth=1, pretraining_batch=4, pretraining_draws=24)


@pytest.fixture(autouse=True)
def _one_thread():
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def weights_after(examples, folder, seed=0):
    backbone, _ = pretrain(examples, preset=TINY, seed=seed, device="cpu", folder=folder)
    return {name: value.clone() for name, value in backbone.vit.state_dict().items()}


def test_an_interrupted_run_ends_where_an_unbroken_one_does(tiny_examples, tmp_path, monkeypatch):
    unbroken = weights_after(tiny_examples, tmp_path / "unbroken")
    take_step, taken = pretraining._Learner.step, []

    def interrupted(self, inputs, truth):
        if len(taken) == 3:
            raise KeyboardInterrupt
        taken.append(1)
        return take_step(self, inputs, truth)

    monkeypatch.setattr(pretraining._Learner, "step", interrupted)
    with pytest.raises(KeyboardInterrupt):
        weights_after(tiny_examples, tmp_path / "broken")
    monkeypatch.undo()
    continued = weights_after(tiny_examples, tmp_path / "broken")
    assert all(torch.equal(unbroken[name], continued[name]) for name in unbroken)


def test_another_seed_gives_other_weights(tiny_examples, tmp_path):
    first = weights_after(tiny_examples, tmp_path / "a", seed=0)
    second = weights_after(tiny_examples, tmp_path / "b", seed=1)
    assert not torch.equal(first["embed.weight"], second["embed.weight"])


def random_case():
    generator = torch.Generator().manual_seed(0)

    def random(*shape):
        return torch.rand(*shape, generator=generator)

    tokens = Tokens(random(3, 8), random(3, 2, 14, 14, 8))
    truth = DenseTruth(
        displacement=random(3, 2, 14, 14, 2) * 5,
        contact=(random(3, 2, 14, 14) > 0.5).float(),
        depth=random(3, 2, 14, 14),
        counts_motion=torch.tensor([1.0, 1.0, 0.0]),
        kind=torch.tensor([0, 1, pretraining.UNSEEN]),
        amount=torch.tensor([[8.0, math.nan], [math.nan, 0.5], [math.nan, math.nan]]),
        magnification=torch.tensor([0.0, 0.3, 0.8]),
    )
    torch.manual_seed(0)
    return tokens, DenseHeads(8), truth


def test_displacement_outside_contact_does_not_count():
    tokens, heads, truth = random_case()
    elsewhere = truth.displacement + 100 * (1 - truth.contact[..., None])
    changed = replace(truth, displacement=elsewhere)
    torch.testing.assert_close(dense_loss(tokens, heads, truth), dense_loss(tokens, heads, changed))


def test_motion_that_leaves_no_trace_does_not_count():
    tokens, heads, truth = random_case()
    displacement = truth.displacement.clone()
    typical = displacement[2].square().sum(-1)
    displacement[2] = displacement[2].flip(-1)  # the same size, another way
    assert torch.allclose(displacement[2].square().sum(-1), typical)
    changed = replace(truth, displacement=displacement)
    torch.testing.assert_close(dense_loss(tokens, heads, truth), dense_loss(tokens, heads, changed))


def test_the_global_target_carries_no_direction():
    tokens, heads, truth = random_case()
    summary = pretraining._summary(truth)
    turned = replace(truth, displacement=-truth.displacement)
    assert torch.equal(summary, pretraining._summary(turned))


def test_the_kind_asked_of_the_global_token_is_the_same_for_every_direction():
    for label in (MotionLabel(motion) for motion in Motion):
        assert pretraining._kind(label) == pretraining._kind(label.mirrored())
    asked = {motion: pretraining._kind(MotionLabel(motion)) for motion in Motion}
    assert len({asked[motion] for motion in ROTATIONS}) == 1
    assert len({asked[motion] for motion in SLIDES}) == 1
    assert len(set(asked.values())) == len(MotionClass)


def test_the_kind_of_a_motion_that_leaves_no_trace_is_not_asked():
    assert pretraining._kind(MotionLabel(Motion.PRESS, is_readable=False)) == pretraining.UNSEEN
    tokens, heads, truth = random_case()
    unseen = replace(truth, kind=torch.full_like(truth.kind, pretraining.UNSEEN))
    dense_loss(tokens, heads, unseen).backward()
    assert heads.kind.weight.grad.abs().max() == 0
    assert heads.summary.weight.grad.abs().max() > 0
    dense_loss(tokens, heads, truth).backward()
    assert heads.kind.weight.grad.abs().max() > 0


def test_the_amount_asked_of_the_global_token_is_that_of_turns_and_slides_whatever_their_way():
    turn = MotionLabel(Motion.COUNTERCLOCKWISE, rotation_deg=-8.0)
    slide = MotionLabel(Motion.UP, slide_x_mm=0.3, slide_y_mm=-0.4)
    turned, slid = (pretraining._amounts(label) for label in (turn, slide))
    assert (turned[0], math.isnan(turned[1])) == (8.0, True)
    assert (math.isnan(slid[0]), slid[1]) == (True, pytest.approx(0.5))
    for label in (turn, slide):
        same = pretraining._amounts(label.mirrored())
        assert str(same) == str(pretraining._amounts(label))
    unasked = (
        replace(turn, is_readable=False),
        MotionLabel(Motion.PRESS),
        MotionLabel(Motion.NONE),
    )
    assert all(math.isnan(one) for label in unasked for one in pretraining._amounts(label))


def test_amounts_told_right_cost_nothing_and_those_that_are_not_asked_never_do():
    true = torch.tensor([[8.0, math.nan], [math.nan, 0.4]])
    told = torch.tensor([[math.log(3.0), 5.0], [-5.0, math.log(2.0)]])
    assert pretraining.amount_loss(told, true).item() == pytest.approx(0, abs=1e-6)
    assert pretraining.amount_loss(told + 0.5, true).item() == pytest.approx(0.45)
    nothing = torch.full_like(true, math.nan)
    told.requires_grad_()
    pretraining.amount_loss(told, nothing).backward()
    assert torch.equal(told.grad, torch.zeros_like(told))
