"""What the model has stays as it is where the recording does not tell another value: a fit moves every value,
and of one that the motion hardly shows it makes whatever the noise asks for.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import reduce

from trunk_ros.compiled import Array
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.curves import followed
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.credible import unshown
from trunk_ros.diagnosis.search.fit import Fit, change, refit
from trunk_ros.diagnosis.search.formed import behind
from trunk_ros.diagnosis.search.moves.swap_all import alike
from trunk_ros.diagnosis.search.score import naming, needed, price_of_change
from trunk_ros.effects import effect
from trunk_ros.effects.bank import Bank
from trunk_ros.guards import ROUNDED
from trunk_ros.levels import NEARLY
from trunk_ros.parameter import Parameter


def as_given(state: Fit) -> Fit:
    """With the values of the model, of each effect that it has, but for those by which the recording is so
    much better explained as effects have to: the fewest that do. Nothing that was found becomes incredible
    beside them.
    """
    for name in state.context.known:
        if not effect(name).named or issubclass(effect(name), Bank):
            continue
        less = _no_fuller(state, name)
        less = _as_given(less, name) if name in less.hypothesis else _there_again(less, name)
        if unshown(less.context, less.hypothesis) <= unshown(state.context, state.hypothesis):
            state = less
    return unrounded(state)


def unrounded(state: Fit) -> Fit:
    """Without what may come of how the model's loops are described, or integrated."""
    while (less := _unrounded(state)) is not None:
        state = refit(state.context, less)
    return state


def _unrounded(state: Fit) -> Hypothesis | None:
    """Without what makes a servo's loop lag more than it is described by no more than a drive may whose own
    steps are finer than the model's: all of it together, or the least of an effect on all its joints, or on
    one; then without what has no name and hardly counts beside what that leaves.
    """
    context, found = state.context, state.hypothesis
    if context.stage.name != "servo":
        return None
    later = {c: behind(context, c) for c in context.columns}
    changes = {n: _changes(context, found, [n]) for n in sorted(found.keys() - context.known.keys())}
    lags = [n for n, each in changes.items() if _is_lag(each, later)]
    share = {(n, c): _share({c: d}, later) for n in lags for c, d in changes[n].items()}
    ways: dict[tuple[str, int | None], float] = {
        (n, None): max(share[n, c] for c in changes[n]) for n in lags
    }
    ways |= {(n, c): s for (n, c), s in share.items() if len(found[n].own) > 1 and found[n].own.get(c)}
    if lags and _share(_changes(context, found, lags), later) < 1.0:
        return found.less(lags)
    least = min(ways, key=lambda way: (ways[way] >= 1.0, way[1] is not None, ways[way]), default=None)
    if least is not None and ways[least] < 1.0:
        return found.without(*least)
    curves = ((n, c) for n, each in changes.items() if not effect(n).named for c in each if c in found[n].own)
    small = (one for one in curves if _size(changes[one[0]][one[1]]) < needed(state, one[1:]))
    return next((found.without(*one) for one in small), None)


def _size(change: Array) -> float:
    return float(change @ change)


def _share(changes: dict[int, Array], later: dict[int, Array]) -> float:
    """How far changes of columns are from half of what a loop may be later that goes on all the time, over
    that, on the joint with most.
    """
    return max(_size(d - later[c] / 2.0) / max(_size(later[c]), ROUNDED) for c, d in changes.items())


def _is_lag(changes: dict[int, Array], later: dict[int, Array]) -> bool:
    """Whether changes of columns are nearly all along how far their loops lag."""
    along = sum(float(d @ later[c]) ** 2 / max(_size(later[c]), ROUNDED) for c, d in changes.items())
    return bool(along > NEARLY * sum(float(d @ d) for d in changes.values()) > 0.0)


def _changes(context: Context, found: Hypothesis, names: Iterable[str]) -> dict[int, Array]:
    """What is predicted otherwise without some effects, by column (rows,), whitened."""
    less = found.less(names)
    return {c: change(context, found, less, c) for c in context.columns}


