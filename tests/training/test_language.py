from dataclasses import replace

import numpy as np
import pytest
import torch
from torch.nn.functional import cross_entropy

from geotlm_lm.core.errors import UsageError
from geotlm_lm.core.labels import Motion, MotionLabel
from geotlm_lm.language.decoder import LanguageSize
from geotlm_lm.training.language import (
    LanguageTraining,
    answer_loss,
    draw_clips,
    drawing_shares,
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


@pytest.fixture(scope="module")
def straight(tokens, tmp_path_factory):
    return weights(
        train_language(tokens, LABELS, config=CONFIG, folder=tmp_path_factory.mktemp("straight"))
    )


def weights(speaker):
    return {name: value.clone() for name, value in speaker.model.state_dict().items()}


def same(one, two):
    return one.keys() == two.keys() and all(torch.equal(one[name], two[name]) for name in one)


def interrupt_after(count):
    def progress(what, step, steps):
        if step == count:
            raise KeyboardInterrupt

    return progress


def test_an_interrupted_run_resumes_to_the_same_weights(tokens, straight, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        train_language(tokens, LABELS, config=CONFIG, folder=tmp_path, progress=interrupt_after(3))
    steps = []
    resumed = train_language(
        tokens,
        LABELS,
        config=CONFIG,
        folder=tmp_path,
        progress=lambda what, step, of: steps.append((step, of)),
    )
    assert steps == [(4, 6), (5, 6), (6, 6)]
    assert same(weights(resumed), straight)


def test_the_same_seed_gives_the_same_weights_and_another_others(tokens, straight, tmp_path):
    again = train_language(tokens, LABELS, config=CONFIG, folder=tmp_path / "a")
    other = train_language(tokens, LABELS, config=replace(CONFIG, seed=1), folder=tmp_path / "b")
    assert same(weights(again), straight)
    assert not torch.equal(
        weights(other)["model.projector.expand.weight"], straight["model.projector.expand.weight"]
    )


def test_a_checkpoint_of_other_settings_is_refused(tokens, tmp_path):
    train_language(tokens, LABELS, config=replace(CONFIG, steps=1), folder=tmp_path)
    with pytest.raises(UsageError) as caught:
        train_language(tokens, LABELS, config=replace(CONFIG, batch=4), folder=tmp_path)
    assert str(caught.value) == (
        f"{tmp_path / 'language_checkpoint.pt'}: was trained with another setting of "
        f"['batch', 'steps']; delete it to start over, or train into another folder."
    )


def test_a_checkpoint_of_other_tokens_is_refused(tokens, tmp_path):
    config = replace(CONFIG, steps=1)
    train_language(tokens, LABELS, config=config, folder=tmp_path)
    with pytest.raises(UsageError, match="fused_tokens"):
        train_language(tokens + 1, LABELS, config=config, folder=tmp_path)


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
        hidden, _ = model.decoder(embedded, torch.arange(ids.shape[1])[None])
        logits = model.logits(hidden)[0, len(prompts[row]) - 1 : -1]
        expected += float(
            cross_entropy(logits, torch.tensor(answers[row]), reduction="sum").detach()
        )
    loss = float(answer_loss(model, token, prompts, answers).detach())
    assert loss == pytest.approx(expected, rel=1e-5)


def test_the_rate_rises_in_a_line_and_falls_to_a_tenth():
    config = LanguageTraining(steps=1000, warmup=100, learning_rate=1.0)
    assert learning_rate_at(49, config) == pytest.approx(0.5)
    assert learning_rate_at(100, config) == pytest.approx(1.0)
    assert learning_rate_at(550, config) == pytest.approx(0.55)
    assert learning_rate_at(1000, config) == pytest.approx(0.1)


def test_tokens_and_labels_must_match(tokens, tmp_path):
    with pytest.raises(ValueError, match=r"\(40, 12\) fused tokens for 39 labels"):
        train_language(tokens, LABELS[:-1], config=CONFIG, folder=tmp_path)


def test_the_rate_falls_to_nothing_in_a_cooldown_of_a_ninth():
    config = LanguageTraining(steps=900, warmup=100)
    assert config.all_steps == 1000
    rates = [learning_rate_at(step, config) for step in range(config.all_steps)]
    assert max(rates) == pytest.approx(config.learning_rate)
    assert rates[900] == pytest.approx(0.1 * config.learning_rate)
    assert rates[999] == pytest.approx(0.001 * config.learning_rate)
    assert all(later < earlier for earlier, later in zip(rates[900:], rates[901:], strict=False))


def test_presses_are_asked_about_twice_as_often_as_turns():
    labels = [MotionLabel(Motion.CLOCKWISE)] * 3 + [MotionLabel(Motion.PRESS)]
    shares = drawing_shares(labels)
    assert shares == pytest.approx([0.2, 0.4, 0.6, 1.0])
    config = LanguageTraining(batch=4000)
    chosen = draw_clips(shares, config, step=0)
    assert np.bincount(chosen) / 4000 == pytest.approx([0.2, 0.2, 0.2, 0.4], abs=0.03)
    assert not np.array_equal(chosen, draw_clips(shares, config, step=1))


def test_noise_changes_what_is_learned(tokens, straight, tmp_path):
    quiet = train_language(tokens, LABELS, config=replace(CONFIG, noise=0.0), folder=tmp_path)
    assert not same(weights(quiet), straight)
