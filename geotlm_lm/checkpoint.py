"""A model bundle on disk: perception, language model, calibration and model card in one folder.

All is stored in half precision (the shipped bundle must stay small) and used in float32; the
language model's folder is one that transformers reads. Anything that is not recognised is refused.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.torch import load_file, save
from torch import Tensor

from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.backbone.vit import FrozenBackbone, ViT, ViTConfig
from geotlm_lm.backbone.weights import without_prefix
from geotlm_lm.core.errors import IncompatibleBundle, first_line
from geotlm_lm.core.files import replacing, resource_dir, write_text_atomically
from geotlm_lm.core.labels import Motion
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.model import GeoTLM
from geotlm_lm.motion.belief import BELIEF_NUMBERS, Belief
from geotlm_lm.motion.network import MotionNetwork
from geotlm_lm.probe.linear import LinearProbe
from geotlm_lm.probe.standardise import Standardiser
from geotlm_lm.query.reader import Reader
from geotlm_lm.query.speaker import Speaker

BUNDLE_FORMAT = 13
CONFIG_FILE = "config.json"
PERCEPTION_FILE = "perception.safetensors"
LANGUAGE_DIR = "language"
CARD_FILE = "README.md"


@dataclass(frozen=True)
class Calibration:
    """Numbers fitted on held-out simulated objects after training.

    Args:
        felt_temperature: Divides the log-likelihoods of the words at the language model's slots
            before they become probabilities.
        contact_threshold: Mean contact mask below which no direction is claimed.
    """

    felt_temperature: float = 1.0
    contact_threshold: float = 0.0

    def slot_probabilities(
        self, log_likelihoods: NDArray[np.floating], *, doubt: float = 1.0
    ) -> NDArray[np.float64]:
        """Return probabilities of the words at a slot from their log-likelihoods, (..., words).

        Args:
            log_likelihoods: As the language model gives them.
            doubt: Multiplies the temperature, where a clip tells less than those it was fitted on.
        """
        scaled = np.asarray(log_likelihoods, dtype=np.float64) / (self.felt_temperature * doubt)
        likelihoods = np.exp(scaled - scaled.max(axis=-1, keepdims=True))
        return likelihoods / likelihoods.sum(axis=-1, keepdims=True)


@dataclass(eq=False)
class Bundle:
    """A whole model: what the sensor shows, how it moved, what is said, and how surely."""

    model: GeoTLM
    motion: MotionNetwork
    calibration: Calibration
    provenance: dict[str, Any]
    reader: Reader

    @cached_property
    def speaker(self) -> Speaker:
        """The language model as it speaks of clips itself; it reads questions by `reader`."""
        return Speaker(self.reader.decoder, self.reader.spelling)

    def digest(self) -> str:
        """Return twelve hex digits of the weights and the calibration, for run records."""
        digest = hashlib.sha256(repr(self.calibration).encode())
        decoder = self.reader.decoder
        language = {"language": decoder.stored, "projector": decoder.projector}
        for part, state in (_perception_states(self) | language).items():
            for name, value in state.items():
                digest.update(f"{part}.{name}".encode())
                digest.update(_bytes_of(value))
        return digest.hexdigest()[:12]


def reading_of(fused_tokens: Tensor, beliefs: Iterable[Belief]) -> Tensor:
    """Return what the language model reads of b clips: z, then what is believed, (b, width)."""
    believed = torch.from_numpy(np.stack([belief.vector() for belief in beliefs])).float()
    return torch.cat([fused_tokens.float(), believed], dim=1)


def _bytes_of(value: Any) -> bytes:
    """Return the bytes of one entry of a state, whatever its number format."""
    if isinstance(value, tuple):  # the weight and the bias of a layer in 8 bits
        return b"".join(map(_bytes_of, value))
    if isinstance(value, np.ndarray):
        return value.tobytes()
    if not isinstance(value, torch.Tensor):
        return repr(value).encode()
    plain = value.dequantize() if value.is_quantized else value.detach()
    return plain.cpu().contiguous().reshape(-1).view(torch.uint8).numpy().tobytes()


def embedded_bundle_dir() -> Path:
    """Return the folder of the bundle that ships with the package.

    Raises:
        IncompatibleBundle: If the installation has none.
    """
    try:
        return resource_dir("bundle")
    except FileNotFoundError as error:
        raise IncompatibleBundle(
            "this installation has no model bundle; install geotlm-lm again, or give the folder "
            "that `geotlm-lm train` wrote by --model."
        ) from error


def embedded_reader() -> Reader:
    """Return what reads questions in the bundle that ships with the package.

    Raises:
        IncompatibleBundle: If the installation has none.
    """
    return Reader.load(embedded_bundle_dir() / LANGUAGE_DIR)


def save_bundle(folder: Path, bundle: Bundle) -> None:
    """Write `bundle`; the configuration goes last, so that a half-written folder does not load."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / CONFIG_FILE).unlink(missing_ok=True)
    model = bundle.model
    tensors = {
        f"{part}.{name}": value.detach().cpu()
        for part, state in _perception_states(bundle).items()
        for name, value in state.items()
    }
    stored = {name: value.half().contiguous() for name, value in tensors.items()}
    with replacing(folder / PERCEPTION_FILE) as stream:
        stream.write(save(stored, metadata={"format": str(BUNDLE_FORMAT)}))
    bundle.reader.save(folder / LANGUAGE_DIR)
    config = {
        "format": BUNDLE_FORMAT,
        "backbone": asdict(model.backbone.vit.config),
        "probe_labels": [label.value for label in model.probe.labels],
        "calibration": asdict(bundle.calibration),
        "provenance": bundle.provenance,
    }
    write_text_atomically(folder / CONFIG_FILE, json.dumps(config, indent=1) + "\n")


