"""Compares how the simulator and real hands mix turn, slide and press.

`PYTHONPATH=. python .ci/mixtures.py ../shared/real/physiclear docs` draws mixtures.png and writes
the numbers into simulator.md. Both are measured alike, by direct alignment of the frames. Of the
real windows those of the `tune` half are taken; the simulated ones are mixed clips of training
objects that turn as far as the real ones, from their 5th to their 95th percentile.
"""

import sys
import textwrap
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from geotlm_lm.benchmarks.cases import rows_of_half
from geotlm_lm.core.clip import Clip
from geotlm_lm.core.labels import ROTATIONS
from geotlm_lm.core.twist import Component
from geotlm_lm.data.labelled_recordings import find_labelled_recordings
from geotlm_lm.probe.rigid_alignment import RigidAlignment
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.simulate import simulate_series

CLIPS, SEED = 1000, 2611
SHARES = (5, 25, 50, 75, 95)
FRAMES = {"four": "four frames", "pair": "pairs"}
MEASURES = {
    "slide": "slide over turn",
    "press": "change of contrast, octaves",
}
BEGIN, END = "<!-- mixtures: written by .ci/mixtures.py -->\n", "<!-- end of mixtures -->\n"


def measured(clip: Clip) -> dict[str, float]:
    """Return a clip's turn in degrees, its slide over its turn, and its change of contrast.

    A press cannot be told in mm from a recording; the imprint's contrast changes with it.
    """
    motion = RigidAlignment().fit(clip)
    first, last = motion.contrast
    return {
        "turn": abs(motion.rotation_deg),
        "slide": motion.slide_px / max(abs(motion.turn_px), 1e-6),
        "press": abs(float(np.log2(max(last, 1e-6) / max(first, 1e-6)))),
    }


def real_windows(folder: Path) -> dict[str, list[dict[str, float]]]:
    """Return what the `tune` half's turns measure, four frames and pairs apart."""
    found = {frames: [] for frames in FRAMES}
    for recordings in find_labelled_recordings(folder):
        rows = tuple(
            row for row in rows_of_half(recordings.rows, "tune") if row.motion in ROTATIONS
        )
        for window in replace(recordings, rows=rows).windows(frames=tuple(FRAMES), backwards=False):
            found[window.frames].append(measured(window.clip))
    return found


def simulated_clips() -> list[dict[str, float]]:
    """Return what mixed clips measure whose turn counts and shows."""
    series = simulate_series(SEED, CLIPS, objects=TRAINING_OBJECTS, mixed_share=1.0)
    found = []
    for made in series:
        turn = made.components[Component.TURN]
        if turn.counts and turn.is_visible:
            radius = RigidAlignment().fit(made.clip).radius_px / made.label.radius_px
            found.append(measured(made.clip) | {"radius": radius})
    return found


def compared(folder: Path) -> dict[str, dict[str, list[dict[str, float]]]]:
    """Return, by the choice of frames, the real windows and the clips that turn as far."""
    clips, sets = simulated_clips(), {}
    for frames, windows in real_windows(folder).items():
        low, high = np.percentile([one["turn"] for one in windows], [5, 95])
        alike = [one for one in clips if low <= one["turn"] <= high]
        sets[frames] = {"real": windows, "simulated": alike}
    return sets


def draw(sets: dict, path: Path) -> None:
    """Write the cumulative shares of both measures, real and simulated."""
    figure = Figure(figsize=(9, 6), layout="constrained")
    axes = figure.subplots(len(FRAMES), len(MEASURES))
    for row, (frames, title) in zip(axes, FRAMES.items(), strict=True):
        for axis, (measure, name) in zip(row, MEASURES.items(), strict=True):
            for kind, colour in (("real", "tab:orange"), ("simulated", "tab:blue")):
                values = np.sort([one[measure] for one in sets[frames][kind]])
                share = (np.arange(len(values)) + 0.5) / len(values)
                axis.plot(values.clip(1e-3), share, colour, label=f"{kind} ({len(values)})")
            axis.set(xscale="log", xlabel=name, ylabel="share below", title=title, ylim=(0, 1))
            axis.grid(alpha=0.3)
            axis.legend(loc="upper left")
    figure.savefig(path, dpi=80)


def told(sets: dict) -> str:
    """Return the numbers as Markdown."""
    lines = [f"| measure | windows | clips | {' | '.join(f'{share} %' for share in SHARES)} |"]
    lines += ["|---|---|---|" + "---|" * len(SHARES)]
    outside = []
    for frames, title in FRAMES.items():
        for measure, name in MEASURES.items():
            values = {
                kind: np.array([one[measure] for one in found])
                for kind, found in sets[frames].items()
            }
            for kind, found in values.items():
                numbers = " | ".join(f"{one:.2f}" for one in np.percentile(found, SHARES))
                lines.append(f"| {name} | {title}, {kind} | {len(found)} | {numbers} |")
            low, high = np.percentile(values["simulated"], [SHARES[0], SHARES[-1]])
            below, above = ((values["real"] < low).mean(), (values["real"] > high).mean())
            outside.append(f"{name}, {title}: {below:.0%} and {above:.0%}")
    ratio = np.median([one["radius"] for one in sets["four"]["simulated"]])
    notes = [
        "Real windows below the 5th and above the 95th percentile of the simulated ones: "
        f"{'; '.join(outside)}.",
        f"The turn's path is taken at the radius of all contrast in view, {ratio:.1f} times the "
        "contact's (median of the simulated clips): at the contact's own, slides are as many times "
        "longer beside turns.",
    ]
    return "\n".join([*lines, "", *(textwrap.fill(note, 106) for note in notes), ""])


def main(real: Path, docs: Path) -> None:
    """Draw the picture and write the numbers into the page."""
    sets = compared(real)
    draw(sets, docs / "mixtures.png")
    page = docs / "simulator.md"
    text = page.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    numbers = told(sets)
    page.write_text(before + BEGIN + numbers + END + rest.split(END)[1], encoding="utf-8")
    print(numbers)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
