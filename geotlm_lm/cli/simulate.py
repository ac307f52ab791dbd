"""`geotlm-lm simulate`: a data set, or a single clip, from the simulator."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from geotlm_lm.cli.grouped import given_of, grouped
from geotlm_lm.cli.options import (
    ClusterAddress,
    Force,
    Seed,
    path_option,
    require_new_file,
    require_writable,
)
from geotlm_lm.cli.simulate_clip import (
    Move,
    OwnObject,
    require_shape,
    simulate_one,
    touch_fields,
    write_clip,
)
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.runs.run import Workers

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
Processes = Annotated[
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
Form = Annotated[
    Literal["npz", "webdataset", "huggingface"] | None,
    typer.Option(
        help="Files of the data set: archives of arrays, webdataset tars, or tables with pictures "
        "for Hugging Face's datasets. [default: npz]"
    ),
]
ClipFile = Annotated[
    Path | None, path_option(help="Write one clip to this .npz instead of a data set.")
]
Mixed = Annotated[
    float | None,
    typer.Option(
        min=0.0,
        max=1.0,
        help="Share of the data set's clips that turn, slide and press at once. [default: 0]",
    ),
]
MotionOf = Annotated[
    MotionName | None,
    typer.Option(
        help="With --clip: what the object does, as a random hand does it. [default: clockwise]"
    ),
]
ObjectName = Annotated[
    str | None,
    typer.Option("--object", help="With --clip: the shape that is pressed. [default: key]"),
]


@grouped
def simulate(
    *,
    out: DataSet = None,
    count: Count = None,
    objects: Objects = None,
    mixed: Mixed = None,
    workers: Processes = None,
    cluster: ClusterAddress = None,
    preset: Preset = "fast",
    drift: Drift = False,
    markers: Markers = False,
    labels_only: LabelsOnly = False,
    form: Form = None,
    clip: ClipFile = None,
    motion: MotionOf = None,
    move: Move,
    object_name: ObjectName = None,
    own: OwnObject,
    force: Force = False,
    seed: Seed = 0,
) -> None:
    """Simulate touches: contact mechanics, optics, noise, and the truth about each clip.

    Example: geotlm-lm simulate --clip clip.npz --turn 20 --slide-right 0.8 --press 0.1
    """
    if (out is None) == (clip is None):
        raise UsageError("Give one of --out (a data set) and --clip (a single clip).")
    scenes = {"preset": preset, "with_drift": drift, "seed": seed}
    moves = given_of(move)
    if clip is not None:
        others = {"--count": count, "--objects": objects, "--mixed": mixed, "--workers": workers}
        others |= {"--cluster": cluster}
        _refuse("--clip", others | {"--labels-only": labels_only or None, "--form": form})
        if motion is not None:
            _refuse("--motion", moves)
        fields, scenes["is_marked"] = touch_fields(moves), markers
        _write_clip(clip, force, motion, fields, object_name, own, scenes)
        print(clip)
    else:
        named = {"--motion": motion, "--object": object_name, "--force": force or None}
        _refuse("--out", named | moves | given_of(own))
        scenes |= {"marker_share": float(markers), "mixed_share": mixed or 0.0}
        scenes |= {"form": form or "npz"}
        by = Workers(workers, cluster)
        _write_data_set(out, count or 100, objects or "training", by, labels_only, scenes)
        print(out)


def _write_clip(
    clip: Path,
    is_forced: bool,
    motion: str | None,
    fields: dict[str, float],
    object_name: str | None,
    own: OwnObject,
    scenes: dict[str, Any],
) -> None:
    if clip.suffix != ".npz":
        raise UsageError(f"--clip {clip} was given, expected a name that ends in .npz.")
    indenter = own.read(object_name)
    name = "key" if indenter is None else own.height_map.stem
    if object_name is not None:
        name = object_name
    if indenter is None:
        require_shape(name)  # told before the simulator is loaded
    require_new_file(clip, "--clip", is_forced=is_forced)
    if not fields:
        motion = Motion(motion or "clockwise")
        write_clip(clip, simulate_one(name, motion, **scenes, indenter=indenter))
        return
    from geotlm_lm.simulation.touch import Touch, simulate_touch

    solving = {key: scenes.pop(key) for key in ("preset", "with_drift")}
    touch = Touch(name, **fields, **scenes, indenter=indenter)
    write_clip(clip, simulate_touch(touch, **solving))


def _write_data_set(
    out: Path,
    count: int,
    objects: str,
    workers: Workers,
    labels_only: bool,
    scenes: dict[str, Any],
) -> None:
    from geotlm_lm.cli.progress import progress_on_stderr
    from geotlm_lm.simulation.dataset import write_dataset

    require_writable(out, "--out")
    told = {"objects": _bodies(objects), "workers": workers, "with_frames": not labels_only}
    write_dataset(out, count, progress=progress_on_stderr(), **told, **scenes)


def _refuse(target: str, others: dict[str, object]) -> None:
    """Refuse options that would be ignored: what they ask for would not be in the result."""
    given = [name for name, value in others.items() if value is not None]
    if given:
        raise UsageError(f"{' and '.join(given)} cannot go with {target}; leave out one of them.")


def _bodies(which: str) -> tuple[str, ...]:
    from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, TRAINING_OBJECTS

    return TRAINING_OBJECTS if which == "training" else EVERYDAY_OBJECTS
