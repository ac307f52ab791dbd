"""The published JSON Schema of an answer, for programs that read it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

SCHEMA_PATH = Path(__file__).with_name("answer.schema.json")
"""JSON Schema of `Answer.to_dict()`; under `$defs`, of a row of a batch."""


def answer_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of an answer, as it ships with the package."""
    return json.loads(SCHEMA_PATH.read_text(encoding="utf-8"))
