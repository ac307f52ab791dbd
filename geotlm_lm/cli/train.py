"""`geotlm-lm train`: make a model bundle from nothing but the simulator."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from geotlm_lm.cli.options import Seed, path_option, require_writable
from geotlm_lm.cli.progress import progress_on_stderr
from geotlm_lm.core.errors import UsageError


def train(
    out: Annotated[Path, path_option(help="Run folder; an interrupted run in it is continued.")],
    preset: Annotated[
        str | None,
        typer.Option(
            help="smoke (minutes, to see it run) or default (the shipped bundle). [default: "
            "default; with --keep the kept bundle's own]"
        ),
    ] = None,
    seed: Seed = 0,
    workers: Annotated[int, typer.Option(min=1, help="Processes that simulate.")] = 2,
    keep: Annotated[
        Path | None,
        path_option(help="Bundle of which all but the odometer is kept; only that is trained."),
    ] = None,
) -> None:
    """Train a model bundle; its folder is printed at the end, progress goes to stderr.

    Example: geotlm-lm train --preset smoke --out runs/smoke
    """
    if keep is not None:
        if preset is not None:
            raise UsageError(
                "--preset cannot go with --keep, which uses the kept bundle's own; leave out one "
                "of them."
            )
        from geotlm_lm.checkpoint import read_config

        read_config(keep)  # told before the training is loaded
        require_writable(out, "--out")
        from geotlm_lm.training.retraining import retrain_odometer

        print(f"training the odometer of {keep} into {out}", file=sys.stderr)
        print(retrain_odometer(keep, out, seed, workers, progress_on_stderr("")))
        return
    from geotlm_lm.training.config import preset_named

    settings = preset_named("default" if preset is None else preset)
    require_writable(out, "--out")
    from geotlm_lm.training.train import train as train_bundle

    print(f"training preset {settings.name} into {out}", file=sys.stderr)
    print(train_bundle(settings.name, out, seed, workers, progress_on_stderr("")))
