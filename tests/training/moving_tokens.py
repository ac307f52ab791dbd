"""Tokens that carry a known displacement and contact linearly."""

import torch

from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.core.geometry import FLOW_SCALE_PX
from geotlm_lm.core.labels import DIRECTED, Motion
from geotlm_lm.training.geometry import ALL_MOTIONS, TokenSet

SIDE = 6

SHIFTS = {
    Motion.LEFT: lambda x, y: (-torch.ones_like(x), 0 * y),
    Motion.RIGHT: lambda x, y: (torch.ones_like(x), 0 * y),
    Motion.UP: lambda x, y: (0 * x, -torch.ones_like(y)),
    Motion.DOWN: lambda x, y: (0 * x, torch.ones_like(y)),
    Motion.CLOCKWISE: lambda x, y: (-y, x),
    Motion.COUNTERCLOCKWISE: lambda x, y: (y, -x),
}


def token_set(count, seed, width=6, among=DIRECTED):
    """Tokens whose first two numbers are the displacement and whose third is the contact."""
    generator = torch.Generator().manual_seed(seed)
    axis = torch.linspace(-1, 1, SIDE)
    y, x = torch.meshgrid(axis, axis, indexing="ij")
    patches = torch.randn(count, 2, SIDE, SIDE, width, generator=generator)
    change = torch.empty(count, SIDE, SIDE, 2)
    motions = []
    for index in range(count):
        motion = among[index % len(among)]
        change[index] = torch.stack(SHIFTS[motion](x, y), dim=-1)
        motions.append(ALL_MOTIONS.index(motion))
    contact = (torch.rand(count, SIDE, SIDE, generator=generator) > 0.3).float()
    patches[..., :2] *= 0.1
    patches[:, 1, :, :, :2] += change * contact[..., None]
    patches[..., 2] = (contact[:, None] - 0.5) * 8
    return TokenSet(
        tokens=Tokens(torch.randn(count, width, generator=generator), patches),
        shear_change=change * FLOW_SCALE_PX,
        contact=contact,
        motions=torch.tensor(motions),
        is_readable=torch.ones(count, dtype=torch.bool),
        counts_motion=torch.ones(count, dtype=torch.bool),
    )
