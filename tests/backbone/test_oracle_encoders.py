"""Expected values: outputs of the encoders' own public code on small random weights.

What one wrong detail costs is held as well: a reference that could not see it would prove nothing.
"""

from dataclasses import replace

import pytest
import torch

from geotlm_lm.backbone import conv_encoder
from geotlm_lm.backbone.adapters.anytouch import GELSIGHT_MINI
from geotlm_lm.backbone.image_vit import sinusoids
from tests.backbone.oracles import FLOAT32_TOLERANCE, FLOAT64_TOLERANCE, check, relative_error


def anytouch2(module, oracle, dtype):
    def tokens(clip, sensor):
        return module(clip.transpose(1, 2), sensor)

    clip, still = oracle.inputs("clip", dtype), oracle.inputs("still", dtype)
    all_tokens = tokens(clip, oracle.inputs("sensor"))
    repeated = still[:, None].expand(-1, oracle.config["frames"], -1, -1, -1)
    return clip_outputs(module, all_tokens) | {
        "tokens_projected": module.projected(all_tokens),
        "still_tokens": tokens(repeated, oracle.inputs("still_sensor")),
    }


def anytouch1(module, oracle, dtype):
    all_tokens = module(oracle.inputs("clip", dtype), oracle.inputs("sensor"))
    still = oracle.inputs("still", dtype)[:, None].expand(-1, oracle.config["frames"], -1, -1, -1)
    still_tokens = module(still, oracle.inputs("still_sensor"))
    lead = module.config.lead
    return clip_outputs(module, all_tokens) | {
        "still_tokens": still_tokens,
        "still_global_projected": module.projected(still_tokens[:, 0]),
        "still_patch_mean_projected": module.projection(still_tokens[:, lead:]).mean(dim=1),
    }


def clip_outputs(module, tokens):
    lead = module.config.lead
    return {
        "tokens": tokens,
        "global": tokens[:, 0],
        "sensor_tokens": tokens[:, 1:lead],
        "patch_grid": module.patch_grid(tokens),
        "global_post_norm": module.normed(tokens[:, 0]),
        "global_projected": module.projected(tokens[:, 0]),
    }


def sparsh(module, oracle, dtype):
    before = module(oracle.inputs("clip", dtype))
    tokens, lead = module.normed(before), module.config.lead
    return {
        "tokens": tokens,
        "register": tokens[:, :lead],
        "patch_tokens": tokens[:, lead:],
        "patch_grid": module.patch_grid(tokens),
        "patch_mean": tokens[:, lead:].mean(dim=1),
        "tokens_before_final_norm": before,
        "positions": sinusoids(module.config.grid, module.config.width),
    }


def internvit(module, oracle, dtype):
    tokens = module(oracle.inputs("image", dtype))
    other = module(oracle.inputs("other_size_image", dtype))
    other_grid = (1, *oracle.config["other_size_grid"])
    return {
        "tokens": tokens,
        "global": tokens[:, 0],
        "patch_grid": module.patch_grid(tokens)[:, 0],
        "other_size_tokens": other,
        "other_size_patch_grid": module.patch_grid(other, other_grid)[:, 0],
    }


def t3(module, oracle, dtype):
    image = oracle.inputs("image", dtype)
    encoded = module.embed(image)
    for block in module.blocks[: oracle.config["encoder_depth"]]:
        encoded = block(encoded)
    before = module(image)
    tokens = module.normed(before)
    return {
        "encoder_tokens": encoded,
        "tokens": tokens,
        "global": tokens[:, 0],
        "patch_grid": module.patch_grid(tokens)[:, 0],
        "patch_mean_without_norm": before[:, 1:].mean(dim=1),
    }


def unit(module, oracle, dtype):
    image = oracle.inputs("image", dtype)
    latent = module(image)
    return {
        "latent": latent,
        "latent_flat": latent.flatten(1),
        "before_quant_conv": module.encoder(image),
    }


OUTPUTS = {f.__name__: f for f in (anytouch2, anytouch1, sparsh, t3, internvit, unit)}

LOOSER = {
    # The authors compute positions in float32.
    "sparsh": dict.fromkeys(
        ("tokens", "register", "patch_tokens", "patch_grid", "patch_mean")
        + ("tokens_before_final_norm", "positions"),
        1e-7,
    ),
    "internvit": {"other_size_tokens": 3e-7, "other_size_patch_grid": 3e-7},
}


@pytest.mark.parametrize("name", OUTPUTS)
def test_oracle_outputs_are_met_in_float64(oracles, name):
    oracle = oracles(name)
    module = oracle.load().module.double()
    outputs = OUTPUTS[name](module, oracle, torch.float64)
    check(oracle, outputs, FLOAT64_TOLERANCE, **LOOSER.get(name, {}))


@pytest.mark.parametrize("name", OUTPUTS)
def test_oracle_outputs_are_met_in_float32(oracles, name):
    oracle = oracles(name)
    module = oracle.load().module
    check(oracle, OUTPUTS[name](module, oracle, torch.float32), FLOAT32_TOLERANCE)


