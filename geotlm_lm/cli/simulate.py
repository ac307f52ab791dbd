"""`geotlm-lm simulate`: a data set, or a single clip, from the simulator."""

from __future__ import annotations

import json
import sys
import time
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from geotlm_lm.cli.options import Seed, require_writable, require_writable_file
from geotlm_lm.core.atomic import replacing
from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.threads import usable_cores

if TYPE_CHECKING:
    from geotlm_lm.simulation.indenter import Indenter
    from geotlm_lm.simulation.presets import PresetName
    from geotlm_lm.simulation.simulate import SimulatedClip

WRITTEN = {"frames", "label", "background", "drift_px", "fps"}
"""What a single clip's file may hold."""

MotionName = Literal[tuple(motion.value for motion in Motion)]


def simulate(
    out: Annotated[
        Path | None, typer.Option(help="Folder of the data set; a started one is continued.")
    ] = None,
    count: Annotated[
        int | None, typer.Option(min=1, help="Clips in the data set. [default: 100]")
    ] = None,
    objects: Annotated[
        Literal["training", "everyday"] | None,
        typer.Option(
            help="Shapes to press: those for training, or 12 everyday ones kept apart. "
            "[default: training]"
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="Processes that simulate. [default: one per usable core]"),
    ] = None,
    preset: Annotated[
        Literal["draft", "fast", "good", "accurate", "reference"],
        typer.Option(help="How finely and tightly the contact is solved."),
    ] = "fast",
    drift: Annotated[
        bool,
        typer.Option("--drift", help="Also solve friction: the gel's own tangential travel."),
    ] = False,
    markers: Annotated[
        bool,
        typer.Option("--markers", help="Print dots on the gel; friction, solved, carries them."),
    ] = False,
    labels_only: Annotated[
        bool,
        typer.Option("--labels-only", help="Write labels and true fields, and no pictures."),
    ] = False,
    clip: Annotated[
        Path | None, typer.Option(help="Write one clip to this .npz instead of a data set.")
    ] = None,
    motion: Annotated[
        MotionName | None,
        typer.Option(help="With --clip: what the object does. [default: clockwise]"),
    ] = None,
    object_name: Annotated[
        str | None,
        typer.Option("--object", help="With --clip: the shape that is pressed. [default: key]"),
    ] = None,
    height_map: Annotated[
        Path | None,
        typer.Option(
            help="With --clip: your own object, a .npy of heights in mm or a grey .png; what is "
            "highest touches first."
        ),
    ] = None,
    mm_per_px: Annotated[
        float | None, typer.Option(help="With --height-map: the size of one sample.")
    ] = None,
    relief_mm: Annotated[
        float | None,
        typer.Option(help="With a .png height map: how far white is above black. [default: 1]"),
    ] = None,
    seed: Seed = 0,
) -> None:
    """Simulate touches: contact mechanics, optics, noise, and the truth about each clip.

    Example: geotlm-lm simulate --clip clip.npz --motion clockwise --object key
    """
    if (out is None) == (clip is None):
        raise UsageError("Give one of --out (a data set) and --clip (a single clip).")
    if clip is not None:
        others = {"--count": count, "--objects": objects, "--workers": workers}
        _refuse("--clip", others | {"--labels-only": labels_only or None})
        _require_clip_name(clip)
        indenter = _own_body(height_map, mm_per_px, relief_mm, object_name)
        made = simulate_one(
            object_name or ("key" if height_map is None else height_map.stem),
            Motion(motion or Motion.CLOCKWISE),
            seed,
            preset=preset,
            with_drift=drift,
            indenter=indenter,
            marker_share=float(markers),
        )
        write_clip(clip, made)
        print(clip)
    else:
        from geotlm_lm.simulation.dataset import write_dataset

        own = {"--height-map": height_map, "--mm-per-px": mm_per_px, "--relief-mm": relief_mm}
        _refuse("--out", {"--motion": motion, "--object": object_name} | own)
        require_writable(out, "--out")
        names = _bodies(objects or "training")
        settings = {"seed": seed, "preset": preset, "with_drift": drift}
        write_dataset(
            out,
            count or 100,
            objects=names,
            workers=workers or usable_cores(),
            marker_share=float(markers),
            with_frames=not labels_only,
            progress=progress_and_rate(),
            **settings,
        )
        print(out)


