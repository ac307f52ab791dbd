"""The transformers configuration of the language model: sizes and token ids, nothing learned."""

from __future__ import annotations

from huggingface_hub.dataclasses import strict
from transformers import AutoConfig, PreTrainedConfig
from transformers.configuration_utils import SubConfigSpec


@strict
class GeoTLMConfig(PreTrainedConfig):
    """Sizes of the projector and, in `text_config`, of the Llama decoder.

    Args:
        text_config: A Llama configuration or its values.
        fused_width: Width of the fused token.
        num_tactile_tokens: Prefix embeddings per clip.
        tactile_token_id: Id of the placeholder they replace.
        format: Version of the folder's layout.
        tie_word_embeddings: The output weights are the embeddings.
    """

    model_type = "geotlm_lm"
    sub_configs_defaults = {  # noqa: RUF012 - transformers reads it from the class
        "text_config": SubConfigSpec(config_class=AutoConfig, model_type="llama")
    }

    text_config: dict | PreTrainedConfig | None = None
    fused_width: int = 192
    num_tactile_tokens: int = 2
    tactile_token_id: int = 2
    format: int = 1
    tie_word_embeddings: bool = True


AutoConfig.register(GeoTLMConfig.model_type, GeoTLMConfig)
