"""`geotlm-lm simulate` and `simulate-clip`: a data set of simulated clips, and a chosen clip."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from typer.core import TyperCommand

from geotlm_lm.cli.options import (
    ClusterAddress,
    Force,
    Seed,
    argument,
    grouped,
    option,
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


MotionName = Literal[tuple(motion.value for motion in Motion)]

FIELDS = {
    "turn": "twist_deg",
    "slide_right": "slide_x_mm",
    "slide_down": "slide_y_mm",
    "press": "press_mm",
    "pivot_right": "pivot_x_mm",
    "pivot_down": "pivot_y_mm",
    "depth": "depth_mm",
}
"""Of `Moves` -> of a `Touch`."""


@dataclass(frozen=True)
class Solving:
    """How clips are simulated."""

    preset: Literal["draft", "fast", "good", "accurate", "reference"] = option(
        "How finely and tightly the contact is solved.", default="fast"
    )
    drift: bool = option(
        "Also solve friction: the gel's own tangential travel.", "--drift", default=False
    )
    markers: bool = option(
        "Print dots on the gel; friction, solved, carries them.", "--markers", default=False
    )


@dataclass(frozen=True)
class Moves:
    """What the object of one clip does: a motion as of a random hand, or all of it exactly."""

    motion: MotionName | None = option(
        "What the object does, as a random hand does it. [default: clockwise]"
    )
    turn: float | None = option("Instead of --motion: degrees turned, clockwise positive.")
    slide_right: float | None = option("At once: mm slid to the right.")
    slide_down: float | None = option("At once: mm slid down the image.")
    press: float | None = option("At once: mm pressed in; negative lifts.")
    pivot_right: float | None = option(
        "With --turn: its axis, mm to the right of where the contact's middle ends."
    )
    pivot_down: float | None = option("The same, mm below it.")
    depth: float | None = option("With these: mm beyond first touch, half-way. [default: 0.6]")

    def numbers(self) -> dict[str, float]:
        """Return what the object is asked to do exactly, by the fields of a `Touch`."""
        moves = {name: value for name in FIELDS if (value := getattr(self, name)) is not None}
        options = {name: f"--{name.replace('_', '-')}" for name in moves}
        if not moves:
            return {}
        if self.motion is not None:
            raise UsageError(
                f"{' and '.join(options.values())} cannot go with --motion; leave out one of them."
            )
        from geotlm_lm.simulation.touch import require_in_range

        for name, value in moves.items():
            require_in_range(FIELDS[name], value, options[name])
        if not self.turn and (self.pivot_right or self.pivot_down):
            raise UsageError(
                "--pivot-right and --pivot-down say where the axis of a --turn lies; give one."
            )
        return {FIELDS[name]: value for name, value in moves.items()}


@dataclass(frozen=True)
class Pressed:
    """The object of one clip: one of ours by its name, or a height map."""

    object_name: str | None = option("The shape that is pressed. [default: key]", "--object")
    height_map: Path | None = option(
        "Your own object, a .npy of heights in mm or a grey .png; what is highest touches first."
    )
    mm_per_px: float | None = option("With --height-map: the size of one sample.")
    relief_mm: float | None = option(
        "With a .png height map: how far white is above black. [default: 1]"
    )

    def read(self) -> tuple[str, Indenter | None]:
        """Return the object's name, and its shape where it is none of ours."""
        if self.height_map is None:
            if self.mm_per_px is not None or self.relief_mm is not None:
                raise UsageError(
                    "--mm-per-px and --relief-mm say how to read a --height-map; give one."
                )
            from geotlm_lm.simulation.indenters import require_shape

            name = "key" if self.object_name is None else self.object_name
            require_shape(name)
            return name, None
        if self.object_name is not None:
            raise UsageError(
                "--object and --height-map both name the object; leave out one of them."
            )
        if self.relief_mm is not None and self.height_map.suffix.lower() == ".npy":
            raise UsageError("--relief-mm is of a .png; the heights of a .npy are in mm already.")
        if self.mm_per_px is None:
            raise UsageError("--height-map needs --mm-per-px, the size of one sample in mm.")
        from geotlm_lm.simulation.shapes import read_height_map

        relief_mm = 1.0 if self.relief_mm is None else self.relief_mm
        shape = read_height_map(self.height_map, self.mm_per_px, relief_mm=relief_mm)
        return self.height_map.stem, shape


