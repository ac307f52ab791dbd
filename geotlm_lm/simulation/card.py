"""The card of a data set of simulated clips: what is in it, counted from its shards."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from geotlm_lm.core.labels import MotionLabel
from geotlm_lm.core.twist import COMPONENTS, Component
from geotlm_lm.simulation.label import components_of
from geotlm_lm.simulation.shard_forms import FORMS
from geotlm_lm.simulation.trace import READABLE_GREY

FRAMES_IN_CARD = "`frames` uint8 (clips, 4, 224, 224, 3) RGB, `backgrounds` the idle gel,"

LABELS_ONLY_IN_CARD = """\
No picture was made: whether a motion is readable is estimated from the surface. Per shard:"""

DRIFT_IN_CARD = "`drift_px` (clips, 4, 14, 14, 2) the gel's own displacement from rest in pixels,"


def card_of(out: Path, count: int, wanted: dict[str, Any]) -> str:
    """Return the data set's card in Markdown, counted from what was written.

    Args:
        out: The folder with its shards.
        count: Clips in it.
        wanted: What `dataset.json` says of it.
    """
    labels: list[MotionLabel] = []
    worst_um = 0.0
    form = FORMS[wanted["form"]]
    for path in sorted(out.glob(f"shard-*{form.suffix}")):
        told = form.read(path)
        worst_um = max(worst_um, *told.penetration_um)
        labels += [MotionLabel.from_dict(values) for values in told.labels]
    motions: dict[str, list[bool]] = {}
    for label in labels:
        motions.setdefault(label.motion.value, []).append(label.is_readable)
    rows = [
        f"| {name} | {len(seen)} | {1 - sum(seen) / len(seen):.3f} |"
        for name, seen in sorted(motions.items())
    ]
    return "\n".join(
        [
            "---",
            "license: apache-2.0",
            "tags: [tactile, gelsight, simulated]",
            *_configuration(wanted["form"], form.suffix),
            "---",
            "# Simulated touch clips",
            "",
            f"{count} clips of {len(wanted['objects'])} bodies, seed {wanted['seed']}, preset",
            f"{wanted['preset']}, series {wanted['series']}, markers on the gel in a share of",
            f"{wanted['marker_share']:g}, turn, slide and press mixed freely in a share of",
            f"{wanted['mixed_share']:g}, made by",
            "`geotlm_lm.simulation`: a rigid body on a bonded elastic layer, seen by a camera",
            "under three coloured lights. Everything is simulated; nothing was recorded.",
            "",
            "| motion | clips | unreadable share |",
            "|---|---|---|",
            *rows,
            "",
            *_component_lines(labels),
            "",
            f"Largest penetration the contact solver left: {worst_um:.1f} micrometres.",
            "",
            *([form.about, ""] if form.about else []),
            "Per shard:" if wanted["with_frames"] else LABELS_ONLY_IN_CARD,
            *([FRAMES_IN_CARD] if wanted["with_frames"] else []),
            "`displacement_px` (clips, 4, 14, 14, 2) travel of the object since frame 0 at each",
            "patch (x right, y down, pixels), `contact` and `depth_mm` (clips, 4, 14, 14),",
            *([DRIFT_IN_CARD] if wanted["with_drift"] else []),
            "`mm_per_px`, `object_names`, `index`, and `labels` as JSON. Positive rotation is",
            "clockwise in the image. Directions are the object's relative to the sensor.",
            "",
            "Bodies: " + ", ".join(wanted["objects"]) + ".",
            "",
        ]
    )


def _configuration(name: str, suffix: str) -> list[str]:
    """Return what tells Hugging Face's `datasets` which files are data; it reads no archives."""
    if name == "npz":
        return []
    return ["configs:", "- config_name: default", f'  data_files: "shard-*{suffix}"']


def _component_lines(labels: list[MotionLabel]) -> list[str]:
    return [
        "Whatever its name, a clip may turn, slide and press at once. A component that counts",
        f"is readable where it alone can have changed the picture by {READABLE_GREY:g} greys.",
        "",
        "| component | counts | ambiguous | does not | readable share of those that count |",
        "|---|---|---|---|---|",
        *(_component_row(component, labels) for component in COMPONENTS),
        "",
        _together(labels),
    ]


def _component_row(component: Component, labels: list[MotionLabel]) -> str:
    told = [components_of(label)[component] for label in labels]
    visible = [one.is_visible for one in told if one.counts]
    share = f"{np.mean(visible):.3f}" if visible else "-"
    numbers = (sum(one.counts is kind for one in told) for kind in (True, None, False))
    return f"| {component} | {' | '.join(map(str, numbers))} | {share} |"


def _together(labels: list[MotionLabel]) -> str:
    """Return how many clips hold how many components at once."""
    held = [sum(one.counts is True for one in components_of(label).values()) for label in labels]
    told = (f"{held.count(number)} of {number}" for number in range(len(COMPONENTS) + 1))
    return f"Clips by the number of components that count: {', '.join(told)}."
