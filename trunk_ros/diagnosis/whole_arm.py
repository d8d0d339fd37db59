"""What was found on some joints, as effects of the whole arm."""

from __future__ import annotations

from typing import Any

import numpy as np

from trunk_ros.effect_values import Values
from trunk_ros.effects import effect


def on_the_arm(
    effects: dict[str, Values],
    had: dict[str, Values],
    seen: tuple[str, ...],
    joints: tuple[str, ...],
    said: set[str],
) -> dict[str, Values]:
    """Effects with values for the joints ``seen`` in the recordings, as effects of all ``joints``: the others
    keep what they ``had``, where that is of the same form. What the model had of which nothing is ``said`` is
    as it was.
    """
    same = {n: v for n, v in had.items() if n in effects.keys() - said and effect(n).named}
    unseen = [k for k, joint in enumerate(joints) if joint not in seen]

    def spread(name: str, key: str, value: Any) -> Any:
        before, now = had.get(name, {}), effects.get(name, {})
        if isinstance(value, (str, float)):
            return value
        null = "" if isinstance(value, list) else effect(name).parameter(key).null
        kept = before.get(key) if before.get("form") == now.get("form", before.get("form")) else None
        there = dict(zip(seen, value, strict=True)) if name in effects and key in now else {}
        whole = [
            there.get(j, kept[k] if kept is not None and k in unseen else null) for k, j in enumerate(joints)
        ]
        return whole if isinstance(value, list) else np.array(whole)

    gone = {
        name: values
        for name, values in had.items()
        if name not in effects and any(_acts(name, values, k) for k in unseen)
    }
    whole = {
        name: {key: spread(name, key, v) for key, v in values.items()}
        for name, values in {**effects, **gone}.items()
    }
    return whole | same


def _acts(name: str, values: Values, joint: int) -> bool:
    """Whether a model has an effect on a joint by a value of its own."""
    own = [p for p in effect(name).parameters if np.ndim(values.get(p.name, 0.0))]
    return any(values[p.name][joint] != p.null for p in own)
