"""Laws: an interrupted run ends where an unbroken one does; another seed gives others."""

from dataclasses import replace

import pytest
import torch

from geotlm_lm.backbone.stem import ALIGNED_AT, PATCH_INPUT_DIM
from geotlm_lm.training import pretraining
from geotlm_lm.training.config import SMOKE
from geotlm_lm.training.pretraining import pretrain
from geotlm_lm.training.ranks import ALONE

TINY = replace(SMOKE, backbone_width=8, backbone_depth=1, pretraining_batch=4, pretraining_draws=24)


@pytest.fixture(autouse=True)
def _one_thread():
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def weights_after(examples, folder, seed=0):
    backbone, _ = pretrain(examples, preset=TINY, seed=seed, folder=folder)
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


def test_displacement_begins_as_the_alignment_of_its_own_time_bin():
    learner = pretraining._Learner(replace(TINY, backbone_width=160), 1, 0, ALONE)
    torch.nn.init.zeros_(learner.vit.positions)
    inputs = torch.randn(2, 2, 14, 14, PATCH_INPUT_DIM)
    with torch.no_grad():
        told = learner.heads.patch(learner.vit(inputs).patches)[..., :2]
    torch.testing.assert_close(told, inputs[..., ALIGNED_AT : ALIGNED_AT + 2], atol=1e-3, rtol=1e-3)
