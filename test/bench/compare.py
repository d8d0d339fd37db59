"""What has changed between two benches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

NOTABLE = 0.1  # of a figure: less is the machine's


@dataclass(frozen=True)
class Change:
    """One figure, then and now; ``factor`` is the share by which it has grown."""

    name: str
    unit: str
    then: float
    now: float
    worse: bool

    @property
    def factor(self) -> float:
        """Growth as a share of what it was."""
        return self.now / self.then - 1.0


def changes(old: dict[str, Any], new: dict[str, Any]) -> list[Change]:
    """Figures of sections that both have and that differ by more than a tenth, the worst first."""
    found = []
    for name, section in new.items():
        before = {row["name"]: row for row in old.get(name, {}).get("rows", [])}
        for row in section["rows"]:
            then = before.get(row["name"], {}).get("value")
            if then and abs(row["value"] / then - 1.0) > NOTABLE:
                more_is_better = str(row.get("target") or "").startswith("≥") or "/s" in row["unit"]
                worse = (row["value"] < then) == more_is_better
                label = f"{name}: {row['name']}"
                found.append(Change(label, row["unit"], float(then), float(row["value"]), worse))
    return sorted(found, key=lambda each: (not each.worse, -abs(each.factor)))
