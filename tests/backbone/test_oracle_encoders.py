"""Expected values: outputs of the encoders' own public code on small random weights.

Checkpoints lie beside these outputs in ../shared/oracles, one folder per encoder; GEOTLM_ORACLES
names further sets in the same layout, as a path variable does. Sizes are read from each
config.json, inputs and outputs from each io.safetensors.
"""

import json
import os
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file

from geotlm_lm.backbone.encoder_modules import sinusoids
from geotlm_lm.backbone.encoders import GELSIGHT_MINI
from geotlm_lm.backbone.released import load_encoder

FLOAT32_TOLERANCE, FLOAT64_TOLERANCE = 1e-5, 1e-9


def oracle_sets():
    further = os.environ.get("GEOTLM_ORACLES", "").split(os.pathsep)
    shared = Path(__file__).resolve().parents[3] / "shared" / "oracles"
    return [shared, *(Path(folder) for folder in further if folder)]


@dataclass
class Oracle:
    """One folder: configuration, inputs, reference outputs and the checkpoint's files."""

    parent: Path
    name: str

    def __post_init__(self):
        self.folder = self.parent / self.name
        if not self.folder.is_dir():
            pytest.skip(f"needs the reference checkpoints in {self.folder}")
        self.config = json.loads((self.folder / "config.json").read_text())
        self.stored = load_file(self.folder / "io.safetensors")

    @property
    def paths(self):
        named = self.config["checkpoint"]
        return [self.folder / one for one in ([named] if isinstance(named, str) else named)]

    def load(self, path=None, name=None, **options):
        options = {
            "heads": self.config.get("heads"),
            "image": tuple(self.config["image"]),
        } | options
        return load_encoder(path or self.paths[0], name, **options)

    def inputs(self, name, dtype=torch.float64):
        value = self.stored[f"in.{name}"]
        return value.to(dtype) if value.is_floating_point() else value

    def error(self, found, name):
        return relative_error(found, self.stored[f"out.{name}"], name)


def relative_error(found, expected, name=""):
    """Return norm(found - expected) / norm(expected) of tensors that hold something."""
    assert found.shape == expected.shape, name
    assert expected.numel() > 0, name
    assert float(expected.norm()) > 0, name
    return float((found.double() - expected).norm() / expected.norm())


def check(oracle, outputs, tolerance, **looser):
    """Hold every output to its tolerance, and leave none of the stored ones out."""
    stored = {name.removeprefix("out.") for name in oracle.stored if name.startswith("out.")}
    assert stored
    assert stored == set(outputs)
    errors = {name: oracle.error(found, name) for name, found in outputs.items()}
    too_large = {n: e for n, e in errors.items() if not e < looser.get(n, tolerance)}
    assert not too_large


@pytest.fixture(params=oracle_sets(), ids=str)
def oracles(request):
    """Return what loads one encoder's folder by name, from each set in turn."""
    return partial(Oracle, request.param)


def anytouch2(module, oracle, dtype):
    def tokens(clip, sensor):
        return module(clip.transpose(1, 2), sensor)

    clip, still = oracle.inputs("clip", dtype), oracle.inputs("still", dtype)
    all_tokens = tokens(clip, oracle.inputs("sensor"))
    repeated = still[:, None].expand(-1, oracle.config["frames"], -1, -1, -1)
    return clip_outputs(module, all_tokens) | {
        "tokens_projected": module.projection(module.normed(all_tokens)),
        "still_tokens": tokens(repeated, oracle.inputs("still_sensor")),
    }


def anytouch1(module, oracle, dtype):
    all_tokens = module(oracle.inputs("clip", dtype), oracle.inputs("sensor"))
    still = oracle.inputs("still", dtype)[:, None].expand(-1, oracle.config["frames"], -1, -1, -1)
    still_tokens = module(still, oracle.inputs("still_sensor"))
    lead = module.config.lead
    return clip_outputs(module, all_tokens) | {
        "still_tokens": still_tokens,
        "still_global_projected": module.projection(module.normed(still_tokens[:, 0])),
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
        "global_projected": module.projection(module.normed(tokens[:, 0])),
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
@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])
def test_oracle_outputs_are_met(oracles, name, dtype):
    oracle = oracles(name)
    outputs = OUTPUTS[name](oracle.load().module.to(dtype), oracle, dtype)
    if dtype == torch.float32:
        check(oracle, outputs, FLOAT32_TOLERANCE)
    else:
        check(oracle, outputs, FLOAT64_TOLERANCE, **LOOSER.get(name, {}))


def test_oracle_weights_of_both_sparsh_containers_are_equal(oracles):
    oracle = oracles("sparsh")
    first, second = (oracle.load(path).module.state_dict() for path in oracle.paths)
    assert first.keys() == second.keys()
    assert all(torch.equal(first[name], second[name]) for name in first)


def test_oracle_tokens_of_the_seam_are_the_reference_of_anytouch2(oracles):
    oracle = oracles("anytouch2")
    encoder = oracle.load()
    module = encoder.module.double()
    sensor_tokens = module.sensor_tokens.clone()
    # The adapter reads all clips as GelSight Mini's: its row gets the tokens of each clip's sensor.
    for index, sensor in enumerate(oracle.inputs("sensor")):
        module.sensor_tokens[GELSIGHT_MINI] = sensor_tokens[sensor]
        tokens = encoder.row.tokens(module, oracle.inputs("clip")[index : index + 1])
        for found, name in ((tokens.global_token, "global"), (tokens.patches, "patch_grid")):
            expected = oracle.stored[f"out.{name}"][index : index + 1]
            assert relative_error(found, expected, name) < FLOAT64_TOLERANCE


def test_oracle_tokens_of_the_seam_are_early_first_and_upright_for_sparsh(oracles):
    oracle = oracles("sparsh")
    encoder = oracle.load()
    tokens = encoder.row.tokens(encoder.module.double(), oracle.inputs("clip"))
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
    tokens = encoder.row.tokens(encoder.module.double(), torch.stack([a, b, b, b])[None])
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
    tokens = encoder.row.tokens(module, torch.stack([a, a, b, b])[None])
    early, late = (
        module(torch.stack([frame] * 3)[None], torch.tensor([GELSIGHT_MINI])) for frame in (a, b)
    )
    torch.testing.assert_close(tokens.patches[:, 0], module.patch_grid(early)[:, 0])
    torch.testing.assert_close(tokens.patches[:, 1], module.patch_grid(late)[:, 0])
    torch.testing.assert_close(tokens.global_token, (early[:, 0] + late[:, 0]) / 2)
