"""Laws: an interrupted run ends where an unbroken one does; what the losses must not look at."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from geotlm_lm.backbone.stem import ALIGNED_AT, FLOW_SCALE_PX, MAGNIFICATION_AT, PATCH_INPUT_DIM
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.edit import MIRRORED
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.training import pretraining
from geotlm_lm.training.config import SMOKE
from geotlm_lm.training.pretraining import DenseHeads, DenseTruth, dense_loss, pretrain
from geotlm_lm.training.truth import component_truth
from tests.training.shared_steps import random_examples

TINY = replace(SMOKE, backbone_width=8, backbone_depth=1, pretraining_batch=4, pretraining_draws=24)


def weights_after(folder, seed=0, progress=lambda *_: None):
    backbone, _ = pretrain(
        random_examples(), preset=TINY, seed=seed, folder=folder, progress=progress
    )
    return {name: value.clone() for name, value in backbone.vit.state_dict().items()}


def test_an_interrupted_run_ends_where_an_unbroken_one_does(tmp_path):
    def interrupted(_, done, steps):
        if done == steps // 2:
            raise KeyboardInterrupt

    unbroken = weights_after(tmp_path / "unbroken")
    with pytest.raises(KeyboardInterrupt):
        weights_after(tmp_path / "broken", progress=interrupted)
    continued = weights_after(tmp_path / "broken")
    assert all(torch.equal(unbroken[name], continued[name]) for name in unbroken)
    other = weights_after(tmp_path / "other", seed=1)
    assert not torch.equal(unbroken["embed.weight"], other["embed.weight"])


def test_displacement_begins_as_the_alignment_of_its_own_time_bin():
    vit, heads = pretraining._fresh(replace(TINY, backbone_width=160), 0)
    torch.nn.init.zeros_(vit.positions)
    inputs = torch.randn(2, 2, 14, 14, PATCH_INPUT_DIM)
    with torch.no_grad():
        found = heads.patch(vit(inputs).patches)[..., :2]
    aligned = inputs[..., ALIGNED_AT : ALIGNED_AT + 2]
    torch.testing.assert_close(found, aligned, atol=1e-3, rtol=1e-3)


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
        components=torch.tensor([[1.0, 0.0, 0.0, 0.0, 1.0], [math.nan] * 5, [0.0] * 5]),
        amount=torch.tensor([[8.0, math.nan], [math.nan, 0.5], [math.nan, math.nan]]),
        magnification=torch.tensor([0.0, 0.3, 0.8]),
    )
    torch.manual_seed(0)
    return tokens, DenseHeads(8), truth


def test_displacement_outside_contact_or_of_a_motion_without_trace_does_not_count():
    tokens, heads, truth = random_case()
    displacement = truth.displacement + 100 * (1 - truth.contact[..., None])
    displacement[2] = displacement[2].flip(-1)  # the same size, another way
    changed = replace(truth, displacement=displacement)
    torch.testing.assert_close(dense_loss(tokens, heads, truth), dense_loss(tokens, heads, changed))


def test_the_global_token_is_asked_for_no_direction():
    tokens, heads, truth = random_case()
    losses = []
    for displacement in (truth.displacement, -truth.displacement):
        dense_loss(tokens, heads, replace(truth, displacement=displacement)).backward()
        losses.append(heads.summary.weight.grad.clone())
        heads.zero_grad()
    assert torch.equal(*losses)


def wanted(label):
    return [None if math.isnan(one) else one for one in pretraining._wanted(component_truth(label))]


def sizes(label):
    found = pretraining._amounts(component_truth(label))
    return [None if math.isnan(one) else one for one in found]


MOVING = MotionLabel(
    Motion.STILL,
    rotation_deg=-8.0,
    depth_change_mm=-0.4,
    travel_px=(3.0, -4.0),
    radius_px=20.0,
    visible_grey=(9.0, 9.0, 9.0),
)


def test_what_is_asked_of_the_global_token_is_the_same_for_every_way_it_turns_or_slides():
    assert wanted(MOVING) == wanted(MIRRORED.of_label(MOVING)) == [1.0, 1.0, 0.0, 1.0, 1.0]
    assert sizes(MOVING) == sizes(MIRRORED.of_label(MOVING)) == [8.0, 5.0]
    # Whether it goes in or out is no way in the image.
    assert wanted(replace(MOVING, depth_change_mm=0.4))[2:4] == [1.0, 0.0]
    assert wanted(replace(MOVING, motion=Motion.NONE)) == [0.0] * 5


def test_what_is_ambiguous_or_leaves_no_trace_is_not_asked():
    dim = replace(MOVING, visible_grey=(9.0, 0.5, 0.5))
    assert (wanted(dim), sizes(dim)) == ([1.0, None, None, None, 1.0], [8.0, None])
    barely = replace(MOVING, travel_px=(0.2, 0.0), depth_change_mm=0.0)
    assert wanted(barely) == [1.0, None, 0.0, 0.0, 1.0]
    assert sizes(replace(MOVING, motion=Motion.NONE)) == [None, None]


def test_components_that_are_not_asked_teach_nothing():
    tokens, heads, truth = random_case()
    unseen = replace(truth, components=torch.full_like(truth.components, math.nan))
    dense_loss(tokens, heads, unseen).backward()
    assert heads.components.weight.grad.abs().max() == 0
    assert heads.summary.weight.grad.abs().max() > 0
    dense_loss(tokens, heads, truth).backward()
    assert heads.components.weight.grad.abs().max() > 0


def test_amounts_told_right_cost_nothing_and_those_that_are_not_asked_never_do():
    true = torch.tensor([[8.0, math.nan], [math.nan, 4.0]])
    told = torch.tensor([[math.log(3.0), 5.0], [-5.0, math.log(2.0)]])
    assert pretraining.amount_loss(told, true).item() == pytest.approx(0, abs=1e-6)
    assert pretraining.amount_loss(told + 0.5, true).item() == pytest.approx(0.45)
    nothing = torch.full_like(true, math.nan)
    told.requires_grad_()
    pretraining.amount_loss(told, nothing).backward()
    assert torch.equal(told.grad, torch.zeros_like(told))


def test_displacement_is_read_out_in_the_unit_in_which_the_stem_tells_it():
    tokens, heads, truth = random_case()
    one_way = torch.tensor([1.0, -2.0])
    truth = replace(truth, displacement=(one_way * FLOW_SCALE_PX).expand(3, 2, 14, 14, 2))
    torch.nn.init.zeros_(heads.patch.weight)

    def loss(factor):
        with torch.no_grad():
            heads.patch.bias[:2] = factor * one_way
            return float(dense_loss(tokens, heads, truth))

    assert loss(1.0) < min(loss(0.9), loss(1.1), loss(FLOW_SCALE_PX), loss(1 / FLOW_SCALE_PX))


def test_inputs_motion_contact_and_depth_are_mirrored_together():
    _, _, truth = random_case()
    pattern = truth.depth
    inputs = torch.zeros(3, 2, 14, 14, PATCH_INPUT_DIM)
    inputs[..., MAGNIFICATION_AT] = pattern  # has no direction: it only goes to another place
    field = torch.stack([pattern, 2 * pattern], dim=-1)
    truth = replace(truth, displacement=field, contact=pattern)
    rng, looks = np.random.default_rng(0), set()
    for _ in range(8):
        seen, mirrored = pretraining.mirrored_at_random(inputs, truth, rng)
        torch.testing.assert_close(mirrored.contact, mirrored.depth)
        torch.testing.assert_close(seen[..., MAGNIFICATION_AT], mirrored.depth)
        signs = mirrored.displacement / torch.stack([mirrored.depth, 2 * mirrored.depth], dim=-1)
        for sign, one, own in zip(signs, mirrored.depth, pattern, strict=True):
            x, y = (float(axis.mean()) for axis in sign.unbind(dim=-1))
            torch.testing.assert_close(sign, torch.tensor([x, y]).expand_as(sign))
            flipped = [axis for axis, way in ((2, x), (1, y)) if way < 0]
            assert torch.equal(one, own.flip(flipped))
            looks.add((round(x), round(y)))
    assert looks == {(1, 1), (-1, 1), (1, -1), (-1, -1)}
