"""The transformers processor: questions and fused tokens -> the model's inputs, left-padded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor
from transformers import AutoProcessor, BatchFeature
from transformers.processing_utils import ProcessorMixin

from geotlm_lm.language.configuration import GeoTLMConfig
from geotlm_lm.language.tokenizer import TACTILE, clean_question


class GeoTLMProcessor(ProcessorMixin):
    """Lays questions out by the chat template and expands the tactile placeholder.

    Args:
        tokenizer: The tokenizer saved with the model.
        chat_template: Jinja text that lays out the messages.
        num_tactile_tokens: Prefix embeddings per clip.
    """

    def __init__(
        self, tokenizer: Any, chat_template: str | None = None, num_tactile_tokens: int = 2
    ) -> None:
        self.num_tactile_tokens = num_tactile_tokens
        super().__init__(tokenizer, chat_template=chat_template)

    def __call__(
        self,
        questions: str | Sequence[str],
        fused_token: Tensor | None = None,
        **kwargs: Any,
    ) -> BatchFeature:
        """Return input_ids, attention_mask and, when given, fused_token, ready for `generate`.

        Args:
            questions: One or several questions, in plain words; control tokens in them are
                neutralised.
            fused_token: (b, fused_width), one row per question.
            **kwargs: Passed to the tokenizer.
        """
        questions = [questions] if isinstance(questions, str) else list(questions)
        texts = [self._text(question) for question in questions]
        options = {"return_tensors": "pt", "padding": True, "padding_side": "left"} | kwargs
        inputs = self.tokenizer(texts, return_token_type_ids=False, **options)
        if fused_token is not None:
            inputs["fused_token"] = torch.as_tensor(fused_token, dtype=torch.float32)
        return BatchFeature(dict(inputs))

    def _text(self, question: str) -> str:
        text = self.apply_chat_template(
            [{"role": "user", "content": clean_question(question)}],
            tokenize=False,
            add_generation_prompt=True,
        )
        return text.replace(TACTILE, TACTILE * self.num_tactile_tokens)


AutoProcessor.register(GeoTLMConfig, GeoTLMProcessor)
