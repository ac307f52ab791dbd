"""The three trainings that ranks share, at sizes of a second: alone, or as one of several ranks.

torchrun --nproc-per-node 2 -m tests.training.shared_steps FOLDER LAST_STEP
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch

from geotlm_lm.backbone.motions import MOTIONS_SHAPE
from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.language.decoder import LanguageSize
from geotlm_lm.query.grammar import corpus
from geotlm_lm.training import reading
from geotlm_lm.training.config import SMOKE
from geotlm_lm.training.examples import Examples
from geotlm_lm.training.language import LanguageTraining, train_language
from geotlm_lm.training.pretraining import pretrain
from geotlm_lm.training.ranks import joined
from geotlm_lm.training.reading import ReadingTraining, train_reader

STEPS = 6
PRETRAINING = replace(
    SMOKE, backbone_width=8, backbone_depth=1, pretraining_batch=4, pretraining_draws=4 * STEPS
)
SIZE = LanguageSize(width=32, layers=1, heads=2, mlp=32, tactile_tokens=2, max_tokens=104)
LANGUAGE = LanguageTraining(steps=STEPS, batch=8, warmup=2, motion_width=18, size=SIZE)
READING = ReadingTraining(
    steps=STEPS,
    batch=16,
    warmup=2,
    dropout=0,  # which byte pairs are left apart no seed governs
    vocabulary=300,
    size=replace(SIZE, tactile_tokens=0, max_tokens=704),
)
LABELS = [MotionLabel(motion) for motion in Motion for _ in range(4)]


def random_examples():
    """Random inputs and truth of the right shapes, of clips of which some show no motion."""
    rng = np.random.default_rng(0)
    count = 20

    def random(*shape):
        return rng.random((count, *shape)).astype(np.float16)

    motions = list(Motion) * 2
    return Examples(
        inputs=random(2, 14, 14, PATCH_INPUT_DIM),
        motions=random(*MOTIONS_SHAPE),
        displacement_px=random(2, 14, 14, 2),
        contact=(random(2, 14, 14) > 0.5).astype(np.float16),
        depth_mm=random(2, 14, 14),
        labels=tuple(MotionLabel(motion, is_readable=i > 1) for i, motion in enumerate(motions)),
        objects=("ball",) * count,
        gels=("mini",) * count,
    )


def curves(folder, ranks, last=STEPS):
    """Take the steps up to `last` of each training; return the losses told, by name."""
    tokens = torch.randn(len(LABELS), 30, generator=torch.Generator().manual_seed(0)) * 3 + 1
    told = {}

    def progress(what, step, _):
        stage, loss = what.split(", loss ")
        told.setdefault(stage, []).append(float(loss))
        if step == last < STEPS:
            raise KeyboardInterrupt

    shared = {"folder": folder, "progress": progress, "ranks": ranks}
    reading.VOCABULARY_PAIRS = 200
    for training in (
        lambda: pretrain(random_examples(), preset=PRETRAINING, seed=0, **shared),
        lambda: train_language(tokens, LABELS, config=LANGUAGE, **shared),
        lambda: train_reader(READING, corpus=corpus("train")[:20], **shared),
    ):
        try:
            training()
        except KeyboardInterrupt:
            continue
    return told


if __name__ == "__main__":
    torch.set_num_threads(1)
    with joined("cpu") as ranks:
        told = curves(Path(sys.argv[1]), ranks, int(sys.argv[2]))
        (Path(sys.argv[1]) / f"losses_{ranks.rank}.json").write_text(json.dumps(told))
