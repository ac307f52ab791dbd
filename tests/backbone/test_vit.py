"""Expected values: token order by perturbation, and a block written out with plain matrices."""

import torch

from geotlm_lm.backbone.vit import NORM_EPS, Block, ViT, ViTConfig

CONFIG = ViTConfig(input_dim=7, width=24, depth=2, heads=3, grid_side=5)


def vit():
    return ViT(CONFIG).initialise(torch.Generator().manual_seed(0)).double()


def test_a_block_equals_its_formula_written_out():
    generator = torch.Generator().manual_seed(1)
    block = Block(CONFIG).double()
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
