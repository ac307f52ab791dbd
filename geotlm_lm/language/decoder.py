"""The language model as it is trained: transformers' `LlamaForCausalLM`, and the tactile projector.

What each position may see is given explicitly: a question and its program are blind to the clip,
slots see the clip alone, and a sentence sees all that stands before it. `sequence` serves the same
weights one text at a time; a test holds both to the same logits.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import torch
from safetensors.torch import load_file
from torch import Tensor, nn
from torch.nn.functional import linear, silu
from transformers import LlamaConfig, LlamaForCausalLM

from geotlm_lm.language.sequence import PROJECTOR_FILE, SequenceDecoder
from geotlm_lm.language.size import PREFIX, RMS_EPSILON, ROPE_THETA, LanguageSize, size_of

EMBEDDING_DEVIATION = 0.04
"""Of fresh embeddings, which serve as output weights too: wider only starts at a higher loss."""

UNSEEN = -1e9
"""Added to the score of what may not be seen."""


class Projector(nn.Module):
    """What is read of a clip, standardised, as the embeddings of its prefix.

    The fused token and the belief each make half of them, so that a clip of which only one is
    known is read as well.

    Args:
        token_width: Width of the fused token.
        belief_width: Numbers of the belief.
        width: Width of the decoder.
    """

    def __init__(self, token_width: int, belief_width: int, width: int) -> None:
        super().__init__()
        self.widths = token_width, belief_width
        self.register_buffer("mean", torch.zeros(token_width + belief_width))
        self.register_buffer("scale", torch.ones(token_width + belief_width))
        half = PREFIX // 2 * width
        self.expand = nn.ModuleList(nn.Linear(each, width) for each in self.widths)
        self.project = nn.ModuleList(nn.Linear(width, half) for _ in self.widths)

    @torch.no_grad()
    def standardise_by(self, numbers: Tensor) -> None:
        """Take mean and scale from clips (n, token and belief); a constant number keeps 1."""
        deviation = numbers.std(dim=0, correction=0)
        self.mean.copy_(numbers.mean(dim=0))
        self.scale.copy_(torch.where(deviation > 1e-6, deviation, 1.0))

    def forward(self, numbers: Tensor) -> Tensor:
        """Return the prefix (b, PREFIX, width) of what is read of b clips."""
        return self.from_standardised((numbers - self.mean) / self.scale)

    def from_standardised(self, numbers: Tensor) -> Tensor:
        """Return the prefix of numbers in units of their spread over the training clips."""
        parts = numbers.split(self.widths, dim=1)
        halves = [
            project(silu(expand(part)))
            for part, expand, project in zip(parts, self.expand, self.project, strict=True)
        ]
        return torch.cat(halves, dim=1).unflatten(1, (PREFIX, -1))


class LanguageModel(nn.Module):
    """The decoder and its projector."""

    def __init__(self, llama: LlamaForCausalLM, projector: Projector) -> None:
        super().__init__()
        self.llama, self.projector = llama, projector

    def embed_weight(self) -> Tensor:
        """Return the embeddings, which are the output weights as well."""
        return self.llama.model.embed_tokens.weight

    def embed(self, ids: Tensor) -> Tensor:
        """Return the embeddings of ids."""
        return self.llama.model.embed_tokens(ids)

    @property
    def size(self) -> LanguageSize:
        """How large it is."""
        return size_of(self.llama.config.to_dict())

    def speaking_parameters(self) -> dict[str, nn.Parameter]:
        """Return the weights of the layers that speak, by name."""
        first = self.llama.config.reading_layers
        layers = self.llama.model.layers
        return {
            f"llama.model.layers.{place}.{name}": weight
            for place in range(first, len(layers))
            for name, weight in layers[place].named_parameters()
        }

    def states(self, embedded: Tensor, mask: Tensor, positions: Tensor) -> tuple[Tensor, Tensor]:
        """Return the states that programs and slots, and that sentences are read from.

        Args:
            embedded: Embeddings, (b, s, width).
            mask: True where a position may look, (b, 1, s, s).
            positions: Of each embedding, (b, s).

        Returns:
            Those behind the layers that read and those behind all, (b, s, width) each.
        """
        decoder = self.llama.model
        # On processors torch's kernel for masked attention takes twice as long as its products.
        kind = "sdpa" if embedded.is_cuda else "eager"
        if decoder.config._attn_implementation != kind:
            decoder.set_attn_implementation(kind)
        if kind == "eager":
            mask = torch.zeros(mask.shape).masked_fill(~mask, UNSEEN)
        reading = decoder.config.reading_layers
        done = decoder(
            inputs_embeds=embedded,
            attention_mask=mask,
            position_ids=positions,
            use_cache=False,
            output_hidden_states=True,
        )
        spoken = done.last_hidden_state
        if reading == decoder.config.num_hidden_layers:
            return spoken, spoken
        return decoder.norm(done.hidden_states[reading]), spoken

    def logits(self, hidden: Tensor) -> Tensor:
        """Return the logits over all ids; the output weights are the embeddings."""
        return linear(hidden, self.llama.model.embed_tokens.weight)


def fresh(
    size: LanguageSize,
    vocabulary: int,
    widths: tuple[int, int],
    generator: torch.Generator,
) -> LanguageModel:
    """Return a model of random weights.

    Args:
        size: How large.
        vocabulary: Ids.
        widths: Of the fused token and of the belief.
        generator: Draws every weight: normal, of unit gain, narrower where a layer adds to the
            stream, so that learning starts at once.
    """
    config = LlamaConfig(
        vocab_size=vocabulary,
        hidden_size=size.width,
        intermediate_size=size.mlp,
        num_hidden_layers=size.layers + size.speaking,
        reading_layers=size.layers,
        num_attention_heads=size.heads,
        num_key_value_heads=size.heads,
        max_position_embeddings=size.max_tokens,
        rms_norm_eps=RMS_EPSILON,
        rope_parameters={"rope_type": "default", "rope_theta": ROPE_THETA},
        tie_word_embeddings=True,
        use_cache=False,
        bos_token_id=None,
        eos_token_id=None,
        pad_token_id=None,
    )
    with torch.random.fork_rng(devices=[]):  # transformers draws what is drawn again below
        model = LanguageModel(LlamaForCausalLM(config), Projector(*widths, size.width))
    shrink = (2 * (size.layers + size.speaking)) ** -0.5
    with torch.no_grad():
        for name, parameter in model.named_parameters():
            if parameter.ndim < 2:
                parameter.fill_(1.0 if "norm" in name else 0.0)
            elif "embed_tokens" in name:
                parameter.normal_(0.0, EMBEDDING_DEVIATION, generator=generator)
            else:
                adds = name.endswith(("o_proj.weight", "down_proj.weight"))
                gain = parameter.shape[1] ** -0.5 * (shrink if adds else 1.0)
                parameter.normal_(0.0, gain, generator=generator)
    return model


def with_speaking(model: LanguageModel, layers: int, generator: torch.Generator) -> LanguageModel:
    """Return a model with so many layers that speak, new ones, above those that read.

    What is read is the same: it is read out below them (early exit, Schuster et al. 2022), and they
    alone are to learn (layers put on top of a frozen model, Wu et al. 2024).
    """
    size = replace(model.size, speaking=layers)
    made = fresh(size, model.llama.config.vocab_size, model.projector.widths, generator)
    below = model.state_dict()
    for name in made.speaking_parameters():
        below.pop(name, None)
    made.load_state_dict(below, strict=False)
    return made


def served(model: LanguageModel) -> SequenceDecoder:
    """Return the same model for one text at a time, in the half precision that it is stored in.

    Its folder is one that `LlamaForCausalLM.from_pretrained` reads.
    """
    config = model.llama.config.to_diff_dict() | {"dtype": "float16"}
    parts = {
        part: {name: x.detach().half().cpu().numpy() for name, x in module.state_dict().items()}
        for part, module in (("llama", model.llama), ("projector", model.projector))
    }
    parts["llama"].pop("lm_head.weight")  # tied to the embeddings
    return SequenceDecoder(config, parts["llama"], parts["projector"])


def stored(folder: Path) -> LanguageModel:
    """Read a language model's folder, in single precision."""
    llama = LlamaForCausalLM.from_pretrained(folder, dtype=torch.float32)
    tensors = {name: x.float() for name, x in load_file(folder / PROJECTOR_FILE).items()}
    widths = [tensors[f"expand.{place}.weight"].shape[1] for place in (0, 1)]
    projector = Projector(*widths, llama.config.hidden_size)
    projector.load_state_dict(tensors)
    return LanguageModel(llama, projector)
