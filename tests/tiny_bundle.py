"""A bundle of random weights, small enough for tests of everything around the weights."""

import numpy as np
import torch

from geotlm_lm.backbone.motions import MOTIONS_SHAPE
from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.backbone.vit import FrozenBackbone, ViT, ViTConfig
from geotlm_lm.checkpoint import Bundle, Calibration
from geotlm_lm.core.labels import Motion
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.language.sequence import SequenceDecoder
from geotlm_lm.language.size import PREFIX
from geotlm_lm.language.tokenizer import byte_pairs
from geotlm_lm.model import GeoTLM
from geotlm_lm.motion.belief import BELIEF_NUMBERS
from geotlm_lm.motion.measured import measured
from geotlm_lm.motion.network import MotionNetwork
from geotlm_lm.probe.linear import LinearProbe
from geotlm_lm.probe.standardise import Standardiser
from geotlm_lm.query.reader import Reader, Spelling

WIDTH = 12


def tiny_bundle(calibration=None):
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)  # of the parts that take no generator
        return _tiny_bundle(calibration, torch.Generator().manual_seed(0))


def _tiny_bundle(calibration, generator):
    vit = ViT(ViTConfig(PATCH_INPUT_DIM, width=WIDTH, depth=1, heads=2)).initialise(generator)
    model = GeoTLM(
        backbone=FrozenBackbone(vit),
        global_standardiser=Standardiser.fit(torch.randn(9, WIDTH, generator=generator)),
        patch_standardiser=Standardiser.fit(torch.randn(9, WIDTH, generator=generator)),
        dgr=DGR(WIDTH),
        probe=LinearProbe(WIDTH, list(Motion)),
        global_probe=LinearProbe(WIDTH, list(Motion)),
    )
    calibration = calibration or Calibration(felt_temperature=2.0, contact_threshold=0.0)
    motion = untrained_motion(model.dgr)
    return Bundle(model, motion, calibration, {"command": "test"}, tiny_reader())


def tiny_reader(seed=0):
    """A language model of random weights, made without transformers."""
    spelling = Spelling(byte_pairs(["which way"], 256))
    return Reader(tiny_decoder(spelling.size, seed), spelling, (1.0, 0.0))


def tiny_decoder(vocabulary, seed=0, width=16, layers=1):
    """A decoder of random weights, embeddings wide enough that one text differs from another."""
    rng, numbers = np.random.default_rng(seed), WIDTH + BELIEF_NUMBERS

    def matrix(*shape):
        return (rng.standard_normal(shape) * shape[-1] ** -0.5).astype(np.float16)

    weights = {
        "model.embed_tokens.weight": matrix(vocabulary, width),
        "model.norm.weight": np.ones(width, np.float16),
    }
    for name in (f"model.layers.{layer}" for layer in range(layers)):
        for part in "qkvo":
            weights[f"{name}.self_attn.{part}_proj.weight"] = matrix(width, width)
        for part in ("gate", "up"):
            weights[f"{name}.mlp.{part}_proj.weight"] = matrix(width, width)
        weights[f"{name}.mlp.down_proj.weight"] = matrix(width, width)
        for part in ("input", "post_attention"):
            weights[f"{name}.{part}_layernorm.weight"] = np.ones(width, np.float16)
    projector = {"mean": np.zeros(numbers, np.float16), "scale": np.ones(numbers, np.float16)}
    for place, part in enumerate((WIDTH, BELIEF_NUMBERS)):
        projector |= {
            f"expand.{place}.weight": matrix(width, part),
            f"expand.{place}.bias": np.zeros(width, np.float16),
            f"project.{place}.weight": matrix(PREFIX // 2 * width, width),
            f"project.{place}.bias": np.zeros(PREFIX // 2 * width, np.float16),
        }
    config = {
        "hidden_size": width,
        "num_hidden_layers": layers,
        "reading_layers": layers,
        "num_attention_heads": 2,
        "intermediate_size": width,
        "max_position_embeddings": 768,
    }
    return SequenceDecoder(config, weights, projector)


@torch.no_grad()
def untrained_motion(dgr):
    """A network that believes what is measured; what it has yet to learn starts at random."""
    patches, inputs = torch.zeros(1, 2, 14, 14, WIDTH), torch.zeros(1, 2, 14, 14, PATCH_INPUT_DIM)
    motions, token = torch.zeros(1, *MOTIONS_SHAPE), torch.zeros(1, WIDTH)
    network = MotionNetwork(measured(inputs, motions, dgr(patches), token).hints.shape[1])
    return network.eval()
