"""Initialise a grounded DGR by least squares on true displacement and contact.

The bundle's own DGR starts from the read-outs its backbone was pretrained through. They are not
kept with the weights, and the encoders of others never had any.
"""

from __future__ import annotations

import torch
from torch import Tensor

from geotlm_lm.core.geometry import FLOW_SCALE_PX
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.training.geometry import TokenSet

RIDGE = 1e-3
"""Added to the tokens' covariance, relative to its mean diagonal: tokens are nearly collinear."""

CONTACT_LOGITS = 4.0
"""Logit between no contact and full contact at the start: masks of 0.12 and 0.88."""


@torch.no_grad()
def initialise_from_truth(dgr: DGR, train: TokenSet) -> None:
    """Set shear and mask to the linear maps that come nearest to the truth of the training rows.

    The change of shear is fitted to the true change of displacement where there is contact, the
    mask's logit to the true contact.

    Args:
        dgr: Its maps to shear and mask are overwritten.
        train: Standardised tokens with their truth.
    """
    patches, contact = train.tokens.patches, train.contact.float()
    counted = contact * train.counts_motion.float()[:, None, None]
    change = train.shear_change.float() / FLOW_SCALE_PX
    shear, _ = _nearest(patches[:, 1] - patches[:, 0], change, counted, has_offset=False)
    mask, offset = _nearest(
        patches.mean(dim=1),
        CONTACT_LOGITS * (contact - 0.5)[..., None],
        torch.ones_like(contact),
        has_offset=True,
    )
    dgr.to_shear.weight.copy_(shear.T)
    dgr.to_shear.bias.zero_()
    dgr.to_mask.weight.copy_(mask.T)
    dgr.to_mask.bias.copy_(offset)


def _nearest(
    features: Tensor, targets: Tensor, weight: Tensor, *, has_offset: bool
) -> tuple[Tensor, Tensor]:
    """Solve the weighted ridge regression of targets (..., c) on features (..., d).

    Returns:
        Map (d, c) and offset (c,).
    """
    width = features.shape[-1]
    gram = torch.zeros(width + 1, width + 1, dtype=torch.float64)
    product = torch.zeros(width + 1, targets.shape[-1], dtype=torch.float64)
    # Clip by clip batches: all patches of a thousand clips in double precision would fill memory.
    for rows in torch.arange(len(features)).split(64):
        x = features[rows].reshape(-1, width)
        x = torch.nn.functional.pad(x, (0, 1), value=float(has_offset))
        weighted = x * weight[rows].reshape(-1, 1)
        gram += (weighted.T @ x).double()
        product += (weighted.T @ targets[rows].reshape(len(x), -1)).double()
    ridge = RIDGE * float(gram.diagonal()[:width].mean()) + 1e-9
    solution = torch.linalg.solve(gram + ridge * torch.eye(width + 1, dtype=torch.float64), product)
    return solution[:width].float(), solution[width].float()
