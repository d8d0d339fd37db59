"""What single recordings show: which effects, and a wire that slipped while it was watched."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from scipy import stats

from trunk_ros.fleet.run.outcome import Row
from trunk_ros.fleet.together.arm_effects import EVENTS
from trunk_ros.fleet.together.correction import ALPHA
from trunk_ros.fleet.together.summary import Change

LIKELY = 0.5  # confidence of the recording's own diagnosis


def events(findings: Iterable[Row], looked_at: int) -> list[Change]:
    """Slips that single recordings show, as changes of their arm; ``looked_at``: recordings times joints."""
    by_place: dict[tuple[str, str, str], dict[str, Row]] = defaultdict(dict)
    for row in findings:
        if row["effect"] in EVENTS and row["value"] is not None and row["confidence"] >= LIKELY:
            by_place[row["path"], row["effect"], row["joint"]][row["parameter"]] = row
    found = (_change(values) for values in by_place.values())
    return [each for each in found if each is not None and each.chance * max(looked_at, 1) <= ALPHA]


def alone(findings: Iterable[Row]) -> dict[str, list[tuple[str, str, int]]]:
    """By arm: effect, joint and in how many recordings it was found, the most frequent first."""
    seen: dict[str, dict[tuple[str, str], set[str]]] = defaultdict(lambda: defaultdict(set))
    for row in findings:
        seen[row["arm"]][row["effect"], row["joint"]].add(row["path"])
    return {
        arm: sorted(((*what, len(paths)) for what, paths in said.items()), key=lambda one: (-one[2], one))
        for arm, said in seen.items()
    }


def _change(values: dict[str, Row]) -> Change | None:
    step, onset = values.get("step"), values.get("onset")
    if step is None or onset is None or not step["std"]:
        return None
    return Change(
        step["arm"], step["effect"], step["joint"], "step", step["time"] + onset["value"],
        onset["std"] or 0.0, step["value"], step["std"], step["unit"],
        2.0 * float(stats.norm.sf(abs(step["value"]) / step["std"])),
    )  # fmt: skip
