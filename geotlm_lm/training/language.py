"""Train the projector and the decoder on clips' readings and labels; the readings stay as they are.

Every step asks questions, drawn afresh from the labels, seen wordings only, of which the loss
counts answer tokens only; and what is felt in the slots, turn, slide, press and contact, of more
clips, in one pass each.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import cross_entropy

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.files import resource_dir
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.core.numbers import generator_for, seed_for
from geotlm_lm.core.process import Progress, silent, uninterrupted_step
from geotlm_lm.core.twist import COMPONENTS
from geotlm_lm.data.questions import askable_types, questions_for, training_corpus, with_typo
from geotlm_lm.language.decoder import LanguageSize, TactileDecoder, initialise
from geotlm_lm.language.generation import Speaker
from geotlm_lm.language.prompt import PromptEncoder
from geotlm_lm.language.slots import SLOTS
from geotlm_lm.language.tokenizer import VOCABULARY_SIZE, clean_question, train_tokenizer
from geotlm_lm.training.fit import load_checkpoint, save_checkpoint
from geotlm_lm.training.ranks import ALONE, Ranks
from geotlm_lm.training.truth import component_truth

WEIGHT_DECAY = 0.1
"""Of the matrices; gains, biases and embeddings are left alone."""

CORPUS_ROUNDS = 16
"""Questions per type and motion the vocabulary is built from; enough to fill it."""

CHECKPOINT_EVERY_S = 30.0

COOLDOWN_SHARE = 1 / 9
"""Steps after the schedule's, relative to them, in which the rate falls from its last tenth to
nothing: the weights settle, where they would end wherever the last batches threw them."""

FELT_BATCH = 256
"""Clips whose slots are filled in a step: seven tokens each, as many as the questions' together."""

SILENT_SHARE = 0.15
"""Share of prefixes that hold the fused token alone."""

TYPO_SHARE = 0.15
"""Share of training questions with a mistyped word: words are also read from their pieces, so that
neither a slip of the finger nor a noun never seen looks like a word that asks for a refusal."""

CHECKPOINT_FILE = "language_checkpoint.pt"

DRAWS = {"draws": 3}
"""Version of how clips and questions are drawn: no run goes on with other draws."""

TYPE_WEIGHTS = {"T1": 6.0, "T2": 4.0, "T3": 8.0, "T17": 2.0}
"""How often a type is asked against 1 for the others: the open question is what users ask most;
verifying and choosing compare the clip with words of the question and are learned last; refusals
have the widest vocabulary."""

MOTION_WEIGHTS = {Motion.PRESS: 2.0, Motion.RELEASE: 2.0, Motion.STILL: 2.0}
"""How often a clip is asked about against 1 for the others. Turns and slides make two thirds of the
clips, so that a doubtful press was called one of them. Measured with a linear read-out of the same
tokens: a direction is claimed of 5.6 % of real presses instead of 9.3 %, of held imprints 0 instead
of 1 %, and real turns are told as well as before."""

UNASKED = -1
"""Stands for a slot of which nothing is asked: ambiguous, or not to be seen."""


@dataclass(frozen=True)
class LanguageTraining:
    """How the language model is trained.

    Args:
        steps: Optimiser steps before the cooldown.
        batch: Questions per step, each about a clip drawn anew.
        learning_rate: Peak of the schedule.
        warmup: Steps of linear rise before the cosine fall to a tenth.
        noise: Deviation of the Gaussian noise added to the fused token, in units of its spread over
            the training clips. There are far more questions than clips: without noise the decoder
            can learn a clip by heart from its token instead of the motion in it.
        motion_width: How many numbers of a reading, the last ones, tell of the motion.
        seed: Of weights, clips, questions and noise.
        size: How large the model is.
    """

    steps: int = 2400
    batch: int = 64
    learning_rate: float = 3e-3
    warmup: int = 100
    noise: float = 0.2
    motion_width: int = 0
    seed: int = 0
    size: LanguageSize = field(default_factory=LanguageSize)

    @property
    def all_steps(self) -> int:
        """Optimiser steps, the cooldown's among them."""
        return self.steps + int(self.steps * COOLDOWN_SHARE)


