"""`geotlm-lm simulate`: a data set, or a single clip, from the simulator."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from geotlm_lm.cli.options import Force, Seed, path_option, require_new_file, require_writable
from geotlm_lm.cli.simulate_clip import own_body, require_shape, simulate_one, write_clip
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.threads import usable_cores

MotionName = Literal[tuple(motion.value for motion in Motion)]

DataSet = Annotated[
    Path | None, path_option(help="Folder of the data set; a started one is continued.")
]
Count = Annotated[int | None, typer.Option(min=1, help="Clips in the data set. [default: 100]")]
Objects = Annotated[
    Literal["training", "everyday"] | None,
    typer.Option(
        help="Shapes to press: those for training, or 12 everyday ones kept apart. "
        "[default: training]"
    ),
]
Workers = Annotated[
    int | None,
    typer.Option(min=1, help="Processes that simulate. [default: one per usable core]"),
]
Preset = Annotated[
    Literal["draft", "fast", "good", "accurate", "reference"],
    typer.Option(help="How finely and tightly the contact is solved."),
]
Drift = Annotated[
    bool,
    typer.Option("--drift", help="Also solve friction: the gel's own tangential travel."),
]
Markers = Annotated[
    bool,
    typer.Option("--markers", help="Print dots on the gel; friction, solved, carries them."),
]
LabelsOnly = Annotated[
    bool,
    typer.Option("--labels-only", help="Write labels and true fields, and no pictures."),
]
ClipFile = Annotated[
    Path | None, path_option(help="Write one clip to this .npz instead of a data set.")
]
MotionOf = Annotated[
    MotionName | None,
    typer.Option(help="With --clip: what the object does. [default: clockwise]"),
]
ObjectName = Annotated[
    str | None,
    typer.Option("--object", help="With --clip: the shape that is pressed. [default: key]"),
]
HeightMap = Annotated[
    Path | None,
    path_option(
        help="With --clip: your own object, a .npy of heights in mm or a grey .png; what is "
        "highest touches first.",
    ),
]
SampleSize = Annotated[
    float | None, typer.Option(help="With --height-map: the size of one sample.")
]
Relief = Annotated[
    float | None,
    typer.Option(help="With a .png height map: how far white is above black. [default: 1]"),
]


def simulate(
    out: DataSet = None,
    count: Count = None,
    objects: Objects = None,
    workers: Workers = None,
    preset: Preset = "fast",
    drift: Drift = False,
    markers: Markers = False,
    labels_only: LabelsOnly = False,
    clip: ClipFile = None,
    motion: MotionOf = None,
    object_name: ObjectName = None,
    height_map: HeightMap = None,
    mm_per_px: SampleSize = None,
    relief_mm: Relief = None,
    force: Force = False,
    seed: Seed = 0,
) -> None:
    """Simulate touches: contact mechanics, optics, noise, and the truth about each clip.

    Example: geotlm-lm simulate --clip clip.npz --motion clockwise --object key
    """
    if (out is None) == (clip is None):
        raise UsageError("Give one of --out (a data set) and --clip (a single clip).")
    scenes = {"preset": preset, "with_drift": drift, "marker_share": float(markers), "seed": seed}
    if clip is not None:
        others = {"--count": count, "--objects": objects, "--workers": workers}
        _refuse("--clip", others | {"--labels-only": labels_only or None})
        if clip.suffix != ".npz":
            raise UsageError(f"--clip {clip} was given, expected a name that ends in .npz.")
        indenter = own_body(height_map, mm_per_px, relief_mm, object_name)
        name = "key" if height_map is None else height_map.stem
        if object_name is not None:
            name = object_name
        if indenter is None:
            require_shape(name)  # told before the simulator is loaded
        require_new_file(clip, "--clip", is_forced=force)
        made = simulate_one(name, Motion(motion or "clockwise"), indenter=indenter, **scenes)
        write_clip(clip, made)
        print(clip)
    else:
        own = {"--height-map": height_map, "--mm-per-px": mm_per_px, "--relief-mm": relief_mm}
        named = {"--motion": motion, "--object": object_name, "--force": force or None}
        _refuse("--out", named | own)
        _write_data_set(out, count or 100, objects or "training", workers, labels_only, scenes)
        print(out)


def _write_data_set(
    out: Path,
    count: int,
    objects: str,
    workers: int | None,
    labels_only: bool,
    scenes: dict[str, Any],
) -> None:
    from geotlm_lm.cli.progress import progress_on_stderr
    from geotlm_lm.simulation.dataset import write_dataset

    require_writable(out, "--out")
    write_dataset(
        out,
        count,
        objects=_bodies(objects),
        workers=workers or usable_cores(),
        with_frames=not labels_only,
        progress=progress_on_stderr(),
        **scenes,
    )


def _refuse(target: str, others: dict[str, object]) -> None:
    """Refuse options that would be ignored: what they ask for would not be in the result."""
    given = [name for name, value in others.items() if value is not None]
    if given:
        raise UsageError(f"{' and '.join(given)} cannot go with {target}; leave out one of them.")


def _bodies(which: str) -> tuple[str, ...]:
    from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, TRAINING_OBJECTS

    return TRAINING_OBJECTS if which == "training" else EVERYDAY_OBJECTS
