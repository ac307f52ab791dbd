"""`geotlm-lm train`: make a model bundle from nothing but the simulator."""

from __future__ import annotations

import sys
from pathlib import Path

from geotlm_lm.cli.options import Seed, grouped, option, require_writable
from geotlm_lm.cli.progress import progress_on_stderr
from geotlm_lm.core.files import training_templates


@grouped
def train(
    out: Path = option("Run folder; an interrupted run in it is continued."),
    preset: str = option(
        "smoke (minutes, to see it run), default, or full (with a larger language model: twenty "
        "minutes of a GPU more).",
        default="default",
    ),
    seed: Seed = 0,
    workers: int = option(
        "Processes that simulate, and that draw questions for a GPU.", default=2, min=1
    ),
    device: str | None = option("cpu or cuda; cuda where there is one if not given."),
    start: Path | None = option(
        "Bundle that is taken as it is up to --stage, and made anew from there."
    ),
    stage: str = option(
        "From where on it is made anew: language (all of it), reading (which goes on learning), "
        "slots (what is felt) or sentences.",
        default="language",
    ),
) -> None:
    """Train a model bundle; its folder is printed at the end, progress goes to stderr.

    Several processes share every step when torchrun starts them; the first one tells how far it is.

    Example: geotlm-lm train --preset smoke --out runs/smoke

    Example: geotlm-lm train --preset full --out runs/language --start geotlm_lm/bundle

    Example: geotlm-lm train --out runs/spoken --start geotlm_lm/bundle --stage sentences

    Example: torchrun --nproc-per-node 2 -m geotlm_lm train --out runs/default
    """
    from geotlm_lm.training.config import preset_named

    settings = preset_named(preset)
    require_writable(out, "--out")
    training_templates()  # an installed package has none: said before hours of simulation
    from geotlm_lm.training.ranks import is_first_of_launch
    from geotlm_lm.training.train import train as train_bundle

    if is_first_of_launch():
        print(f"training preset {settings.name} into {out}", file=sys.stderr)
    progress = progress_on_stderr("")
    options = (seed, workers, progress, device, start, stage)
    folder = train_bundle(settings.name, out, *options)
    if is_first_of_launch():
        print(folder)