def train_language(
    fused_tokens: Tensor,
    labels: Sequence[MotionLabel],
    *,
    config: LanguageTraining,
    folder: Path,
    ranks: Ranks = ALONE,
    progress: Progress = silent,
) -> Speaker:
    """Return a speaker trained to answer questions about `fused_tokens`.

    Continues from the checkpoint in `folder` when there is one of the same configuration, with the
    same result as without the break. An interrupt saves a checkpoint first.

    Args:
        fused_tokens: Readings of n clips, (n, fused width), unitless.
        labels: n labels; questions are asked of the readable ones.
        config: How to train.
        folder: Where the checkpoint lies; the first rank writes it.
        ranks: Which process this is, and where it trains.
        progress: Told after each step.

    Raises:
        ValueError: If tokens and labels differ in number, or a token is not finite.
        UsageError: If the checkpoint belongs to another configuration, or the batch does not divide
            among the ranks.
    """
    ranks.refuse_uneven(config.batch, FELT_BATCH)
    if fused_tokens.ndim != 2 or len(fused_tokens) != len(labels) or not len(labels):
        raise ValueError(f"{tuple(fused_tokens.shape)} fused tokens for {len(labels)} labels")
    if not bool(torch.isfinite(fused_tokens).all()):
        raise ValueError("a fused token holds values that are not finite")
    speaker = new_speaker(fused_tokens, config)
    model = speaker.model.to(ranks.device).train()
    optimiser = torch.optim.AdamW(parameter_groups(model), betas=(0.9, 0.98))
    step = restore_language(folder, config, model, optimiser)
    asked = [row for row, label in enumerate(labels) if label.is_readable]
    shares, felt = drawing_shares([labels[row] for row in asked]), felt_words(labels)
    saved_at = time.monotonic()
    try:
        while step < config.all_steps:
            with uninterrupted_step():
                drawn = draw_clips(shares, config.batch, seed=config.seed, step=step)
                chosen = [asked[place] for place in drawn]
                others = generator_for(config.seed, "language", "felt", step).integers(
                    len(labels), size=FELT_BATCH
                )
                loss = _step(
                    speaker,
                    optimiser,
                    (fused_tokens[chosen], [labels[row] for row in chosen]),
                    (fused_tokens[others], felt[others]),
                    config,
                    step,
                    ranks,
                )
                step += 1
            progress(f"train language, loss {loss:.3f}", step, config.all_steps)
            if ranks.is_first and time.monotonic() - saved_at > CHECKPOINT_EVERY_S:
                store_language(folder, config, model, optimiser, step)
                saved_at = time.monotonic()
    finally:
        if ranks.is_first:
            store_language(folder, config, model, optimiser, step)
    return Speaker(model.cpu(), speaker.prompts)


def new_speaker(fused_tokens: Tensor, config: LanguageTraining) -> Speaker:
    """Return the speaker before its first step: vocabulary, fresh weights, measured scale."""
    rng = generator_for(config.seed, "language", "vocabulary")
    corpus = training_corpus(rng, CORPUS_ROUNDS)
    answers = set(corpus[1::2])
    cleaned = [clean_question(question) for question in corpus[::2]]
    tokenizer = train_tokenizer([*cleaned, *sorted(answers) * 20], VOCABULARY_SIZE)
    template = (resource_dir("prompts") / "chat_template.jinja").read_text(encoding="utf-8")
    size = config.size
    prompts = PromptEncoder(tokenizer, template, size.tactile_tokens, size.max_tokens)
    # torch fills new layers from its global generator; what it draws is replaced below.
    with torch.random.fork_rng(devices=[]):
        model = TactileDecoder(
            size,
            fused_width=fused_tokens.shape[1],
            vocabulary=tokenizer.get_vocab_size(),
            tactile_id=prompts.tactile_id,
        )
    initialise(model, size.layers, _torch_generator(config.seed, "weights"))
    model.projector.standardise_by(fused_tokens)
    return Speaker(model, prompts)


