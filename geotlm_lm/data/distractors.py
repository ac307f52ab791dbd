"""Draw distractors for a multiple choice: hard to tell apart, in no telling order.

A set is exchangeable: the chance of drawing it is the same whichever of its members is the truth.
So under motions drawn evenly the set itself says nothing, and a claim drawn from a set of two, true
half of the time, says nothing either. Opposites are the hard rivals; horizontal and vertical slides
are each other's next of kin.
"""

from __future__ import annotations

import numpy as np

from geotlm_lm.core.labels import Motion

PAIRS = (
    (Motion.CLOCKWISE, Motion.COUNTERCLOCKWISE),
    (Motion.LEFT, Motion.RIGHT),
    (Motion.UP, Motion.DOWN),
    (Motion.PRESS, Motion.RELEASE),
    (Motion.STILL, Motion.NONE),
)

OPPOSITE_SHARE = 0.7
"""How often the rival in a set of two is the opposite motion."""

_KIN = 0.6  # how often the second pair beside one slide pair is the other slide pair
_FAR = (1 - _KIN) / 3
_REST = (1 - 2 * _FAR) / 2
# Symmetric with rows that sum to one: that is what makes the sets exchangeable.
SECOND_PAIR = np.array(
    [
        [0, _FAR, _FAR, _REST, _REST],
        [_FAR, 0, _KIN, _FAR, _FAR],
        [_FAR, _KIN, 0, _FAR, _FAR],
        [_REST, _FAR, _FAR, 0, _REST],
        [_REST, _FAR, _FAR, _REST, 0],
    ]
)

_PAIR_OF = {motion: index for index, pair in enumerate(PAIRS) for motion in pair}


def draw_option_set(truth: Motion, count: int, rng: np.random.Generator) -> list[Motion]:
    """Return `count` different motions, `truth` among them, in no telling order.

    Two: the opposite, or any motion of another pair. Three: a pair and one motion of another pair,
    the truth standing in the pair twice as often as alone, as two of three members do. Four: two
    pairs.

    Args:
        truth: The motion that must be offered.
        count: 2, 3 or 4.
        rng: Draws the set.

    Raises:
        ValueError: If `count` is another number.
    """
    own = _PAIR_OF[truth]
    other = int(rng.choice(len(PAIRS), p=SECOND_PAIR[own]))
    stranger = PAIRS[other][int(rng.integers(2))]
    if count == 2:
        return list(PAIRS[own]) if rng.random() < OPPOSITE_SHARE else [truth, stranger]
    if count == 3:
        is_in_pair = rng.random() < 2 / 3
        return [*PAIRS[own], stranger] if is_in_pair else [truth, *PAIRS[other]]
    if count == 4:
        return [*PAIRS[own], *PAIRS[other]]
    raise ValueError(f"a question offers 2 to 4 options, not {count}")
