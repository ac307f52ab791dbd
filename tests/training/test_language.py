from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import torch
from torch.nn.functional import cross_entropy

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.language.decoder import LanguageSize
from geotlm_lm.language.slots import SLOTS
from geotlm_lm.training.language import (
    SILENT_SHARE,
    UNASKED,
    LanguageTraining,
    _disturbed,
    answer_loss,
    draw_clips,
    drawing_shares,
    felt_loss,
    felt_words,
    learning_rate_at,
    new_speaker,
    train_language,
)

LABELS = [MotionLabel(motion) for motion in Motion for _ in range(4)]
CONFIG = LanguageTraining(
    steps=6,
    batch=8,
    warmup=2,
    size=LanguageSize(width=32, layers=2, heads=2, mlp=48, tactile_tokens=2, max_tokens=104),
)


@pytest.fixture(scope="module")
def tokens():
    torch.set_num_threads(1)
    return torch.randn(len(LABELS), 12, generator=torch.Generator().manual_seed(0)) * 3 + 1


def trained(tokens, folder, config=CONFIG, progress=lambda *_: None):
    speaker = train_language(tokens, LABELS, config=config, folder=folder, progress=progress)
    return {name: value.clone() for name, value in speaker.model.state_dict().items()}


def test_one_seed_gives_the_same_weights_also_after_an_interruption(tokens, tmp_path):
    steps = []

    def interrupted(_, step, of):
        steps.append((step, of))
        if len(steps) == 3:
            raise KeyboardInterrupt

    straight = trained(tokens, tmp_path / "straight")
    with pytest.raises(KeyboardInterrupt):
        trained(tokens, tmp_path / "broken", progress=interrupted)
    resumed = trained(tokens, tmp_path / "broken", progress=interrupted)
    assert steps == [(step, 6) for step in range(1, 7)]
    assert straight.keys() == resumed.keys()
    assert all(torch.equal(resumed[name], value) for name, value in straight.items())
    other = trained(tokens, tmp_path / "other", replace(CONFIG, seed=1))
    assert not all(torch.equal(other[name], value) for name, value in straight.items())


@pytest.mark.parametrize(
    ("batch", "shift", "reason"),
    [(4, 0, r"another setting of \['batch'\]; delete it to start over"), (8, 1, "fused_tokens")],
)
def test_a_checkpoint_of_another_run_is_refused(tokens, tmp_path, batch, shift, reason):
    config = replace(CONFIG, steps=1)
    trained(tokens, tmp_path, config)
    with pytest.raises(UsageError, match=reason):
        trained(tokens + shift, tmp_path, replace(config, batch=batch))


def test_the_loss_is_that_of_the_answer_tokens_alone(tokens):
    speaker = new_speaker(tokens, CONFIG)
    model, encoder = speaker.model, speaker.prompts
    prompts = [encoder.prompt("which way?"), encoder.prompt("is the cap turning cw or not?")]
    answers = [encoder.answer("A slide."), encoder.answer("Left, in the camera image.")]
    token = model.projector.standardise(tokens[:2])
    expected = 0.0
    for row in range(2):
        ids = torch.tensor([prompts[row] + answers[row]])
        embedded = model.embed(ids, model.projector(tokens[row : row + 1]))
        hidden = model.decoder(embedded)
        logits = model.logits(hidden)[0, len(prompts[row]) - 1 : -1]
        expected += float(
            cross_entropy(logits, torch.tensor(answers[row]), reduction="sum").detach()
        )
    loss = float(answer_loss(model, token, prompts, answers).detach())
    assert loss == pytest.approx(expected, rel=1e-5)


def test_the_rate_falls_to_nothing_in_a_cooldown_of_a_ninth():
    config = LanguageTraining(steps=900, warmup=100)
    assert config.all_steps == 1000
    rates = [learning_rate_at(step, config) for step in range(config.all_steps)]
    assert max(rates) == pytest.approx(config.learning_rate)
    assert rates[900] == pytest.approx(0.1 * config.learning_rate)
    assert rates[999] == pytest.approx(0.001 * config.learning_rate)
    assert all(later < earlier for earlier, later in pairwise(rates[900:]))


