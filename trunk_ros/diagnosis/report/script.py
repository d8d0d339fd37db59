"""What may run on the page: texts of our own, each allowed by its hash."""

from __future__ import annotations

import base64
import hashlib
import json
from functools import cache
from pathlib import Path
from typing import Any

from markupsafe import Markup

HERE = Path(__file__).parent


@cache
def script() -> Markup:
    """uPlot and the page's own script."""
    return _joined("uplot/uPlot.iife.min.js", "plots.js")


@cache
def stylesheet() -> Markup:
    """uPlot's and the page's own."""
    return _joined("uplot/uPlot.min.css", "page.css")


def _joined(*files: str) -> Markup:
    return Markup("\n".join((HERE / file).read_text(encoding="utf-8").strip() for file in files))


def policy(scripted: bool) -> Markup:
    """Content security policy: nothing from elsewhere, no style and no script but these, to the letter."""
    scripts = f"; script-src {allowed(script())}" if scripted else ""
    return Markup(f"default-src 'none'; img-src data:; style-src {allowed(stylesheet())}{scripts}")


def allowed(text: str) -> str:
    """The source expression of a text between its tags."""
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return f"'sha256-{base64.b64encode(digest).decode('ascii')}'"


def as_data(content: dict[str, Any]) -> Markup:
    """JSON that no name in it can end: without <, > and & it is text to every parser of HTML."""
    text = json.dumps(content, separators=(",", ":"), allow_nan=False)
    for letter in "<>&":
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return Markup(text)
