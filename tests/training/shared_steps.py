"""The two trainings that ranks share, at sizes of a second: alone, or as one of several ranks.

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
from geotlm_lm.language.size import LanguageSize
from geotlm_lm.motion.belief import BELIEF_NUMBERS
from geotlm_lm.training import language
from geotlm_lm.training import ranks as ranks_module
from geotlm_lm.training.config import SMOKE
from geotlm_lm.training.examples import Examples
from geotlm_lm.training.grammar import corpus
from geotlm_lm.training.language import LanguageTraining, Taught, train_language
from geotlm_lm.training.pretraining import pretrain
from geotlm_lm.training.ranks import joined
from geotlm_lm.training.sentences import Row, Sentences

STEPS = 6
PRETRAINING = replace(
    SMOKE, backbone_width=8, backbone_depth=1, pretraining_batch=4, pretraining_draws=4 * STEPS
)
LANGUAGE = LanguageTraining(
    english_steps=STEPS,
    reading_steps=STEPS,
    slots_steps=STEPS,
    sentences_steps=STEPS,
    batch=16,
    warmup=2,
    dropout=0,  # which byte pairs are left apart no seed governs
    vocabulary=300,
    size=LanguageSize(width=32, layers=1, heads=2, mlp=32, speaking=1),
)
STAGES_BEFORE = "language, english", "language, reading", "language, slots"
"""Those that the language model's last stage goes on from."""
PASSAGES = ["a cap turns about its axis when a hand turns it, and so does a lid of a jar"] * 20
SAID = "It turns clockwise, about 12 degrees, in the camera image."


def random_answers():
    """Answers about random numbers, of clips of which a part is not asked about."""
    rng = np.random.default_rng(0)
    return Sentences(
        numbers=rng.standard_normal((5, 12 + BELIEF_NUMBERS)).astype(np.float16),
        words=np.array([[0, 4, 2, 0], [1, 0, -1, 0], [2, 2, 1, 1], [0, 1, 1, 0], [1, 1, 0, 0]]),
        labels=(MotionLabel(Motion.CLOCKWISE),) * 5,
        rows=tuple(Row(k % 5, "which way?" + " ok" * k, "way all", SAID, True) for k in range(9)),
        asked=9,
    )


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
    told = {}

    def progress(what, step, _):
        stage, loss = what.split(", loss ")
        told.setdefault(stage, []).append(float(loss))
        if step == last < STEPS and stage not in STAGES_BEFORE:
            raise KeyboardInterrupt

    shared = {"folder": folder, "progress": progress, "ranks": ranks}
    language.VOCABULARY_PAIRS = 200
    # Half as precise products round otherwise in shares: what is compared is who takes which rows.
    ranks_module.has_bfloat16 = lambda kind: False
    taught = Taught(corpus("train")[:20], PASSAGES, random_answers(), (12, BELIEF_NUMBERS))
    for training in (
        lambda: pretrain(random_examples(), preset=PRETRAINING, seed=0, **shared),
        lambda: train_language(LANGUAGE, taught, **shared),
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
