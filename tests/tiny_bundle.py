"""A bundle of random weights, small enough for tests of everything around the weights."""

import torch

from geotlm_lm.backbone.motions import MOTIONS_SHAPE
from geotlm_lm.backbone.stem import PATCH_INPUT_DIM
from geotlm_lm.backbone.vit import FrozenBackbone, ViT, ViTConfig
from geotlm_lm.checkpoint import Bundle, Calibration
from geotlm_lm.core.labels import Motion
from geotlm_lm.data.templates import load_templates
from geotlm_lm.dgr.encoder import DGR
from geotlm_lm.language.decoder import LanguageSize, initialise
from geotlm_lm.language.tokenizer import byte_pairs
from geotlm_lm.model import GeoTLM
from geotlm_lm.motion.measured import measured
from geotlm_lm.motion.network import BELIEF_NUMBERS, MotionNetwork
from geotlm_lm.probe.linear import LinearProbe
from geotlm_lm.probe.standardise import Standardiser
from geotlm_lm.query.reader import QuestionDecoder, Reader
from geotlm_lm.query.spelling import Spelling
from geotlm_lm.training.language import LanguageTraining, new_speaker

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
    size = LanguageSize(width=16, layers=1, heads=2, mlp=16)
    readings = torch.randn(9, WIDTH + BELIEF_NUMBERS, generator=generator)
    speaker = new_speaker(readings, LanguageTraining(size=size))
    calibration = calibration or Calibration(temperature=2.0, contact_threshold=0.0)
    grammar = load_templates().grammar()
    motion = untrained_motion(model.dgr)
    return Bundle(model, motion, speaker, grammar, calibration, {"command": "test"}, tiny_reader())


def tiny_reader():
    """A reader of random weights."""
    spelling = Spelling(byte_pairs(["which way"], 256))
    size = LanguageSize(width=16, layers=1, heads=2, mlp=16, tactile_tokens=0, max_tokens=704)
    model = QuestionDecoder(size, spelling.size)
    initialise(model, size.layers, torch.Generator().manual_seed(0))
    return Reader(model, spelling, (1.0, 0.0))


@torch.no_grad()
def untrained_motion(dgr):
    """A network that believes what is measured; what it has yet to learn starts at random."""
    patches, inputs = torch.zeros(1, 2, 14, 14, WIDTH), torch.zeros(1, 2, 14, 14, PATCH_INPUT_DIM)
    motions, token = torch.zeros(1, *MOTIONS_SHAPE), torch.zeros(1, WIDTH)
    network = MotionNetwork(measured(inputs, motions, dgr(patches), token).hints.shape[1])
    return network.eval()
