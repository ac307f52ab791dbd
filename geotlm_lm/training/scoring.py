"""Score a finished bundle on perceived clips, and write its model card: by code alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from geotlm_lm.checkpoint import CARD_FILE, Bundle, reading_of
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.labels import ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.core.record import RunRecord
from geotlm_lm.core.twist import COMPONENTS
from geotlm_lm.language.size import SLOTS
from geotlm_lm.motion.belief import BELIEF_NUMBERS
from geotlm_lm.motion.measured import Measured
from geotlm_lm.motion.network import belief_of_one
from geotlm_lm.probe.linear import LinearProbe
from geotlm_lm.query.program import WAY_ATOMS
from geotlm_lm.simulation.gels import GELS, HELD_OUT_GELS, TRAINING_GELS, Print
from geotlm_lm.training.config import TrainingPreset
from geotlm_lm.training.examples import DAMAGED_SHARE, VARIED
from geotlm_lm.training.geometry import EQUAL_ACCURACY
from geotlm_lm.training.sentences import felt_words
from geotlm_lm.training.truth import UNASKED


@dataclass(frozen=True, eq=False)
class ClipSet:
    """Perceived clips with their truth."""

    fused_tokens: Tensor  # z, shape (n, d)
    global_tokens: Tensor  # c, shape (n, d)
    contact_share: NDArray[np.floating]  # mean contact mask, shape (n,)
    measured: Measured  # what is measured of each clip's motion
    labels: Sequence[MotionLabel]

    def readable(self) -> list[int]:
        """Return the rows whose motion leaves a trace in the image."""
        return [row for row, label in enumerate(self.labels) if label.is_readable]

    @torch.no_grad()
    def readings(self, bundle: Bundle) -> Tensor:
        """Return what the language model of `bundle` reads of each clip, (n, width)."""
        beliefs = bundle.motion(self.measured)
        each = (belief_of_one(beliefs, row) for row in range(len(self.labels)))
        return reading_of(self.fused_tokens, each)


def felt_likelihoods(
    bundle: Bundle, clips: ClipSet
) -> tuple[NDArray[np.floating], NDArray[np.integer]]:
    """Return the likelihoods of the words at all slots of which something is asked, and the truth.

    Slots have different numbers of words: what a slot lacks has likelihood 0. Log-likelihoods are
    (n, words), true words (n,).
    """
    slots, wanted = _felt(bundle, clips.readings(bundle)), felt_words(clips.labels).numpy()
    most = max(map(len, SLOTS.values()))
    rows, truths = [], []
    for place, likelihoods in enumerate(slots.values()):
        asked = wanted[:, place] != UNASKED
        lacking = (0, 0), (0, most - likelihoods.shape[1])
        rows.append(np.pad(likelihoods[asked], lacking, constant_values=-np.inf))
        truths.append(wanted[asked, place])
    return np.concatenate(rows), np.concatenate(truths)


def _felt(bundle: Bundle, readings: Tensor) -> dict[str, NDArray[np.float64]]:
    """Return the log-likelihoods of the words at each slot, (n, words)."""
    slots = [bundle.speaker.prefix(each).slots for each in readings.detach().numpy()]
    return {slot: np.array([each[slot] for each in slots], np.float64) for slot in SLOTS}


def felt_scores(bundle: Bundle, clips: ClipSet, *, is_silent: bool = False) -> dict[str, float]:
    """Return the share of right words at each slot, of those of which something is asked.

    A silent model reads the fused token alone.
    """
    readings = clips.readings(bundle)
    if is_silent:
        mean = torch.from_numpy(bundle.reader.decoder.projector["mean"])
        readings[:, -BELIEF_NUMBERS:] = mean[-BELIEF_NUMBERS:]
    slots, wanted = _felt(bundle, readings), felt_words(clips.labels).numpy()
    scores = {}
    for place, (slot, likelihoods) in enumerate(slots.items()):
        asked = wanted[:, place] != UNASKED
        scores[slot] = _share((likelihoods.argmax(axis=1) == wanted[:, place])[asked].tolist())
    return scores


def score_bundle(bundle: Bundle, clips: ClipSet) -> dict[str, Any]:
    """Return accuracies on objects no weight has seen, among the motions of each task."""
    readable = clips.readable()
    slots = _felt(bundle, clips.readings(bundle))
    scores: dict[str, Any] = {
        "clips": len(clips.labels),
        "unreadable_clips": len(clips.labels) - len(readable),
    }
    for task, slot, motions in (("rotation", "turn", ROTATIONS), ("sliding", "slide", SLIDES)):
        rows = [row for row in readable if clips.labels[row].motion in motions]
        words = [WAY_ATOMS.get(word) for word in SLOTS[slot]]
        places = [words.index(motion) for motion in motions]
        named = slots[slot][rows][:, places].argmax(axis=1)
        named = [motions[place] for place in named]
        true = [clips.labels[row].motion for row in rows]
        right = [one is other for one, other in zip(named, true, strict=True)]
        plain = bundle.model.global_probe
        scores[task] = {
            "clips": len(rows),
            "language model's slots": _share(right),
            "probe": _probe_accuracy(bundle.model.probe, clips.fused_tokens, clips, rows, motions),
            "global_probe": _probe_accuracy(plain, clips.global_tokens, clips, rows, motions),
        }
    return scores


def _probe_accuracy(
    probe: LinearProbe, tokens: Tensor, clips: ClipSet, rows: list[int], motions: tuple[Motion, ...]
) -> float:
    named = probe.predict(tokens[rows], motions)
    return _share([one == clips.labels[row].motion for one, row in zip(named, rows, strict=True)])


def _share(hits: Sequence[bool]) -> float:
    """Return the share of hits; 0 where there is nothing to count, since JSON knows no NaN."""
    return float(np.mean(hits)) if hits else 0.0


def write_card(folder: Path, bundle: Bundle, scores: dict[str, Any], seconds: float) -> None:
    """Write the scores, as a run record, and the card into the bundle's folder."""
    made = bundle.provenance
    record = RunRecord(
        name="train",
        command=made["command"],
        seed=made["seed"],
        seconds=round(seconds),
        numbers=scores,
        config={name: made[name] for name in ("preset", "device", "dgr_validation_accuracy")},
        commit=made["commit"],
        machine=made["machine"],
    )
    record.save(folder / "scores.json")
    write_text_atomically(folder / CARD_FILE, _card(folder, bundle, scores, seconds))


