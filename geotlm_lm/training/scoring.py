"""Score a finished bundle on fused tokens, and write its model card: by code alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import pad

from geotlm_lm.checkpoint import CARD_FILE, Bundle, reading_of
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.labels import DIRECTED, ROTATIONS, SLIDES, Motion, MotionLabel
from geotlm_lm.core.numbers import generator_for
from geotlm_lm.core.record import RunRecord
from geotlm_lm.core.twist import COMPONENTS
from geotlm_lm.data.questions import WORDINGS, QuestionAnswer, questions_for
from geotlm_lm.motion.measured import Measured
from geotlm_lm.motion.network import BELIEF_NUMBERS
from geotlm_lm.probe.linear import LinearProbe
from geotlm_lm.simulation.gels import GELS, HELD_OUT_GELS, TRAINING_GELS, Print
from geotlm_lm.training.calibration import expected_calibration_error
from geotlm_lm.training.config import TrainingPreset
from geotlm_lm.training.examples import DAMAGED_SHARE, VARIED
from geotlm_lm.training.geometry import EQUAL_ACCURACY
from geotlm_lm.training.language import UNASKED, felt_words

OPEN_TYPE = "T1"


@dataclass(frozen=True, eq=False)
class ClipSet:
    """Perceived clips with their truth."""

    fused_tokens: Tensor  # z, shape (n, d)
    global_tokens: Tensor  # c, shape (n, d)
    contact_share: NDArray[np.floating]  # mean contact mask, shape (n,)
    measured: Measured  # what is measured of each clip's motion
    labels: Sequence[MotionLabel]
    objects: Sequence[str]  # name of the touched object of each clip

    def readable(self) -> list[int]:
        """Return the rows whose motion leaves a trace in the image."""
        return [row for row, label in enumerate(self.labels) if label.is_readable]

    def readings(self, bundle: Bundle) -> Tensor:
        """Return what the language model of `bundle` reads of each clip, (n, width)."""
        return reading_of(self.fused_tokens, bundle.motion(self.measured))

    def only(self, rows: Sequence[int]) -> ClipSet:
        """Return the clips of `rows`, in that order."""
        return ClipSet(
            fused_tokens=self.fused_tokens[rows],
            global_tokens=self.global_tokens[rows],
            contact_share=self.contact_share[rows],
            measured=self.measured.only(rows),
            labels=[self.labels[row] for row in rows],
            objects=[self.objects[row] for row in rows],
        )


def true_option_likelihoods(
    bundle: Bundle, clips: ClipSet, seed: int
) -> tuple[NDArray[np.floating], NDArray[np.integer]]:
    """Return log-likelihoods (n, options) of the answers to an open question, and the true ones."""
    rows, truths = [], []
    readings = clips.readings(bundle)
    for row in clips.readable():
        asked = _asked(clips.labels[row], seed, row, "seen", (OPEN_TYPE,))[0]
        scores = bundle.speaker.score(readings[row], asked.question, asked.options)
        rows.append(scores)
        truths.append(asked.options.index(asked.answer))
    return np.array(rows), np.array(truths)


def felt_likelihoods(
    bundle: Bundle, clips: ClipSet
) -> tuple[NDArray[np.floating], NDArray[np.integer]]:
    """Return the likelihoods of the words at all slots of which something is asked, and the truth.

    Slots have different numbers of words: what a slot lacks has likelihood 0. Log-likelihoods are
    (n, words), true words (n,).
    """
    felt, wanted = bundle.speaker.feel(clips.readings(bundle)), felt_words(clips.labels)
    most = max(logits.shape[1] for logits in felt.values())
    rows, truths = [], []
    for place, logits in enumerate(felt.values()):
        asked = wanted[:, place] != UNASKED
        lacking = (0, most - logits.shape[1])
        rows.append(pad(logits[asked], lacking, value=-torch.inf).double().numpy())
        truths.append(wanted[asked, place].numpy())
    return np.concatenate(rows), np.concatenate(truths)


def felt_scores(bundle: Bundle, clips: ClipSet, *, is_silent: bool = False) -> dict[str, float]:
    """Return the share of right words at each slot, of those of which something is asked.

    A silent model reads the fused token alone.
    """
    readings = clips.readings(bundle)
    if is_silent:
        readings[:, -BELIEF_NUMBERS:] = bundle.speaker.model.projector.mean[-BELIEF_NUMBERS:]
    felt, wanted = bundle.speaker.feel(readings), felt_words(clips.labels)
    scores = {}
    for place, (slot, logits) in enumerate(felt.items()):
        asked = wanted[:, place] != UNASKED
        scores[slot] = _share((logits.argmax(dim=1) == wanted[:, place])[asked].tolist())
    return scores


def score_bundle(bundle: Bundle, clips: ClipSet, seed: int) -> dict[str, Any]:
    """Return accuracies on objects no weight has seen.

    Answers are free: any sentence may come, and one that is none of the answers counts as wrong, as
    does one withheld for want of contact. The probes choose among the motions of the task.
    """
    readable = clips.readable()
    said = {wordings: _ask_all(bundle, clips, wordings, seed) for wordings in ("seen", "held_out")}
    scores: dict[str, Any] = {
        "clips": len(clips.labels),
        "unreadable_clips": len(clips.labels) - len(readable),
    }
    for task, motions in (("rotation", ROTATIONS), ("sliding", SLIDES)):
        rows = [row for row in readable if clips.labels[row].motion in motions]
        scores[task] = {
            "clips": len(rows),
            "generated": _open_accuracy(said["seen"], rows),
            "generated_held_out_wordings": _open_accuracy(said["held_out"], rows),
            "probe": _probe_accuracy(bundle.model.probe, clips.fused_tokens, clips, rows, motions),
            "global_probe": _probe_accuracy(
                bundle.model.global_probe, clips.global_tokens, clips, rows, motions
            ),
        }
    scores["by_type"] = {
        f"{type_id} {wordings}": _share([one.is_right for one in replies if one.type_id == type_id])
        for wordings, replies in said.items()
        for type_id in dict.fromkeys(one.type_id for one in replies)
    }
    # How often an open question about a clip without direction is answered with one.
    scores["false_directions"] = _share(
        [
            one.claim in DIRECTED
            for one in said["seen"]
            if one.type_id == OPEN_TYPE and clips.labels[one.row].motion not in DIRECTED
        ]
    )
    # How the most likely answer to an open question fares, and its stated probability.
    likelihoods, truths = true_option_likelihoods(bundle, clips, seed)
    is_right = likelihoods.argmax(axis=1) == truths
    confidence = bundle.calibration.probabilities(likelihoods).max(axis=1)
    scores["scored"] = _share(is_right.tolist())
    scores["calibration_error"] = expected_calibration_error(confidence, is_right)
    return scores


@dataclass(frozen=True)
class _Reply:
    """What the model said to one question; `claim` is the motion it names, None if none."""

    row: int
    type_id: str
    is_right: bool
    claim: Motion | None


def _ask_all(bundle: Bundle, clips: ClipSet, wordings: WORDINGS, seed: int) -> list[_Reply]:
    """Ask one question of every type about every readable clip."""
    asked = [
        (row, one)
        for row in clips.readable()
        for one in _asked(clips.labels[row], seed, row, wordings, None)
    ]
    # Questions of one type are of like length: the padding of a batch stays short.
    asked.sort(key=lambda pair: int(pair[1].type_id.removeprefix("T")))
    rows = [row for row, _ in asked]
    texts = bundle.speaker.generate(
        clips.readings(bundle)[rows], [one.question for _, one in asked]
    )
    replies = []
    for (row, one), text in zip(asked, texts, strict=True):
        slots = bundle.grammar.parse(text)
        claim = slots.direction if slots else None
        is_withheld = bundle.calibration.withholds(claim, float(clips.contact_share[row]))
        is_right = text == one.answer and not is_withheld
        replies.append(_Reply(row, one.type_id, is_right, None if is_withheld else claim))
    return replies


def _open_accuracy(replies: Sequence[_Reply], rows: Sequence[int]) -> float:
    wanted = set(rows)
    return _share([r.is_right for r in replies if r.type_id == OPEN_TYPE and r.row in wanted])


def _probe_accuracy(
    probe: LinearProbe, tokens: Tensor, clips: ClipSet, rows: list[int], motions: tuple[Motion, ...]
) -> float:
    said = probe.predict(tokens[rows], motions)
    return _share([one == clips.labels[row].motion for one, row in zip(said, rows, strict=True)])


def _asked(
    label: MotionLabel, seed: int, row: int, wordings: WORDINGS, types: tuple[str, ...] | None
) -> list[QuestionAnswer]:
    rng = generator_for(seed, "scoring", wordings, row)
    return questions_for(label, rng, types=types, wordings=wordings)


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
- Language model: trained from random weights, {preset["language_steps"]:,} steps of
  {preset["language_batch"]} questions.
- Reader of questions: a decoder of its own, {_reader_made(made["command"], preset)}.
- Command: `{made["command"]}`, {seconds / 60:.0f} min on {machine["processor"]}
  ({machine["cores"]} cores, {made["device"]}), torch {machine["versions"]["torch"]}, commit
  {made["commit"] or "unknown"}.
- Size: {size_mb:.1f} MB, perception in half precision; computed in float32."""


