"""Who is taken for whom, as pictures: one PNG per table of an evaluation, a panel per method.

A picture is opaque, so that it reads on a light page and on a dark one, and holds the digest of the
numbers it shows, so that one drawn from an older record can be told.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geotlm_lm.core.atomic import replacing
from geotlm_lm.core.errors import MissingDependency
from geotlm_lm.core.labels import Motion
from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.facts import SHARE_OF_A_TABLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FOLDER = "confusions"
"""Where the pictures lie, beside the page that shows them."""

FREE_PROBE, PROBE = "linear probe on z, all motions", "linear probe on z"

SHOWN = ("language model, words", FREE_PROBE, PROBE, "optical flow + rigid fit")
"""Methods drawn, in this order; of a record without any of them, all."""

NO_ANSWER = "no answer"

PAPER = (255, 255, 255)
INK = (0, 0, 0)
RIGHT, WRONG = (23, 88, 160), (190, 75, 0)
"""Colours of a full cell, blue and orange: the colour-blind tell them apart."""

CELL_IN, DPI = 0.42, 110
"""Side of a cell in inches, and pixels per inch."""

PANELS_ACROSS = 2


def confusion_pictures(record: RunRecord) -> dict[str, str]:
    """Return title -> path of its picture beside the page, for every table that gets one.

    Shares of a table (one direction, one frame rate, one sensor) have none of their own.
    """
    titles = [title for title in record.numbers["tables"] if not SHARE_OF_A_TABLE.search(title)]
    return {title: f"{FOLDER}/{_file_name(title)}" for title in titles}


def draw_confusions(record: RunRecord, folder: Path) -> list[Path]:
    """Draw the pictures of every table into `folder`, and return their paths.

    Raises:
        MissingDependency: If matplotlib is not installed.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        raise MissingDependency(
            "pictures are drawn by matplotlib, which is not installed; run `pip install "
            "'geotlm-lm[eval]'`."
        ) from error
    paths = []
    for title, name in confusion_pictures(record).items():
        paths.append(folder / Path(name).name)
        _draw(title, record.numbers["tables"][title], paths[-1])
    return paths


def stale_pictures(record: RunRecord, folder: Path) -> list[Path]:
    """Return the pictures that are missing, or show other numbers than the record."""
    stale = []
    for title, name in confusion_pictures(record).items():
        path, digest = folder / Path(name).name, _digest(record.numbers["tables"][title])
        if not path.is_file() or digest.encode() not in path.read_bytes():
            stale.append(path)
    return stale


def panels(table: Mapping[str, Any]) -> dict[str, tuple[list[str], list[str], NDArray[np.int64]]]:
    """Return the matrix of each method drawn, all with the same columns.

    Args:
        table: One table of a record.

    Returns:
        Method -> truths, answers, and counts of shape (truths, answers).
    """
    methods = [name for name in SHOWN if name in table["methods"]] or list(table["methods"])
    if {FREE_PROBE, PROBE} <= set(methods) and _same(table, FREE_PROBE, PROBE):
        methods.remove(FREE_PROBE)  # the task is all ten motions: both chose among the same
    order = [str(motion) for motion in Motion]
    truths = [name for name in order if name in table["truths"]]
    found = {name: _counted(table["methods"][name]["confusion"]) for name in methods}
    given = {answer for counts in found.values() for (_, answer), n in counts.items() if n}
    answers = [name for name in (*order, NO_ANSWER) if name in given | set(truths)]
    return {
        name: (
            truths,
            answers,
            np.array([[counts.get((t, a), 0) for a in answers] for t in truths]),
        )
        for name, counts in found.items()
    }


def shade(share: float, is_right: bool) -> tuple[int, int, int]:
    """Return the colour of a cell, RGB, 0 to 255.

    Args:
        share: Of its row, in [0, 1]; its root is drawn, so that a rare mistake still shows.
        is_right: Whether the answer is the truth.
    """
    full, depth = RIGHT if is_right else WRONG, float(np.sqrt(share))
    red, green, blue = (
        round(empty + depth * (own - empty)) for empty, own in zip(PAPER, full, strict=True)
    )
    return red, green, blue


