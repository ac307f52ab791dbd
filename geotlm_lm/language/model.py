"""The language model as a transformers class: the same weights and logits as `decoder`.

For those who fine-tune, export or serve with transformers. Its modality key is `fused_token`; like
pixels it belongs to the prefill alone, so generation drops it after the first step.
"""

from __future__ import annotations

from typing import Any

from torch import Tensor, nn
from transformers import AutoModel, AutoModelForImageTextToText, GenerationMixin, PreTrainedModel
from transformers.modeling_outputs import BaseModelOutputWithPast, CausalLMOutputWithPast

from geotlm_lm.language.configuration import GeoTLMConfig
from geotlm_lm.language.decoder import merge_prefix
from geotlm_lm.language.projector import Projector


class GeoTLMPreTrainedModel(PreTrainedModel):
    """What the two classes below share with transformers."""

    config_class = GeoTLMConfig
    base_model_prefix = "model"
    _supports_sdpa = True
    _supports_attention_backend = True


class GeoTLMModel(GeoTLMPreTrainedModel):
    """Projector and Llama decoder without the output head."""

    def __init__(self, config: GeoTLMConfig) -> None:
        super().__init__(config)
        width = config.text_config.hidden_size
        self.projector = Projector(config.fused_width, width, config.num_tactile_tokens)
        self.language_model = AutoModel.from_config(config.text_config)
        self.post_init()

    def get_input_embeddings(self) -> nn.Module:
        """Return the token embeddings."""
        return self.language_model.get_input_embeddings()

    def set_input_embeddings(self, value: nn.Module) -> None:
        """Replace the token embeddings."""
        self.language_model.set_input_embeddings(value)

    def forward(
        self,
        input_ids: Tensor | None = None,
        fused_token: Tensor | None = None,
        attention_mask: Tensor | None = None,
        position_ids: Tensor | None = None,
        past_key_values: Any = None,
        inputs_embeds: Tensor | None = None,
        **kwargs: Any,
    ) -> BaseModelOutputWithPast:
        """Return hidden states; `fused_token` (b, fused_width) fills the tactile placeholders.

        Raises:
            ValueError: If placeholders and prefix embeddings differ in number.
        """
        if inputs_embeds is None:
            inputs_embeds = self.get_input_embeddings()(input_ids)
        if fused_token is not None:
            prefix = self.projector(fused_token.to(self.projector.mean.dtype))
            inputs_embeds = merge_prefix(
                inputs_embeds, input_ids, prefix, self.config.tactile_token_id
            )
        return self.language_model(
            inputs_embeds=inputs_embeds,
            attention_mask=attention_mask,
            position_ids=position_ids,
            past_key_values=past_key_values,
            **kwargs,
        )


class GeoTLMForConditionalGeneration(GeoTLMPreTrainedModel, GenerationMixin):
    """Fused token and prompt -> the next words."""

    _tied_weights_keys = {  # noqa: RUF012 - transformers reads it from the class
        "lm_head.weight": "model.language_model.embed_tokens.weight"
    }

    def __init__(self, config: GeoTLMConfig) -> None:
        super().__init__(config)
        self.model = GeoTLMModel(config)
        text = config.text_config
        self.lm_head = nn.Linear(text.hidden_size, text.vocab_size, bias=False)
        self.post_init()

    def get_input_embeddings(self) -> nn.Module:
        """Return the token embeddings."""
        return self.model.get_input_embeddings()

    def set_input_embeddings(self, value: nn.Module) -> None:
        """Replace the token embeddings."""
        self.model.set_input_embeddings(value)

    def get_output_embeddings(self) -> nn.Module:
        """Return the head tied to the token embeddings."""
        return self.lm_head

    def forward(
        self,
        input_ids: Tensor | None = None,
        fused_token: Tensor | None = None,
        attention_mask: Tensor | None = None,
        position_ids: Tensor | None = None,
        past_key_values: Any = None,
        inputs_embeds: Tensor | None = None,
        labels: Tensor | None = None,
        logits_to_keep: int | Tensor = 0,
        **kwargs: Any,
    ) -> CausalLMOutputWithPast:
        """Return logits, and the loss where `labels` is given; -100 marks what does not count."""
        outputs = self.model(
            input_ids=input_ids,
            fused_token=fused_token,
            attention_mask=attention_mask,
            position_ids=position_ids,
            past_key_values=past_key_values,
            inputs_embeds=inputs_embeds,
            **kwargs,
        )
        hidden = outputs.last_hidden_state
        kept = slice(-logits_to_keep, None) if isinstance(logits_to_keep, int) else logits_to_keep
        logits = self.lm_head(hidden[:, kept])
        loss = None
        if labels is not None:
            vocabulary = self.config.text_config.vocab_size
            loss = self.loss_function(logits=logits, labels=labels, vocab_size=vocabulary)
        return CausalLMOutputWithPast(
            loss=loss, logits=logits, past_key_values=outputs.past_key_values
        )

    def prepare_inputs_for_generation(
        self, *args: Any, is_first_iteration: bool = False, **kwargs: Any
    ) -> dict[str, Any]:
        """Keep the fused token for the prefill only: later steps hold no placeholder."""
        inputs = super().prepare_inputs_for_generation(
            *args, is_first_iteration=is_first_iteration, **kwargs
        )
        if not is_first_iteration:
            inputs.pop("fused_token", None)
        return inputs


AutoModel.register(GeoTLMConfig, GeoTLMModel)
AutoModelForImageTextToText.register(GeoTLMConfig, GeoTLMForConditionalGeneration)