def test_oracle_weights_of_both_sparsh_containers_are_equal(oracles):
    oracle = oracles("sparsh")
    first, second = (oracle.load(path).module.state_dict() for path in oracle.paths)
    assert first.keys() == second.keys()
    assert all(torch.equal(first[name], second[name]) for name in first)


def reconfigured(module, **changes):
    """Return the same weights under a changed configuration."""
    twin = type(module)(replace(module.config, **changes)).double()
    twin.load_state_dict(module.state_dict())
    return twin.requires_grad_(False)


def main_output(name, module, oracle):
    outputs = OUTPUTS[name](module, oracle, torch.float64)
    main = "latent" if name == "unit" else "tokens"
    return oracle.error(outputs[main], main)


SEEN_IN_FLOAT32 = 10 * FLOAT32_TOLERANCE
"""Error by which a wrong detail is seen in either precision, whatever a set's weights are."""


def seen(name):
    """Return the error of the main output from which on a wrong detail is seen in float64."""
    return LOOSER.get(name, {}).get("tokens", FLOAT64_TOLERANCE)


def other_heads(heads):
    """Return another number of heads that divides the same width."""
    return heads // 2 if heads % 2 == 0 else 1 if heads > 1 else 2


WRONG_EPS = {"anytouch2": 1e-6, "anytouch1": 1e-6, "sparsh": 1e-5, "internvit": 1e-5}


@pytest.mark.parametrize("name", WRONG_EPS)
def test_oracle_sees_a_wrong_epsilon(oracles, name):
    oracle = oracles(name)
    module = oracle.load().module.double()
    wrong = reconfigured(module, block_eps=(WRONG_EPS[name],) * len(module.blocks))
    assert main_output(name, wrong, oracle) > seen(name)


@pytest.mark.parametrize("part", ["encoder", "trunk"])
def test_oracle_sees_the_epsilon_of_t3s_other_part(oracles, part):
    oracle = oracles("t3")
    module = oracle.load().module.double()
    eps = {"encoder": (1e-5,), "trunk": (1e-6,)}[part] * len(module.blocks)
    assert main_output("t3", reconfigured(module, block_eps=eps), oracle) > seen("t3")


@pytest.mark.parametrize("name", ["anytouch2", "anytouch1", "sparsh", "t3", "internvit"])
def test_oracle_sees_a_wrong_number_of_heads(oracles, name):
    oracle = oracles(name)
    module = oracle.load().module.double()
    wrong = reconfigured(module, heads=other_heads(module.config.heads))
    assert main_output(name, wrong, oracle) > SEEN_IN_FLOAT32


@pytest.mark.parametrize("name", ["sparsh", "internvit"])
def test_oracle_sees_a_missing_layer_scale(oracles, name):
    oracle = oracles(name)
    module = oracle.load().module.double()
    with torch.no_grad():
        for block in module.blocks:
            block.gain1.fill_(1)
            block.gain2.fill_(1)
    assert main_output(name, module, oracle) > SEEN_IN_FLOAT32


@pytest.mark.parametrize("name", ["anytouch2", "anytouch1", "internvit", "t3"])
def test_oracle_sees_swapped_rows_and_columns(oracles, name):
    oracle = oracles(name)
    module = oracle.load().module.double()
    rows, columns = module.config.grid[1:]
    with torch.no_grad():
        own = module.positions[1:].unflatten(0, (-1, rows, columns))
        module.positions[1:] = own.transpose(1, 2).flatten(0, 2)
    assert main_output(name, module, oracle) > SEEN_IN_FLOAT32


def test_oracle_sees_time_reversed_in_anytouch2(oracles):
    oracle = oracles("anytouch2")
    module = oracle.load().module.double()
    oracle.stored["in.clip"] = oracle.stored["in.clip"].flip(1)
    assert main_output("anytouch2", module, oracle) > SEEN_IN_FLOAT32


def test_oracle_sees_time_and_colour_exchanged_in_anytouch1(oracles):
    oracle = oracles("anytouch1")
    module = oracle.load().module.double()
    oracle.stored["in.clip"] = oracle.stored["in.clip"].transpose(1, 2)
    assert main_output("anytouch1", module, oracle) > SEEN_IN_FLOAT32


def test_oracle_sees_a_position_on_the_sensor_tokens(oracles):
    oracle = oracles("anytouch2")
    module = oracle.load().module.double()
    with torch.no_grad():
        module.sensor_tokens += module.positions[0]
    assert main_output("anytouch2", module, oracle) > SEEN_IN_FLOAT32


