"""Hold names to plain technical English: `python .ci/words.py` lists those that are not.

A name is the thing it holds: `answer_text`, not `told`; `event`, not `one`.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

NAMES = {"told", "said", "found", "felt", "heard", "whoever", "nobody"}
LOOP_NAMES = {"one"}
ROOT = Path(__file__).resolve().parents[1]


def odd_names(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the line and the name of every variable, parameter, function or class of the lists."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id in NAMES:
            yield node.lineno, node.id
        elif isinstance(node, ast.arg) and node.arg in NAMES:
            yield node.lineno, node.arg
        elif isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name.lower() in NAMES:
            yield node.lineno, node.name
        target = getattr(node, "target", None)
        is_loop = isinstance(node, ast.For | ast.comprehension)
        if is_loop and isinstance(target, ast.Name) and target.id in LOOP_NAMES:
            yield target.lineno, target.id


def main() -> int:
    """Print the odd names of the rooms that are held to the list; return how a process ends."""
    files = [*(ROOT / "geotlm_lm").rglob("*.py"), *(ROOT / "app").rglob("*.py")]
    places = []
    for path in sorted(files):
        name = path.relative_to(ROOT)
        places += [f"{name}:{line}: {word}" for line, word in odd_names(path)]
    print("\n".join(places) or "names say what they hold")
    return 1 if places else 0


if __name__ == "__main__":
    sys.exit(main())
