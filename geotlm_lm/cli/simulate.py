"""`geotlm-lm simulate` and `simulate-clip`: a data set of simulated clips, and a chosen clip."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from typer.core import TyperCommand

from geotlm_lm.cli.options import (
    ClusterAddress,
    Force,
    Seed,
    path_of,
    path_option,
    require_new_file,
    require_writable,
)
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.files import replacing
from geotlm_lm.core.labels import Motion
from geotlm_lm.runs.run import Workers

if TYPE_CHECKING:
    from geotlm_lm.simulation.shapes import Indenter
    from geotlm_lm.simulation.simulate import SimulatedClip

Processes = Annotated[
    int | None,
    typer.Option(min=1, help="Processes that simulate. [default: one per usable core]"),
]
Form = Annotated[
    Literal["npz", "huggingface"],
    typer.Option(
        help="Files of the data set: archives of arrays, or tables with pictures for Hugging "
        "Face's datasets."
    ),
]
SolverPreset = Annotated[
    Literal["draft", "fast", "good", "accurate", "reference"],
    typer.Option("--preset", help="How finely and tightly the contact is solved."),
]
Drift = Annotated[
    bool,
    typer.Option("--drift", help="Also solve friction: the gel's own tangential travel."),
]
Markers = Annotated[
    bool,
    typer.Option("--markers", help="Print dots on the gel; friction, solved, carries them."),
]
MotionName = Annotated[
    Literal[tuple(motion.value for motion in Motion)] | None,
    typer.Option(help="What the object does, as a random hand does it. [default: clockwise]"),
]
ObjectName = Annotated[
    str | None, typer.Option("--object", help="The shape that is pressed. [default: key]")
]
Turn = Annotated[
    float | None,
    typer.Option(help="Instead of --motion: degrees turned, clockwise positive."),
]
SlideRight = Annotated[float | None, typer.Option(help="At once: mm slid to the right.")]
SlideDown = Annotated[float | None, typer.Option(help="At once: mm slid down the image.")]
Press = Annotated[float | None, typer.Option(help="At once: mm pressed in; negative lifts.")]
PivotRight = Annotated[
    float | None,
    typer.Option(help="With --turn: its axis, mm to the right of where the contact's middle ends."),
]
PivotDown = Annotated[float | None, typer.Option(help="The same, mm below it.")]
Depth = Annotated[
    float | None,
    typer.Option(help="With these: mm beyond first touch, half-way. [default: 0.6]"),
]
HeightMapFile = Annotated[
    Path | None,
    path_option(
        help="Your own object, a .npy of heights in mm or a grey .png; what is highest touches "
        "first."
    ),
]
SampleSize = Annotated[
    float | None, typer.Option(help="With --height-map: the size of one sample.")
]
Relief = Annotated[
    float | None,
    typer.Option(help="With a .png height map: how far white is above black. [default: 1]"),
]


class ForwardsClip(TyperCommand):
    """`simulate --clip FILE ...` is `simulate-clip FILE ...`, which it was once part of."""

    def make_context(self, info_name: str, args: list[str], parent: Any = None, **extra: Any):
        """Return the context of the command that runs."""
        words = [word.removeprefix("--clip=") for word in args if word != "--clip"]
        if words == args:
            return super().make_context(info_name, args, parent, **extra)
        command = parent.command.get_command(parent, "simulate-clip")
        return command.make_context("simulate-clip", words, parent, **extra)


def simulate(
    *,
    out: Annotated[Path, path_option(help="Folder of the data set; a started one is continued.")],
    count: Annotated[int, typer.Option(min=1, help="Clips in the data set.")] = 100,
    objects: Annotated[
        Literal["training", "everyday"],
        typer.Option(help="Shapes to press: those for training, or 12 everyday ones kept apart."),
    ] = "training",
    mixed: Annotated[
        float,
        typer.Option(
            min=0.0, max=1.0, help="Share of the clips that turn, slide and press at once."
        ),
    ] = 0.0,
    workers: Processes = None,
    cluster: ClusterAddress = None,
    preset: SolverPreset = "fast",
    drift: Drift = False,
    markers: Markers = False,
    labels_only: Annotated[
        bool,
        typer.Option("--labels-only", help="Write labels and true fields, and no pictures."),
    ] = False,
    form: Form = "npz",
    seed: Seed = 0,
) -> None:
    """Simulate a data set of touches: mechanics, optics, noise, and the truth about each clip.

    Example: geotlm-lm simulate --out clips --count 200 --mixed 0.5
    """
    by = Workers(workers, cluster)
    require_writable(out, "--out")
    from geotlm_lm.cli.progress import progress_on_stderr
    from geotlm_lm.simulation import dataset
    from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, TRAINING_OBJECTS

    dataset.write_dataset(
        out,
        count,
        seed=seed,
        objects=TRAINING_OBJECTS if objects == "training" else EVERYDAY_OBJECTS,
        workers=by,
        preset=preset,
        with_drift=drift,
        marker_share=float(markers),
        mixed_share=mixed,
        with_frames=not labels_only,
        form=form,
        progress=progress_on_stderr(),
    )
    print(out)


def simulate_clip(
    *,
    out: Annotated[
        Path, typer.Argument(parser=path_of, metavar="OUT", help="The .npz that is written.")
    ],
    motion: MotionName = None,
    turn: Turn = None,
    slide_right: SlideRight = None,
    slide_down: SlideDown = None,
    press: Press = None,
    pivot_right: PivotRight = None,
    pivot_down: PivotDown = None,
    depth: Depth = None,
    object_name: ObjectName = None,
    height_map: HeightMapFile = None,
    mm_per_px: SampleSize = None,
    relief_mm: Relief = None,
    preset: SolverPreset = "fast",
    drift: Drift = False,
    markers: Markers = False,
    force: Force = False,
    seed: Seed = 0,
) -> None:
    """Simulate one touch: a clip with its label, turned, slid and pressed as you say.

    Example: geotlm-lm simulate-clip clip.npz --turn 20 --slide-right 0.8 --press 0.1
    """
    if out.suffix != ".npz":
        raise UsageError(f"OUT {out} was given, expected a name that ends in .npz.")
    moves = {
        "--turn": ("twist_deg", turn),
        "--slide-right": ("slide_x_mm", slide_right),
        "--slide-down": ("slide_y_mm", slide_down),
        "--press": ("press_mm", press),
        "--pivot-right": ("pivot_x_mm", pivot_right),
        "--pivot-down": ("pivot_y_mm", pivot_down),
        "--depth": ("depth_mm", depth),
    }
    numbers = _numbers(moves, motion)
    indenter = _own_object(height_map, mm_per_px, relief_mm, object_name)
    name = object_name if object_name is not None else "key"
    if indenter is not None:
        name = height_map.stem
    else:
        from geotlm_lm.simulation.indenters import require_shape

        require_shape(name)
    require_new_file(out, "OUT", is_forced=force)
    from geotlm_lm.simulation.touch import Touch, simulate_motion, simulate_touch

    solving = {"preset": preset, "with_drift": drift}
    own = {"indenter": indenter, "is_marked": markers, "seed": seed}
    if numbers:
        made = simulate_touch(Touch(name, **numbers, **own), **solving)
    else:
        made = simulate_motion(name, Motion(motion or "clockwise"), **own, **solving)
    _write(out, made)
    print(out)


def _numbers(moves: dict[str, tuple[str, float | None]], motion: str | None) -> dict[str, float]:
    """Return what the object is asked to do, exactly, by the fields of a `Touch`."""
    moves = {option: values for option, values in moves.items() if values[1] is not None}
    if not moves:
        return {}
    if motion is not None:
        raise UsageError(f"{' and '.join(moves)} cannot go with --motion; leave out one of them.")
    from geotlm_lm.simulation.touch import require_in_range

    for option, (field, value) in moves.items():
        require_in_range(field, value, option)
    numbers = dict(moves.values())
    if not numbers.get("twist_deg") and (numbers.get("pivot_x_mm") or numbers.get("pivot_y_mm")):
        raise UsageError(
            "--pivot-right and --pivot-down say where the axis of a --turn lies; give one."
        )
    return numbers


def _own_object(
    height_map: Path | None,
    mm_per_px: float | None,
    relief_mm: float | None,
    object_name: str | None,
) -> Indenter | None:
    if height_map is None:
        if mm_per_px is not None or relief_mm is not None:
            raise UsageError(
                "--mm-per-px and --relief-mm say how to read a --height-map; give one."
            )
        return None
    if object_name is not None:
        raise UsageError("--object and --height-map both name the object; leave out one of them.")
    if relief_mm is not None and height_map.suffix.lower() == ".npy":
        raise UsageError("--relief-mm is of a .png; the heights of a .npy are in mm already.")
    if mm_per_px is None:
        raise UsageError("--height-map needs --mm-per-px, the size of one sample in mm.")
    from geotlm_lm.simulation.shapes import read_height_map

    relief_mm = 1.0 if relief_mm is None else relief_mm
    return read_height_map(height_map, mm_per_px, relief_mm=relief_mm)


def _write(path: Path, made: SimulatedClip) -> None:
    """Write frames, idle gel, rate, shape of pixels, label (JSON) and drift, if solved, as .npz."""
    import numpy as np

    label = json.dumps(made.label.to_dict() | {"object": made.object_name})
    arrays = {"frames": made.clip.frames, "label": np.array(label)}
    # The simulated camera's picture is of four to three: no reader need assume it.
    arrays["square_pixels"] = np.array(False)
    arrays["background"] = made.clip.background
    if made.drift_px is not None:
        arrays["drift_px"] = made.drift_px
    arrays["fps"] = np.array(made.clip.fps)
    with replacing(path) as stream:
        np.savez_compressed(stream, **arrays)
