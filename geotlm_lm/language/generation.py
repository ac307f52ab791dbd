"""Generate an answer from a fused token and a question, or score a closed set of answers.

Knows neither where the fused token comes from nor what an answer means.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from geotlm_lm.core.errors import IncompatibleBundle
from geotlm_lm.language.answer_tree import AnswerTree
from geotlm_lm.language.decoder import Cache, TactileDecoder
from geotlm_lm.language.prompt import MAX_ANSWER_TOKENS, PromptEncoder
from geotlm_lm.language.weights import load_decoder, save_decoder

BATCH = 64
"""Questions generated side by side; more gains nothing on a processor."""


MOST_TREES = 256
"""Sets of answers whose tokens are remembered: a grammar has some twenty, and what a choice offers
cuts smaller ones from one of them."""


class Speaker:
    """The language model, ready to answer.

    Args:
        model: The weights.
        prompts: What turns questions into ids and ids into words.

    Raises:
        ValueError: If the two disagree on the length of the tactile prefix.
    """

    def __init__(self, model: TactileDecoder, prompts: PromptEncoder) -> None:
        if prompts.tactile_tokens != model.size.tactile_tokens:
            raise ValueError(
                f"the processor writes {prompts.tactile_tokens} tactile placeholders, the model "
                f"reads {model.size.tactile_tokens}"
            )
        self.model = model.eval()
        self.prompts = prompts
        self._trees: dict[tuple[str, ...], AnswerTree] = {}

    @classmethod
    def load(cls, folder: str | Path) -> Speaker:
        """Read a model folder, without transformers.

        Raises:
            IncompatibleBundle: If the folder is incomplete or of another format.
        """
        folder = Path(folder)
        model = load_decoder(folder)
        prompts = PromptEncoder.load(folder, max_tokens=model.size.max_tokens)
        try:
            return cls(model, prompts)
        except ValueError as error:
            raise IncompatibleBundle(
                f"{folder}: {error}; save or download the model again."
            ) from error

    def save(self, folder: str | Path) -> None:
        """Write a model folder that `load` and transformers' Auto classes read."""
        folder = Path(folder)
        eos_id, pad_id = self.prompts.eos_id, self.prompts.pad_id
        save_decoder(self.model, folder, eos_id=eos_id, pad_id=pad_id)
        self.prompts.save(folder)

    @torch.inference_mode()
    def generate(self, fused_token: Tensor, questions: Sequence[str]) -> list[str]:
        """Return the most likely words, token by token, one answer per row.

        Args:
            fused_token: (b, fused width), unitless.
            questions: b questions.

        Raises:
            ValueError: If the shapes disagree, or a token is not finite.
            UsageError: If a question is empty or too long.
        """
        fused_token = self._checked(fused_token, (len(questions), self.model.fused_width))
        prompts = [self.prompts.prompt(question) for question in questions]
        answers: list[str] = []
        for start in range(0, len(prompts), BATCH):
            part = slice(start, start + BATCH)
            answers += self._generate(fused_token[part], prompts[part])
        return answers

    @torch.inference_mode()
    def feel(self, fused_token: Tensor) -> dict[str, Tensor]:
        """Return the log-probability of each word at each slot, from one pass over the prefix.

        Args:
            fused_token: (b, fused width), unitless.

        Returns:
            Slot -> (b, words), in the order of `slots.SLOTS`.

        Raises:
            ValueError: If the shape is another, or a token is not finite.
        """
        fused_token = self._checked(fused_token, (len(fused_token), self.model.fused_width))
        return self.model.slot_logits(
            self.model.projector(fused_token), self.prompts.slot_prompt, self.prompts.slot_words
        )

    @torch.inference_mode()
    def would_write(self, fused_token: Tensor, question: str, sentence: str) -> bool:
        """Tell whether `generate` answers a question by exactly this sentence, from one pass.

        It does where every token of the sentence, its end included, is the likeliest behind those
        before it (but for ties in the last bit).

        Args:
            fused_token: (fused width,), unitless.
            question: The question.
            sentence: The answer in question.

        Raises:
            ValueError: If the shape is another, or a token is not finite.
            UsageError: If the question is empty or too long.
        """
        fused_token = self._checked(fused_token, (self.model.fused_width,))
        prompt, answer = self.prompts.prompt(question), self.prompts.answer(sentence)
        hidden, _ = self._read(fused_token[None], torch.tensor([[*prompt, *answer[:-1]]]))
        likeliest = self.model.logits(hidden[0, len(prompt) - 1 :]).argmax(dim=-1)
        return likeliest.tolist() == answer

    @torch.inference_mode()
    def score(self, fused_token: Tensor, question: str, options: Sequence[str]) -> np.ndarray:
        """Return the log-probability of each option as the whole answer, its end included.

        The prompt is read once; its keys and values serve every option.

        Args:
            fused_token: (fused width,), unitless.
            question: The question.
            options: Answers to compare.

        Raises:
            ValueError: If there is no option, the shape is another, or a token is not finite.
            UsageError: If the question is empty or too long.
        """
        if not options:
            raise ValueError("score needs at least one option")
        fused_token = self._checked(fused_token, (self.model.fused_width,))
        prompt = torch.tensor([self.prompts.prompt(question)])
        tree = self._tree(tuple(options))
        hidden, cache = self._read(fused_token[None], prompt)
        logits = self.model.logits(hidden[0, -1:])
        if tree.ids.numel():
            logits = torch.cat([logits, self._continue(tree, cache)])
        return tree.log_likelihoods(logits.log_softmax(-1)).double().numpy()

    def _tree(self, options: tuple[str, ...]) -> AnswerTree:
        """Return the tree of some options; kept, as few sets are ever asked for."""
        found = self._trees.get(options)
        if found is None:
            found = AnswerTree.of([self.prompts.answer(option) for option in options])
            if len(self._trees) >= MOST_TREES:
                self._trees.clear()
            self._trees[options] = found
        return found

    def _read(self, fused_token: Tensor, prompt: Tensor) -> tuple[Tensor, Cache]:
        """Return hidden states and cache of one unpadded prompt."""
        embedded = self.model.embed(prompt, self.model.projector(fused_token))
        return self.model.decoder(embedded, torch.arange(prompt.shape[1])[None])

    def _continue(self, tree: AnswerTree, cache: Cache) -> Tensor:
        """Return the logits after each node of a tree behind a prompt, (nodes, vocabulary)."""
        past = cache[0][0].shape[2]
        prompt = torch.ones(len(tree.sees), past, dtype=torch.bool)
        visible = torch.cat([prompt, tree.sees], dim=1)[None, None]
        embedded = self.model.embed(tree.ids, None)
        hidden, _ = self.model.decoder(embedded, past + tree.depths, visible, cache)
        return self.model.logits(hidden[0])

    def _generate(self, fused_token: Tensor, prompts: list[list[int]]) -> list[str]:
        ids, is_text = _left_padded(prompts, self.prompts.pad_id)
        rows, length = ids.shape
        visible = is_text[:, None, :] & torch.ones(length, length, dtype=torch.bool).tril()
        # A padding position that may look nowhere would give NaN; let it see itself.
        visible = visible | torch.eye(length, dtype=torch.bool)
        positions = (is_text.cumsum(1) - 1).clamp(min=0)
        embedded = self.model.embed(ids, self.model.projector(fused_token))
        hidden, cache = self.model.decoder(embedded, positions, visible[:, None])
        place, seen = positions[:, -1:], is_text
        written: list[Tensor] = []
        is_done = torch.zeros(rows, dtype=torch.bool)
        for _ in range(MAX_ANSWER_TOKENS):
            token = self.model.logits(hidden[:, -1]).argmax(-1)
            written.append(token)
            is_done |= token == self.prompts.eos_id
            if bool(is_done.all()):
                break
            place = place + 1
            seen = torch.cat([seen, torch.ones(rows, 1, dtype=torch.bool)], dim=1)
            hidden, cache = self.model.decoder(
                self.model.embed(token[:, None], None), place, seen[:, None, None], cache
            )
        return [self.prompts.decode(row) for row in torch.stack(written, dim=1).tolist()]

    def _checked(self, fused_token: Tensor, shape: tuple[int, ...]) -> Tensor:
        fused_token = torch.as_tensor(fused_token, dtype=torch.float32)
        if tuple(fused_token.shape) != shape:
            raise ValueError(
                f"fused tokens have shape {tuple(fused_token.shape)}, expected {shape}"
            )
        if not bool(torch.isfinite(fused_token).all()):
            raise ValueError("a fused token holds values that are not finite")
        return fused_token


def _left_padded(rows: list[list[int]], pad_id: int) -> tuple[Tensor, Tensor]:
    """Return ids (b, s) and True where they are text."""
    length = max(map(len, rows))
    ids = torch.tensor([[pad_id] * (length - len(row)) + row for row in rows])
    counts = torch.tensor([len(row) for row in rows])
    return ids, torch.arange(length) >= length - counts[:, None]