def _card(folder: Path, bundle: Bundle, scores: dict[str, Any], seconds: float) -> str:
    return f"""---
license: apache-2.0
tags: [tactile, gelsight, robotics]
---
# Embedded tactile-language bundle

{_how_made(folder, bundle, seconds)}

{_scores_text(scores)}

## Limits

One contact per clip. Directions are told in the camera image, object relative to
sensor. A smooth ball turning about its own axis does not change a markerless
image and cannot be read.
"""


def _how_made(folder: Path, bundle: Bundle, seconds: float) -> str:
    made = bundle.provenance
    config = bundle.model.backbone.vit.config
    preset, machine = made["preset"], made["machine"]
    modes = ", ".join(
        f"{mode} {value:.3f}" for mode, value in made["dgr_validation_accuracy"].items()
    )
    shares = TRAINING_GELS.items()
    printed = sum(share for name, share in shares if GELS[name].printed is not Print.NONE)
    fresh = TrainingPreset(**preset).fresh_clips
    pretrained_on = preset["pretraining_clips"] + preset["head_clips"] - fresh
    parameters = sum(weight.numel() for weight in bundle.motion.parameters())
    kinds, left_out = ("; ".join(gels) for gels in (TRAINING_GELS, HELD_OUT_GELS))
    size_mb = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 1e6
    return f"""\
Answers questions about the motion of a touched object in a four-frame clip of a GelSight-like
sensor. Every weight was trained on simulated clips alone: {VARIED["mixed_share"]:.0%} of them
turn, slide and press at once, {printed:.0%} are on gels that are printed on, {DAMAGED_SHARE:.0%}
damaged by compression, a dim or drifting camera or a faint touch.

- Gels: {kinds}. Left out of training, and judged on below: {left_out}.
- Backbone: ViT, width {config.width}, {config.depth} layers, {config.heads} heads, one
  token for both time-bins of a patch, frozen after pretraining on {pretrained_on:,} simulated
  clips, each drawn as it is or seen in a mirror ({preset["pretraining_draws"]:,} draws), with the
  simulator's dense displacement, contact and depth; DGR learnt from {fresh:,} others.
- DGR: the probe's mean accuracy on turns and slides of objects kept from training: {modes}, each
  at the epoch that was best on them; `grounded` is stored unless `paper` leads by more than
  {EQUAL_ACCURACY:g}.
- Motion: turn, slide, press and contact with their spread, {parameters:,} weights on the rigid
  motions of residual, relief and learned shear and on the fused token; before training it tells
  the measured motions.
- Language model: {_language_made(bundle)}
- Command: `{made["command"]}`, {seconds / 60:.0f} min on {machine["processor"]}
  ({machine["cores"]} cores, {made["device"]}), torch {machine["versions"]["torch"]}, commit
  {made["commit"] or "unknown"}.
- Size: {size_mb:.1f} MB, perception in half precision; computed in float32."""