def _no_fuller(state: Fit, name: str) -> Fit:
    """With an effect in the place of a fuller law on joints where that explains hardly more: one that bends
    at a load which the joint never bears.
    """
    known = state.context.known[name]
    fuller = [t for t in state.hypothesis.values() if name in effect(t.effect).replaces]
    both = known.own.keys() & state.cost
    for law, column in [(t.effect, c) for t in fuller for c in t.columns if c in both]:
        less = state.hypothesis.without(law, column)
        less.have(column, _beside(known, less))
        trial = _held(replace(state, hypothesis=less), less[name], effect(name).used(known.form))
        if trial.total < state.total + needed(state, [column]):
            state = trial
    return state


def _there_again(state: Fit, name: str) -> Fit:
    """With an effect that was left out, where the recording does not tell that it is gone: that is a claim as
    well. On joints that have what includes it, that says something else of it.
    """
    known, kind = state.context.known[name], effect(name)
    terms = state.hypothesis.values()
    others = {c for t in terms if alike(kind, effect(t.effect)) for c in t.own}
    known = replace(
        _beside(known, state.hypothesis),
        own={c: own for c, own in known.own.items() if c not in others},
        words={c: said for c, said in known.words.items() if c not in others},
    )
    if not known.own:
        return state
    trial = _held(state, known)
    gone = naming(kind.stage) + needed(state, state.context.judged(known))
    return trial if trial.total < state.total + gone else state


def _beside(known: Term, others: Hypothesis) -> Term:
    """An effect of the model without masses that another one carries by now."""
    carried = {name for term in others.values() for name in term.carried}
    return replace(known, shared={n: v for n, v in known.shared.items() if n not in carried})


def _as_given(state: Fit, name: str) -> Fit:
    known, now, kind = state.context.known[name], state.hypothesis[name], effect(name)
    if known == now:
        return state
    trials = [_held(state, known)]
    if known.form == now.form or kind.apart not in (known.form, now.form):
        trials += _ways(state, name)
    return min([state, *trials], key=lambda fit: fit.total + price_of_change(fit, name))


def _ways(state: Fit, name: str) -> Iterator[Fit]:
    """With what joints share as the model has it, with what each has, and with one joint after the other."""
    known, now, used = state.context.known[name], state.hypothesis[name], effect(name).used
    yield _held(state, back(now, known, None), [p for p in used(now.form) if p.shared])
    each = reduce(lambda term, column: back(term, known, column), known.columns, now)
    yield _held(state, each, [p for p in used(now.form) if not p.shared])
    for column in known.columns:
        trial = _held(state, back(state.hypothesis[name], known, column))
        if trial.total + price_of_change(trial, name) < state.total + price_of_change(state, name):
            state = trial
    there = replace(state.hypothesis[name], given=now.given)
    yield replace(state, hypothesis=Hypothesis({**state.hypothesis, name: there}))


def back(now: Term, known: Term, column: int | None) -> Term:
    """A term with the values of the model on a joint, or those that joints share; what a form has besides
    stays, what happens in mid-run is gone.
    """
    out, kind = now.copy(), effect(now.effect)
    moments = {m.name for m in kind.moments()}
    if column is None:
        options = {p.name for p in kind.parameters if p.optional} | moments
        kept = {n: v for n, v in now.shared.items() if n not in options}
        used = {p.name for p in kind.used(now.form) if p.shared}
        out.shared = kept | {n: v for n, v in known.shared.items() if n in used}
    else:
        had = {n: v for n, v in now.own.get(column, {}).items() if n not in moments}
        out.have(column, had | known.own[column])
        out.words.pop(column, None)
        if column in known.words:
            out.words[column] = dict(known.words[column])
    return out


def _held(state: Fit, term: Term, values: Iterable[Parameter] | None = None) -> Fit:
    """All else fitted beside an effect of which some values, or all, stay exactly so, also in what is fitted
    later, and curves drawn anew: they may have stood for it.
    """
    values = effect(term.effect).used(term.form) if values is None else values
    held = replace(term.copy(), given=frozenset(p.name for p in values))
    return followed(refit(state.context, Hypothesis({**state.hypothesis, term.effect: held})), term.columns)