def test_presses_are_asked_about_twice_as_often_as_turns():
    labels = [MotionLabel(Motion.CLOCKWISE)] * 3 + [MotionLabel(Motion.PRESS)]
    shares = drawing_shares(labels)
    assert shares == pytest.approx([0.2, 0.4, 0.6, 1.0])
    chosen = draw_clips(shares, 4000, seed=0, step=0)
    assert np.bincount(chosen) / 4000 == pytest.approx([0.2, 0.2, 0.2, 0.4], abs=0.03)
    assert not np.array_equal(chosen, draw_clips(shares, 4000, seed=0, step=1))


def label(**truth):
    made = {"contact_fraction": (0.1,), "radius_px": 20.0, "visible_grey": (9.0, 9.0, 9.0)}
    return MotionLabel(Motion.STILL, **made | truth)


def test_felt_words_are_those_of_every_component_at_once():
    labels = [
        label(rotation_deg=8.0, travel_px=(-5.0, 4.0), depth_change_mm=-0.3),
        label(rotation_deg=-8.0, travel_px=(0.2, 0.0)),  # slides too little
        label(rotation_deg=8.0, visible_grey=(0.5, 9.0, 9.0)),  # turns unseen
        label(travel_px=(0.0, 5.0), contact_fraction=(0.0,)),
    ]
    told = [
        [
            None if place == UNASKED else words[place]
            for place, words in zip(row, SLOTS.values(), strict=True)
        ]
        for row in felt_words(labels).tolist()
    ]
    assert told == [
        ["clockwise", "left", "release", "yes"],
        ["counterclockwise", None, "none", "yes"],
        [None, "none", "none", "yes"],
        ["none", "none", "none", "no"],
    ]


def test_some_readings_are_disturbed_to_the_fused_token_alone(tokens):
    config, many = replace(CONFIG, motion_width=5), tokens.repeat(50, 1)
    model = new_speaker(tokens, config).model
    plain = model.projector.standardise(many)
    token = _disturbed(model, many, config, 0, "noise")
    is_silent = (token[:, -5:] == 0).all(dim=1)
    assert float(is_silent.float().mean()) == pytest.approx(SILENT_SHARE, abs=0.03)
    # What tells of the motion is noisy in itself; the fused token gets noise in every row.
    assert torch.equal(token[~is_silent, -5:], plain[~is_silent, -5:])
    assert float((token - plain)[:, :-5].std()) == pytest.approx(config.noise, rel=0.03)


def test_slots_are_learned_from_the_whole_reading_and_from_the_fused_token_alone():
    rng = np.random.default_rng(0)
    labels = [
        label(rotation_deg=float(turn), travel_px=tuple(way), depth_change_mm=float(press))
        for turn, way, press in zip(
            rng.choice([-9, 0, 9], 300),
            rng.choice([-6.0, 0.0, 6.0], (300, 2)) * (1.0, 0.7),
            rng.choice([-0.4, 0, 0.4], 300),
            strict=True,
        )
    ]
    words = felt_words(labels)
    told = torch.cat([torch.eye(5)[words[:, place]] for place in range(4)], dim=1)
    readings = torch.cat([told, told], dim=1)
    config = replace(CONFIG, motion_width=20)
    speaker = new_speaker(readings, config)
    optimiser = torch.optim.AdamW(speaker.model.parameters(), lr=3e-3)
    for step in range(60):
        loss = felt_loss(speaker, _disturbed(speaker.model, readings, config, step, "felt"), words)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    silent = readings.clone()
    silent[:, -20:] = speaker.model.projector.mean[-20:]
    for seen, least in ((readings, 0.98), (silent, 0.95)):
        for place, shares in enumerate(speaker.feel(seen).values()):
            assert (shares.argmax(dim=1) == words[:, place]).float().mean() > least


def test_slots_of_which_nothing_is_asked_teach_nothing(tokens):
    speaker = new_speaker(tokens, CONFIG)
    words = torch.full((len(tokens), len(SLOTS)), UNASKED)
    felt_loss(speaker, speaker.model.projector.standardise(tokens), words).backward()
    grads = [one.grad for one in speaker.model.parameters() if one.grad is not None]
    assert grads
    assert all(bool((one == 0).all()) for one in grads)