def _step(
    speaker: Speaker,
    optimiser: torch.optim.Optimizer,
    asked: tuple[Tensor, Sequence[MotionLabel]],
    others: tuple[Tensor, Tensor],
    config: LanguageTraining,
    step: int,
    ranks: Ranks,
) -> float:
    """Ask one question about each clip, what is felt of others, and learn from the answers.

    Each rank learns from its share of them; the loss of all is returned.
    """
    fused_tokens, labels = asked
    rng = generator_for(config.seed, "language", "batch", step)
    prompts, answers = [], []
    for label in labels:
        (asked,) = questions_for(label, rng, types=[draw_type(label, rng)])
        mistyped = rng.random() < TYPO_SHARE
        question = with_typo(asked.question, rng) if mistyped else asked.question
        prompts.append(speaker.prompts.prompt(question))
        answers.append(speaker.prompts.answer(asked.answer))
    model = speaker.model
    device = ranks.device
    token = _disturbed(model, fused_tokens.to(device), config, step, "noise")
    felt_of = _disturbed(model, others[0].to(device), config, step, "felt noise")
    per_rank = sum(map(len, answers)) / ranks.count
    optimiser.zero_grad(set_to_none=True)
    total = 0.0
    for part in map(ranks.share, _by_length(prompts, answers)):
        if part:
            with ranks.bfloat16_products(on_cpu=False):
                loss = answer_loss(
                    model, token[part], [prompts[i] for i in part], [answers[i] for i in part]
                )
            (loss / per_rank).backward()
            total += loss.item()
    with ranks.bfloat16_products(on_cpu=False):
        felt = felt_loss(speaker, ranks.share(felt_of), ranks.share(others[1]).to(device))
    felt.backward()
    told = ranks.average(model.parameters(), total / per_rank)
    torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
    for group in optimiser.param_groups:
        group["lr"] = learning_rate_at(step, config)
    optimiser.step()
    return told


def _disturbed(
    model: TactileDecoder, readings: Tensor, config: LanguageTraining, step: int, name: str
) -> Tensor:
    """Return standardised readings with noise, some of them without what tells of the motion."""
    token = model.projector.standardise(readings)
    noise = torch.randn(token.shape, generator=_torch_generator(config.seed, name, step))
    noise = noise.to(token.device)
    if not config.motion_width:
        return token + config.noise * noise
    # The motion is a measurement with its own spread: noise would only blur it.
    noise[:, -config.motion_width :] = 0
    token = token + config.noise * noise
    is_silent = generator_for(config.seed, "language", name, "silent", step).random(len(token))
    is_silent = torch.from_numpy(is_silent < SILENT_SHARE).to(token.device)
    token[is_silent, -config.motion_width :] = 0
    return token


def answer_loss(
    model: TactileDecoder, token: Tensor, prompts: list[list[int]], answers: list[list[int]]
) -> Tensor:
    """Return the summed cross entropy of the answer tokens alone, in nats.

    Rows are padded on the right: under causal order no text position sees a padding one.
    """
    rows = [prompt + answer for prompt, answer in zip(prompts, answers, strict=True)]
    length, device = max(map(len, rows)), token.device
    ids = torch.tensor([row + [0] * (length - len(row)) for row in rows], device=device)
    starts = torch.tensor([len(prompt) for prompt in prompts], device=device)[:, None]
    ends = torch.tensor([len(row) for row in rows], device=device)[:, None]
    place = torch.arange(length, device=device)
    is_answer = (place >= starts) & (place < ends)
    prefix = model.projector.from_standardised(token)
    hidden = model.decoder(model.embed(ids, prefix))
    before = hidden[:, :-1][is_answer[:, 1:]]
    return cross_entropy(model.logits(before), ids[is_answer], reduction="sum")


def learning_rate_at(step: int, config: LanguageTraining) -> float:
    """Return the rate of `step`: linear rise, cosine fall to a tenth of the peak, then to zero."""
    if step < config.warmup:
        return config.learning_rate * (step + 1) / config.warmup
    if step >= config.steps:
        return (
            0.1
            * config.learning_rate
            * (config.all_steps - step)
            / (config.all_steps - config.steps)
        )
    share = (step - config.warmup) / max(1, config.steps - config.warmup)
    return config.learning_rate * (0.1 + 0.45 * (1 + math.cos(math.pi * share)))


def _by_length(
    prompts: list[list[int]], answers: list[list[int]], parts: int = 4
) -> list[list[int]]:
    """Return row numbers in groups of like length: less padding to multiply by."""
    lengths = [len(p) + len(a) for p, a in zip(prompts, answers, strict=True)]
    order = np.argsort(lengths, kind="stable")
    return [part.tolist() for part in np.array_split(order, parts) if len(part)]


