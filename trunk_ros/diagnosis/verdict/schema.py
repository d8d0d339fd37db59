"""The published JSON Schema of ``diagnosis.json``."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any


def diagnosis_schema() -> dict[str, Any]:
    """Draft 2020-12, for any validator: ``jsonschema.validate(content, diagnosis_schema())``."""
    text = files("trunk_ros.diagnosis.verdict").joinpath("diagnosis.schema.json").read_text(encoding="utf-8")
    schema: dict[str, Any] = json.loads(text)
    return schema
