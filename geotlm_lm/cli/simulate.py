"""`geotlm-lm simulate`: a data set of clips from the simulator."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer
from typer.core import TyperCommand

from geotlm_lm.cli.options import ClusterAddress, Seed, path_option, require_writable
from geotlm_lm.cli.simulate_clip import Drift, Markers, SolverPreset
from geotlm_lm.runs.run import Workers

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