def parameter_groups(model: torch.nn.Module) -> list[dict]:
    """Return the weights of a decoder for its optimiser: the matrices decay, the others do not."""
    decayed = [p for n, p in model.named_parameters() if p.ndim == 2 and "embed_tokens" not in n]
    plain = [p for n, p in model.named_parameters() if p.ndim < 2 or "embed_tokens" in n]
    return [
        {"params": decayed, "weight_decay": WEIGHT_DECAY},
        {"params": plain, "weight_decay": 0.0},
    ]


def _torch_generator(seed: int, *names: str | int) -> torch.Generator:
    return torch.Generator().manual_seed(seed_for(seed, "language", *names))


def drawing_shares(labels: Sequence[MotionLabel]) -> NDArray[np.float64]:
    """Return how probable it is that a draw gives a clip or one before it, (n,)."""
    weights = np.array([MOTION_WEIGHTS.get(label.motion, 1.0) for label in labels])
    return np.cumsum(weights) / weights.sum()


def draw_clips(
    shares: NDArray[np.float64], count: int, *, seed: int, step: int
) -> NDArray[np.int64]:
    """Return the places of the `count` clips asked about in `step`."""
    rng = generator_for(seed, "language", "clips", step)
    return np.searchsorted(shares[:-1], rng.random(count), side="right")


def draw_type(label: MotionLabel, rng: np.random.Generator) -> str:
    """Return the type of one training question, the hard types more often."""
    among = askable_types(label)
    weights = np.array([TYPE_WEIGHTS.get(type_id, 1.0) for type_id in among])
    return among[int(rng.choice(len(among), p=weights / weights.sum()))]


def felt_words(labels: Sequence[MotionLabel]) -> Tensor:
    """Return the place of the true word at each slot, `UNASKED` where nothing is asked, (n, 4)."""
    places = []
    for label in labels:
        truth, row = component_truth(label), []
        for component in COMPONENTS:
            words, wanted = SLOTS[component], truth.moves[component]
            if wanted:
                row.append(words.index(truth.twist.way(component)))
            else:
                row.append(UNASKED if wanted is None else words.index("none"))
        places.append([*row, SLOTS["contact"].index("yes" if truth.is_touched else "no")])
    return torch.tensor(places)


def felt_loss(speaker: Speaker, token: Tensor, words: Tensor) -> Tensor:
    """Return the mean cross entropy of what is felt, summed over the slots, in nats.

    Readings are standardised, (b, fused width); words are as in `felt_words`.
    """
    model, prompts = speaker.model, speaker.prompts
    prefix = model.projector.from_standardised(token)
    slots = model.slot_logits(prefix, prompts.slot_prompt, prompts.slot_words)
    losses = [
        cross_entropy(logits, words[:, place], ignore_index=UNASKED, reduction="sum")
        for place, logits in enumerate(slots.values())
    ]
    return torch.stack(losses).sum() / len(words)


def store_language(
    folder: Path,
    config: LanguageTraining,
    model: torch.nn.Module,
    optimiser: torch.optim.Optimizer,
    step: int,
) -> None:
    """Write the state after `step` steps, atomically."""
    state = {
        "config": asdict(config) | DRAWS,
        "step": step,
        "model": model.state_dict(),
        "optimiser": optimiser.state_dict(),
    }
    save_checkpoint(folder / CHECKPOINT_FILE, state)


def restore_language(
    folder: Path, config: LanguageTraining, model: torch.nn.Module, optimiser: torch.optim.Optimizer
) -> int:
    """Restore the state in `folder` and return its step; 0 when there is none.

    Raises:
        UsageError: If it belongs to another configuration or other tokens, or cannot be read.
    """
    path = folder / CHECKPOINT_FILE
    state = load_checkpoint(path)
    if state is None:
        return 0
    found = state.get("config", {})
    asked = asdict(config) | DRAWS
    differing = sorted(name for name, value in asked.items() if found.get(name) != value)
    if not differing and not torch.equal(
        state["model"]["model.projector.mean"], model.projector.mean.cpu()
    ):
        differing = ["fused_tokens"]
    if differing:
        raise UsageError(
            f"{path}: was trained with another setting of {differing}; delete it to start over, or "
            f"train into another folder."
        )
    model.load_state_dict(state["model"])
    optimiser.load_state_dict(state["optimiser"])
    return int(state["step"])
