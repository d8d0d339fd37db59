"""From recordings to a diagnosis: align, search each stage, judge, say."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from trunk_ros.diagnosis.against import SERVO, Simulator, identified, nominal_for
from trunk_ros.diagnosis.context import LEAST, Context, Work
from trunk_ros.diagnosis.data.align import Span, common_joints, servo_span, wire_span
from trunk_ros.diagnosis.data.mix_ups import MixUp, mix_ups, without_mix_ups
from trunk_ros.diagnosis.data.other_simulator import completed, shifted
from trunk_ros.diagnosis.data.quality import quality_of_recording
from trunk_ros.diagnosis.data.sensing import clocks_put_right, readings_put_right
from trunk_ros.diagnosis.data.sensor_faults import without_faults
from trunk_ros.diagnosis.evidence.cross_validation import held_out
from trunk_ros.diagnosis.evidence.determined import determined
from trunk_ros.diagnosis.evidence.evidence import Evidence, evidence, spreads
from trunk_ros.diagnosis.evidence.one_arm import contradiction
from trunk_ros.diagnosis.evidence.residual_dependence import rests as powers
from trunk_ros.diagnosis.evidence.veto import harmless
from trunk_ros.diagnosis.experiment.design import experiment, proposals
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.long import searched
from trunk_ros.diagnosis.search.score import STRONG
from trunk_ros.diagnosis.servo import ServoStage
from trunk_ros.diagnosis.stage import Stage
from trunk_ros.diagnosis.tip.judged import fitted_tip, judged_tip
from trunk_ros.diagnosis.verdict.differences import told_as_differences
from trunk_ros.diagnosis.verdict.findings import (
    findings,
    is_known,
    left_over,
    without_a_name,
)
from trunk_ros.diagnosis.verdict.result import STAGES, Diagnosis, Finding, Plots, Unexplained
from trunk_ros.diagnosis.wire import WireStage
from trunk_ros.effects import effect
from trunk_ros.errors import RecordingError
from trunk_ros.model import Model, Values, load_model
from trunk_ros.recording.read import read_parts, read_recording
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.time_range import time_range
from trunk_ros.recording.topics import TIP_TOPIC

Progress = Callable[[str], None]
WORK = 3e9  # simulated joint-steps of a stage: half a minute of one core, whatever the recording


def diagnose(
    recordings: Recording | str | Path | Sequence[Recording | str | Path],
    model: Model | str | Path | None = None,
    against: Recording | str | Path | None = None,
    from_time: str | None = None,
    until: str | None = None,
    progress: Progress = lambda _: None,
    namespace: str | None = None,
) -> Diagnosis:
    """Compare recordings of one arm with a model, and find what the model leaves out.

    ``recordings``: one or several, each a path or in memory. ``model``: in memory, a file, or a name in
    config/; by default the nominal arm. ``from_time``, ``until``: "12.5" (s) or "70%" of each recording.
    ``progress`` is told each step. ``against``: a simulator's recording of the same motion; what it does
    is found from it first, by default from an ideal transmission, and takes the place of the model.
    ``namespace``: of the arm, where recordings hold several.
    Raises RecordingError or ModelError in one line.
    """
    several = [recordings] if isinstance(recordings, (Recording, str, Path)) else recordings
    read = [part for r in several for part in _read(r, from_time, until, namespace)]
    other = (
        None if against is None else against if isinstance(against, Recording) else read_recording(against)
    )
    read = [completed(r, other) for r in read]
    if model is None:
        nominal = load_model("trunk") if other is None else nominal_for(read[0].joints)
    else:
        nominal = model if isinstance(model, Model) else load_model(model)
    read = [without_faults(readings_put_right(r, nominal)) for r in read]
    mixed = [mix_ups(r, nominal) for r in read]
    read = [without_mix_ups(r, found) for r, found in zip(read, mixed, strict=True)]
    read = [clocks_put_right(r, nominal) for r in read]
    if other is None:
        return Diagnoser(read, nominal, None, progress, mixed).run()
    progress("what the simulation has itself")
    simulator = identified(
        other, read, nominal, lambda r, m: Diagnoser([r], m, None, progress, experiments=False).run()
    )
    result = Diagnoser(read, simulator.model, simulator, progress, mixed).run()
    return told_as_differences(result, simulator.model, simulator.found)


class Diagnoser:
    """One diagnosis in the making."""

    def __init__(
        self,
        recordings: list[Recording],
        model: Model,
        against: Simulator | None,
        progress: Progress,
        mixed: Sequence[list[MixUp]] = (),
        experiments: bool = True,
    ):
        """``mixed``: what is mixed up in each recording, and left out of it."""
        self.recordings, self.against, self.say, self.mixed = recordings, against, progress, mixed
        self.experiments = experiments
        topics = set.intersection(*(set(r.series) for r in recordings))
        servo_alone = "joint_states" not in topics and {"setpoints", "gearbox_states"} <= topics
        tip_alone = "gearbox_states" not in topics and all(r.tip is not None for r in recordings)
        spans = [] if servo_alone or tip_alone else [wire_span(r, model) for r in recordings]
        key = "gearbox_states" if servo_alone else "joint_states"
        seen = [s.joints for s in spans] or [common_joints(r, model, r.require(key)) for r in recordings]
        self.joints = seen[0]
        if any(joints != self.joints for joints in seen):
            raise RecordingError("the recordings have different joints: they are not of one arm")
        self.model = model.for_joints(self.joints)
        self.spans = (
            spans
            if against is None
            else [shifted(s, against.context("wire", r)) for s, r in zip(spans, recordings, strict=True)]
        )
        self.result = Diagnosis({}, [], [], [], self.model, plots=Plots())
        self.effects: dict[str, Values] = {}
        self.lasting: dict[str, float] = {}
        """Joint noise [rad] that lasts from sample to sample."""

    def run(self) -> Diagnosis:
        """All stages."""
        self.result.stages["servo"] = {"compared": False, "joints": {}}  # comes first in what is said
        self.wire()
        self.servo()  # with the payload that the wires show
        self.tip()
        self.result.findings.sort(key=lambda finding: STAGES.index(finding.stage))
        self._say_what_is_mixed_up()
        self._refuse_if_nothing_was_seen()
        longest = max(r.duration for r in self.recordings)
        judged = {s for s, told in self.result.stages.items() if told["compared"]}
        kept = {n: v for n, v in self.model.effects.items() if effect(n).stage not in judged} | self.effects
        self.result.model = replace(self.model, effects=kept, duration=longest)
        self.result.quality = _by_name(self.recordings, self.model, self.mixed)
        return self.result

    def _say_what_is_mixed_up(self) -> None:
        """What was left out for it is not explained."""
        for one in dict.fromkeys(one for found in self.mixed for one in found if one.certain):
            rest = Unexplained(one.stage, list(one.joints), "always", 1.0, [], one.statement)
            self.result.unexplained.insert(0, rest)
            stage = self.result.stages[one.stage]
            stage["silent"] = [joint for joint in stage.get("silent", []) if joint not in one.joints]

    def _refuse_if_nothing_was_seen(self) -> None:
        stages = self.result.stages.values()
        seen = any(stage.get("joints") or stage.get("tip") for stage in stages)
        if not seen and not self.result.unexplained:
            raise RecordingError(
                f"{', '.join(r.name for r in self.recordings)}: no joint moves for {LEAST} samples or more: "
                "record a motion that moves the joints, over a longer time"
            )

    def servo(self) -> None:
        """Setpoint to gearbox, where setpoints were recorded, by another simulator as well."""
        other = self.against
        recorded = [r for r in self.recordings if set(r.series) >= SERVO]
        spans = [servo_span(r, self.model) for r in recorded if other is None or other.has_servo]
        if other is not None and other.has_servo:
            spans = [shifted(s, other.context("servo", r)) for s, r in zip(spans, recorded, strict=True)]
        spans = [s for s in spans if s.joints == self.joints]
        if spans:
            self.say("servo")
            arm = replace(self.model, effects={**self.model.effects, **self.effects}).loaded_arm()
            self._stage(ServoStage(spans, replace(self.model, arm=arm), self.recordings[0].units))

    def wire(self) -> None:
        """Gearbox to joint, where the joints have sensors."""
        if not self.spans:
            self.result.stages["wire"] = {"compared": False, "joints": {}}
            return
        self.say("wire")
        state = self._stage(WireStage(self.spans, self.model, self.recordings[0].units))
        if state is not None:
            noises = zip(self.joints, state.context.noise, strict=True)
            self.lasting = {joint: noise.std for joint, noise in noises if noise.correlation > 0.0}

    def _stage(self, stage: Stage) -> Fit | None:
        context = Context.of(stage, Work(WORK))
        if not context.columns:
            self.result.stages[stage.name] = {
                "compared": False, "joints": {}, "silent": list(stage.joints)
            }  # fmt: skip
            return None
        wrong = contradiction(context, lambda text: self.say(f"{stage.name}: {text}"))
        if wrong is not None:
            raise RecordingError(wrong.statement())
        done = searched(context, lambda text: self.say(f"{stage.name}: {text}"))
        self.say(f"{stage.name}: evidence")
        state = harmless(done.state)
        part = state if done.part is done.state else refit(done.part.context, state.hypothesis)
        found = evidence(part, state)
        std, context = spreads(state), state.context
        errors = held_out(state)
        effects = state.hypothesis.model_effects(len(stage.joints))
        self.effects |= on_the_arm(effects, stage.joints, self.model.arm.joints)
        self.result.stages[stage.name] = {
            "compared": True,
            "joints": {
                stage.joints[c]: {
                    "unit": self.recordings[0].units.get(stage.joints[c], "rad"),
                    "rmse_before": e.before,
                    "rmse_after": e.after,
                    "noise_floor": e.noise_floor,
                    "resolution": float(np.hypot(stage.own_steps(c), stage.resolution(c))),
                    "rmse_before_std": e.before_std,
                    "rmse_after_std": e.after_std,
                }
                for c, e in errors.items()
            },
            "silent": [stage.joints[c] for c in range(len(stage.joints)) if c not in context.columns],
            "search": {"joint_steps": context.work.done, "ended_early": done.early},
        }
        named = findings(context, state.hypothesis, found, std, determined(state))
        new = [f for f in named if not is_known(context, f)]
        rests = left_over(context, state.hypothesis)
        self.result.unexplained += rests
        strong = {stage.joints[c] for c, power in powers(context, state.hypothesis).items() if power > STRONG}
        told = {j for f in new if f.effect == "unknown" for j in f.joints}
        nameless = [rest for rest in rests if (strong - told) & set(rest.joints)]
        self.result.findings += without_a_name(nameless, new)
        self._plot(context, state.hypothesis)
        self._experiment(part, {f.effect: found[f.effect] for f in new if f.equivalents})
        return state

    def _experiment(self, state: Fit, found: dict[str, Evidence]) -> None:
        """The motion that tells what was found from its equivalents."""
        if not self.experiments:
            return
        stage = state.context.stage.name
        self.say(f"{stage}: experiment")
        done, file = experiment(state, found), f"experiment_{stage}.yaml"
        if done is not None:
            told = proposals(done, file, self.recordings[0].units)
            self.result.experiments += told
            if any(entry["trajectory"] for entry in told):
                self.result.trajectories[file] = done.motion

    def _plot(self, context: Context, hypothesis: Hypothesis) -> None:
        assert self.result.plots is not None
        for c in context.columns:
            span: Span = context.views[0].span
            self.result.plots.signals[context.stage.name, context.joints[c]] = {
                "stamp": span.stamp,
                "measured": span.target[:, c],
                "valid": span.valid[:, c],
                "before": context.predict(0, context.known, c),
                "after": context.predict(0, hypothesis, c),
                "gearbox": span.gearbox[span.rows, c],
                "velocity": span.velocity[span.rows, c],
                "noise": context.noise[c].std,
            }

    def tip(self) -> None:
        """Joint to tip."""
        late = float(self.effects.get("sensor_delay", {}).get("delay", 0.0))
        model = replace(self.model, effects={**self.model.effects, **self.effects})
        best = fitted_tip(self.recordings, model, late, self.lasting) if self.against is None else None
        if best is None:
            self.result.stages["arm"] = {"compared": False, "tip": {}}
            return
        self.say("arm")
        self.result.stages["arm"], found, values = judged_tip(*best)
        if strays := self.result.stages["arm"]["strays"]:
            note = f"{TIP_TOPIC}: {strays} poses far from those beside them are left out"
            self.recordings[0] = replace(self.recordings[0], notes=(*self.recordings[0].notes, note))
        self.result.findings += found
        self.effects |= values


def _read(
    recording: Recording | str | Path, from_time: str | None, until: str | None, namespace: str | None
) -> list[Recording]:
    """The recordings that one is: two where its clock was set."""
    if isinstance(recording, Recording):
        return [recording.part(*time_range(recording.duration, from_time, until))]
    return read_parts(recording, from_time, until, namespace)


def on_the_arm(
    effects: dict[str, Values], seen: tuple[str, ...], joints: tuple[str, ...]
) -> dict[str, Values]:
    """Effects with values for the joints ``seen`` in the recordings, as effects of all ``joints``."""

    def spread(name: str, key: str, value: Any) -> Any:
        if isinstance(value, (str, float)):
            return value
        here = dict(zip(seen, value, strict=True))
        if isinstance(value, list):
            return [here.get(joint, "") for joint in joints]
        return np.array([here.get(joint, effect(name).parameter(key).null) for joint in joints])

    return {
        name: {key: spread(name, key, v) for key, v in values.items()} for name, values in effects.items()
    }


def _by_name(recordings: list[Recording], model: Model, mixed: Sequence[list[MixUp]]) -> dict[str, Any]:
    """Quality by name of recording; those of one name are numbered."""
    out: dict[str, Any] = {}
    for number, recording in enumerate(recordings, start=1):
        name = recording.name if recording.name not in out else f"{recording.name} ({number})"
        found = mixed[number - 1] if mixed else []
        out[name] = quality_of_recording(recording, model, found)
    return out


__all__ = ["Diagnosis", "Finding", "diagnose"]
