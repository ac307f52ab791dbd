"""Small checkpoints of released encoders beside the outputs of their authors' own modules.

They lie in ../shared/oracles, one folder per encoder; GEOTLM_ORACLES names further sets in the same
layout, as a path variable does. Sizes are read from each config.json, inputs and outputs from each
io.safetensors.
"""

import json
import os
from dataclasses import dataclass
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file

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
