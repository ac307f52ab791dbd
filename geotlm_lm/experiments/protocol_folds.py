"""One task's rows, fold by fold: trained, named, and kept as soon as a fold is done."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import torch

from geotlm_lm.core.atomic import write_text_atomically
from geotlm_lm.evaluation.splits import Fold
from geotlm_lm.experiments.cases import TASKS
from geotlm_lm.experiments.protocol_clips import TaskClips
from geotlm_lm.experiments.protocol_rows import CURL, FLOW, ROWS
from geotlm_lm.probe.logistic import fit_logistic
from geotlm_lm.probe.standardise import Standardiser
from geotlm_lm.training.folds import StandardisedFold, standardise_fold, train_on_fold

Outcome = dict[str, Any]
"""What a row came to on one fold, as plain JSON values: `predictions`, the motion named for each
test row; `seconds`; and of a trained row `best_epoch`, `validation_accuracy`, `parameters`."""


def run_folds(
    clips: TaskClips,
    task: str,
    folds: Sequence[Fold],
    rows: Sequence[str],
    *,
    epochs: int,
    seed: int,
    keep: Callable[[int], Path],
    progress: Callable[[int], None] = lambda done: None,
) -> list[dict[str, Outcome]]:
    """Return what every row came to, fold by fold; folds that were kept are read.

    Args:
        clips: The task's clips.
        task: "rotation" or "sliding".
        folds: The folds.
        rows: Names in `ROWS`.
        epochs: Epochs of every training.
        seed: Offset by the fold's number, it is the root of the fold's training.
        keep: The file of each fold's outcomes.
        progress: Told how many rows of folds are done.
    """
    found = []
    for number, fold in enumerate(folds):
        path = keep(number)
        outcomes = json.loads(path.read_text()) if path.exists() else {}
        reader = _FoldReader(clips, task, fold, epochs, seed + number)
        for done, name in enumerate(rows):
            if name not in outcomes:
                outcomes[name] = reader.outcome(name)
                write_text_atomically(path, json.dumps(outcomes) + "\n")
            progress(number * len(rows) + done + 1)
        found.append({name: outcomes[name] for name in rows})
    return found


class _FoldReader:
    """One fold of a task, standardised once for all rows that read the same tokens."""

    def __init__(self, clips: TaskClips, task: str, fold: Fold, epochs: int, seed: int) -> None:
        self.clips, self.fold = clips, fold
        self.labels, self.epochs, self.seed = TASKS[task], epochs, seed
        self._standardised: dict[int, StandardisedFold] = {}

    def outcome(self, name: str) -> Outcome:
        """Return what one row comes to."""
        started = time.perf_counter()
        read = {FLOW: self._flow, CURL: self._curl}.get(name, partial(self._trained, name))
        found = read()
        found["predictions"] = [motion.value for motion in found["predictions"]]
        return found | {"seconds": time.perf_counter() - started}

    def _flow(self) -> Outcome:
        """Read what was named when the clip was at hand: nothing is trained."""
        return {"predictions": [self.clips.flow[row] for row in self.fold.test]}

    def _curl(self) -> Outcome:
        """Fit the logistic line on the training rows; there is no epoch to choose."""
        features = torch.from_numpy(self.clips.curl)
        standardiser = Standardiser.fit(features[self.fold.train])
        motions = [self.clips.truths[row] for row in self.fold.train]
        probe = fit_logistic(standardiser.apply(features[self.fold.train]), motions, self.labels)
        return {
            "predictions": probe.predict(standardiser.apply(features[self.fold.test])),
            "parameters": sum(parameter.numel() for parameter in probe.parameters()),
        }

    def _trained(self, name: str) -> Outcome:
        row = ROWS[name]
        if row.frames not in self._standardised:
            data = self.clips.data[row.frames]
            self._standardised[row.frames] = standardise_fold(data, self.fold)
        outcome = train_on_fold(
            self._standardised[row.frames],
            self.labels,
            row.recipe,
            epochs=self.epochs,
            seed=self.seed,
        )
        return dict(vars(outcome))
