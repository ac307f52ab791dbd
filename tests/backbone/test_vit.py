"""Expected values: token order by perturbation, a block written out with plain matrices, and laws
that tie a part to a plainer one.
"""

from dataclasses import replace

import pytest
import torch
from torch import nn

from geotlm_lm.backbone import vit as engines
from geotlm_lm.backbone.encoder_modules import ImageViT, ImageViTConfig
from geotlm_lm.backbone.vit import NORM_EPS, Block, ViT, ViTConfig, linear

CONFIG = ViTConfig(input_dim=7, width=24, depth=2, heads=3, grid_side=5)


def vit():
    return ViT(CONFIG).initialise(torch.Generator().manual_seed(0)).double()


def test_a_block_equals_its_formula_written_out():
    generator = torch.Generator().manual_seed(1)
    block = Block(24, 3, 96).double()
    for parameter in block.parameters():
        torch.nn.init.normal_(parameter, 0, 0.5, generator=generator)
    x = torch.randn(2, 6, 24, generator=generator, dtype=torch.float64)

    def norm(values, layer):
        centred = values - values.mean(-1, keepdim=True)
        spread = (centred.square().mean(-1, keepdim=True) + NORM_EPS).sqrt()
        return centred / spread * layer.weight + layer.bias

    query, key, value = (norm(x, block.norm1) @ block.qkv.weight.T + block.qkv.bias).chunk(3, -1)
    mixed = torch.empty_like(x)
    for head in range(3):
        part = slice(8 * head, 8 * head + 8)
        weights = (query[..., part] @ key[..., part].mT / 8**0.5).softmax(-1)
        mixed[..., part] = weights @ value[..., part]
    expected = x + mixed @ block.proj.weight.T + block.proj.bias
    hidden = norm(expected, block.norm2) @ block.fc1.weight.T + block.fc1.bias
    hidden = hidden * 0.5 * (1 + torch.erf(hidden / 2**0.5))
    expected = expected + hidden @ block.fc2.weight.T + block.fc2.bias
    torch.testing.assert_close(block(x), expected)


def changes_from_one_input(model):
    """Return how far every patch token goes when an input of the late time-bin changes."""
    model.blocks = torch.nn.ModuleList()  # without attention only the own token may change
    inputs = torch.randn(1, 2, 5, 5, 7, dtype=torch.float64)
    changed = inputs.clone()
    changed[0, 1, 2, 4] += 1
    return (model(changed).patches - model(inputs).patches).abs().sum(-1)


def test_each_patch_input_lands_in_the_tokens_of_its_own_patch():
    model = vit()
    torch.nn.init.normal_(model.split.weight)
    change = changes_from_one_input(model)
    assert change.nonzero().tolist() == [[0, 0, 2, 4], [0, 1, 2, 4]]


def test_time_bins_begin_apart():
    change = changes_from_one_input(vit())
    assert change[0, 1, 2, 4] > 1
    change[0, 1, 2, 4] = 0
    assert change.max() < 1e-5


def test_a_batch_equals_its_clips_one_by_one():
    model, inputs = vit(), torch.randn(3, 2, 5, 5, 7, dtype=torch.float64)
    together = model(inputs)
    for index in range(3):
        alone = model(inputs[index : index + 1])
        torch.testing.assert_close(together.patches[index], alone.patches[0])
        torch.testing.assert_close(together.global_token[index], alone.global_token[0])


def layer(bias=True):
    torch.manual_seed(0)
    return nn.Linear(160, 96, bias=bias)


@pytest.mark.parametrize("bias", [True, False])
def test_the_faster_engine_equals_the_layer_but_for_rounding_and_keeps_gradients(bias):
    plain = layer(bias)
    shapes = [(160,), (7, 160), (3, 202, 160), (0, 160)]
    for values in (*map(torch.randn, shapes), torch.randn(160, 202).T):
        with torch.inference_mode():
            torch.testing.assert_close(linear(plain, values), plain(values), rtol=1e-5, atol=1e-5)
    values = torch.randn(5, 160, requires_grad=True)
    linear(plain, values).sum().backward()
    torch.testing.assert_close(values.grad, plain.weight.sum(dim=0).expand(5, -1))


@pytest.mark.skipif(engines._ONEDNN is None, reason="this torch lacks oneDNN's linear product")
def test_plain_layers_go_through_the_faster_engine(monkeypatch):
    monkeypatch.setattr(nn.Linear, "forward", None)
    with torch.inference_mode():
        assert linear(layer(), torch.randn(5, 160)).shape == (5, 96)


IMAGE_CONFIG = ImageViTConfig(
    width=24,
    heads=3,
    mlp_width=40,
    block_eps=(1e-5, 1e-6),
    patch=(2, 4, 5),
    grid=(2, 3, 4),
    sensor_rows=7,
    sensor_tokens=5,
    registers=2,
    pre_norm_eps=1e-5,
    norm_eps=1e-6,
    projection=11,
)
SENSORS = torch.tensor([2, -1])


def image_vit(**changes):
    generator = torch.Generator().manual_seed(0)
    module = ImageViT(replace(IMAGE_CONFIG, **changes)).double().requires_grad_(False)
    for parameter in module.parameters():
        parameter.normal_(0, 0.5, generator=generator)
    return module


def clips(count=2):
    generator = torch.Generator().manual_seed(1)
    return torch.randn(count, 3, 4, 12, 20, generator=generator, dtype=torch.float64)


def test_tokens_come_in_the_order_global_sensor_registers_patches():
    module, pixels = image_vit(pre_norm_eps=None), clips()
    tokens = module.embed(pixels, SENSORS)
    assert tokens.shape == (2, 1 + 5 + 2 + 24, 24)
    torch.testing.assert_close(tokens[0, 0], module.global_token + module.positions[0])
    torch.testing.assert_close(tokens[0, 1:6], module.sensor_tokens[2])
    torch.testing.assert_close(tokens[1, 1:6], module.sensor_tokens[6])
    torch.testing.assert_close(tokens[1, 6:8], module.registers)


def test_each_pixel_lands_in_its_own_token_time_slowest():
    module, pixels = image_vit(), clips(1)
    changed = pixels.clone()
    changed[0, 1, 3, 5, 13] += 1  # frames 2-3, rows 4-7, columns 10-14
    before, after = (module.patch_grid(module.embed(p, SENSORS[:1])) for p in (pixels, changed))
    assert (after - before).abs().sum(-1).nonzero().tolist() == [[0, 1, 1, 2]]


def test_layer_scale_is_a_gain_that_can_be_folded_into_the_layers_before_it():
    scaled, pixels = image_vit(has_layer_scale=True), clips()
    plain = image_vit()
    plain.load_state_dict(scaled.state_dict(), strict=False)
    for block, source in zip(plain.blocks, scaled.blocks, strict=True):
        for layer, gain in ((block.proj, source.gain1), (block.fc2, source.gain2)):
            layer.weight *= gain[:, None]
            layer.bias *= gain
    torch.testing.assert_close(plain(pixels, SENSORS), scaled(pixels, SENSORS))
