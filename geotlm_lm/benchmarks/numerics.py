"""How firm the model's numbers are: formats, and contact that vanishes.

Rows of plain numbers; knows no pass mark.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import torch
from torch import Tensor

from geotlm_lm.answering import Answerer, Encoded
from geotlm_lm.benchmarks.judging import Case
from geotlm_lm.benchmarks.rows import Row, Run
from geotlm_lm.benchmarks.stability_rows import QUESTION, simulated_cases
from geotlm_lm.core.geometry import GRID_SIDE, REGIONS
from geotlm_lm.core.labels import Motion
from geotlm_lm.dgr.regions import MASS_FLOOR, pool_regions, region_mass
from geotlm_lm.precision import FLOATS, GEOMETRY, PARTS, in_precision

MASKS = tuple(10.0**-power for power in range(13))
"""Contact masks from full contact to 1e-12."""

CLIPS = 20
"""Clips whose answers are compared across number formats."""

Said = tuple[Motion | None, float]
"""The motion that an answer names, or None, and its probability."""


def numerics_rows(run: Run) -> Iterator[Row]:
    """Yield how firm pooling and number formats are, in this order."""
    yield from contact_rows()
    yield from format_rows(run.answerer, simulated_cases(run, CLIPS, 2))


def contact_rows(masks: Sequence[float] = MASKS) -> Iterator[Row]:
    """Yield what Eq. 5 and its gradients come to under fainter and fainter contact.

    A unit field is pooled in float32; `recovered` undoes the floor by the exposed mass, and
    `empty_half` is the difference of the halves where only the lower is touched. The gradients of
    the descriptor's sum are by the mask, and by what that is the sigmoid of, in float64.
    """
    shape = (1, GRID_SIDE, GRID_SIDE)
    field = torch.randn(shape, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    for value in masks:
        whole, lower = torch.full(shape, value), torch.full(shape, value)
        lower[:, : GRID_SIDE // 2] = 0
        pooled, mass, half, half_mass = (
            dict(zip(REGIONS, values[0].tolist(), strict=True))
            for mask in (whole, lower)
            for values in (pool_regions(torch.ones_like(mask), mask), region_mass(mask))
        )
        mask = torch.full_like(field, value).requires_grad_(True)
        pool_regions(field, mask).sum().backward()
        numbers = {
            "pooled": pooled["global"],
            # The sum of the mask is its mass times the cells.
            "recovered": pooled["global"] * (1 + MASS_FLOOR / (mass["global"] * GRID_SIDE**2)),
            "empty_half": half["upper_minus_lower"],
            "its_mass": half_mass["upper_minus_lower"],
            "by_mask": float(mask.grad.norm()),
            "by_logit": float(mask.grad.norm()) * value * (1 - value),  # d sigmoid / d logit
        }
        yield Row(f"contact {value:.0e}", "-", detail=numbers)


def format_rows(answerer: Answerer, cases: Sequence[Case]) -> Iterator[Row]:
    """Yield what each number format does to the descriptor and to the answers, against float64.

    The error is the descriptor's largest over clips and numbers, in parts of its largest number.
    """
    for parts in ((GEOMETRY,), PARTS):
        exact, expected = _in_format(answerer, "float64", parts, cases)
        for precision in FLOATS:
            found, said = _in_format(answerer, precision, parts, cases)
            changed = sum(a[0] != b[0] for a, b in zip(said, expected, strict=True))
            numbers = _counts(said, cases) | {"answers_changed": changed}
            case, error = " + ".join(parts), float((found - exact).abs().max() / exact.abs().max())
            yield Row(case, precision, len(cases), error, "of the largest", detail=numbers)


def _in_format(
    answerer: Answerer, precision: str, parts: tuple[str, ...], cases: Sequence[Case]
) -> tuple[Tensor, list[Said]]:
    """Return descriptors (clips, 14) and what was said of each clip."""
    changed = Answerer(in_precision(answerer.bundle, precision, parts))
    encoded = [changed.encode(case.clip) for case in cases]
    descriptors = [one.perception.geometry.descriptor[0].double() for one in encoded]
    return torch.stack(descriptors), [_said(changed, one) for one in encoded]


def _said(answerer: Answerer, encoded: Encoded) -> Said:
    try:
        answer = answerer.ask(encoded, QUESTION)
    except ValueError:  # a token that overflowed is refused by the language model
        return None, 0.0
    return answer.direction, answer.confidence


def _counts(said: Sequence[Said], cases: Sequence[Case]) -> dict[str, float | None]:
    sure = [confidence for motion, confidence in said if motion is not None]
    right = sum(one[0] == case.motion for one, case in zip(said, cases, strict=True))
    return {"right": right, "probability": sum(sure) / len(sure) if sure else None}
