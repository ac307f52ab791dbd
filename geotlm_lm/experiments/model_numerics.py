"""How firm the model's numbers are: precision, the mass floor of Eq. 5, gradients, feature scales.

Rows of plain numbers; knows no pass mark.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import torch
from torch import Tensor

from geotlm_lm.answering import Answerer, Encoded
from geotlm_lm.backbone.tokens import Tokens
from geotlm_lm.checkpoint import Bundle
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.geometry import GRID_SIDE, REGIONS, TIME_BIN_COUNT
from geotlm_lm.core.labels import Motion
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.dgr.regions import MASS_FLOOR, pool_regions, region_mass
from geotlm_lm.experiments.compare import Case
from geotlm_lm.experiments.judging import QUESTION
from geotlm_lm.precision import FLOATS, GEOMETRY, PARTS, in_precision

MASKS = tuple(10.0**-power for power in range(13))
"""Contact masks from full contact to 1e-12."""

SCALES = (1e-4, 1e-2, 0.1, 0.5, 1.0, 2.0, 10.0, 1e2, 1e4)
"""Factors on every token."""

GRADIENT_WIDTH = 6
"""Width of the tokens whose gradients are checked: each costs a pass."""


@dataclass(frozen=True, eq=False)
class Truths:
    """Clips of four frames with a background each, and their motions."""

    clips: Sequence[Clip]
    motions: Sequence[Motion]


def prepared(cases: Sequence[Case]) -> Truths:
    """Return the cases as the model takes them."""
    return Truths([case.clip for case in cases], [case.motion for case in cases])


def mass_floor_rows() -> list[dict[str, Any]]:
    """Return what a unit field pools to under fainter and fainter contact (Eq. 5), in float32.

    `recovered` undoes the floor by the exposed mass: the sum of the mask is that mass times the
    cells, so the mean without a floor is the pooled value times 1 + floor / sum.
    """
    rows = []
    for value in MASKS:
        for region, touched in (("everywhere", slice(None)), ("lower half", _LOWER)):
            mask = torch.zeros(1, GRID_SIDE, GRID_SIDE)
            mask[:, touched] = value
            pooled = dict(zip(REGIONS, pool_regions(torch.ones_like(mask), mask)[0], strict=True))
            mass = dict(zip(REGIONS, region_mass(mask)[0].tolist(), strict=True))
            summed = mass["global"] * GRID_SIDE**2
            rows.append(
                {
                    "mask": value,
                    "contact": region,
                    "global": float(pooled["global"]),
                    "recovered": float(pooled["global"]) * (1 + MASS_FLOOR / summed),
                    "mass": mass["global"],
                    "upper_minus_lower": float(pooled["upper_minus_lower"]),
                    "mass_upper_minus_lower": mass["upper_minus_lower"],
                }
            )
    return rows


_LOWER = slice(GRID_SIDE // 2, None)


def gradient_rows() -> list[dict[str, Any]]:
    """Return gradients of the descriptor, in float64, as contact vanishes.

    Norms are of the gradient of the descriptor's sum: by the field, by the mask itself, and by what
    the mask is the sigmoid of, which is what training changes. `checked` tells whether the gradient
    of the whole of DGR by its tokens agrees with central differences there.
    """
    generator = torch.Generator().manual_seed(0)
    field = torch.randn(1, GRID_SIDE, GRID_SIDE, generator=generator, dtype=torch.float64)
    rows = []
    for value in MASKS:
        norms = _gradient_norms(field, value)
        rows.append({"mask": value, **norms, "checked": _is_checked(value, generator)})
    return rows


def _gradient_norms(field: Tensor, value: float) -> dict[str, float]:
    mask = torch.full_like(field, value).requires_grad_(True)
    field = field.clone().requires_grad_(True)
    pool_regions(field, mask).sum().backward()
    # d sigmoid = mask (1 - mask) d logit.
    by_logit = mask.grad * value * (1 - value)
    return {
        "by_field": float(field.grad.norm()),
        "by_mask": float(mask.grad.norm()),
        "by_logit": float(by_logit.norm()),
    }


def _is_checked(value: float, generator: torch.Generator) -> bool:
    dgr = DGR(GRADIENT_WIDTH).double()
    with torch.no_grad():
        for parameter in dgr.parameters():
            parameter.normal_(0.0, 0.5, generator=generator)
        # Noise on the mask's logit, so that the cells differ; its middle gives `value`.
        dgr.to_mask.weight.mul_(0.1)
        dgr.to_mask.bias.fill_(
            float(torch.logit(torch.tensor(min(value, 1 - 1e-6), dtype=torch.float64)))
        )
    shape = (1, TIME_BIN_COUNT, 4, 4, GRADIENT_WIDTH)
    patches = torch.randn(shape, generator=generator, dtype=torch.float64).requires_grad_(True)
    return torch.autograd.gradcheck(
        lambda tokens: dgr(tokens).feature, patches, raise_exception=False
    )


def precision_rows(answerer: Answerer, truths: Truths) -> list[dict[str, Any]]:
    """Return what each number format does to the descriptor and to the answers.

    Errors are against the same parts in float64; those of the descriptor are the largest over clips
    and numbers, in parts of its largest number.
    """
    rows = []
    for parts in ((GEOMETRY,), PARTS):
        exact, said = _answers_in(answerer.bundle, "float64", parts, truths)
        size = float(exact.abs().max())
        for precision in FLOATS:
            found, answers = _answers_in(answerer.bundle, precision, parts, truths)
            changes = [abs(a[1] - b[1]) for a, b in zip(answers, said, strict=True)]
            rows.append(
                {
                    "parts": " + ".join(parts),
                    "precision": precision,
                    "descriptor_error": float((found - exact).abs().max()) / size,
                    "is_finite": bool(torch.isfinite(found).all()),
                    "answers_changed": sum(
                        a[0] != b[0] for a, b in zip(answers, said, strict=True)
                    ),
                    "confidence_change": max(changes),
                    **_share_right([one[0] for one in answers], truths),
                }
            )
    return rows


def _answers_in(
    bundle: Bundle, precision: str, parts: tuple[str, ...], truths: Truths
) -> tuple[Tensor, list[tuple[Motion | None, float]]]:
    changed = Answerer(in_precision(bundle, precision, parts))
    descriptors, answers = [], []
    for clip in truths.clips:
        encoded = changed.encode(clip)
        descriptors.append(encoded.perception.geometry.descriptor[0].double())
        try:
            answer = changed.ask(encoded, QUESTION)
            answers.append((answer.direction, answer.confidence))
        except ValueError:  # a token that overflowed is refused by the language model
            answers.append((None, 0.0))
    return torch.stack(descriptors), answers


def scale_rows(answerer: Answerer, truths: Truths) -> list[dict[str, Any]]:
    """Return what a factor on every token does, with the statistics as shipped and scaled along."""
    tokens = [answerer.bundle.model.backbone.encode([clip]) for clip in truths.clips]
    rows = []
    for factor in SCALES:
        for statistics in ("as shipped", "scaled along"):
            model = answerer.bundle.model
            if statistics == "scaled along":
                scaled = {
                    name: _scaled_statistics(getattr(model, name), factor)
                    for name in ("global_standardiser", "patch_standardiser")
                }
                model = replace(model, **scaled)
            answers = []
            for clip, own in zip(truths.clips, tokens, strict=True):
                perception = model.fuse(_scaled_tokens(own, factor))
                answers.append(answerer.ask(Encoded(clip, perception, {}), QUESTION))
            sure = [one.confidence for one in answers if not one.abstained]
            rows.append(
                {
                    "factor": factor,
                    "statistics": statistics,
                    "abstained": sum(one.abstained for one in answers),
                    "confidence": sum(sure) / len(sure) if sure else None,
                    **_share_right([one.direction for one in answers], truths),
                }
            )
    return rows


def _scaled_statistics(statistics: Any, factor: float) -> Any:
    return replace(statistics, mean=statistics.mean * factor, scale=statistics.scale * factor)


def _scaled_tokens(tokens: Tokens, factor: float) -> Tokens:
    return replace(
        tokens, global_token=tokens.global_token * factor, patches=tokens.patches * factor
    )


def _share_right(said: Sequence[Motion | None], truths: Truths) -> dict[str, Any]:
    right = sum(a == b for a, b in zip(said, truths.motions, strict=True))
    return {"right": right, "clips": len(said)}
