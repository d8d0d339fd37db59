"""A smooth curve in the place of physics that no name fits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.spectrum import spectrum
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.jumps import jumps, moved_by
from trunk_ros.diagnosis.discrepancy.smooth import smoothed
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.fit import Fit, costed_on, fit
from trunk_ros.diagnosis.search.score import SIGNIFICANT
from trunk_ros.effects import effect, registry
from trunk_ros.effects.curve import HIGH, KNOTS, LOW, ON, SPEED_OF, VALUES, Curve, abscissa
from trunk_ros.effects.wire.unknown import Unknown
from trunk_ros.effects.wire.unknown_cycle import UnknownCycle
from trunk_ros.effects.wire.unknown_jumps import MOMENTS, UnknownJumps
from trunk_ros.effects.wire.unknown_slips import UnknownSlips
from trunk_ros.effects.wire.unknown_waves import UnknownWaves
from trunk_ros.levels import PART, TURNS
from trunk_ros.recording.signal.resample import SLOW

BUMP = 1e-4  # rad of a dead band, for derivatives
ZONES = np.geomspace(1e-4, 0.1, 30)  # rad, tried as constants: a small zone shows nothing of a large one
NEAR = np.linspace(0.88, 1.12, 25)  # of the best of them, likewise
MOST_JUMPS = 16
SHORTER = (1.0, 0.5, 0.25, 0.125)  # of a step: what judges a curve may not miss that it can be drawn


@dataclass(frozen=True)
class Place:
    """A kind of curve, what it is drawn over, from where to where, and when it jumps."""

    kind: str
    variable: str
    low: float
    high: float
    moments: tuple[float, ...] = ()

    @property
    def curve(self) -> type[Curve]:
        """The effect."""
        found = effect(self.kind)
        assert issubclass(found, Curve)
        return found

    def basis(self, x: Array) -> Array:
        """(n, KNOTS) the curve at ``x`` (n,) per value."""
        if self.moments:
            return np.eye(KNOTS)[np.searchsorted(self.moments, x, side="right")]
        return self.curve.basis(x, self.low, self.high)


@dataclass(frozen=True)
class Drawn:
    """A fitted curve; ``worth`` also counts how freely it bends (Schwarz 1978)."""

    fit: Fit
    worth: float


def curve_fit(context: Context, bare: Hypothesis, column: int) -> Fit | None:
    """The hypothesis with the curve, of whatever it is best a curve of and over what it is best drawn over,
    that explains most of a column's rest.
    """
    return curve_fits(context, bare, column)[0]


def curve_fits(context: Context, bare: Hypothesis, column: int) -> tuple[Fit | None, Fit | None]:
    """The same, and of those curves whose values are tied to those beside them."""
    bare = fit(context, bare, [column]).hypothesis
    able = [some for some in places(context, bare, column) if some]
    drawn = [_best(context, bare, column, some) for some in able]
    tied = [d for d, some in zip(drawn, able, strict=True) if len(some[0].curve.bend())]
    best, smooth = (min(some, key=lambda d: d.worth, default=None) for some in (drawn, tied))
    return best.fit if best else None, smooth.fit if smooth else None


def curves_beside(context: Context, hypothesis: Hypothesis, column: int) -> list[Hypothesis]:
    """The hypothesis with a curve of the angle beside its names, over one thing or another."""
    found = [Place(Unknown.id, v, *ends(context, column, v)) for v in variables(context, column)]
    return [_alternate(context, hypothesis, column, place).fit.hypothesis for place in found]


def promised(context: Context, bare: Hypothesis, column: int, linear: bool = True) -> float:
    """Squared unit-noise residual above the noise that a curve added to the angle would leave of a column by
    a linear look: a fit leaves no more. Not ``linear``: that of curves of what the core does, such as its
    dead band; a fit may leave more or less.
    """
    some = (place for kinds in _smooth(context, column) for place in kinds if place.curve.linear == linear)
    rest = context.whitened(bare, column)
    left = (_look(context, bare, column, place, rest)[0] for place in some)
    return max(min(left, default=np.inf) - context.count(column), 0.0)


def _look(context: Context, bare: Hypothesis, column: int, place: Place, rest: Array) -> tuple[float, float]:
    """What a curve would leave of a column's ``rest`` by a linear look, and how many values it is worth."""
    values = _begun(context, bare, column, place)
    design = _design(context, bare, column, place, values)
    if values.any():
        rest = context.whitened(with_curve(bare, place, column, values), column)
    moved, bends = smoothed(design, rest + design @ values, place.curve.bend())
    off = rest - design @ (moved - values)
    return float(off @ off), bends


