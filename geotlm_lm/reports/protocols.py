"""The record of the paper's protocols -> tables in the paper's layout, its figures beside ours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from geotlm_lm.core.labels import Motion
from geotlm_lm.core.record import RunRecord
from geotlm_lm.reports.published import (
    ABLATION,
    BACKBONE,
    CURL,
    DATA,
    FRAMES,
    GEOTLM,
    ROTATION,
    SLIDING,
    Cells,
    Published,
)
from geotlm_lm.reports.tables import markdown, provenance

FIVE_FOLD, LEAVE_ONE_OUT = "five-fold", "leave-one-object-out"
"""Keys of a task's protocols."""

COUNTERPARTS: dict[str, dict[str, str]] = {
    "rotation": {"Curl + LR": CURL, "probe on c": BACKBONE, "DGR, paper": GEOTLM},
    "sliding": {"probe on c": BACKBONE, "DGR, paper": GEOTLM},
}
"""Our row -> the paper's row of the same method on its own backbone and data."""

ABLATED: dict[str, tuple[str, str, str | None]] = {
    "probe on c": ("no", "no", BACKBONE),
    "DGR, neither": ("no", "no", None),
    "DGR, region pool only": ("yes", "no", "DGR - contact mask"),
    "DGR, contact mask only": ("no", "yes", "DGR - region pool"),
    "DGR, paper": ("yes", "yes", GEOTLM),
    "DGR, differential operators on": ("yes", "yes", None),
}
"""Row of the ablation -> seven regions, learned mask, the paper's row."""

BY_FRAMES: dict[str, tuple[str, str]] = {
    "probe on c, 2 frames": ("2", "AnyTouch 2, 2-frame"),
    "probe on c": ("4", "AnyTouch 2, 4-frame"),
    "DGR, paper, 2 frames": ("2", "GeoTLM, 2-frame"),
    "DGR, paper": ("4", "GeoTLM, 4-frame"),
}
"""Row of the frame counts -> frames, the paper's row."""

INTRO = """\
# The paper's protocols

*Ours* are clips that the product's simulator made of {objects} everyday objects, which no weight of
its backbone was trained on; *published* are the paper's figures on its own data and backbone. They
share a protocol, not data: a difference between the two says nothing about either.

- Backbone of our rows: {backbone}, frozen; every clip was encoded once.
- Folds have three parts with no object in two of them; the epoch is chosen on the validation
  objects. The paper chooses it too and does not say on what.
- Tokens are standardised with the statistics of the training part. AdamW, {head_rate:g} for the
  head and {dgr_rate:g} for DGR, weight decay {weight_decay:g}, batches of {batch}, {epochs} epochs,
  best validation epoch (among equally accurate ones the least loss), seed {seed} + fold.
- Figures are mean and standard deviation (n - 1) over folds; recalls are means over folds.
- *probe on c* reads the global token alone, which is the paper's row of the bare backbone. *DGR,
  paper* is shaped by the classification loss only; *grounded* by true displacement and contact as
  well, from their least-squares read-outs on the training part.
- *Curl + LR*: the paper does not say what shear its curl is of; here it is of the imprint's optical
  flow. *Optical flow + rigid fit* is not trained; its folds only cut the same clips.
- Without the *region pool* the contact-weighted mean over the whole grid is left; without the
  *contact mask* every patch weighs the same; *neither* is the plain mean, which the paper does not
  have: its row without both is the bare backbone. *Differential operators* pools curl, divergence
  and two strains of the shear change beside it; the paper leaves them off and gives no figure.
- Two frames are the first and the last of the same clip, fed as a, a, b, b: what moves is the same,
  what is seen of the way is not."""


def protocols_page(record: RunRecord) -> str:
    """Return everything the record says, as Markdown."""
    training = record.config["training"]
    intro = INTRO.format(
        objects=len(record.config["objects"]),
        backbone=_backbone(record),
        epochs=record.config["epochs"],
        seed=record.seed,
        **training,
    )
    minutes = sum(task["seconds_from_nothing"] for task in record.numbers["tasks"].values()) / 60
    time = (
        f"Simulating, encoding and training took {minutes:.1f} min in all, in this run and those "
        f"it continued."
    )
    return "\n\n".join([intro, protocol_tables(record), f"{provenance(record)} {time}"]) + "\n"


