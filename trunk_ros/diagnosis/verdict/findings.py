"""Hypotheses in the words of ``diagnosis.json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from trunk_ros.data.noise import is_none
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.evidence.cross_validation import Error
from trunk_ros.diagnosis.evidence.determined import Determined
from trunk_ros.diagnosis.evidence.evidence import UNNAMED, Evidence
from trunk_ros.diagnosis.evidence.residual_dependence import depends_on, rests
from trunk_ros.diagnosis.evidence.spreads import Spreads
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.formed import but_for_a_zero
from trunk_ros.diagnosis.stages.stage import Stage
from trunk_ros.diagnosis.verdict import bank_words, curve_words
from trunk_ros.diagnosis.verdict.answer import Unexplained
from trunk_ros.diagnosis.verdict.finding import UNKNOWN, Finding, evidence_of
from trunk_ros.effects import Effect, effect
from trunk_ros.effects.bank import Bank
from trunk_ros.effects.curve import Curve, words_of
from trunk_ros.guards import TINY
from trunk_ros.levels import HALF, MOST, ROUGH, SLIGHT, SURE
from trunk_ros.parameter import Parameter, leading
from trunk_ros.units import as_read, is_open, unit_on
from trunk_ros.words import listed, significant

VARIES_WITH: dict[str, list[str]] = {
    "always": [],
    "posture": ["position"],
    "reversal": ["direction"],
    "hold": ["time"],
    "low_speed": ["speed"],
    "high_speed": ["speed"],
    "time": ["time"],
}
ARM = "arm"
NO_CURVE = "No effect and no curve explains it."


def findings(
    context: Context, hypothesis: Hypothesis, found: dict[str, Evidence], std: Spreads, told: Determined
) -> list[Finding]:
    """One finding per effect, with all its joints."""
    out = []
    for name in hypothesis:
        whole = not issubclass(effect(name), Curve)
        for term in [hypothesis[name]] if whole else curve_words.by_variable(context, hypothesis[name]):
            out.append(_finding(context, term, found[name], std, told.of(name)))
    return sorted(out, key=lambda f: -f.evidence["strength"])


def _finding(context: Context, term: Term, found: Evidence, std: Spreads, told: Determined) -> Finding:
    kind = effect(term.effect)
    joints = [context.joints[c] for c in _touched(context, kind, term)]
    where, parameters = ", ".join(joints) if joints else "the arm", {}
    untold = [option for option in found.untold if option not in term.shared]
    if issubclass(kind, Curve):
        variable = curve_words.variable_of(term, term.columns[0])
        varies, regime = [*kind.also, *words_of(variable)], curve_words.regime_of(kind, variable)
        statement = curve_words.statement(context, kind, term, where)
        curve = curve_words.told(context, kind, term)
    elif issubclass(kind, Bank):
        parameters = bank_words.parameters(context, kind, term) if kind.named else {}
        varies, regime = bank_words.varies_with(term), kind.regime
        statement, curve = bank_words.statement(kind, term, where), bank_words.told(context, kind, term)
    else:
        parameters = _parameters(context, kind, term, std)
        varies, regime = _varies_with(kind, term), kind.regime
        statement, curve = statement_of(kind.title(term.form), where, parameters), {}
        statement = " ".join([statement, *(kind.parameter(one).untold for one in untold)])
    return Finding(
        effect=term.effect if kind.named else UNKNOWN,
        stage=kind.stage,
        joints=joints,
        regime=regime,
        confidence=round(
            min(found.confidence, settled(kind, term, std), believable(kind, term, context.joints, told)), 3
        ),
        equivalents=found.equivalents,
        parameters=parameters,
        depends_on=varies,
        statement=statement,
        evidence=evidence_of(
            found.strength,
            kind.signature,
            gain={context.joints[c]: g for c, g in found.gain.items()},
            rivals=found.rivals,
            form=term.form,
            untold=untold,
            **asdict(told),
        ),
        curve=curve,
    )


def _touched(context: Context, kind: type[Effect], term: Term) -> list[int]:
    """The joints of a term; what all joints share by nature is also on those that said nothing."""
    shared = kind.everywhere and all(p.shared for p in kind.own_parameters(term.form))
    whole = shared and set(term.columns) >= set(context.columns)
    return list(range(len(context.joints))) if whole else term.columns


def settled(kind: type[Effect], term: Term, std: Spreads) -> float:
    """1 where one of the effect's sizes, or that of one of a bank's shapes, is well above its spread on its
    surest joint, less where it is not. Beside what the arm's description states a size is as uncertain as
    that is, and it is enough that it is above its spread.
    """
    own = kind.own_parameters(term.form)
    sizes = [
        abs(values[lead.name] - (lead.absent if lead.scale == "linear" else 0.0))  # endless is no surer
        / max(std.get((term.effect, lead.name, c), 0.0), TINY)
        for lead in own
        if issubclass(kind, Bank) or lead is leading(own) or lead.name in kind.sizes
        for c, values in term.own.items()
        if lead.name in values and lead.name not in term.given
    ]
    stated = any(p.stated and p.name in term.given for p in kind.parameters)
    return 1.0 if not sizes or max(sizes) > (1.0 if stated else SURE) else 0.5


def believable(kind: type[Effect], term: Term, joints: Sequence[str], told: Determined) -> float:
    """1, or no more than of what has no name where the effect's size would go beyond its bounds wherever it
    is: what is there is not this alone, however much of it follows.
    """
    lead = kind.own_parameters(term.form)[0].name
    where = {ARM} if lead in term.shared else {joints[c] for c in term.columns}
    beyond = {bound.place.joint for bound in told.at_bound if bound.place.parameter == lead}
    return UNNAMED if where <= beyond else 1.0


def _varies_with(kind: type[Effect], term: Term) -> list[str]:
    sources = sorted({w for words in term.words.values() for w in words.values() if w})
    load = ["load"] if kind.bears(term.form) else []
    return sources or load or list(VARIES_WITH[kind.regime])


def _parameters(
    context: Context, kind: type[Effect], term: Term, std: Spreads
) -> dict[str, dict[str, dict[str, Any]]]:
    """By joint, but for what is as uncertain as it is large: a load past all others at which a wire bends."""
    out: dict[str, dict[str, dict[str, Any]]] = {}
    for p in kind.used(term.form):
        if p.name in term.shared:
            out.setdefault(ARM, {})[p.name] = value_of(
                term.shared[p.name], std.get((term.effect, p.name, None)), _shared_unit(context, p, term)
            )
        for c in term.columns:
            if p.name in term.own[c]:
                unit = unit_on(p, context.stage.unit(c))
                value, spread = term.own[c][p.name], std.get((term.effect, p.name, c))
                if spread is None or p.scale == "linear" or spread < value:  # else it is out of reach
                    out.setdefault(context.joints[c], {})[p.name] = value_of(value, spread, unit)
    for c, words in term.words.items():
        for text, word in words.items():
            out.setdefault(context.joints[c], {})[text] = {"value": word, "std": None, "unit": ""}
    return out


def _shared_unit(context: Context, parameter: Parameter, term: Term) -> str:
    """The unit of what all joints share: theirs, where they have one."""
    units = {context.stage.unit(c) for c in term.columns}
    return unit_on(parameter, units.pop()) if len(units) == 1 else parameter.unit


def value_of(value: float, std: float | None, unit: str) -> dict[str, Any]:
    """A parameter as diagnosis.json has it; ``std`` null where the data do not tell it."""
    return {"value": value, "std": std if std is not None and np.isfinite(std) else None, "unit": unit}


def statement_of(what: str, where: str, parameters: dict[str, dict[str, dict[str, Any]]]) -> str:
    """A finding in a sentence: where, what, how much."""
    values = [f"{owner} {_said(name, v)}" for owner, named in parameters.items() for name, v in named.items()]
    return f"{where}: {what[0].lower()}{what[1:]}" + (f" ({'; '.join(values)})." if values else ".")


def _said(name: str, value: dict[str, Any]) -> str:
    return f"{name}{' ' if isinstance(value['value'], str) or is_open(value) else ' = '}{as_read(value)}"


def left_over(
    context: Context, hypothesis: Hypothesis, errors: Mapping[int, Error] | None = None
) -> list[Unexplained]:
    """What is left after all findings, if it is more than the noise, also of blocks that the fit has not seen
    (``errors``), joints that vary with the same thing together; as a share of what is no constant.
    """
    found: dict[tuple[str, ...], list[tuple[str, float, float]]] = {}
    beside: dict[tuple[str, ...], str] = {}
    for column, power in rests(context, hypothesis, errors).items():
        if power < 1.0:
            continue
        varies = depends_on(context, hypothesis, column)
        nominal = context.whitened(context.known, column)
        before = float(np.mean(but_for_a_zero(context, column, nominal) ** 2))
        if before < HALF * float(np.mean(nominal**2)):
            rest = context.whitened(hypothesis, column)
            lasting = float(np.mean(rest**2) - np.mean(but_for_a_zero(context, column, rest) ** 2))
            told = lasting < SLIGHT * (float(np.mean(nominal**2)) - before)
            beside[tuple(varies)] = " beside a constant" + (", which is explained" if told else "")
        share = float(np.clip(power / max(before - 1.0, power), 0.0, 1.0))
        size = float("nan") if is_none(context.noise[column].std) else float(np.sqrt(power))
        found.setdefault(tuple(varies), []).append((context.joints[column], share, size))
    stage = context.stage
    return [
        _unexplained(stage.name, list(varies), each, stage.whole + beside.get(varies, ""))
        for varies, each in found.items()
    ]


def _unexplained(
    stage: str, varies: list[str], each: list[tuple[str, float, float]], whole: str = Stage.whole
) -> Unexplained:
    """What is left on joints, with its share of the ``whole``, and its size over the noise, NaN where there
    is none.
    """
    joints, shares, sizes = (list(column) for column in zip(*each, strict=True))
    regime = curve_words.REGIME_OF.get(varies[0], "posture") if varies else "always"
    on = f" and depends on {' and '.join(varies)}" if varies else ""
    known = [size for size in sizes if size == size]
    times = f" {significant(max(known), 2)} times the noise," if known else ""
    part = f"{max(shares):.1%}" if max(shares) >= ROUGH else f"less than {ROUGH:.1%}"
    size = f"{part} of {whole},{times}"
    statement = f"{', '.join(joints)} ({stage}): {size} stays unexplained{on}."
    return Unexplained(stage, joints, regime, max(shares), varies, statement)


def unchanged(found: dict[str, Any], believed: float) -> bool:
    """Whether a value is the one that the model has, within its spread."""
    near = max(SURE * (found["std"] or 0.0), SLIGHT * abs(believed))
    return bool(abs(found["value"] - believed) <= near)


def without_a_name(rests: list[Unexplained], known: list[Finding]) -> list[Finding]:
    """Rests that are most of the misfit are a finding, even where no curve could stand in for them; they
    add to what is ``known`` of the same stage to have no name.
    """
    rests = [rest for rest in rests if rest.share > MOST]
    if not rests:
        return known
    joints = sorted({joint for rest in rests for joint in rest.joints})
    varies = list(dict.fromkeys(on for rest in rests for on in rest.depends_on))
    share = max(rest.share for rest in rests)
    statement = (
        f"{', '.join(joints)}: {share:.0%} of the residual fits no effect of the library and no smooth curve"
    )
    statement += f"; it depends on {listed(varies)}." if varies else "."
    for number, finding in enumerate(known):
        if not finding.named:
            both = sorted({*finding.joints, *joints})
            on = list(dict.fromkeys([*finding.depends_on, *varies]))
            said = f"{finding.statement} {statement}"
            joined = replace(finding, joints=both, depends_on=on, statement=said)
            return [*known[:number], joined, *known[number + 1 :]]
    stage, regime, evidence = rests[0].stage, rests[0].regime, evidence_of(signature=NO_CURVE)
    told = Finding(UNKNOWN, stage, joints, regime, UNNAMED, [], {}, varies, statement, evidence)
    return [*known, told]