def _reader_made(command: str, preset: Mapping[str, Any]) -> str:
    if " --reader " in command:
        return "taken as it is from the bundle before this one"
    teachers, steps = preset["reading_teachers"], preset["taught_steps"]
    taught = f"by each of {teachers}, which taught it in {steps:,} more" if teachers else "once"
    return (
        f"trained from random weights, {preset['reading_steps']:,} steps of "
        f"{preset['reading_batch']} questions that the grammar writes, {taught}"
    )


def _scores_text(scores: dict[str, Any]) -> str:
    return f"""## Scores on simulated everyday objects never trained on

{scores["clips"]} clips, {scores["unreadable_clips"]} left out because their motion changes the
image by less than the camera's noise or is the lesser one in it. Generated answers are free text
over all ten motions, and a direction withheld for want of contact counts as wrong; the probes
choose among the motions of the task.

| task | clips | generated | generated, held-out wordings | probe on z | probe on c, no DGR |
|---|---|---|---|---|---|
{_task_rows(scores)}

A direction is claimed of {100 * scores["false_directions"]:.1f} % of the clips that have none.
Choosing the most likely of the ten answers instead of writing freely is right for
{100 * scores["scored"]:.1f} % of all clips; its stated probability is off by
{100 * scores["calibration_error"]:.1f} % on average (expected calibration error).

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
{_gel_rows(scores["gels"])}

| question type | seen wordings | held-out wordings |
|---|---|---|
{_type_rows(scores)}"""


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
    columns = ("generated", "generated_held_out_wordings", "probe", "global_probe")
    return "\n".join(
        f"| {task} | {scores[task]['clips']} | "
        + " | ".join(f"{scores[task][column]:.3f}" for column in columns)
        + " |"
        for task in ("rotation", "sliding")
    )


def _rate(share: float | None) -> str:
    return "none" if share is None else f"{share:.3f}"


def _type_rows(scores: dict[str, Any]) -> str:
    by_type = scores["by_type"]
    names = [name.removesuffix(" seen") for name in by_type if name.endswith(" seen")]
    return "\n".join(
        f"| {name} | {by_type[f'{name} seen']:.3f} | {by_type[f'{name} held_out']:.3f} |"
        for name in names
    )
