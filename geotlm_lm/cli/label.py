"""`geotlm-lm label`: what a camera of a LeRobot data set felt, as columns of a new one."""

from __future__ import annotations

from pathlib import Path

from geotlm_lm.cli.options import (
    Answering,
    ClusterAddress,
    SquarePixels,
    argument,
    grouped,
    option,
    require_writable,
)
from geotlm_lm.cli.progress import print_notes, progress_on_stderr
from geotlm_lm.runs.run import Workers

REFUSED_TOLD = 5
"""Episodes that could not be tracked which are told; of more than these, how many."""


@grouped
def label(
    *,
    data_set: Path = argument("DATASET", "Folder of a LeRobot data set, version 3."),
    camera: str = option("The touch sensor's feature, as observation.images.tactile."),
    out: Path = option("Folder of the new data set; a stopped run is continued."),
    workers: int | None = option("Processes that track. [default: one per usable core]", min=1),
    cluster: ClusterAddress = None,
    square_pixels: SquarePixels = None,
    answering: Answering,
) -> None:
    """Label a LeRobot data set: how the touched object turns and travels in every frame.

    Every episode is tracked; the data set that is written beside the original holds its columns,
    the rates and the contact of each frame with their deviations, and a table of events. Videos
    are linked or copied, never encoded again.

    Example: geotlm-lm label robot --camera observation.images.tactile --out robot_labelled
    """
    by = Workers(workers, cluster)
    scale = answering.frame.mm_per_px
    from geotlm_lm.data_sets.lerobot import read_data_set

    read_data_set(data_set).require_camera(camera)
    require_writable(out.parent, "--out")

    # Imported only now: a wrong path must not wait for the model's libraries.
    from geotlm_lm.data_sets.labelling import Labelling, label_data_set

    labelling = Labelling(data_set, camera, answering.model, square_pixels, scale)
    result = label_data_set(labelling, out, workers=by, progress=progress_on_stderr("episodes"))
    if result.continued:
        print_notes(f"{result.continued} episodes were there from a stopped run")
    for index, why in list(result.refused.items())[:REFUSED_TOLD]:
        print_notes(f"episode {index} has no labels: {why}")
    if len(result.refused) > REFUSED_TOLD:
        print_notes(f"{len(result.refused)} episodes in all have no labels")
    print(f"{out}: {result.episodes} episodes, {result.frames} frames, {result.events} events")