def load_bundle(folder: Path | None = None) -> Bundle:
    """Load a bundle; the embedded one when `folder` is None.

    Raises:
        IncompatibleBundle: If the folder is missing, incomplete, or of another format.
    """
    folder = folder or embedded_bundle_dir()
    config = read_config(folder)
    try:
        tensors = load_file(folder / PERCEPTION_FILE)
        wide = {name: value.float() for name, value in tensors.items()}
        model, motion = _assemble(config, wide)
        calibration, provenance = Calibration(**config["calibration"]), config["provenance"]
    except (OSError, SafetensorError, KeyError, TypeError, RuntimeError, ValueError) as error:
        raise IncompatibleBundle(
            f"{folder}: {PERCEPTION_FILE} does not fit {CONFIG_FILE} ({first_line(error)}); train "
            f"or copy the bundle again."
        ) from error
    reader = Reader.load(folder / LANGUAGE_DIR)
    width = model.backbone.width + BELIEF_NUMBERS
    if reader.decoder.clip_width != width:
        raise IncompatibleBundle(
            f"{folder}: {LANGUAGE_DIR} reads {reader.decoder.clip_width} numbers of a clip, "
            f"{PERCEPTION_FILE} gives {width}; copy the bundle again."
        )
    return Bundle(model, motion, calibration, provenance, reader)


def read_config(folder: Path) -> dict[str, Any]:
    """Read and check a bundle's configuration.

    Raises:
        IncompatibleBundle: If it is missing, no JSON, or of another format.
    """
    path = folder / CONFIG_FILE
    try:
        config = json.loads(path.read_text())
    except OSError as error:
        raise IncompatibleBundle(
            f"{folder}: found no model bundle there (no {CONFIG_FILE}); give the folder that "
            f"`geotlm-lm train` wrote."
        ) from error
    except ValueError as error:
        raise IncompatibleBundle(
            f"{path}: is not JSON ({error}); copy the bundle again."
        ) from error
    bundle_format = config.get("format") if isinstance(config, dict) else None
    if bundle_format != BUNDLE_FORMAT:
        raise IncompatibleBundle(
            f"{folder}: the bundle has format {bundle_format}, this version reads "
            f"{BUNDLE_FORMAT}; train it again or install the matching geotlm-lm."
        )
    return config


def _perception_states(bundle: Bundle) -> dict[str, dict[str, Tensor]]:
    model = bundle.model
    return {
        "vit": model.backbone.state_dict(),
        "global_standardiser": model.global_standardiser.state(),
        "patch_standardiser": model.patch_standardiser.state(),
        "dgr": model.dgr.state_dict(),
        "probe": model.probe.state_dict(),
        "global_probe": model.global_probe.state_dict(),
        "motion": bundle.motion.state_dict(),
    }


def _assemble(config: dict[str, Any], tensors: dict[str, Tensor]) -> tuple[GeoTLM, MotionNetwork]:
    vit_config = ViTConfig(**config["backbone"])
    if vit_config.input_dim != PATCH_INPUT_DIM:
        raise ValueError(
            f"patch inputs have {vit_config.input_dim} numbers, this version's {PATCH_INPUT_DIM}"
        )
    labels = [Motion(name) for name in config["probe_labels"]]
    width = vit_config.width
    with torch.device("meta"):
        modules = {
            "vit": ViT(vit_config),
            "dgr": DGR(width),
            "probe": LinearProbe(width, labels),
            "global_probe": LinearProbe(width, labels),
            "motion": MotionNetwork(len(tensors["motion.mean"])),
        }
    standardisers = ("global_standardiser", "patch_standardiser")
    strangers = {name.partition(".")[0] for name in tensors} - {*modules, *standardisers}
    if strangers:
        raise ValueError(f"unknown parts {sorted(strangers)}")
    state = {part: without_prefix(tensors, f"{part}.") for part in (*modules, *standardisers)}
    for name, module in modules.items():
        module.load_state_dict(state[name], assign=True)
        module.requires_grad_(False).eval()
    model = GeoTLM(
        backbone=FrozenBackbone(modules["vit"]),
        global_standardiser=Standardiser.from_state(state["global_standardiser"]),
        patch_standardiser=Standardiser.from_state(state["patch_standardiser"]),
        dgr=modules["dgr"],
        probe=modules["probe"],
        global_probe=modules["global_probe"],
    )
    return model, modules["motion"]
