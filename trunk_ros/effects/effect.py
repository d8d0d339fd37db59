"""What an effect is: a block like ``scipy.signal.lfilter``, or a change to what its stage's core does."""

from __future__ import annotations

import sys
from abc import ABC
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any, ClassVar, Literal

from trunk_ros.compiled import Array
from trunk_ros.effects.core import Core
from trunk_ros.effects.now import Motion as Motion
from trunk_ros.effects.now import Now as Now
from trunk_ros.effects.now import View
from trunk_ros.effects.now import borne as borne
from trunk_ros.effects.swing import Transients
from trunk_ros.errors import ModelError
from trunk_ros.parameter import FROM, GROWN, LATER, UNTIL, Parameter

Stage = Literal["servo", "wire", "arm"]
Regime = Literal["always", "posture", "reversal", "hold", "low_speed", "high_speed", "time"]


AT_REST = ("always", "time", "reversal")  # regimes shown by a joint that others move and not its motor


class Effect(ABC):
    """One phenomenon. Subclasses state it as data and override ``run`` or ``adjust``, and ``invert``."""

    id: ClassVar[str] = ""
    stage: ClassVar[Stage]
    place: ClassVar[int]
    """Physical order: blocks below ``CORE`` act before the stage's core, blocks above it after."""
    regime: ClassVar[Regime]
    signature: ClassVar[str]
    """What one sees in the residual, one sentence."""
    source: ClassVar[str]
    parameters: ClassVar[tuple[Parameter, ...]]
    texts: ClassVar[tuple[str, ...]] = ()
    """Names of parameters that are words, one per joint."""
    forms: ClassVar[tuple[str, ...]] = ("",)
    refined: ClassVar[tuple[str, ...]] = ()
    """Forms with more to them, which are looked at once another form has been found."""
    apart: ClassVar[str] = ""
    """The form in which each joint has values of its own of what all share in the others."""
    shaking: ClassVar[tuple[str, ...]] = ()
    """Forms by which joints move each other, so that all are computed together."""
    dear: ClassVar[Mapping[str, int]] = {}
    """Steps of usual effects that one takes as long as, in forms that take longer."""
    includes: ClassVar[Mapping[str, str]] = {}
    """Another effect that is part of some of its forms, by form, and is told besides."""
    beyond: ClassVar[str] = ""
    """In a wide loop: another effect that is its flat part, and has to be there first."""
    named: ClassVar[bool] = True
    """It is known physics; curves that stand in for what nobody has named are not."""
    exact: ClassVar[bool] = False
    """Whether its formula is geometry or a time, which no material bends."""
    compensable: ClassVar[bool] = True
    remembers: ClassVar[bool] = False
    """What moved before a recording began shows in it, however long ago; the friction element always does."""
    tried: ClassVar[bool] = True
    """The diagnosis tries it; others are switched on in a model by hand."""
    shifts_links: ClassVar[bool] = False
    """It moves what follows a joint by a constant, which behind the last joint is the tool's place."""
    moves_joints: ClassVar[bool] = False
    """At the tip it looks as if a joint stood elsewhere than its sensor says."""
    of_every_joint: ClassVar[bool] = False
    """Each transmission has a value of it, which hides the others' that are so too."""
    everywhere: ClassVar[bool] = False
    """Physics acts on all joints alike, so that it is judged for the arm as a whole."""
    in_plane: ClassVar[bool] = False
    """It moves the tip of a chain in a plane within that plane, and nothing simpler does the same there."""
    delays_readings: ClassVar[bool] = False
    """Its first parameter [s] is the age of the joints' readings; the joints themselves are not late."""
    shifts_readings: ClassVar[bool] = False
    """Its first parameter is a constant in a joint's reading, as where its sensor's zero is off."""
    clips: ClassVar[int] = 0
    """1 where it is a drive's largest setpoint, -1 its smallest."""
    in_coupling: ClassVar[bool] = False
    """What it says of a joint, ``wire.coupling`` says as well."""
    changes: ClassVar[str] = ""
    """The number of the arm that it says is another one, such as ``ratio`` or ``kp``; see ``changed``."""
    begins: ClassVar[bool] = False
    """It may begin or end in the middle of a recording."""
    grows: ClassVar[bool] = False
    """It may do so little by little, and no other effect is just that."""
    scalable: ClassVar[bool] = True
    """It grows in proportion to its first parameter's distance from null: a linear look finds its size."""
    sizes: ClassVar[tuple[str, ...]] = ()
    """Values to which, counted from their null, what it does is in proportion: they are others where it has
    another size for good.
    """
    view: ClassVar[View | None] = None
    """What its signature is drawn over, where that is not what its regime says."""
    needs: ClassVar[tuple[str, ...]] = ()
    """``load``: it must be known, by masses or effort; ``weight``: by masses; ``effort``: by effort;
    ``dead_band``: nominal dead bands to compare; ``several``: more than one joint.
    """
    replaces: ClassVar[tuple[str, ...]] = ()
    """Effects that this one includes: never both at once."""
    confused_with: ClassVar[tuple[tuple[str, str], ...]] = ()
    """(effect, motion that separates the two)."""
    imitated_by: ClassVar[tuple[str, ...]] = ()
    """Kinds of what clocks and sensors do (``quality.observed``) that look like it."""

    CORE: ClassVar[int] = 100

    def __init__(
        self, values: Mapping[str, Array], texts: Mapping[str, tuple[str, ...]] | None = None, form: str = ""
    ):
        """Bind parameter values, each (columns,); ``form`` is one of ``forms``.

        Raises ModelError for an unknown form.
        """
        self.form = self.form_of(form)
        self.values = values
        self.words = texts or {}
        self.acts: tuple[tuple[Array, Array], ...] = ()
        """For stamps (n,) s that were asked for last, how much of it acts (n, columns)."""
        self.lasts: bool | None = None
        """Whether it acts all the time, once somebody asked."""

    def __getitem__(self, name: str) -> Array:
        return self.values[name]

    def run(self, x: Array, now: Now, state: Any) -> tuple[Array, Any]:
        """Pass ``x`` (n, columns) [rad, m at sliding joints] through the phenomenon; returns the same shape
        and the state after it. ``state`` is None at the start of a recording.
        """
        return x, state

    def invert(self, y: Array, now: Now, state: Any) -> tuple[Array, Any]:
        """What must go in for ``y`` (n, columns) to come out."""
        return y, state

    def adjust(self, core: Core, now: Now) -> None:
        """Change the core's settings in place of acting on the signal."""
        return None

    @property
    def acts_at(self) -> int:
        """Its place, in this form."""
        return self.place

    @classmethod
    def bears(cls, form: str) -> bool:
        """Whether it goes by the load, in a form."""
        return not {"load", "weight"}.isdisjoint(cls.needs)

    def upstream(self) -> Effect | None:
        """The part of an effect behind the stage's core that lies before it, if any."""
        return None

    def downstream(self) -> Effect | None:
        """The part of an effect behind the stage's core that does lie behind it, if any."""
        return self

    def included(self, now: Now) -> Mapping[str, Array]:
        """Values (columns,) of the effect that its form includes."""
        return {}

    def check(self, joints: tuple[str, ...]) -> None:
        """Raise ModelError where the words do not fit the arm's joints."""
        for text, words in self.words.items():
            if len(words) != len(joints):
                raise ModelError(f"effects.{self.id}.{text} has {len(words)} words for {len(joints)} joints")

    def credible(self, now: Now, beside: bool = False) -> bool:
        """Whether the motion can show the effect as it was fitted: past that it is a guess at something
        else. ``beside``: less will do, as another joint of the arm shows the same beyond doubt.
        """
        return True

    @classmethod
    def forms_shown(cls, motion: Motion) -> tuple[str, ...]:
        """The forms that a joint's motion can show, if any."""
        if motion.rests and cls.regime not in AT_REST and "several" not in cls.needs:
            return tuple(filter(cls.bears, cls.forms))
        return () if cls.regime in motion.untold else cls.forms

    def transients(self, now: Now) -> Transients | None:
        """How one joint may swing or creep besides, from before the recording, by knocks, or by what nobody
        saw. It is no part of a model: a diagnosis fits their sizes to each recording.
        """
        return None

    def starts(self, now: Now, column: int, rest: Array | None = None) -> list[dict[str, Any]]:
        """Start values for a fit on one column: every combination of the scanned parameters. ``rest`` (n,):
        the residual there, where one is known.
        """
        combined: list[dict[str, Any]] = [{}]
        for parameter in self.own_parameters(self.form):
            if parameter.optional:
                continue
            grid = self.grid(parameter, now, column, rest)
            combined = [{**start, parameter.name: value} for start in combined for value in grid]
        return combined

    @classmethod
    def options(cls, form: str) -> tuple[dict[str, float], ...]:
        """What joints share besides, in each way in which it is looked for from the beginning."""
        return ({},)

    def grid(
        self, parameter: Parameter, now: Now, column: int, rest: Array | None = None
    ) -> tuple[float, ...]:
        """Start values of one parameter, in its unit; override where they depend on the recording. ``rest``
        (n,) rad: what is not explained yet.
        """
        own = "N*m" in parameter.unit and not self.everywhere  # what acts on all joints begins alike
        size = parameter.under(borne(now.load[:, column])) if own else 1.0
        return tuple(size * start for start in parameter.scan or (parameter.typical,))

    @classmethod
    def title(cls, form: str | None = None) -> str:
        """What it is, in the first line of its file; or what it is in one of its forms."""
        module = sys.modules.get(cls.__module__)
        text = (module and module.__doc__) or cls.__doc__ or cls.id
        return " ".join(text.strip().split("\n\n")[0].split()).rstrip(".")

    @classmethod
    def turning(cls, form: str) -> Mapping[str, tuple[str, float]]:
        """Its phases at motor-side angle 0: the periods per turn that each goes with, and how many times."""
        return {}

    @classmethod
    def form_of(cls, said: str) -> str:
        """A form that is said, the first by default. Raises ModelError for one that there is not."""
        if said and said not in cls.forms:
            able = ", ".join(filter(None, cls.forms))
            raise ModelError(f"{cls.id} has no form {said!r}: choose one of {able}")
        return said or cls.forms[0]

    @classmethod
    def own_parameters(cls, form: str) -> tuple[Parameter, ...]:
        """The parameters that a form uses."""
        return cls.of_each() if form and form == cls.apart else cls.parameters

    @classmethod
    @cache
    def of_each(cls) -> tuple[Parameter, ...]:
        """The parameters as values of each joint."""
        return tuple(replace(p, shared=False) for p in cls.parameters)

    @classmethod
    @cache
    def carried(cls) -> tuple[Parameter, ...]:
        """Masses at the tip among the parameters."""
        return tuple(p for p in cls.parameters if p.carried)

    @classmethod
    @cache
    def moments(cls) -> tuple[Parameter, ...]:
        """When it begins, changes its size and ends, and the same of what it makes the arm carry."""
        if not cls.begins:
            return ()
        lead, own = cls.parameters[0], (FROM, UNTIL, *([GROWN] if cls.grows else []), *LATER)
        loads = [
            replace(_of_size(m, p), name=f"{p.name}_{m.name}", shared=True)
            for p in cls.carried()
            for m in (FROM, UNTIL, *LATER)
        ]
        return (*(replace(_of_size(m, lead), shared=lead.shared) for m in own), *loads)

    @classmethod
    def used(cls, form: str) -> tuple[Parameter, ...]:
        """Those of a form, and the moments."""
        return (*cls.own_parameters(form), *cls.moments())

    @classmethod
    def changed(cls, number: Any, values: Mapping[str, Any]) -> Any:
        """The arm's number that it ``changes``, with a model's values of it."""
        return number

    @classmethod
    def plain(cls, values: dict[str, float]) -> dict[str, float]:
        """The same physics in the values that one would write down, such as a positive amplitude."""
        return values

    @classmethod
    def null(cls) -> dict[str, float]:
        """The values at which nothing changes."""
        return {parameter.name: parameter.null for parameter in cls.parameters}

    @classmethod
    def parameter(cls, name: str) -> Parameter:
        """Look a parameter up by name. Raises ModelError naming those that exist."""
        for parameter in (*cls.parameters, *cls.moments()):
            if parameter.name == name:
                return parameter
        able = ", ".join(p.name for p in cls.parameters)
        raise ModelError(f"{cls.id} has no parameter {name!r}: it has {able}")


def _of_size(moment: Parameter, lead: Parameter) -> Parameter:
    """A moment, or a size of what has none below 0."""
    least = moment.bounds[0] if lead.bounds[0] < lead.null else 0.0
    return moment if moment.moment else replace(moment, bounds=(least, moment.bounds[1]))
