"""The same model in another number format: half, bfloat16, double, or 8-bit weights.

Inputs and outputs of each part stay as they are, so that the parts can be mixed. Copies: the bundle
handed in is left alone.
"""

from __future__ import annotations

import copy
import warnings
from dataclasses import replace
from types import MethodType

import torch
from torch import Tensor, nn

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.vit import FrozenBackbone
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.number_formats import INT8, require_offered
from geotlm_lm.language.generation import Speaker
from geotlm_lm.probe.standardise import Standardiser

FLOATS = {
    "float64": torch.float64,
    "float32": torch.float32,
    "float16": torch.float16,
    "bfloat16": torch.bfloat16,
}
PRECISIONS = (*FLOATS, INT8)
"""`int8` keeps the linear layers' weights in 8 bits and quantises their inputs as they come. What
the language model writes of one clip is computed in float32 from weights that were rounded so."""

BACKBONE, GEOMETRY, LANGUAGE = "backbone", "geometry", "language"
PARTS = (BACKBONE, GEOMETRY, LANGUAGE)


class CastViT(nn.Module):
    """A backbone that computes in one precision between a float32 input and `result` tokens."""

    def __init__(self, vit: nn.Module, dtype: torch.dtype, result: torch.dtype) -> None:
        super().__init__()
        self.vit, self.dtype, self.result = vit, dtype, result
        self.config, self.global_token = vit.config, vit.global_token

    def forward(self, patch_inputs: Tensor) -> Tokens:
        """Return the tokens of patch inputs (b, 2, gh, gw, dim)."""
        tokens = self.vit(patch_inputs.to(self.dtype))
        return Tokens(tokens.global_token.to(self.result), tokens.patches.to(self.result))


class CastInput(nn.Module):
    """A layer that is handed another precision than it computes in."""

    def __init__(self, layer: nn.Module, dtype: torch.dtype) -> None:
        super().__init__()
        self.layer, self.dtype = layer, dtype

    def forward(self, values: Tensor) -> Tensor:
        """Return what the layer makes of the values."""
        return self.layer(values.to(self.dtype))


def in_precision(bundle: Bundle, precision: str, parts: tuple[str, ...] = PARTS) -> Bundle:
    """Return a copy of `bundle` with `parts` in another precision.

    Args:
        bundle: In float32.
        precision: One of `PRECISIONS`.
        parts: Any of `PARTS`; `geometry` is standardisation, DGR and the probes, which 8-bit
            weights leave alone: they hold one layer of 14 numbers and one of 10.

    Raises:
        ValueError: If the precision or a part is unknown.
    """
    if precision not in PRECISIONS or not set(parts) <= set(PARTS):
        raise ValueError(f"found {precision} of {parts}, expected {PRECISIONS} of {PARTS}")
    changed = replace(bundle, model=copy.copy(bundle.model))
    if BACKBONE in parts:
        wide = FLOATS.get(precision, torch.float32) if GEOMETRY in parts else torch.float32
        changed.model.backbone = _backbone(bundle, precision, wide)
    if GEOMETRY in parts and precision in FLOATS:
        _cast_geometry(changed, bundle, FLOATS[precision])
    if LANGUAGE in parts:
        changed.speaker = _speaker(bundle.speaker, precision)
    return changed


def in_offered_format(bundle: Bundle, precision: str) -> Bundle:
    """Return `bundle` the way a user wants it run; itself in float32.

    Args:
        bundle: With the embedded backbone.
        precision: A number format.

    Raises:
        UsageError: If the format is none of `OFFERED`, or this machine cannot run it.
    """
    require_offered(precision)
    if precision == "float32":
        return bundle
    changed = if_runnable(bundle, precision)
    if changed is None:
        raise UsageError(f"this processor or this torch cannot run {precision}; take float32.")
    return changed


def if_runnable(bundle: Bundle, precision: str) -> Bundle | None:
    """Return `bundle` with backbone and language model changed; None where it cannot run here.

    Tokens, pooling and the 14 numbers stay in float32: what is drawn and graded is read from them.
    """
    try:
        changed = in_precision(bundle, precision, (BACKBONE, LANGUAGE))
        backbone = changed.model.backbone
        side, width = backbone.vit.config.grid_side, backbone.vit.config.input_dim
        backbone.encode_inputs(torch.zeros(1, 2, side, side, width))
    except RuntimeError:  # no engine packs the weights, or no kernel takes the format
        return None
    return changed


def _backbone(bundle: Bundle, precision: str, result: torch.dtype) -> FrozenBackbone:
    vit = copy.deepcopy(bundle.model.backbone.vit)
    if precision == INT8:
        return FrozenBackbone(_quantised(vit))
    return FrozenBackbone(CastViT(vit.to(FLOATS[precision]), FLOATS[precision], result))


def _cast_geometry(changed: Bundle, bundle: Bundle, dtype: torch.dtype) -> None:
    model = bundle.model
    for name in ("global_standardiser", "patch_standardiser"):
        own: Standardiser = getattr(model, name)
        setattr(changed.model, name, Standardiser(own.mean.to(dtype), own.scale.to(dtype)))
    for name in ("dgr", "probe", "global_probe"):
        layer = CastInput(copy.deepcopy(getattr(model, name)).to(dtype), dtype)
        setattr(changed.model, name, layer if name == "dgr" else _probe(layer))


def _probe(layer: CastInput) -> nn.Module:
    probe = layer.layer
    probe.head = CastInput(probe.head, layer.dtype)
    return probe


def _speaker(speaker: Speaker, precision: str) -> Speaker:
    model = copy.deepcopy(speaker.model)
    if precision == INT8:
        model = _quantised(model)
    else:
        model = model.to(FLOATS[precision])
        model.model.projector = CastInput(model.projector, FLOATS[precision])
    model.logits = MethodType(_wide_logits, model)
    return Speaker(model, speaker.prompts)


def _wide_logits(model: nn.Module, hidden: Tensor) -> Tensor:
    """Return logits in float32 or better: their normalisation sums over the whole vocabulary."""
    logits = type(model).logits(model, hidden)
    return logits if logits.dtype == torch.float64 else logits.float()


def _quantised(module: nn.Module) -> nn.Module:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # its successor is a package of its own
        return torch.ao.quantization.quantize_dynamic(module, {nn.Linear}, dtype=torch.qint8)
