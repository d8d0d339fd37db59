"""A parameter is declared once: nodes, fits, model files and docs all read this declaration."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any, Literal


@dataclass(frozen=True)
class Parameter:
    """One number of an effect, per joint unless ``shared``.

    ``null`` is the value at which the effect is absent, ``typical`` a usual size: the fit's first step and
    scale.
    ``scan`` holds start values where a fit from ``typical`` alone would miss the optimum.
    """

    name: str
    unit: str
    bounds: tuple[float, float]
    meaning: str
    typical: float
    null: float = 0.0
    scale: Literal["linear", "log"] = "linear"
    shared: bool = False
    scan: tuple[float, ...] = ()
    optional: bool = False
    """An optional parameter stays at ``null`` unless the data ask for it."""
    measured: bool = False
    """What the motion itself tells, at the start of a fit, is not fitted."""
    gone: float | None = None
    """The value at which the effect is absent, where what is meant by default is another one."""
    relative: bool = False
    """Of a number of the arm, which is multiplied by 1 more than that."""
    carried: bool = False
    """A mass at the tip [kg], which all joints feel."""
    periodic: bool = False
    """A phase [rad]: a whole turn more is the same, so that a fit is held by no bounds."""
    stated: str = ""
    """The name under which the arm's description may state it for each joint."""
    slide: str = ""
    """Its unit where a joint's position is in m, of what does not follow from ``unit``: a phase stays one."""
    untold: str = ""
    """What is said where what has an option does without it, and the data are as well explained with it."""
    moment: bool = False
    """A time at which something happens: a fit sees only what lies next to it, so it is looked for."""

    @property
    def reach(self) -> tuple[float, float]:
        """How far a fit may move it: a phase as far as it will."""
        return (-inf, inf) if self.periodic else self.bounds

    @property
    def absent(self) -> float:
        """The value at which the effect is absent."""
        return self.null if self.gone is None else self.gone

    def under(self, load: float) -> float:
        """By how much the usual sizes differ on a joint that bears a ``load`` [N m]: per moment they are less
        on a strong arm.
        """
        if load <= 0.0 or "N*m" not in self.unit:
            return 1.0
        return LOADED / load if self.unit.endswith("/(N*m)") else load / LOADED


def leading(parameters: Sequence[Parameter]) -> Parameter:
    """The one by which an effect's size is told: that with a value of its own at which it is gone, else the
    first.
    """
    return next((p for p in parameters if p.gone is not None), parameters[0])


@dataclass(frozen=True)
class Declaration:
    """One ROS parameter: the type is that of ``default``; a one-element list stands for one value per
    joint.
    """

    name: str
    default: Any
    unit: str
    bounds: tuple[float, float] | None
    meaning: str
    fixed: bool = False
    """A node takes it at its start only."""
    free: bool = False
    """One number or a list: no ROS type is fixed."""

    @property
    def description(self) -> str:
        """Meaning and unit."""
        return self.meaning + (f" [{self.unit}]" if self.unit else "")

    @property
    def range(self) -> str:
        """Bounds and unit; "" without bounds."""
        if self.bounds is None:
            return ""
        low, high = self.bounds
        return f"{low:g} to {high:g} {self.unit}".strip()


ANY = (-1e6, 1e6)
"""Bounds of what has no usual size: of a curve, as far as whatever it describes goes."""
LOADED = 0.1
"""N m: for joints that bear so much the usual sizes are told."""
NEVER = 1e6
"""s: until then what does not end lasts."""
FROM = Parameter("from", "s", (0.0, NEVER), "when it begins", typical=1.0, optional=True, moment=True)
UNTIL = Parameter(
    "until", "s", (0.0, NEVER), "when it ends", typical=1.0, null=NEVER, optional=True, moment=True
)
GROWN = Parameter(
    "grown", "s", (0.0, NEVER), "when it has its full size; at once where it is not said", typical=1.0,
    optional=True, moment=True,
)  # fmt: skip
SPELLS = 3
"""Times that an effect may come, each time with a size of its own."""


def spell(number: int) -> tuple[Parameter, Parameter, Parameter]:
    """When it comes again for the second time or a later one, until when, and with how much of its size."""
    often = {2: "second", 3: "third"}[number]
    return (
        replace(UNTIL, name=f"from_{number}", meaning=f"when its {often} size begins"),
        replace(UNTIL, name=f"until_{number}", meaning=f"when its {often} size ends"),
        Parameter(
            f"times_{number}", "1", (-MANY, MANY), f"its {often} size over its first", typical=1.0, null=1.0,
            optional=True,
        ),
    )  # fmt: skip


MANY = 10.0
LATER = tuple(p for number in range(2, SPELLS + 1) for p in spell(number))
SPELL_NAMES = (
    (FROM.name, UNTIL.name, ""),
    *((begin.name, until.name, times.name) for begin, until, times in map(spell, range(2, SPELLS + 1))),
)
"""Of each time that an effect comes: names of when it begins and ends, and of its size; the first is 1."""
