"""Where an answer's milliseconds go, stage by stage: each one alone, on one clip, in turn."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from geotlm_lm.answering import four_frames_with_background
from geotlm_lm.backbone.evened import evened_motions
from geotlm_lm.backbone.stem import look
from geotlm_lm.core.clip import Clip
from geotlm_lm.experiments.judging import QUESTION
from geotlm_lm.experiments.runtime import spread
from geotlm_lm.recordings.read import read_clip

if TYPE_CHECKING:
    from geotlm_lm.answering import Answerer

RECORDING_FRAMES = 125
"""Frames of a recording that four are chosen from: 5 s at 25 fps."""


def stage_rows(answerer: Answerer, clip: Clip, repeats: int) -> list[dict[str, Any]]:
    """Return milliseconds of every stage of an answer.

    Args:
        answerer: The model.
        clip: Four frames with a background.
        repeats: Times each stage runs, after one that is not counted.
    """
    with tempfile.TemporaryDirectory() as folder:
        stages = _stages(answerer, clip, Path(folder))
        times: dict[str, list[float]] = {name: [] for name in stages}
        for repeat in range(repeats + 1):
            for name, stage in stages.items():
                started = time.perf_counter()
                stage()
                if repeat:
                    times[name].append(1e3 * (time.perf_counter() - started))
    return [{"stage": name, **spread(own)} for name, own in times.items()]


def _stages(answerer: Answerer, clip: Clip, folder: Path) -> dict[str, Callable[[], object]]:
    model, speaker = answerer.bundle.model, answerer.bundle.speaker
    path = folder / "clip.npz"
    np.savez_compressed(path, frames=clip.frames, background=clip.background)
    recording = long_recording(clip)
    seen, _, traces = look(clip)
    inputs = torch.from_numpy(seen)[None]
    tokens = model.backbone.encode_inputs(inputs)
    token = model.fuse(tokens).fused_token
    sentences = answerer.bundle.grammar.options_for("direction")
    return {
        "read 4 frames, .npz": lambda: read_clip(path),
        "choose 4 of 125 frames": lambda: four_frames_with_background(recording),
        "stem: residual, flow, alignment": lambda: look(clip),
        "backbone": lambda: model.backbone.encode_inputs(inputs),
        "DGR and fused token": lambda: model.fuse(tokens),
        "probe": lambda: model.probe.predict(token),
        "how far: motions of evened images": lambda: evened_motions(traces),
        "LM: prompt read": _prefill(answerer, token),
        "LM: one token": _one_token(answerer, token),
        "LM: whole answer, token by token": lambda: speaker.generate(token, [QUESTION]),
        "LM: ten answers weighed, what is written among them": lambda: speaker.weigh(
            token[0], QUESTION, sentences
        ),
    }


def long_recording(clip: Clip) -> Clip:
    """Return the idle gel and then the clip, each frame held: what frames are chosen from."""
    lead = RECORDING_FRAMES // 5
    held = (RECORDING_FRAMES - lead) // len(clip)
    idle = np.repeat(clip.background[None], RECORDING_FRAMES - held * len(clip), axis=0)
    return Clip(np.concatenate([idle, np.repeat(clip.frames, held, axis=0)]))


def _prefill(answerer: Answerer, token: torch.Tensor) -> Callable[[], object]:
    model = answerer.bundle.speaker.model
    ids = torch.tensor([answerer.bundle.speaker.prompts.prompt(QUESTION)])
    positions = torch.arange(ids.shape[1])[None]

    @torch.inference_mode()
    def prefill() -> object:
        return model.decoder(model.embed(ids, model.projector(token)), positions)

    return prefill


def _one_token(answerer: Answerer, token: torch.Tensor) -> Callable[[], object]:
    model = answerer.bundle.speaker.model
    _, cache = _prefill(answerer, token)()
    past = cache[0][0].shape[2]
    place = torch.tensor([[past]])
    visible = torch.ones(1, 1, 1, past + 1, dtype=torch.bool)

    @torch.inference_mode()
    def step() -> object:
        hidden, _ = model.decoder(model.embed(torch.tensor([[0]]), None), place, visible, cache)
        return model.logits(hidden[:, -1]).argmax(-1)

    return step