def protocols_headline(record: RunRecord) -> str:
    """Return the paper's two main tables, ours and the published figures apart, for the README."""
    tasks = record.numbers["tasks"]
    tables = [table for name in tasks if name in _TABLES for table in _TABLES[name](tasks)]
    return "\n\n".join([*tables, provenance(record)])


def protocol_tables(record: RunRecord) -> str:
    """Return the tables that were run, then each object's accuracy, differences and folds."""
    tasks, parts = record.numbers["tasks"], []
    for name in record.config["tables"]:
        parts += [f"## {name.capitalize()}", *_TABLES[name](tasks)]
    for task, found in tasks.items():
        parts += [f"## {task.capitalize()}, object by object"]
        parts += [f"Leave-one-object-out. {_facts(found)}", object_table(found)]
        parts += [f"## {task.capitalize()}, row by row"]
        for protocol in found["protocols"]:
            parts += [f"### {protocol}", row_table(found["protocols"][protocol])]
        parts += [f"## {task.capitalize()}, differences"]
        parts += ["First less second, paired by clip; intervals and p by object.",
                  difference_table(found)]  # fmt: skip
    parts += ["## Folds", fold_table(tasks)]
    return "\n\n".join(parts)


def comparison_table(
    found: Mapping[str, Any], rows: Sequence[str], task: str, published: Mapping[str, Cells]
) -> str:
    """Return the paper's main table: ours in both protocols, the published ones on their data.

    Published rows without a counterpart stand below ours.
    """
    header = [task]
    published_on = [f"published, {name}" for name in DATA]
    for title in ("ours, five-fold", "ours, leave-one-object-out", *published_on):
        header += [title, "recall"]
    counterparts = COUNTERPARTS[task]
    lines = []
    for row in rows:
        other = counterparts.get(row)
        label = row if other is None else f"{row} (paper: {other})"
        lines.append([label, *_ours(found, row), *_published(published.get(other or ""))])
    for other, cells in published.items():
        if other not in counterparts.values():
            lines.append([f"paper: {other}", *("-",) * 4, *_published(cells)])
    return f"{markdown(header, lines)}\n\nRecalls: {' / '.join(_truths(found))}."


def ablation_table(tasks: Mapping[str, Any]) -> str:
    """Return which parts of DGR give what, for every task that was run."""
    header = ["variant", "region pool", "contact mask", *_columns(tasks)]
    header += [f"published, {name}, rotation" for name in DATA[:2]]
    lines = []
    for row, (regions, mask, other) in ABLATED.items():
        cells = ABLATION.get(other or "", (None, None, None))
        label = row if other is None else f"{row} (paper: {other})"
        lines.append([label, regions, mask, *_overall(tasks, row), *map(_overall_of, cells[:2])])
    return markdown(header, lines)


def frames_table(tasks: Mapping[str, Any]) -> str:
    """Return what two frames give against four."""
    header = ["variant", "frames", *_columns(tasks), f"published, {DATA[0]}, rotation"]
    lines = [
        [f"{row} (paper: {other})", frames, *_overall(tasks, row), _overall_of(FRAMES[other][0])]
        for row, (frames, other) in BY_FRAMES.items()
    ]
    return markdown(header, lines)


def object_table(found: Mapping[str, Any]) -> str:
    """Return each held-out object's accuracy, one column per row of the tables."""
    rows = found["protocols"][LEAVE_ONE_OUT]["rows"]
    names = next(iter(rows.values()))["by_object"]
    lines = [
        [name, *(f"{scores['by_object'][name]:.3f}" for scores in rows.values())] for name in names
    ]
    return markdown(["held out", *rows], lines)


