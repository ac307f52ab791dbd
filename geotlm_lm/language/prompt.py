"""Question and answer -> token ids, through the chat template; knows the text, not the weights."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from jinja2.sandbox import ImmutableSandboxedEnvironment
from tokenizers import Tokenizer

from geotlm_lm.core.errors import IncompatibleBundle, UsageError, first_line
from geotlm_lm.core.files import write_text_atomically
from geotlm_lm.language.slots import SLOT_TOKENS, SLOTS
from geotlm_lm.language.tokenizer import (
    EOS,
    PAD,
    SPECIAL_TOKENS,
    TACTILE,
    clean_question,
)


@dataclass(frozen=True)
class PromptEncoder:
    """Builds the model's text from a question, and an answer from its tokens.

    Args:
        tokenizer: The trained vocabulary.
        chat_template: Jinja text that lays out the messages.
        tactile_tokens: How many prefix embeddings stand for one clip.
        max_tokens: Longest prompt and answer together.
    """

    tokenizer: Tokenizer
    chat_template: str
    tactile_tokens: int
    max_tokens: int

    @cached_property
    def _template(self):
        return ImmutableSandboxedEnvironment().from_string(self.chat_template)

    @cached_property
    def tactile_id(self) -> int:
        """Id of the placeholder a prefix embedding replaces."""
        return self.tokenizer.token_to_id(TACTILE)

    @cached_property
    def eos_id(self) -> int:
        """Id of the token that ends an answer."""
        return self.tokenizer.token_to_id(EOS)

    @cached_property
    def pad_id(self) -> int:
        """Id of the token that fills a batch."""
        return self.tokenizer.token_to_id(PAD)

    @cached_property
    def slot_prompt(self) -> list[int]:
        """Ids of the prefix and, behind it, of every slot."""
        slots = [self.tokenizer.token_to_id(token) for token in SLOT_TOKENS]
        return [self.tactile_id] * self.tactile_tokens + slots

    @cached_property
    def slot_words(self) -> dict[str, list[int]]:
        """Ids of the words that may fill each slot."""
        return {slot: [self._word(word) for word in words] for slot, words in SLOTS.items()}

    def _word(self, word: str) -> int:
        ids = self.tokenizer.encode(word).ids
        if len(ids) != 1:
            raise ValueError(f"'{word}' takes {len(ids)} tokens, expected one")
        return ids[0]

    def prompt(self, question: str) -> list[int]:
        """Return the ids up to where the answer begins.

        Raises:
            UsageError: If the question is empty or leaves too little room for an answer.
        """
        cleaned = clean_question(question)
        if not cleaned:
            raise UsageError(
                "The question is empty; ask something like 'Which way is it turning?'."
            )
        ids = self._encode(self._laid_out(cleaned))
        limit = self.max_tokens - MAX_ANSWER_TOKENS
        if len(ids) > limit:
            around = len(self._encode(self._laid_out("")))
            # A tenth less: the words left out may have been the longer ones.
            share = 0.9 * (limit - around) / (len(ids) - around)
            fitting = max(round(share * len(cleaned)), 1)
            raise UsageError(
                f"The question has {len(cleaned)} characters, expected at most about {fitting} of "
                f"this kind; shorten it."
            )
        return ids

    def answer(self, text: str) -> list[int]:
        """Return the ids of an answer, its end included."""
        return [*self.tokenizer.encode(text).ids, self.eos_id]

    def decode(self, ids: list[int]) -> str:
        """Return the words of an answer up to its end."""
        if self.eos_id in ids:
            ids = ids[: ids.index(self.eos_id)]
        return self.tokenizer.decode(ids, skip_special_tokens=False)

    def _laid_out(self, question: str) -> str:
        messages = [{"role": "user", "content": question}]
        return self._template.render(messages=messages, add_generation_prompt=True)

    def _encode(self, text: str) -> list[int]:
        return self.tokenizer.encode(text.replace(TACTILE, TACTILE * self.tactile_tokens)).ids

    def save(self, folder: Path) -> None:
        """Write the text files of a model folder, readable by transformers as well."""
        special = list(SPECIAL_TOKENS)
        files = {
            "tokenizer.json": self.tokenizer.to_str(),
            "chat_template.jinja": self.chat_template,
            "tokenizer_config.json": _json(
                tokenizer_class="TokenizersBackend",
                processor_class="GeoTLMProcessor",
                backend="tokenizers",
                clean_up_tokenization_spaces=False,
                model_max_length=self.max_tokens,
                padding_side="left",
                pad_token=PAD,
                eos_token=EOS,
                extra_special_tokens=special[2:],
            ),
            "processor_config.json": _json(
                processor_class="GeoTLMProcessor", num_tactile_tokens=self.tactile_tokens
            ),
        }
        for name, text in files.items():
            write_text_atomically(folder / name, text)

    @classmethod
    def load(cls, folder: Path, *, max_tokens: int) -> PromptEncoder:
        """Read what `save`, or transformers, wrote.

        Raises:
            IncompatibleBundle: If a file is missing or the special tokens are others.
        """
        try:
            tokenizer = Tokenizer.from_str((folder / "tokenizer.json").read_text(encoding="utf-8"))
            template = (folder / "chat_template.jinja").read_text(encoding="utf-8")
            settings = json.loads((folder / "processor_config.json").read_text(encoding="utf-8"))
            encoder = cls(tokenizer, template, int(settings["num_tactile_tokens"]), max_tokens)
            if encoder._laid_out("which way?").count(TACTILE) != 1:
                raise ValueError(f"the chat template does not lay out one {TACTILE}")
            if None not in encoder.slot_prompt:
                encoder.slot_words  # noqa: B018 - refuses a vocabulary without them
        except Exception as error:  # tokenizers raises nothing narrower, a template whatever it has
            raise IncompatibleBundle(
                f"{folder}: its tokenizer, chat template or processor file is missing or broken "
                f"({first_line(error)}); save or download the model again."
            ) from error
        missing = [token for token in SPECIAL_TOKENS if tokenizer.token_to_id(token) is None]
        if missing:
            raise IncompatibleBundle(
                f"{folder}: the tokenizer lacks {missing}; use the tokenizer saved with the model."
            )
        tokenizer.no_padding()
        tokenizer.no_truncation()
        return encoder


MAX_ANSWER_TOKENS = 48
"""Room kept for an answer; measured, the longest canonical one takes 41 tokens."""


def _json(**values: object) -> str:
    return json.dumps(values, indent=2) + "\n"
