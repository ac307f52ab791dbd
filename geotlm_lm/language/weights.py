"""The decoder's weights and sizes on disk, in the layout transformers reads; knows no text."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from safetensors import SafetensorError
from safetensors.torch import load_file, save

from geotlm_lm.core.errors import IncompatibleBundle, first_line
from geotlm_lm.core.files import replacing, write_text_atomically
from geotlm_lm.language.decoder import RMS_EPSILON, ROPE_THETA, LanguageSize, TactileDecoder

FORMAT = 1
"""Raised when a folder written before can no longer be read."""


WHAT_DAMAGE_RAISES = (
    OSError,
    ArithmeticError,
    AttributeError,
    LookupError,
    RuntimeError,
    SafetensorError,
    TypeError,
    ValueError,
)
"""What sizes and weights that were changed by hand or cut off make of the code that builds them."""


def save_decoder(decoder: TactileDecoder, folder: Path, *, eos_id: int, pad_id: int) -> None:
    """Write config.json, generation_config.json and model.safetensors, each atomically."""
    tensors = {name: value.detach().contiguous() for name, value in decoder.state_dict().items()}
    with replacing(folder / "model.safetensors") as stream:
        stream.write(save(tensors, metadata={"format": "pt"}))
    config = config_values(decoder, eos_id=eos_id, pad_id=pad_id)
    write_text_atomically(folder / "config.json", json.dumps(config, indent=2) + "\n")
    ending = {"eos_token_id": eos_id, "pad_token_id": pad_id, "do_sample": False}
    write_text_atomically(folder / "generation_config.json", json.dumps(ending, indent=2) + "\n")


def config_values(decoder: TactileDecoder, *, eos_id: int, pad_id: int) -> dict[str, Any]:
    """Return the sizes as the values of a transformers configuration."""
    size = decoder.size
    text = {
        "model_type": "llama",
        "vocab_size": decoder.vocabulary,
        "hidden_size": size.width,
        "intermediate_size": size.mlp,
        "num_hidden_layers": size.layers,
        "num_attention_heads": size.heads,
        "max_position_embeddings": size.max_tokens,
        "rms_norm_eps": RMS_EPSILON,
        "rope_parameters": {"rope_type": "default", "rope_theta": ROPE_THETA},
        "tie_word_embeddings": True,
        "bos_token_id": None,
        "eos_token_id": eos_id,
        "pad_token_id": pad_id,
    }
    return {
        "model_type": "geotlm_lm",
        "architectures": ["GeoTLMForConditionalGeneration"],
        "format": FORMAT,
        "dtype": "float32",
        "fused_width": decoder.fused_width,
        "num_tactile_tokens": size.tactile_tokens,
        "tactile_token_id": decoder.tactile_id,
        "tie_word_embeddings": True,
        "text_config": text,
    }


def load_decoder(folder: Path) -> TactileDecoder:
    """Read a folder written by `save_decoder` or by transformers' save_pretrained.

    Raises:
        IncompatibleBundle: If a file is missing, broken, or of another format.
    """
    try:
        config = json.loads((folder / "config.json").read_text(encoding="utf-8"))
        found = config.get("format") if isinstance(config, dict) else None
        if found != FORMAT:
            raise IncompatibleBundle(
                f"{folder}: was written in language-model format {found}, this version reads "
                f"{FORMAT}; install the matching version or download the model again."
            )
        decoder = _empty_decoder(config)
        tensors = load_file(folder / "model.safetensors")
        # transformers also stores the output weights it ties to the embeddings.
        tensors.pop("lm_head.weight", None)
        decoder.load_state_dict(tensors)
    except IncompatibleBundle:
        raise
    except WHAT_DAMAGE_RAISES as error:
        raise IncompatibleBundle(
            f"{folder}: config.json and model.safetensors are missing, broken or do not belong "
            f"together ({first_line(error)}); save or download the model again."
        ) from error
    return decoder.eval()


def _empty_decoder(config: dict[str, Any]) -> TactileDecoder:
    text = config["text_config"]
    size = LanguageSize(
        width=text["hidden_size"],
        layers=text["num_hidden_layers"],
        heads=text["num_attention_heads"],
        mlp=text["intermediate_size"],
        tactile_tokens=config["num_tactile_tokens"],
        max_tokens=text["max_position_embeddings"],
    )
    if size.heads < 1 or size.width % (2 * size.heads):
        raise ValueError(f"a width of {size.width} makes no {size.heads} heads of even width")
    return TactileDecoder(
        size,
        fused_width=config["fused_width"],
        vocabulary=text["vocab_size"],
        tactile_id=config["tactile_token_id"],
    )
