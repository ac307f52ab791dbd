"""The model card of a trained bundle: how it was made and what it scored, by code alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from geotlm_lm.checkpoint import CARD_FILE, Bundle
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.core.record import RunRecord
from geotlm_lm.core.twist import COMPONENTS
from geotlm_lm.training.config import TrainingPreset
from geotlm_lm.training.examples import DAMAGED_SHARE, VARIED
from geotlm_lm.training.geometry import EQUAL_ACCURACY

SCORES_FILE = "scores.json"


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
    record.save(folder / SCORES_FILE)
    write_text_atomically(folder / CARD_FILE, _card(folder, bundle, scores, seconds))


def _card(folder: Path, bundle: Bundle, scores: dict[str, Any], seconds: float) -> str:
    return f"""---
license: apache-2.0
tags: [tactile, gelsight, robotics]
---
# Embedded tactile-language bundle

{_how_made(folder, bundle, seconds)}

{_scored(scores)}

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
    markers = VARIED["marker_share"]
    fresh = TrainingPreset(**preset).fresh_clips
    pretrained_on = preset["pretraining_clips"] + preset["head_clips"] - fresh
    parameters = sum(one.numel() for one in bundle.motion.parameters())
    size_mb = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 1e6
    return f"""\
Answers questions about the motion of a touched object in a four-frame clip of a GelSight-like
sensor. Every weight was trained on simulated clips alone: {VARIED["mixed_share"]:.0%} of them
turn, slide and press at once, {markers:.0%} are on gels with markers, {DAMAGED_SHARE:.0%} damaged
by compression, a dim or drifting camera or a faint touch.

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
- Reader of questions: a decoder of its own, trained from random weights,
  {preset["reading_steps"]:,} steps of {preset["reading_batch"]} questions that the grammar writes,
  {_taught(preset)}.
- Command: `{made["command"]}`, {seconds / 60:.0f} min on {machine["processor"]}
  ({machine["cores"]} cores, {made["device"]}), torch {machine["versions"]["torch"]}, commit
  {made["commit"] or "unknown"}.
- Size: {size_mb:.1f} MB, perception in half precision; computed in float32."""


def _taught(preset: dict[str, Any]) -> str:
    teachers, steps = preset["reading_teachers"], preset["taught_steps"]
    return f"by each of {teachers}, which taught it in {steps:,} more" if teachers else "once"


def _scored(scores: dict[str, Any]) -> str:
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

Of freely mixed motions of the same objects, readable components that are not ambiguous:

| component | n | way | counts | amount within tolerance | span holds it |
|---|---|---|---|---|---|
{_mixed_rows(scores["mixed"])}

Where a clip turns and slides both are right in {_share(scores["mixed"].get("both ways"))}. The
words at the language model's slots are right in {_felt(scores["felt"])}; by the fused token alone
in {_felt(scores["felt by the fused token alone"])}. An amount is right within 2 degrees, 2 pixels
of the 224-pixel image, 0.2 mm, or a fifth.

| question type | seen wordings | held-out wordings |
|---|---|---|
{_type_rows(scores)}"""


def _mixed_rows(mixed: dict[str, float]) -> str:
    columns = ("way", "counts", "amount", "span")
    return "\n".join(
        f"| {component} | {mixed.get(f'{component} way, number', 0):.0f} | "
        + " | ".join(_share(mixed.get(f"{component} {column}")) for column in columns)
        + " |"
        for component in COMPONENTS
    )


def _felt(slots: dict[str, float]) -> str:
    return ", ".join(f"{slot} {share:.3f}" for slot, share in slots.items())


def _task_rows(scores: dict[str, Any]) -> str:
    columns = ("generated", "generated_held_out_wordings", "probe", "global_probe")
    return "\n".join(
        f"| {task} | {scores[task]['clips']} | "
        + " | ".join(f"{scores[task][column]:.3f}" for column in columns)
        + " |"
        for task in ("rotation", "sliding")
    )


def _share(share: float | None) -> str:
    return "none" if share is None else f"{share:.3f}"


def _type_rows(scores: dict[str, Any]) -> str:
    by_type = scores["by_type"]
    names = [name.removesuffix(" seen") for name in by_type if name.endswith(" seen")]
    return "\n".join(
        f"| {name} | {by_type[f'{name} seen']:.3f} | {by_type[f'{name} held_out']:.3f} |"
        for name in names
    )