def test_oracle_sees_positions_in_another_order_of_axes(oracles):
    oracle = oracles("sparsh")
    module = oracle.load().module.double()
    config = module.config
    # A third of the width belongs to each axis: column, time, row in place of time, row, column.
    moved = sinusoids(config.grid, config.width).roll(config.width // 3, 1).double()
    module.positions_for = lambda grid: (moved.new_zeros(1), moved)
    assert main_output("sparsh", module, oracle) > SEEN_IN_FLOAT32


def test_oracle_sees_bilinear_positions_at_another_size(oracles, monkeypatch):
    oracle = oracles("internvit")
    module = oracle.load().module.double()
    resize = torch.nn.functional.interpolate
    monkeypatch.setattr(
        torch.nn.functional, "interpolate", lambda x, **o: resize(x, **o | {"mode": "bilinear"})
    )
    outputs = internvit(module, oracle, torch.float64)
    accepted = LOOSER["internvit"]["other_size_tokens"]
    assert oracle.error(outputs["other_size_tokens"], "other_size_tokens") > accepted
    assert oracle.error(outputs["tokens"], "tokens") < FLOAT64_TOLERANCE


def test_oracle_sees_halving_that_pads_left_and_top(oracles, monkeypatch):
    oracle = oracles("unit")
    module = oracle.load().module.double()
    pad = torch.nn.functional.pad
    monkeypatch.setattr(conv_encoder.F, "pad", lambda x, _: pad(x, (1, 0, 1, 0)))
    assert main_output("unit", module, oracle) > SEEN_IN_FLOAT32


def test_oracle_sees_attention_left_out(oracles):
    oracle = oracles("unit")
    module = oracle.load().module.double()
    module.encoder.down[-1].attn = torch.nn.ModuleList()
    assert main_output("unit", module, oracle) > SEEN_IN_FLOAT32


@pytest.mark.parametrize("eps", [1e-5, 1e-7])
def test_oracle_sees_a_wrong_epsilon_of_the_group_norms(oracles, eps):
    oracle = oracles("unit")
    module = oracle.load().module.double()
    for part in module.modules():
        if isinstance(part, torch.nn.GroupNorm):
            part.eps = eps
    assert main_output("unit", module, oracle) > seen("unit")


def test_oracle_tokens_of_the_seam_are_the_reference_of_anytouch2(oracles):
    oracle = oracles("anytouch2")
    encoder = oracle.load()
    module = encoder.module.double()
    sensor_tokens = module.sensor_tokens.clone()
    # The adapter reads all clips as GelSight Mini's: its row gets the tokens of each clip's sensor.
    for index, sensor in enumerate(oracle.inputs("sensor")):
        module.sensor_tokens[GELSIGHT_MINI] = sensor_tokens[sensor]
        tokens = encoder.adapter.tokens(module, oracle.inputs("clip")[index : index + 1])
        for found, name in ((tokens.global_token, "global"), (tokens.patches, "patch_grid")):
            expected = oracle.stored[f"out.{name}"][index : index + 1]
            assert relative_error(found, expected, name) < FLOAT64_TOLERANCE


def test_oracle_tokens_of_the_seam_are_early_first_and_upright_for_sparsh(oracles):
    oracle = oracles("sparsh")
    encoder = oracle.load()
    tokens = encoder.adapter.tokens(encoder.module.double(), oracle.inputs("clip"))
    assert oracle.error(tokens.global_token, "patch_mean") < 1e-7
    rows, columns = encoder.module.config.grid[1:]
    assert tokens.patches.shape[1:4] == (2, columns, rows)
    # The module sees the newest frames first, and the picture turned clockwise by 90 degrees: its
    # first column is the camera's last row.
    expected = oracle.stored["out.patch_grid"]
    torch.testing.assert_close(tokens.patches[:, 0, -1], expected[:, 1, :, 0], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", ["t3", "internvit", "unit"])
def test_oracle_tokens_of_the_seam_are_means_over_the_frames_of_a_bin(oracles, name):
    oracle = oracles(name)
    encoder = oracle.load()
    images = oracle.inputs("image")
    a, b = images[0], images[-1]  # one and the same in a set of one image
    tokens = encoder.adapter.tokens(encoder.module.double(), torch.stack([a, b, b, b])[None])
    grids = oracle.stored["out.latent"].movedim(1, -1) if name == "unit" else None
    grids = oracle.stored["out.patch_grid"] if grids is None else grids
    flat = oracle.stored["out.latent_flat" if name == "unit" else "out.global"]
    expected = torch.stack([(grids[0] + grids[-1]) / 2, grids[-1]])
    assert relative_error(tokens.patches[0], expected) < FLOAT64_TOLERANCE
    assert relative_error(tokens.global_token[0], (flat[0] + 3 * flat[-1]) / 4) < FLOAT64_TOLERANCE


def test_oracle_tokens_of_the_seam_see_each_bins_own_frames_for_anytouch1(oracles):
    oracle = oracles("anytouch1")
    encoder = oracle.load()
    module = encoder.module.double()
    a, b = oracle.inputs("clip")[0, 0], oracle.inputs("clip")[0, -1]
    tokens = encoder.adapter.tokens(module, torch.stack([a, a, b, b])[None])
    early, late = (
        module(torch.stack([frame] * 3)[None], torch.tensor([GELSIGHT_MINI])) for frame in (a, b)
    )
    torch.testing.assert_close(tokens.patches[:, 0], module.patch_grid(early)[:, 0])
    torch.testing.assert_close(tokens.patches[:, 1], module.patch_grid(late)[:, 0])
    torch.testing.assert_close(tokens.global_token, (early[:, 0] + late[:, 0]) / 2)
