"""The verdict in one sentence, and what stands directly below it."""

from __future__ import annotations

from trunk_ros.diagnosis.report.errors import ABOVE, Ratio, ratios
from trunk_ros.diagnosis.report.signals import entries, judged
from trunk_ros.diagnosis.report.units import fall, rounded, spoken, times
from trunk_ros.diagnosis.verdict.answer import STAGES, Answer
from trunk_ros.diagnosis.verdict.differences import is_excess
from trunk_ros.diagnosis.verdict.finding import Finding
from trunk_ros.words import listed

FEW = 2  # findings that a sentence can hold
LIKELY = 0.5  # confidence: of more a finding is likely; what is capped at a half for its size is a guess


def headline(result: Answer) -> str:
    """What the busy reader needs to know; more than FEW findings are counted, for the list below to name."""
    if not judged(result) and result.unexplained:
        return f"Nothing can be said before the data are put right: {result.unexplained[0].statement}"
    if not judged(result):
        return "Nothing can be said: no signal moved enough, or was measured enough, to be judged."
    if result.verdict == "no_mismatch":
        return _no_mismatch(result)
    if not result.findings:
        where = listed([_place(result, u.stage, u.joints) for u in result.unexplained])
        return f"The recording departs from the simulation on {where}, and no effect explains it."
    if len(result.findings) > FEW:
        mixed = any(map(is_excess, result.findings))
        what = f"missing in the simulation{', or too much in it' if mixed else ''}"
        return f"{len(result.findings)} effects are {what}{_doubts(result)}."
    missing, much = (listed(_told(result, excess)) for excess in (False, True))
    said = [f"Missing in the simulation: {missing}."] if missing else []
    return " ".join([*said, f"Too much in the simulation: {much}."] if much else said)


def _doubts(result: Answer) -> str:
    """How many of what is counted could be something else, or nothing."""
    open_ = sum(bool(f.equivalents) for f in result.findings)
    guessed = sum(f.confidence <= LIKELY for f in result.findings)
    told = [f"{open_} of them could also be another effect"] if open_ else []
    told += [f"{guessed} of them {'is' if guessed == 1 else 'are'} no more than a guess"] if guessed else []
    return f"; {' and '.join(told)}" if told else ""


def gain(result: Answer) -> str:
    """By how much the findings lower the error on unseen data, in units first, and what is left."""
    rows = ratios(result)
    if not rows or not result.findings:
        return ""
    worst, left = max(rows, key=lambda r: r.before), max(rows, key=lambda r: r.after)
    text = f"Held-out error of the worst signal, {_signal(worst)}: {_fall(result, worst)}."
    if left is not worst and left.after > ABOVE:
        text += f" The largest that remains, {_signal(left)}: {_fall(result, left)}."
    if not result.unexplained:
        return text
    where = listed([_place(result, u.stage, u.joints) for u in result.unexplained])
    return f"{text} Not fully explained on: {where}."


def _signal(row: Ratio) -> str:
    return f"{row.stage} {row.name}"


def _fall(result: Answer, row: Ratio) -> str:
    said = entries(result, row.stage)[row.name]
    unit = str(said.get("unit", "rad"))
    if said["rmse_before"] == said["rmse_after"]:
        return f"{rounded(said['rmse_before'], unit)}, as before ({times(row.before)} times the {row.of})"
    sizes = fall(said["rmse_before"], said["rmse_after"], unit)
    return f"{sizes} ({times(row.before)} → {times(row.after)} times the {row.of})"


def _no_mismatch(result: Answer) -> str:
    """How closely the simulation follows, in a unit."""
    every = [said for stage in STAGES for said in entries(result, stage).values()]
    coarse = [bool(said.get("resolution", 0.0) > said["noise_floor"]) for said in every]
    worst = max(every, key=lambda said: float(said["rmse_before"]))
    left = rounded(worst["rmse_before"], worst.get("unit", "rad"))
    if all(coarse):
        return f"No effect is missing: the residual that remains ({left} rms) is below a step of the encoder."
    grain = "noise and encoder steps" if any(coarse) else "noise"
    return f"No effect is missing: what remains ({left} rms at most) is no more than the sensors' {grain}."


def _told(result: Answer, excess: bool) -> list[str]:
    """What is missing, or too much: the likely ones first, in the order of the table."""
    some = [f for f in result.findings if is_excess(f) == excess]
    ranked = sorted(some, key=lambda f: f.confidence <= LIKELY)
    return [_unnamed(result, f) if not f.named else _named(result, f) for f in ranked]


def _named(result: Answer, finding: Finding) -> str:
    much = "perhaps " if finding.confidence <= LIKELY else ""
    names = [f"({spoken(name)})" if " + " in name else spoken(name) for name in finding.candidates]
    either = "either " if len(names) > 2 else ""  # beside other findings, which are listed with commas too
    place = _place(result, finding.stage, finding.joints)
    return f"{much}{either}{listed(names, 'or')} ({place}, {finding.confidence:.0%})"


def _unnamed(result: Answer, finding: Finding) -> str:
    varies = f", which depends on {listed(finding.depends_on)}" if finding.depends_on else ""
    where = _place(result, finding.stage, finding.joints)
    return f"physics that is not in the effect library ({where}{varies})"


def _place(result: Answer, stage: str, joints: list[str]) -> str:
    """The same, with the stage where it is not the wire."""
    where = place(result, stage, joints)
    return f"servo of {where}" if stage == "servo" and joints else where


def place(result: Answer, stage: str, joints: list[str]) -> str:
    """Joints in words; all of them in two."""
    every = entries(result, stage)
    if not joints:
        return {"arm": "the tip", "servo": "the servo", "wire": "all joints"}.get(stage, stage)
    if stage != "arm" and len(joints) > 2 and set(joints) >= set(every):
        return "all joints"
    return listed(joints)


WORDS = {
    "no_mismatch": "no mismatch",
    "explained": "explained",
    "partly_explained": "partly explained",
    "unexplained": "unexplained",
}


def verdict_word(result: Answer) -> str:
    """The verdict as words, as the other files and the command line have it; or that there is none."""
    return WORDS[result.verdict] if judged(result) or result.unexplained else "nothing judged"