def redrawn(context: Context, hypothesis: Hypothesis, column: int) -> Hypothesis:
    """The hypothesis with its curves on a column drawn anew, over what they were drawn over before."""
    for term in drawn_on(context, hypothesis, column):
        bare = hypothesis.without(term.effect, column)
        hypothesis = _alternate(context, bare, column, _place(term, column), SHORTER).fit.hypothesis
    return hypothesis


def followed(now: Fit, columns: Iterable[int]) -> Fit:
    """With the curves on some columns drawn anew, where that leaves less: they can do what stood beside
    them.
    """
    for column in now.hypothesis.curved.intersection(columns, now.cost):
        trial = costed_on(now, redrawn(now.context, now.hypothesis, column), column)
        if trial.cost[column] < now.cost[column]:
            now = trial
    return now


def drawn_on(context: Context, hypothesis: Hypothesis, column: int) -> list[Term]:
    """The curves on a column that the model does not have already."""
    curves = [term for term in hypothesis.on(column) if issubclass(effect(term.effect), Curve)]
    return [term for term in curves if term.effect not in context.known]


def _place(term: Term, column: int) -> Place:
    own = term.own[column]
    moments = tuple(own[p.name] for p in MOMENTS if p.name in own)
    return Place(term.effect, term.words[column][ON], own[LOW], own[HIGH], moments)


def places(context: Context, bare: Hypothesis, column: int) -> list[list[Place]]:
    """The curves that may be drawn in a stage, those of one kind together."""
    timed = context.stage.name == "wire" and "time" in variables(context, column)
    return [*_smooth(context, column), *(_in_time(context, bare, column) if timed else [])]


def _smooth(context: Context, column: int) -> list[list[Place]]:
    """Those over what is measured."""
    over = variables(context, column)
    moving = [v for v in over if v.removeprefix(SPEED_OF) not in context.joints]
    own = [] if column in context.wide else moving
    stage = [kind for kind in registry().values() if kind.stage == context.stage.name]
    tried = [(kind, kind.over(over, own)) for kind in stage if issubclass(kind, Curve)]
    tried.sort(key=lambda one: (not one[0].linear, -len(one[1])))
    return [[Place(kind.id, v, *ends(context, column, v)) for v in some] for kind, some in tried if some]


def _in_time(context: Context, bare: Hypothesis, column: int) -> Iterator[list[Place]]:
    """A curve over the time within the period that stands out of a column's rest, and one of its jumps."""
    index = context.telling(column)[0]
    span, noise = context.views[index].span, context.noise[column]
    valid = span.valid[:, column]
    stamp, rest = span.stamp[valid], context.residual(index, bare, column)[valid]
    frequency, share = spectrum(stamp, rest)
    if share > PART:
        near = frequency + PART * np.arange(-2.0, 3.0) / (stamp[-1] - stamp[0])
        periods = [Place(UnknownCycle.id, "time", 0.0, 1.0 / f) for f in near if f > 0.0]
        yield periods
        whole = context.whitened(bare, column)
        likeliest = min(periods, key=lambda place: _look(context, bare, column, place, whole)[0])
        yield [replace(likeliest, kind=UnknownWaves.id)]
    worth = SIGNIFICANT * (1.0 + noise.remembers) / (1.0 - noise.remembers)
    moments = jumps(stamp, rest / noise.std, worth, MOST_JUMPS + 1)
    angles = span.measured(context.views[index].angles)[valid]
    # a single jump has a name, and many imitate anything
    if 1 < len(moments) <= MOST_JUMPS and not moved_by(stamp, rest, moments, angles, column):
        for jump in (UnknownJumps, UnknownSlips):
            yield [Place(jump.id, "time", float(stamp[0]), float(stamp[-1]), tuple(moments.tolist()))]


def _best(context: Context, bare: Hypothesis, column: int, some: list[Place]) -> Drawn:
    """The curve of one kind over what a linear look finds best, fitted."""
    rest = context.whitened(bare, column)

    def left(place: Place) -> float:
        left, bends = _look(context, bare, column, place, rest)
        return left + bends * float(np.log(context.count(column)))

    return _alternate(context, bare, column, min(some, key=left) if len(some) > 1 else some[0])


