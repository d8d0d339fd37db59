"""How sure a finding is: what it gains, and the rivals that explain the data as well."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from trunk_ros.diagnosis.evidence.cross_validation import Error
from trunk_ros.diagnosis.evidence.rivals import FAR, Looks, by_its_own_angles, loss, rivals
from trunk_ros.diagnosis.evidence.sets import pairs
from trunk_ros.diagnosis.evidence.unseen import unrepeated
from trunk_ros.diagnosis.evidence.without_options import untold
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.resources.cores import each
from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.score import need, needed, prices
from trunk_ros.effects import effect
from trunk_ros.effects.bank import Bank
from trunk_ros.effects.curve import Curve

EQUIVALENTS = 5  # that are said
SUREST = 0.95  # on cases made to build with, so many of the surest were right
UNNAMED = 0.7  # confidence in what no formula states, at most
TIED = 0.9  # confidence in names that do alike: of 262 on the proof's plants 0.91 were right


@dataclass
class Evidence:
    """What speaks for one effect."""

    gain: dict[int, float]
    """Squared unit-noise residual that it removes, by column."""
    asked: float
    """What that has to come to, on all columns together, for a name to be said."""
    strength: float
    """Root mean square of the effect over the sensor noise, over its joints."""
    rivals: dict[str, float] = field(default_factory=dict)
    """Loss if another effect stood in its place, refitted to the same data (``rivals.loss``)."""
    fitted: dict[str, Hypothesis] = field(default_factory=dict)
    """The hypothesis with each rival in its place."""
    equivalents: list[str | list[str]] = field(default_factory=list)
    untold: list[str] = field(default_factory=list)
    """Options that it is without, though the data are explained as well with them."""
    confidence: float = 0.0

    @property
    def gain_share(self) -> float:
        """What it gains over what is asked for, or over what a rival gains beyond it if that is more: then it
        is bent to what neither is; 1 where it was not judged.
        """
        asked = max(self.asked, *(-lost for lost in self.rivals.values()), 0.0)
        return sum(self.gain.values()) / asked if self.asked > 0.0 else 1.0


def evidence(
    state: Fit,
    whole: Fit | None = None,
    work: Work | None = None,
    before: Mapping[str, Evidence] | None = None,
) -> dict[str, Evidence]:
    """Evidence for each effect of a hypothesis; ``whole``: a fit of the same to more, for effects of which
    ``state`` shows nothing. ``work``: where what is simulated for it is counted. ``before``: what is known of
    some of them.
    """
    known, work = before or {}, work or Work()
    names = [name for name in state.hypothesis if name not in known]
    own, more = state.working(work), (whole or state).working(work)
    told = each(work, lambda name: one_evidence(_showing(own, more, name), name), names)
    new = dict(zip(names, told, strict=True))
    return {name: new[name] if name in new else known[name] for name in state.hypothesis}


def banks_evidence(state: Fit, found: Mapping[str, Evidence]) -> dict[str, Evidence]:
    """Evidence for the banks of a hypothesis, and for curves on joints where what was ``found`` had none:
    they have no rivals, and not more confidence than what has no name.
    """
    out = {}
    for name, term in state.hypothesis.items():
        judged = [c for c in term.columns if c in state.cost]
        told = name in found and found[name].gain.keys() >= set(judged)
        if told or not issubclass(effect(name), (Bank, Curve)):
            continue
        less = {c: state.context.whitened(state.hypothesis.without(name), c) for c in judged}
        gain = {c: float(less[c] @ less[c]) - state.cost[c] for c in judged}
        limit = doubt(state, gain)
        sure = min(likely(limit or 1.0, sum(gain.values()), []), UNNAMED)
        out[name] = Evidence(gain, needed(state, gain), strength(state, name), confidence=sure)
    return out


def doubt(state: Fit, columns: Iterable[int]) -> float:
    """What a name on some columns has to gain, and others in its place to lose: more than chance and formulas
    make, and as much as is left there, since whatever that is may stand behind the name as well.
    """
    return sum(max(need(state.context, c, state.rest(c)), state.rest(c)) for c in columns)


def as_unseen(state: Fit, found: Mapping[str, Evidence], errors: Mapping[int, Error]) -> dict[str, Evidence]:
    """Evidence for names, no surer than they are beside what is left of blocks that the fit has not seen: it
    may stand behind them as well.
    """
    left = {
        c: max(e.after**2 - e.noise_floor**2, 0.0) / state.context.noise[c].std ** 2 * state.context.count(c)
        for c, e in errors.items()
    }
    out = dict(found)
    for name, told in found.items():
        rest = sum(left.get(c, 0.0) for c in told.gain)
        if effect(name).named and rest > doubt(state, told.gain):
            sure = likely(rest, sum(told.gain.values()), [])
            out[name] = replace(told, confidence=min(told.confidence, sure))
    return out


def _showing(state: Fit, whole: Fit, name: str) -> Fit:
    judged = set(state.hypothesis[name].columns) & state.cost.keys()
    return state if judged and strength(state, name) > 0.0 else whole


def one_evidence(state: Fit, name: str) -> Evidence:
    """Evidence for one of them."""
    context = state.context
    bare = refit(context, state.hypothesis.without(name))
    columns = state.hypothesis[name].columns
    gain = {c: bare.cost[c] - state.cost[c] for c in columns if c in bare.cost}
    limit = doubt(state, gain)
    out = Evidence(gain, needed(state, gain), strength(state, name))
    losses: list[float] = []
    if effect(name).named:
        doubted = replace(beside_the_same(state, name) or bare, context=replace(context, doubts=True))
        looks = Looks.of(doubted, context.judged(state.hypothesis[name]))
        fits = rivals(state, name, doubted, looks, limit or 1.0)
        out.rivals = {rival: lost for rival, (lost, _) in fits.items()}
        out.fitted = {rival: fitted for rival, (_, fitted) in fits.items()}
        ahead = {rival: out.fitted[rival] for rival, lost in out.rivals.items() if lost < 0.0}
        for rival in unrepeated(state, ahead):
            out.rivals[rival] = 0.0  # ahead by what other recordings do not repeat: no better
        for rival in [rival for rival, lost in out.rivals.items() if lost < limit]:
            own = by_its_own_angles(state, out.fitted[rival])
            if own is not None:
                out.rivals[rival], out.fitted[rival] = loss(state, own, columns), own.hypothesis
        near = [rival for rival, lost in out.rivals.items() if lost < limit]
        own_price = prices(context, state.hypothesis)
        more = {r: max(prices(context, out.fitted[r]) - own_price, 0.0) for r in near}
        alone = sorted(near, key=lambda rival: (out.rivals[rival] + more[rival], rival))
        losses += out.rivals.values()
        both = pairs(state, name, doubted, looks, out.asked, {name, *near, *state.hypothesis})
        said: list[str | list[str]] = [
            list(pair) for pair in sorted(both, key=lambda pair: (both[pair], pair))
        ]
        out.equivalents = [*alone, *said][:EQUIVALENTS]
        losses += [lost + out.asked for lost in both.values()]  # a second effect has its price
        out.untold = untold(state, name, limit)
    out.confidence = likely(limit or 1.0, sum(gain.values()), losses)
    return out


def beside_the_same(state: Fit, name: str) -> Fit | None:
    """Without an effect, what each joint has by itself fitted anew beside what joints share as it is: that
    would bend to stand for the effect, on joints where a rival is to do so. None where they share nothing.
    """
    less = state.hypothesis.without(name)
    if not any(set(term.shared) - term.given for term in less.values()):
        return None
    held = {n: replace(term, given=term.given | set(term.shared)) for n, term in less.items()}
    found = refit(state.context, Hypothesis(held))
    free = {n: replace(term, given=less[n].given) for n, term in found.hypothesis.items()}
    return replace(found, hypothesis=Hypothesis(free))


def strength(state: Fit, name: str) -> float:
    """Root mean square of what an effect does on its joints, over the noise."""
    less = replace(state, hypothesis=state.hypothesis.without(name))
    return apart(state, less, state.hypothesis[name].columns)


def apart(one: Fit, other: Fit, columns: Iterable[int]) -> float:
    """Root mean square of what two fits say of some joints differently, over the noise of the first."""
    power = []
    for c in columns:
        pair = (fit.context.predictions(fit.hypothesis, c) for fit in (one, other))
        off = np.concatenate([a - b for a, b in zip(*pair, strict=True)])
        power.append(np.mean(off**2) / one.context.noise[c].std ** 2)
    return float(np.sqrt(np.mean(power))) if power else 0.0


def likely(limit: float, gain: float, losses: list[float], tied: float = TIED) -> float:
    """Probability that a name or one of its equivalents is right, from its gain and its rivals' losses, both
    against the ``limit`` that an effect must gain: ``tied`` where the best rival does as well, less where it
    does better.
    """
    margin = min(losses, default=FAR * limit) / limit
    surplus = gain / limit
    sure = 1.0 - np.exp(-0.5 * max(surplus, 0.0) - 0.3)
    ahead = 1.0 / (1.0 + (1.0 / tied - 1.0) * np.exp(-4.0 * margin))
    return float(np.clip(sure * ahead, 0.02, SUREST))
