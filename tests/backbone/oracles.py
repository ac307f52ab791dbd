"""Small checkpoints of released encoders beside the outputs of their authors' own modules.

They lie in ../shared/oracles, one folder per encoder; sizes are read from each config.json.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file

from geotlm_lm.backbone.released import load_encoder

ORACLES = Path(__file__).resolve().parents[3] / "shared" / "oracles"

FLOAT32_TOLERANCE, FLOAT64_TOLERANCE = 1e-5, 1e-9


@dataclass
class Oracle:
    """One folder: configuration, inputs, reference outputs and the checkpoint's files."""

    name: str

    def __post_init__(self):
        self.folder = ORACLES / self.name
        if not self.folder.is_dir():
            pytest.skip(f"needs the reference checkpoints of ../shared/oracles/{self.name}")
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
        """Return the relative error of a whole tensor."""
        expected = self.stored[f"out.{name}"]
        assert found.shape == expected.shape, name
        return float((found.double() - expected).norm() / expected.norm())


def check(oracle, outputs, tolerance, **looser):
    """Hold every output to its tolerance, and leave none of the stored ones out."""
    stored = {name.removeprefix("out.") for name in oracle.stored if name.startswith("out.")}
    assert stored == set(outputs)
    errors = {name: oracle.error(found, name) for name, found in outputs.items()}
    too_large = {n: e for n, e in errors.items() if not e < looser.get(n, tolerance)}
    assert not too_large
