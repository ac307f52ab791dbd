"""Generate an answer from a fused token and a question, or score a closed set of answers.

Knows neither where the fused token comes from nor what an answer means.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from geotlm_lm.core.errors import IncompatibleBundle
from geotlm_lm.language.decoder import TactileDecoder
from geotlm_lm.language.prompt import MAX_ANSWER_TOKENS, PromptEncoder
from geotlm_lm.language.sequence import Floats, SequenceDecoder, TextCache, log_softmax
from geotlm_lm.language.weights import load_decoder, save_decoder


class Speaker:
    """The language model, ready to answer.

    Args:
        model: The weights; they have to stay as they are from the first question on.
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
        return [
            self.prompts.decode(self._written(token, self.prompts.prompt(question)))
            for token, question in zip(fused_token, questions, strict=True)
        ]

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
        answers = [self.prompts.answer(option) for option in options]
        longest = max(map(len, answers))
        hidden, cache = self._read(fused_token, self.prompts.prompt(question), longest)
        length, decoder, told = cache.length, self._decoder, []
        for answer in answers:
            cache.length, states = length, hidden[-1:]
            if len(answer) > 1:
                rest = decoder.read(decoder.embeddings[answer[:-1]], cache)
                states = np.concatenate([states, rest])
            logits = decoder.logits(states)
            told.append(log_softmax(logits)[np.arange(len(answer)), answer].sum())
        return np.array(told, dtype=np.float64)

    @cached_property
    def _decoder(self) -> SequenceDecoder:
        return SequenceDecoder(self.model.decoder)

    @torch.inference_mode()
    def _read(
        self, fused_token: Tensor, prompt: list[int], room: int = 0
    ) -> tuple[Floats, TextCache]:
        """Return the hidden states (s, width) of a prompt, its keys and values, with room behind.

        Raises:
            ValueError: If all that is longer than the model reads.
        """
        if len(prompt) + room > self.model.size.max_tokens:
            raise ValueError(
                f"prompt and answer hold {len(prompt) + room} tokens, the model reads "
                f"{self.model.size.max_tokens}"
            )
        prefix = self.model.projector(fused_token[None])
        embedded = self.model.embed(torch.tensor([prompt]), prefix)[0].float().numpy()
        cache = self._decoder.started(len(prompt) + room)
        return self._decoder.read(embedded, cache), cache

    def _written(self, fused_token: Tensor, prompt: list[int]) -> list[int]:
        """Return the likeliest tokens behind a prompt, one by one."""
        hidden, cache = self._read(fused_token, prompt, MAX_ANSWER_TOKENS - 1)
        written = [int(self._decoder.logits(hidden[-1]).argmax())]
        while written[-1] != self.prompts.eos_id and len(written) < MAX_ANSWER_TOKENS:
            hidden = self._decoder.read(self._decoder.embeddings[written[-1:]], cache)
            written.append(int(self._decoder.logits(hidden[-1]).argmax()))
        return written

    def _checked(self, fused_token: Tensor, shape: tuple[int, ...]) -> Tensor:
        fused_token = torch.as_tensor(fused_token, dtype=torch.float32)
        if tuple(fused_token.shape) != shape:
            raise ValueError(
                f"fused tokens have shape {tuple(fused_token.shape)}, expected {shape}"
            )
        if not bool(torch.isfinite(fused_token).all()):
            raise ValueError("a fused token holds values that are not finite")
        return fused_token