def ink_on(colour: tuple[int, int, int]) -> tuple[int, int, int]:
    """Return the one of `PAPER` and `INK` that reads better on `colour`."""
    return max((PAPER, INK), key=lambda ink: contrast(ink, colour))


def contrast(first: tuple[int, int, int], second: tuple[int, int, int]) -> float:
    """Return the contrast ratio of two colours (WCAG 2), from 1 to 21; text wants 4.5."""
    light, dark = sorted((_luminance(first), _luminance(second)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def _draw(title: str, table: Mapping[str, Any], path: Path) -> None:
    from matplotlib.figure import Figure

    drawn = panels(table)
    truths, answers, _ = next(iter(drawn.values()))
    rows = -(-len(drawn) // PANELS_ACROSS)
    size = (
        PANELS_ACROSS * (CELL_IN * len(answers) + 0.3) + 1.2,
        rows * (CELL_IN * len(truths) + 1.6) + 0.4,
    )
    figure = Figure(figsize=size, layout="constrained", facecolor=_unit(PAPER))
    figure.suptitle(title, color=_unit(INK), fontsize=11)
    grid = figure.subplots(rows, PANELS_ACROSS, sharey=True, squeeze=False)
    for axes in grid.flat[len(drawn) :]:
        axes.remove()
    for axes, (method, (_, _, counts)) in zip(grid.flat, drawn.items(), strict=False):
        _draw_panel(axes, method, truths, answers, counts)
    for axes in grid[:, 0]:
        axes.set_ylabel("truth", color=_unit(INK), fontsize=8)
    metadata = {"Title": title, "Comment": _digest(table), "Software": None}
    with replacing(path) as stream:
        figure.savefig(
            stream,
            dpi=DPI,
            format="png",
            facecolor=_unit(PAPER),
            transparent=False,
            bbox_inches="tight",  # slanted labels reach beyond what the layout reckons with
            metadata=metadata,
        )


def _draw_panel(
    axes: Axes, method: str, truths: list[str], answers: list[str], counts: NDArray[np.int64]
) -> None:
    totals = np.maximum(counts.sum(axis=1), 1)
    image = np.zeros((*counts.shape, 3), np.uint8)
    for row, truth in enumerate(truths):
        for column, answer in enumerate(answers):
            count = int(counts[row, column])
            colour = shade(count / totals[row], answer == truth)
            image[row, column] = colour
            if count:
                ink = _unit(ink_on(colour))
                axes.text(column, row, str(count), ha="center", va="center", color=ink, fontsize=8)
    axes.imshow(image, aspect="equal")
    axes.set_title(method, color=_unit(INK), fontsize=9)
    axes.set_xticks(range(len(answers)), answers, rotation=60, ha="right", rotation_mode="anchor")
    axes.set_yticks(range(len(truths)), truths)
    axes.tick_params(colors=_unit(INK), labelsize=8, length=0)
    axes.set_xlabel("answer", color=_unit(INK), fontsize=8)
    for spine in axes.spines.values():
        spine.set_color("0.6")


def _counted(confusion: Mapping[str, Any]) -> dict[tuple[str, str], int]:
    columns = [*confusion["labels"], NO_ANSWER]
    return {
        (truth, answer): count
        for truth, row in zip(confusion["labels"], confusion["counts"], strict=True)
        for answer, count in zip(columns, row, strict=True)
    }


def _same(table: Mapping[str, Any], first: str, second: str) -> bool:
    return table["methods"][first]["confusion"] == table["methods"][second]["confusion"]


def _digest(table: Mapping[str, Any]) -> str:
    """Return a fingerprint of everything a picture shows of a table."""
    shown = {name: [t, a, counts.tolist()] for name, (t, a, counts) in panels(table).items()}
    return hashlib.sha256(json.dumps(shown).encode()).hexdigest()[:16]


def _file_name(title: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-") + ".png"


def _luminance(colour: tuple[int, int, int]) -> float:
    parts = np.asarray(colour) / 255
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


def _unit(colour: tuple[int, int, int]) -> tuple[float, float, float]:
    red, green, blue = (value / 255 for value in colour)
    return red, green, blue
