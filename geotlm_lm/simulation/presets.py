"""How finely and how tightly a scene is solved: five presets from draft to reference."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import torch

from geotlm_lm.core.errors import UsageError
from geotlm_lm.simulation.march import Effort
from geotlm_lm.simulation.normal_contact import PENETRATION_LIMIT_UM, ROUNDS

PresetName = Literal["draft", "fast", "good", "accurate", "reference"]


@dataclass(frozen=True)
class Preset:
    """One compromise between error and run time.

    Args:
        name: What it is called.
        cells: Cells per side of the contact grid, over the pad's 25.6 mm.
        effort: How hard every increment is solved.
        dtype: Precision; fields converge to 1e-5 in single precision as in double.
        is_half_space: Take the pad for infinitely thick, for comparison only.
        step_share: Length of an increment with friction, relative to the farthest that is small.
        skips_fine_profile: Whether a body is taken as the contact grid's cells hold it where they
            hold all there is of it.
        acceptable_um: Penetration up to which the result counts as converged.
        acceptable_share: Projected gradient of the frictional problem, likewise.
    """

    name: PresetName
    cells: int
    effort: Effort
    dtype: torch.dtype = torch.float32
    is_half_space: bool = False
    step_share: float = 1.0
    skips_fine_profile: bool = True
    acceptable_um: float = PENETRATION_LIMIT_UM
    acceptable_share: float = 0.1

    @property
    def harder(self) -> Preset | None:
        """The next preset up, for the same body and no less precise; None above the reference."""
        names = list(PRESETS)
        above = names[names.index(self.name) + 1 :]
        if not above:
            return None
        wider = torch.promote_types(self.dtype, PRESETS[above[0]].dtype)
        kept = {
            name: getattr(self, name)
            for name in ("is_half_space", "step_share", "skips_fine_profile")
        }
        return replace(PRESETS[above[0]], dtype=wider, **kept)


_LADDER = (
    Preset(
        "draft",
        32,
        Effort(
            (6, 12, 40),
            friction_iterations=15,
            passes=1,
            most_passes=8,
            enough_um=5.0,
            gradient_share=0.1,
        ),
    ),
    Preset("fast", 48, Effort(ROUNDS, friction_iterations=40, enough_um=5.0, gradient_share=3e-2)),
    Preset("good", 64, Effort((12, 24, 60, 150), friction_iterations=100, gradient_share=1e-2)),
    Preset(
        "accurate",
        128,
        Effort((50, 100, 400), 1000, passes=3, penetration_um=0.1, gradient_share=1e-4),
        torch.float64,
        acceptable_um=1.0,
        acceptable_share=1e-3,
    ),
    Preset(
        "reference",
        256,
        Effort((100, 200, 400, 1000), 1000, penetration_um=0.01, gradient_share=1e-5),
        torch.float64,
        acceptable_um=0.1,
        acceptable_share=1e-4,
    ),
)

PRESETS: dict[str, Preset] = {preset.name: preset for preset in _LADDER}

FAST = PRESETS["fast"]


def preset_named(name: str) -> Preset:
    """Return the preset called `name`.

    Raises:
        UsageError: If there is none.
    """
    if name not in PRESETS:
        raise UsageError(f"there is no preset '{name}'; choose one of {', '.join(PRESETS)}.")
    return PRESETS[name]