def _language_made(bundle: Bundle) -> str:
    made, decoder = bundle.provenance["preset"], bundle.reader.decoder
    size, weights = decoder.size, sum(x.size for x in decoder.stored.values())
    return f"""a Llama decoder of transformers, {size.layers} layers of width {size.width} that read
  and {size.speaking} above them that speak, {weights:,} weights, from random ones unless the
  command names a bundle: {made["english_steps"]:,} steps on English (free texts of Debian
  packages), {made["reading_steps"]:,} on questions and their programs, {made["slots_steps"]:,} on
  what is felt in {made["answer_clips"]:,} simulated clips, {made["sentences_steps"]:,} on answers
  about them;
  {made["language_batch"]} questions a step, each learned from {made["question_passes"]} times."""


def _scores_text(scores: dict[str, Any]) -> str:
    return f"""## Scores on simulated everyday objects never trained on

{scores["clips"]} clips, {scores["unreadable_clips"]} left out because their motion changes the
image by less than the camera's noise or is the lesser one in it. All choose among the motions of
the task.

| task | clips | language model's slots | probe on z | probe on c, no DGR |
|---|---|---|---|---|
{_task_rows(scores)}

Of freely mixed motions of the same objects, readable components that move by 0.3 px or 0.06 mm, or
more:

| component | n | way | told the right way | told at rest | amount in tolerance | in span |
|---|---|---|---|---|---|---|
{_mixed_rows(scores["mixed"])}

Where a clip turns and slides both are right in {_rate(scores["mixed"].get("both ways"))}. The
words at the language model's slots are right in {_slots(scores["felt"])}; by the fused token alone
in {_slots(scores["felt by the fused token alone"])}. An amount is right within 2 degrees, 2 pixels
of the 224-pixel image, 0.2 mm, or a fifth.

On kinds of gel in training (`validation`, by which spans are widened) and on kinds left out of it,
of clips like training's:

| gels | kind | n | turn way | slide way | both ways | turn amount | slide amount |
|---|---|---|---|---|---|---|---|
{_gel_rows(scores["gels"])}"""


def _mixed_rows(mixed: dict[str, float]) -> str:
    columns = ("way", "seen", "false", "amount", "span")
    return "\n".join(
        f"| {component} | {mixed.get(f'{component} way, number', 0):.0f} | "
        + " | ".join(_rate(mixed.get(f"{component} {column}")) for column in columns)
        + " |"
        for component in COMPONENTS
    )


def _gel_rows(gels: dict[str, dict[str, dict[str, float]]]) -> str:
    columns = ("turn way", "slide way", "both ways", "turn amount", "slide amount")
    return "\n".join(
        f"| {title} | {name} | {sum(scores.get(f'{way}, number', 0) for way in columns[:2]):.0f} | "
        + " | ".join(_rate(scores.get(column)) for column in columns)
        + " |"
        for title, kinds in gels.items()
        for name, scores in kinds.items()
    )


def _slots(slots: dict[str, float]) -> str:
    return ", ".join(f"{slot} {share:.3f}" for slot, share in slots.items())


def _task_rows(scores: dict[str, Any]) -> str:
    columns = ("language model's slots", "probe", "global_probe")
    return "\n".join(
        f"| {task} | {scores[task]['clips']} | "
        + " | ".join(f"{scores[task][column]:.3f}" for column in columns)
        + " |"
        for task in ("rotation", "sliding")
    )


def _rate(share: float | None) -> str:
    return "none" if share is None else f"{share:.3f}"
