"""A single field of a table: a number, a date, or text."""

import re
from datetime import UTC, datetime

_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")


def with_comma(text: str) -> bool:
    """Whether a field is a number with a decimal comma."""
    return bool(_COMMA.fullmatch(text.strip()))


def as_date(text: str) -> float:
    """s since 1970 of a date and time in ISO 8601; UTC where it names no zone. ValueError where it is no
    such date.
    """
    date = datetime.fromisoformat(text.strip())
    return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp()


def is_date(text: str) -> bool:
    """Whether a field is a date and time in ISO 8601, and no number."""
    try:
        return "-" in text and ":" in text and as_date(text) == as_date(text)
    except ValueError:
        return False


def as_number(text: str) -> float | None:
    """A number with a decimal point or comma, or s since 1970 of a date; None where a field is neither."""
    try:
        return as_date(text) if is_date(text) else float(text.replace(",", "."))
    except ValueError:
        return None


def are_numbers(names: list[str]) -> bool:
    """Whether the names of columns are numbers, as where a table has no header; whole ones that only count
    on are names.
    """
    values = [as_number(name) for name in names]
    if None in values or not values:
        return False
    return values not in ([*range(len(values))], [*range(1, len(values) + 1)])
