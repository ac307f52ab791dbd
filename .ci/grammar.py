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

from geotlm_lm.benchmarks.reading import primitive_of
from geotlm_lm.query.lines import PROGRAM_WORDS
from geotlm_lm.training.grammar import SPLITS, Pair, grammar


@dataclass(frozen=True)
class Coverage:
    """What a number of pairs holds.

    Args:
        first: Pairs that ask each primitive first, "fact" where nothing is asked.
        anywhere: Pairs that hold each word of programs.
        ambiguous: Text -> the programs it is written for, where these are several.
    """

    first: Counter[str]
    anywhere: Counter[str]
    ambiguous: dict[str, tuple[str, ...]]


def coverage(pairs: Iterable[Pair]) -> Coverage:
    """Return what these pairs hold."""
    first: Counter[str] = Counter()
    anywhere: Counter[str] = Counter()
    meant: dict[str, set[str]] = {}
    for pair in pairs:
        first[primitive_of(pair.query)] += 1
        anywhere.update(set(pair.query.split()))
        meant.setdefault(pair.text.lower(), set()).add(pair.query)
    several = {text: tuple(sorted(lines)) for text, lines in meant.items() if len(lines) > 1}
    return Coverage(first, anywhere, several)


def main() -> None:
    """Print some pairs, the coverage of more, and the texts among these that mean two things."""
    parser = argparse.ArgumentParser(description="Show what the grammar writes.")
    parser.add_argument("--pairs", type=int, default=20_000, help="how many are drawn")
    parser.add_argument("--sample", type=int, default=0, help="how many of them are printed")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    parser.add_argument("--split", choices=SPLITS, help="families of one split alone")
    asked = parser.parse_args()
    pairs = list(islice(grammar().pairs(asked.seed, asked.split), asked.pairs))
    for pair in pairs[: asked.sample]:
        print(f"{pair.text}\n    {pair.query}    [{', '.join(pair.families)}]")
    print(as_table(coverage(pairs)))


def as_table(held: Coverage) -> str:
    """Return a coverage as a table, and the texts that mean two things."""
    lines = [f"{'':16} {'first':>8} {'anywhere':>8}"]
    for word in PROGRAM_WORDS:
        first, anywhere = held.first[word], held.anywhere[word]
        lines.append(f"{word:16} {first or '-':>8} {anywhere or '-':>8}")
    lines.append(f"\n{len(held.ambiguous)} texts mean two things")
    lines += ["\n    ".join((text, *held.ambiguous[text])) for text in sorted(held.ambiguous)]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
