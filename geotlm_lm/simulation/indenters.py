"""The registry of bodies by name: eighty and more for training, twelve everyday things held back.

Every body is a formula for its underside, with its own random features; no file is read.
"""

from __future__ import annotations

from geotlm_lm.simulation.everyday import EVERYDAY
from geotlm_lm.simulation.indenter import Indenter
from geotlm_lm.simulation.shapes_free import FREE
from geotlm_lm.simulation.shapes_outline import OUTLINES
from geotlm_lm.simulation.shapes_rough import ROUGH
from geotlm_lm.simulation.shapes_round import ROUND
from geotlm_lm.simulation.shapes_solid import SOLIDS
from geotlm_lm.simulation.shapes_woven import WOVEN

_TRAINING: dict[str, Indenter] = SOLIDS | OUTLINES | ROUGH | WOVEN | ROUND | FREE

TRAINING_OBJECTS: tuple[str, ...] = tuple(_TRAINING)
"""Names a model may be trained on."""

EVERYDAY_OBJECTS: tuple[str, ...] = tuple(EVERYDAY)
"""Names kept for evaluation; their formulas are in no training body."""

INDENTERS: dict[str, Indenter] = _TRAINING | EVERYDAY
"""Every body by name."""