def _refuse(target: str, others: dict[str, object]) -> None:
    """Refuse options that would be ignored: what they ask for would not be in the result."""
    given = [name for name, value in others.items() if value is not None]
    if given:
        raise UsageError(f"{' and '.join(given)} cannot go with {target}; leave out one of them.")


def _require_clip_name(path: Path) -> None:
    if path.suffix != ".npz":
        raise UsageError(f"--clip {path} was given, expected a name that ends in .npz.")
    require_writable_file(path, "--clip")
    if path.exists() and not _is_simulated(path):
        raise UsageError(
            f"--clip: {path} is there already and is no clip that this command wrote; give another "
            f"name, or delete it first."
        )


def _is_simulated(path: Path) -> bool:
    """Tell whether a file holds what `write_clip` writes: no recording has such a label."""
    try:
        with zipfile.ZipFile(path) as archive:
            members = {name.removesuffix(".npy") for name in archive.namelist()}
    except (OSError, zipfile.BadZipFile):
        return False
    return {"frames", "label"} <= members <= WRITTEN


def _own_body(
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
    from geotlm_lm.simulation.height_map import read_height_map

    return read_height_map(height_map, mm_per_px, relief_mm=1.0 if relief_mm is None else relief_mm)


def _bodies(which: str) -> tuple[str, ...]:
    from geotlm_lm.simulation.indenters import EVERYDAY_OBJECTS, TRAINING_OBJECTS

    return TRAINING_OBJECTS if which == "training" else EVERYDAY_OBJECTS


def simulate_one(
    object_name: str,
    motion: Motion,
    seed: int,
    *,
    preset: PresetName = "fast",
    with_drift: bool = False,
    indenter: Indenter | None = None,
    marker_share: float = 0.0,
) -> SimulatedClip:
    """Return one simulated clip of a built-in shape or of an `indenter` of one's own.

    Options are those of `simulation.simulate.simulate` and `simulation.randomise.random_scene`.

    Raises:
        UsageError: If there is no such shape.
    """
    from geotlm_lm.core.seeding import generator_for
    from geotlm_lm.simulation.indenters import INDENTERS
    from geotlm_lm.simulation.randomise import random_scene
    from geotlm_lm.simulation.simulate import simulate as simulate_scenes

    if indenter is None and object_name not in INDENTERS:
        raise UsageError(
            f"There is no shape '{object_name}', expected one of {', '.join(sorted(INDENTERS))}."
        )
    rng = generator_for(seed, "single clip", object_name, motion.value)
    scene = random_scene(
        rng,
        object_name=object_name,
        motion=motion,
        indenter=indenter,
        marker_share=marker_share,
    )
    made = simulate_scenes([scene], seed=seed, preset=preset, with_drift=with_drift)
    return made[0]


def write_clip(path: Path, made: SimulatedClip) -> None:
    """Write frames, background, frame rate, label (JSON) and drift, if solved, to a .npz file."""
    import numpy as np

    label = json.dumps(made.label.to_dict() | {"object": made.object_name})
    arrays = {"frames": made.clip.frames, "label": np.array(label)}
    if made.clip.background is not None:
        arrays["background"] = made.clip.background
    if made.drift_px is not None:
        arrays["drift_px"] = made.drift_px
    if made.clip.fps is not None:
        arrays["fps"] = np.array(made.clip.fps)
    with replacing(path) as stream:
        np.savez_compressed(stream, **arrays)


def progress_and_rate(clock: Callable[[], float] = time.perf_counter) -> Callable[[int, int], None]:
    """Return what prints the clips done and, from the second report on, the clips per second.

    The rate counts from the first report: neither starting up nor what an earlier run left behind
    is in it.

    Args:
        clock: Seconds from any moment on.
    """
    first: list[tuple[int, float]] = []

    def show(done: int, total: int) -> None:
        now, rate = clock(), ""
        if first:
            before, began = first[0]
            rate = f", {(done - before) / max(now - began, 1e-9):.1f} clips/s"
        else:
            first.append((done, now))
        print(f"simulated {done} of {total} clips{rate}", file=sys.stderr)

    return show