def row_table(protocol: Mapping[str, Any]) -> str:
    """Return what the main tables leave out: balanced accuracy, interval, parameters, epochs."""
    lines = []
    for name, scores in protocol["rows"].items():
        low, high = scores["interval"]
        epochs = sorted(epoch for epoch in scores["best_epoch"] if epoch is not None)
        worst = min(scores["by_object"], key=scores["by_object"].get)
        lines.append(
            [
                name,
                f"{scores['mean']:.3f} ± {scores['sd']:.3f}",
                f"{scores['balanced_mean']:.3f} ± {scores['balanced_sd']:.3f}",
                f"{low:.3f}-{high:.3f}",
                f"{scores['by_object'][worst]:.3f} ({worst})",
                f"{scores['parameters']:,}",
                str(epochs[len(epochs) // 2]) if epochs else "-",
            ]
        )
    header = [
        "row",
        "accuracy",
        "balanced",
        "95 % of all clips",
        "lowest object",
        "trained numbers",
    ]
    return markdown([*header, "best epoch, median"], lines)


def difference_table(found: Mapping[str, Any]) -> str:
    """Return paired differences, one line per pair, protocols side by side."""
    protocols = found["protocols"]
    pairs = [(one["first"], one["second"]) for one in protocols[FIVE_FOLD]["differences"]]
    lines = []
    for number, (first, second) in enumerate(pairs):
        line = [f"{first} less {second}"]
        for protocol in protocols.values():
            one = protocol["differences"][number]
            line.append(f"{one['difference']:+.3f} ({one['low']:+.3f} to {one['high']:+.3f})")
            line.append(f"{one['p_value']:.3f}")
        lines.append(line)
    header = ["difference, 95 %"]
    for name in protocols:
        header += [name, "p"]
    return markdown(header, lines)


def fold_table(tasks: Mapping[str, Any]) -> str:
    """Return who stands in which part; the folds of all tasks are the same."""
    protocols = next(iter(tasks.values()))["protocols"]
    lines = [
        [
            f"{name} {number}",
            ", ".join(fold["test"]),
            ", ".join(fold["val"]),
            " / ".join(str(count) for count in fold["clips"]),
        ]  # fmt: skip
        for name, protocol in protocols.items()
        for number, fold in enumerate(protocol["folds"])
    ]
    return markdown(["fold", "test", "validation", "clips, train / val / test"], lines)


_TABLES = {
    "rotation": lambda tasks: [_main("rotation", tasks, ROTATION)],
    "sliding": lambda tasks: [_main("sliding", tasks, SLIDING)],
    "ablation": lambda tasks: [ablation_table(tasks)],
    "frames": lambda tasks: [frames_table(tasks)],
}


def _main(task: str, tasks: Mapping[str, Any], published: Mapping[str, Cells]) -> str:
    own = ("Curl + LR", "optical flow + rigid fit", "probe on c", "DGR, paper", "DGR, grounded")
    found = tasks[task]
    rows = found["protocols"][FIVE_FOLD]["rows"]
    return comparison_table(found, [row for row in own if row in rows], task, published)


def _backbone(record: RunRecord) -> str:
    return f"{record.config['backbone']} ({record.config['backbone_digest']})"


def _facts(found: Mapping[str, Any]) -> str:
    truths = ", ".join(f"{count} {motion}" for motion, count in _truths(found).items())
    return (
        f"{found['clips']} clips: {truths}; {found['unreadable_left_out']} left out, their images "
        f"do not show the motion."
    )


def _truths(found: Mapping[str, Any]) -> dict[str, int]:
    """Return the clips of each motion in the order of the published recalls, not by letter."""
    return {name: found["truths"][name] for name in Motion if name in found["truths"]}


def _ours(found: Mapping[str, Any], row: str) -> list[str]:
    cells = []
    for protocol in (FIVE_FOLD, LEAVE_ONE_OUT):
        scores = found["protocols"][protocol]["rows"][row]
        recalls = " / ".join(f"{scores['recall'][name]:.3f}" for name in _truths(found))
        cells += [f"{scores['mean']:.3f} ± {scores['sd']:.3f}", recalls]
    return cells


def _published(cells: Cells | None) -> list[str]:
    line = []
    for cell in cells or (None, None, None):
        recalls = "-" if cell is None else " / ".join(f"{value:.3f}" for value in cell.recall)
        line += [_overall_of(cell), recalls]
    return line


def _overall_of(cell: Published | None) -> str:
    return "-" if cell is None else f"{cell.mean:.3f} ± {cell.sd:.3f}"


def _columns(tasks: Mapping[str, Any]) -> list[str]:
    return [f"ours, {name}, {task}" for task in tasks for name in (FIVE_FOLD, LEAVE_ONE_OUT)]


def _overall(tasks: Mapping[str, Any], row: str) -> list[str]:
    cells = []
    for found in tasks.values():
        for name in (FIVE_FOLD, LEAVE_ONE_OUT):
            scores = found["protocols"][name]["rows"][row]
            cells.append(f"{scores['mean']:.3f} ± {scores['sd']:.3f}")
    return cells
