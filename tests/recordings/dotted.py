"""Gels with dots, which a touch moves aside."""

import numpy as np

from geotlm_lm.core.clip import Clip

ROWS, COLUMNS = 120, 160


def shading():
    y, x = np.mgrid[-1 : 1 : ROWS * 1j, -1 : 1 : COLUMNS * 1j]
    return np.stack([120 + 30 * x - 20 * y * y, 110 - 25 * y, 100 + 20 * x * y], axis=-1)


def dotted(strength, seed=0, *, light=1.0, worn=1, noise=1.0):
    """Return a frame of a gel with dots, which a bar pushes aside by up to 4 pixels."""
    y, x = np.mgrid[:ROWS, :COLUMNS].astype(float)
    near = strength / 40 * np.exp(-(((x - 80) / 30) ** 2) - ((y - 60) / 30) ** 2)
    x_rest, y_rest = x - 4 * near, y - 2 * near
    away = np.hypot((x_rest + 5) % 14 - 7, (y_rest + 5) % 14 - 7)
    number = x_rest // 14 + 3 * (y_rest // 14)
    ink = 60 * np.exp(-((away / 2.2) ** 2)) * np.where(number % worn == 0, 1, 0.5)
    bar = np.exp(-(((x - 80) / 6) ** 2) - ((y - 60) / 20) ** 2)
    frame = shading() + strength * 6 * np.gradient(bar, axis=1)[..., None] * [1, 0.6, -1]
    frame = light * frame - ink[..., None]
    frame = frame + np.random.default_rng(seed).normal(0, noise, frame.shape)
    return np.clip(np.rint(frame), 0, 255).astype(np.uint8)


def dotted_recording(strengths, *, drift=0.0, **how):
    lights = np.linspace(1, 1 + drift, len(strengths))
    frames = [
        dotted(strength, number, light=light, **how)
        for number, (strength, light) in enumerate(zip(strengths, lights, strict=True))
    ]
    return Clip(np.stack(frames))
