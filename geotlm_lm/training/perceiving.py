"""Simulated examples as a frozen backbone and its geometry perceive them."""

from __future__ import annotations

import torch

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.backbone.vit import ENCODE_BATCH, FrozenBackbone
from geotlm_lm.core.progress import Progress, silent
from geotlm_lm.model import GeoTLM
from geotlm_lm.motion.measured import Measured, measured
from geotlm_lm.training.examples import Examples
from geotlm_lm.training.geometry import ALL_MOTIONS, TokenSet
from geotlm_lm.training.motion_loss import counts_motion
from geotlm_lm.training.scoring import ClipSet


def perceive_examples(model: GeoTLM, examples: Examples, progress: Progress = silent) -> ClipSet:
    """Return tokens, contact share and what is measured of every example."""
    fused, plain, contact, found = [], [], [], []
    for start in range(0, len(examples), ENCODE_BATCH):
        inputs = torch.from_numpy(examples.inputs[start : start + ENCODE_BATCH])
        perception = model.fuse(model.backbone.encode_inputs(inputs))
        fused.append(perception.fused_token)
        plain.append(perception.global_token)
        contact.append(perception.geometry.region_mass[:, -1])
        motions = torch.from_numpy(examples.motions[start : start + ENCODE_BATCH])
        found.append(measured(inputs, motions, perception.geometry, perception.fused_token))
        progress("perceive", min(start + ENCODE_BATCH, len(examples)), len(examples))
    return ClipSet(
        fused_tokens=torch.cat(fused),
        global_tokens=torch.cat(plain),
        contact_share=torch.cat(contact).numpy(),
        measured=Measured.joined(found),
        labels=examples.labels,
        objects=examples.objects,
    )


def token_set(
    backbone: FrozenBackbone, examples: Examples, count: int, progress: Progress
) -> TokenSet:
    """Encode the first `count` examples; tokens stay in half precision to fit in memory."""
    count = min(count, len(examples))
    parts = []
    for start in range(0, count, ENCODE_BATCH):
        rows = slice(start, min(start + ENCODE_BATCH, count))
        tokens = backbone.encode_inputs(torch.from_numpy(examples.inputs[rows]))
        parts.append((tokens.global_token, tokens.patches.half()))
        progress("encode", rows.stop, count)
    displacement = torch.from_numpy(examples.displacement_px[:count])
    labels = examples.labels[:count]
    return TokenSet(
        tokens=Tokens(*(torch.cat(column) for column in zip(*parts, strict=True))),
        shear_change=displacement[:, 1] - displacement[:, 0],
        contact=torch.from_numpy(examples.contact[:count]).float().mean(dim=1),
        motions=torch.tensor([ALL_MOTIONS.index(label.motion) for label in labels]),
        is_readable=torch.tensor([label.is_readable for label in labels]),
        counts_motion=torch.tensor([counts_motion(label) for label in labels]),
    )
