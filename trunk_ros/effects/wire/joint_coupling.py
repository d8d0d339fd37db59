"""Another joint's angle changes the path of this joint's wire."""

from functools import cached_property
from typing import Any

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.effects.effect import Effect, Now
from trunk_ros.effects.sources import STANDS, check_sources
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.parameter import Parameter

SOURCES = 3
BEHIND = 245  # where curves of other joints act as well


def _gain(k: int) -> Parameter:
    name = "gain" if k == 1 else f"gain_{k}"
    return Parameter(
        name, "1", (-3.0, 3.0), "joint angle per angle of the source", typical=0.005, optional=k > 1
    )


class JointCoupling(Effect):
    """u += gain theta_source, for up to three sources a joint. behind: theta += gain theta_source, behind the
    friction of the joint's own wire, as where its sensor or its last guide lies on the source's link.
    motors: u += gain s with s = r phi of the source's wire, whatever that loses on its way, as where one
    motor sits on another's shaft or their gears mesh.

    drag: wires that touch. u += gain s + drag (s - play(s, reach)): the source's wire takes this joint's
    along by friction, as far as ``reach``, and then slides on it.
    """

    id = "joint_coupling"
    sizes = ("gain", "gain_2", "gain_3", "drag")
    stage, place, regime = "wire", 30, "posture"
    exact = True
    begins = in_coupling = True
    signature = "The residual follows another joint's angle, whether this joint moves or not."
    remembers = True
    source = (
        "Ciofu & Stan, fig. 1: wires of distal joints pass through the guides of the proximal ones; "
        "drag: presliding friction between two wires, Dahl (1968) in its play form."
    )
    forms = ("angle", "behind", "motors", "drag")
    refined = ("behind",)
    parameters = (
        *(_gain(k) for k in range(1, SOURCES + 1)),
        Parameter("drag", "1", (-5.0, 5.0), "share of the first source's motion taken along", typical=0.1),
        Parameter(
            "reach", "rad", (1e-5, 5.0), "half the motion after which the source's wire slides", typical=0.1,
            null=0.1, scale="log", scan=(0.02, 0.2),
        ),
    )  # fmt: skip
    texts = ("source", *(f"source_{k}" for k in range(2, SOURCES + 1)))
    needs = ("several",)
    confused_with = (
        ("load_elasticity", "hold this joint and turn others so that the arm's reach stays the same"),
    )

    @property
    def acts_at(self) -> int:
        return BEHIND if self.form == "behind" else self.place

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        pull, state = self._pull(now, state)
        return x + pull, state

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        pull, state = self._pull(now, state)
        return y - pull, state

    def credible(self, now: Now, beside: bool = False) -> bool:
        """A source that stands is no more than an offset; a drag that never slides is a gain, and by how it
        began an offset.
        """
        moved = np.ptp(self._seen(now), axis=0)
        stand = any(moved[now.joints.index(s)] <= STANDS * moved.max() for _, s, _ in self._links)
        return not stand and (self.form != "drag" or self._slides(now))

    def _slides(self, now: Now) -> bool:
        dragging = zip(self.words.get("source", ()), self["reach"], strict=False)
        return all(2.0 * r < np.ptp(now.wires[:, now.joints.index(s)]) for s, r in dragging if s)

    @classmethod
    def title(cls, form: str | None = None) -> str:
        titles = {
            "drag": "Another joint's wire drags this joint's along",
            "motors": "Another joint's motor turns this joint as well",
        }
        return titles.get(form or "") or super().title()

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        return cls.parameters if form == "drag" else cls.parameters[:SOURCES]

    def check(self, joints: tuple[str, ...]) -> None:
        super().check(joints)
        drags = [("drag", self.texts[0])] if self.form == "drag" else []
        check_sources(self.id, [*self.pairs(), *drags], self.values, self.words, joints)

    def pairs(self) -> list[tuple[str, str]]:
        """Names of each gain and the source that belongs to it."""
        return [(p.name, text) for p, text in zip(self.parameters[:SOURCES], self.texts, strict=True)]

    @cached_property
    def _links(self) -> list[tuple[int, str, float]]:
        """Column, source and gain of each coupling that there is."""
        return [
            (column, source, float(self[gain][column]))
            for gain, text in self.pairs()
            for column, source in enumerate(self.words.get(text, ()))
            if source and self[gain][column] != 0.0
        ]

    _gains: tuple[tuple[str, ...], Array] = (), np.empty(0)
    """For the joints of an arm, (all joints, columns) joint angle per angle of each source."""

    def _seen(self, now: Now) -> Array:
        """(n, all joints) rad of what the sources act by: their motors where it is their wires."""
        return now.wires if self.form in ("motors", "drag") else now.angles

    def _pull(self, now: Now, state: Any) -> tuple[Array, Any]:
        """(n, columns) rad that the sources add."""
        joints, gains = self._gains
        if joints != now.joints:
            gains = np.zeros((len(now.joints), len(now.ratio)))
            for column, source, gain in self._links:
                gains[now.joints.index(source), column] += gain
            self._gains = now.joints, gains
        pulled = self._seen(now) @ gains
        if self.form != "drag":
            return np.asarray(pulled), None
        dragging = [source or "" for source in self.words.get("source", ("",) * len(now.ratio))]
        moved = np.zeros((len(now.stamp), len(now.ratio)))
        for column, source in enumerate(dragging):
            if source:
                moved[:, column] = now.wires[:, now.joints.index(source)]
        stuck, state = SharpPlay().run(moved, self["reach"][None], state)
        return np.asarray(pulled + self["drag"] * (moved - stuck)), state