def _alternate(
    context: Context, bare: Hypothesis, column: int, place: Place, shares: Sequence[float] = (1.0,)
) -> Drawn:
    """Curve and named values in turn, as long as that helps; ``shares`` of a step, where the first may go too
    far: a curve that is not linear.
    """
    shares = shares[:1] if place.curve.linear else shares
    values, bends = _begun(context, bare, column, place), 0.0
    done = fit(context, with_curve(bare, place, column, values), [column])
    for _ in range(TURNS):
        design = _design(context, done.hypothesis, column, place, values)
        rest = context.whitened(done.hypothesis, column)
        moved, freedom = smoothed(design, rest + design @ values, place.curve.bend())
        for share in shares:
            there = values + share * (moved - values)
            trial = fit(context, with_curve(done.hypothesis, place, column, there), [column])
            if trial.cost[column] <= done.cost[column]:
                break
        else:
            break
        done, values, bends = trial, there, freedom
    return Drawn(done, done.cost[column] + bends * float(np.log(context.count(column))))


def _begun(context: Context, bare: Hypothesis, column: int, place: Place) -> Array:
    """(knots,) where a curve begins: at nothing, or at the best constant; ahead of the core at what behind it
    would explain most, where that is better than nothing.
    """
    nothing = np.zeros(KNOTS)

    def best(tried: Sequence[Array]) -> Array:
        trials = [(with_curve(bare, place, column, values), column) for values in tried]
        left = [float(np.sum(rest**2)) for rest in context.whitened_each(trials)]
        return tried[int(np.argmin(left))]

    if place.curve.hides:
        constant = best([*np.multiply.outer(ZONES, np.ones(KNOTS))])
        return best([*np.multiply.outer(NEAR, constant)])
    if place.curve.ahead:
        behind, _ = smoothed(
            design_of(context, column, place), context.whitened(bare, column), place.curve.bend()
        )
        return best([nothing, behind])
    return nothing


def _design(context: Context, now: Hypothesis, column: int, place: Place, values: Array) -> Array:
    """(rows, knots) change of the whitened prediction per curve value."""
    if place.curve.linear:
        return design_of(context, column, place)

    there = [values, *(values + BUMP * np.eye(KNOTS))]
    pairs = [(with_curve(now, place, column, at), column) for at in there]
    base, *steps = context.predictions_each(pairs)
    changes = [[(p - b) / BUMP for p, b in zip(step, base, strict=True)] for step in steps]
    return np.column_stack([context.whiten_change(change, column) for change in changes])


def with_curve(bare: Hypothesis, place: Place, column: int, values: Array) -> Hypothesis:
    """The hypothesis with a curve on a column."""
    out, kind = bare.copy(), place.kind
    term = out.setdefault(kind, Term(kind, given=frozenset(p.name for p in effect(kind).parameters)))
    own = dict(zip((p.name for p in VALUES), np.clip(values, *VALUES[0].bounds).tolist(), strict=True))
    moments = {p.name: at for p, at in zip(MOMENTS, place.moments, strict=False)}
    term.own[column] = {LOW: place.low, HIGH: place.high, **own, **moments}
    term.words[column] = {ON: place.variable}
    return out


def variables(context: Context, column: int) -> list[str]:
    """What a curve may be drawn over: words of the effect ``unknown``."""
    others = [joint for k, joint in enumerate(context.joints) if k != column]
    load = ["load"] if context.stage.has_load else []
    hidden = column in context.wide
    told = context.step < SLOW and not hidden
    speeds = ["speed", *(SPEED_OF + joint for joint in others)] if told else []
    time = ["time"] if context.timed(column) and not hidden else []
    return ["position", *speeds, *time, *load, *others]


def ends(context: Context, column: int, variable: str) -> tuple[float, float]:
    """Range of a variable over all spans."""
    parts = [abscissa(variable, context.now(i, column), 0) for i in range(len(context.views))]
    low, high = min(float(p.min()) for p in parts), max(float(p.max()) for p in parts)
    return low, max(high, low + max(1e-6, 1e-6 * abs(low)))


def design_of(context: Context, column: int, place: Place) -> Array:
    """(rows, knots) change of the whitened prediction per value of a curve that is added to the angle."""
    parts = []
    for i, view in enumerate(context.views):
        now = context.now(i, column)
        x = view.span.measured(abscissa(place.variable, now, 0))
        factor = np.broadcast_to(place.curve.factor(now), (len(now.stamp), 1))
        parts.append(place.basis(x) * view.span.measured(factor))
    return np.column_stack([context.whiten_change([p[:, k] for p in parts], column) for k in range(KNOTS)])
