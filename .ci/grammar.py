"""Show what the grammar writes: some pairs, its coverage, and texts that mean two things.

Nothing is drawn but from a seed, with no clip at hand, so that no text can give an answer away. Run
it: `python .ci/grammar.py --pairs 20000 --sample 50 --seed 0`.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice

from geotlm_lm.benchmarks.questions import VIEWS, cell_of
from geotlm_lm.query.grammar import SPLITS, Pair, grammar
from geotlm_lm.query.text import read
from geotlm_lm.query.types import ASKS

SUBJECTS = ("clip", "half", "span")


@dataclass(frozen=True)
class Coverage:
    """What a number of pairs holds.

    Args:
        views: Pairs of each ask, "fact" where nothing is asked, from each point of view.
        subjects: Pairs of each ask about another clip, a half of the contact or a span of time.
        ambiguous: Text -> the queries it is written for, where these are several.
    """

    views: Counter[tuple[str, str]]
    subjects: Counter[tuple[str, str]]
    ambiguous: dict[str, tuple[str, ...]]


def coverage(pairs: Iterable[Pair]) -> Coverage:
    """Return what these pairs hold."""
    views: Counter[tuple[str, str]] = Counter()
    subjects: Counter[tuple[str, str]] = Counter()
    meant: dict[str, set[str]] = {}
    for pair in pairs:
        parts = read(pair.query).parts
        ask, view = cell_of(parts)
        views[ask, view] += 1
        for name in SUBJECTS:
            subjects[ask, name] += any(getattr(one.subject, name) is not None for one in parts)
        meant.setdefault(pair.text.lower(), set()).add(pair.query)
    several = {text: tuple(sorted(all_)) for text, all_ in meant.items() if len(all_) > 1}
    return Coverage(views, subjects, several)


def main() -> None:
    """Print some pairs, the coverage of more, and the texts among these that mean two things."""
    parser = argparse.ArgumentParser(description="Show what the grammar writes.")
    parser.add_argument("--pairs", type=int, default=20_000, help="how many are drawn")
    parser.add_argument("--sample", type=int, default=0, help="how many of them are printed")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    parser.add_argument("--split", choices=SPLITS, help="families of one split alone")
    asked = parser.parse_args()
    pairs = list(islice(grammar().pairs(asked.seed, asked.split), asked.pairs))
    for one in pairs[: asked.sample]:
        print(f"{one.text}\n    {one.query}    [{', '.join(one.families)}]")
    print(as_table(coverage(pairs)))


def as_table(held: Coverage) -> str:
    """Return a coverage as a table, and the texts that mean two things."""
    columns = (*VIEWS, *SUBJECTS)
    lines = [f"{'':14} " + " ".join(f"{one:>11}" for one in columns)]
    for ask in ("fact", *ASKS):
        counts = [held.views[ask, one] for one in VIEWS]
        counts += [held.subjects[ask, one] for one in SUBJECTS]
        lines.append(f"{ask:14} " + " ".join(f"{one or '-':>11}" for one in counts))
    lines.append(f"\n{len(held.ambiguous)} texts mean two things")
    lines += ["\n    ".join((text, *all_)) for text, all_ in sorted(held.ambiguous.items())]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