class ForwardsClip(TyperCommand):
    """`simulate --clip FILE ...` is `simulate-clip FILE ...`, which it was once part of."""

    def make_context(self, info_name: str, args: list[str], parent: Any = None, **extra: Any):
        """Return the context of the command that runs."""
        words = [word.removeprefix("--clip=") for word in args if word != "--clip"]
        if words == args:
            return super().make_context(info_name, args, parent, **extra)
        command = parent.command.get_command(parent, "simulate-clip")
        return command.make_context("simulate-clip", words, parent, **extra)


@grouped
def simulate(
    *,
    out: Path = option("Folder of the data set; a started one is continued."),
    count: int = option("Clips in the data set.", default=100, min=1),
    objects: Literal["training", "everyday"] = option(
        "Shapes to press: those for training, or 12 everyday ones kept apart.", default="training"
    ),
    mixed: float = option(
        "Share of the clips that turn, slide and press at once.", default=0.0, min=0.0, max=1.0
    ),
    workers: int | None = option("Processes that simulate. [default: one per usable core]", min=1),
    cluster: ClusterAddress = None,
    solving: Solving,
    labels_only: bool = option(
        "Write labels and true fields, and no pictures.", "--labels-only", default=False
    ),
    form: Literal["npz", "huggingface"] = option(
        "Files of the data set: archives of arrays, or tables with pictures for Hugging Face's "
        "datasets.",
        default="npz",
    ),
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
        preset=solving.preset,
        with_drift=solving.drift,
        marker_share=float(solving.markers),
        mixed_share=mixed,
        with_frames=not labels_only,
        form=form,
        progress=progress_on_stderr(),
    )
    print(out)


@grouped
def simulate_clip(
    *,
    out: Path = argument("OUT", "The .npz that is written."),
    moves: Moves,
    pressed: Pressed,
    solving: Solving,
    force: Force = False,
    seed: Seed = 0,
) -> None:
    """Simulate one touch: a clip with its label, turned, slid and pressed as you say.

    Example: geotlm-lm simulate-clip clip.npz --turn 20 --slide-right 0.8 --press 0.1
    """
    if out.suffix != ".npz":
        raise UsageError(f"OUT {out} was given, expected a name that ends in .npz.")
    numbers = moves.numbers()
    name, indenter = pressed.read()
    require_new_file(out, "OUT", is_forced=force)
    from geotlm_lm.simulation.touch import Touch, simulate_motion, simulate_touch

    how = {"preset": solving.preset, "with_drift": solving.drift}
    own = {"indenter": indenter, "is_marked": solving.markers, "seed": seed}
    if numbers:
        made = simulate_touch(Touch(name, **numbers, **own), **how)
    else:
        made = simulate_motion(name, Motion(moves.motion or "clockwise"), **own, **how)
    _write(out, made)
    print(out)


def _write(path: Path, made: SimulatedClip) -> None:
    """Write frames, idle gel, layout, rate, shape of pixels, label (JSON) and drift as .npz."""
    import numpy as np

    label = json.dumps(made.label.to_dict() | {"object": made.object_name})
    arrays = {"frames": made.clip.frames, "label": np.array(label)}
    # The simulated camera's picture is of four to three: no reader need assume it.
    arrays["square_pixels"] = np.array(False)
    arrays["background"], arrays["layout"] = made.clip.background, np.array("THWC-RGB")
    if made.drift_px is not None:
        arrays["drift_px"] = made.drift_px
    arrays["fps"] = np.array(made.clip.fps)
    with replacing(path) as stream:
        np.savez_compressed(stream, **arrays)
