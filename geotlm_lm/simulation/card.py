"""The card of a data set of simulated clips: what is in it, counted from its shards."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

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
    motions: dict[str, list[bool]] = {}
    worst_um = 0.0
    for path in sorted(out.glob("shard-*.npz")):
        with np.load(path, allow_pickle=False) as stored:
            worst_um = max(worst_um, float(stored["penetration_um"].max()))
            for values in json.loads(str(stored["labels"])):
                motions.setdefault(values["motion"], []).append(values["is_readable"])
    rows = [
        f"| {name} | {len(seen)} | {1 - sum(seen) / len(seen):.3f} |"
        for name, seen in sorted(motions.items())
    ]
    return "\n".join(
        [
            "---",
            "license: apache-2.0",
            "tags: [tactile, gelsight, simulated]",
            "---",
            "# Simulated touch clips",
            "",
            f"{count} clips of {len(wanted['objects'])} bodies, seed {wanted['seed']}, preset",
            f"{wanted['preset']}, series {wanted['series']}, markers on the gel in a share of",
            f"{wanted['marker_share']:g}, made by",
            "`geotlm_lm.simulation`: a rigid body on a bonded elastic layer, seen by a camera",
            "under three coloured lights. Everything is simulated; nothing was recorded.",
            "",
            "| motion | clips | unreadable share |",
            "|---|---|---|",
            *rows,
            "",
            f"Largest penetration the contact solver left: {worst_um:.1f} micrometres.",
            "",
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
