"""Expected values: laws that tie a part to a plainer one, and closed forms of positions."""

from dataclasses import replace

import torch

from geotlm_lm.backbone.image_vit import ImageViT, ImageViTConfig

CONFIG = ImageViTConfig(
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


def vit(**changes):
    generator = torch.Generator().manual_seed(0)
    module = ImageViT(replace(CONFIG, **changes)).double().requires_grad_(False)
    for parameter in module.parameters():
        parameter.normal_(0, 0.5, generator=generator)
    return module


def clips(count=2):
    generator = torch.Generator().manual_seed(1)
    return torch.randn(count, 3, 4, 12, 20, generator=generator, dtype=torch.float64)


def test_tokens_come_in_the_order_global_sensor_registers_patches():
    module, pixels = vit(pre_norm_eps=None), clips()
    tokens = module.embed(pixels, SENSORS)
    assert tokens.shape == (2, 1 + 5 + 2 + 24, 24)
    torch.testing.assert_close(tokens[0, 0], module.global_token + module.positions[0])
    torch.testing.assert_close(tokens[0, 1:6], module.sensor_tokens[2])
    torch.testing.assert_close(tokens[1, 1:6], module.sensor_tokens[6])
    torch.testing.assert_close(tokens[1, 6:8], module.registers)


def test_each_pixel_lands_in_its_own_token_time_slowest():
    module, pixels = vit(), clips(1)
    changed = pixels.clone()
    changed[0, 1, 3, 5, 13] += 1  # frames 2-3, rows 4-7, columns 10-14
    before, after = (module.patch_grid(module.embed(p, SENSORS[:1])) for p in (pixels, changed))
    assert (after - before).abs().sum(-1).nonzero().tolist() == [[0, 1, 1, 2]]


def test_layer_scale_is_a_gain_that_can_be_folded_into_the_layers_before_it():
    scaled, pixels = vit(has_layer_scale=True), clips()
    plain = vit()
    plain.load_state_dict(scaled.state_dict(), strict=False)
    for block, source in zip(plain.blocks, scaled.blocks, strict=True):
        for layer, gain in ((block.proj, source.gain1), (block.fc2, source.gain2)):
            layer.weight *= gain[:, None]
            layer.bias *= gain
    torch.testing.assert_close(plain(pixels, SENSORS), scaled(pixels, SENSORS))
