"""One diagnosis in the making: stage by stage, from spans to findings, model and plots."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.align import common_joints, driven, hidden_by_gaps, servo_span, wire_span
from trunk_ros.data.counting import with_counting
from trunk_ros.data.load_cells import celled
from trunk_ros.data.mix_ups import MixUp, as_if_standing
from trunk_ros.data.quality import quality_by_name
from trunk_ros.data.rests import of_few_rests
from trunk_ros.data.sensing.thinned import how_far_off
from trunk_ros.diagnosis.beside import Beside, beside
from trunk_ros.diagnosis.context import LEAST
from trunk_ros.diagnosis.drawn import drawn
from trunk_ros.diagnosis.evidence.at_rest import honest
from trunk_ros.diagnosis.evidence.cross_validation import Error
from trunk_ros.diagnosis.evidence.evidence import Evidence
from trunk_ros.diagnosis.evidence.residual_dependence import rests as powers
from trunk_ros.diagnosis.evidence.turned_load import turned_loads
from trunk_ros.diagnosis.experiment.design import experiment, proposals
from trunk_ros.diagnosis.free_run import free_run
from trunk_ros.diagnosis.judged import judged
from trunk_ros.diagnosis.pace import with_its_clocks
from trunk_ros.diagnosis.resources.aside import aside, size_of
from trunk_ros.diagnosis.search.fit import Fit
from trunk_ros.diagnosis.servos.described_servo import as_it_runs
from trunk_ros.diagnosis.servos.nominal_servo import Servos, with_its_servo, with_other_numbers
from trunk_ros.diagnosis.simulators.against import Simulator
from trunk_ros.diagnosis.simulators.other_simulator import shifted
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.diagnosis.stages.stage import Stage
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.diagnosis.tip.judged import fitted_tip, judged_tip
from trunk_ros.diagnosis.tip.lasting import lasting_of
from trunk_ros.diagnosis.verdict.answer import Unexplained
from trunk_ros.diagnosis.verdict.changes import MODEL, SIMULATION
from trunk_ros.diagnosis.verdict.findings import left_over, without_a_name
from trunk_ros.diagnosis.verdict.included import all_findings, names_said
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.diagnosis.verdict.together import together
from trunk_ros.diagnosis.whole_arm import on_the_arm
from trunk_ros.effect_values import Values, lateness
from trunk_ros.effects import effect
from trunk_ros.errors import RecordingError
from trunk_ros.heap import give_back
from trunk_ros.model import Model
from trunk_ros.own_time import drawn_from
from trunk_ros.recording.quality import of_one_stamp
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.topics import TIP_TOPIC
from trunk_ros.start import SETTLE
from trunk_ros.transmission import uncoupled

Progress = Callable[[str], None]


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
        settle: float = SETTLE,
        servos: Servos | None = None,
    ):
        """``recordings``: a list that this object empties and changes. ``mixed``: what is mixed up in each,
        and left out. ``servos``: what was found of the arm's in other recordings.
        """
        self.recordings, self.against, self.say = recordings, against, progress
        self.mixed = mixed or [[] for _ in recordings]
        self.units, self.cells = recordings[0].units, celled(recordings)
        self.experiments, self.settle, self.servos = experiments, settle, servos
        self.size = size_of(recordings)
        topics = set.intersection(*(set(r.series) for r in recordings))
        servo_alone = "joint_states" not in topics and {"setpoints", "gearbox_states"} <= topics
        tip_alone = "gearbox_states" not in topics and all(r.tip is not None for r in recordings)
        self.wires = [uncoupled(r, model)[0] for r in recordings]
        """The recordings with a path of its own to each joint."""
        path = replace(model, arm=model.arm.uncoupled())
        spans = (
            []
            if servo_alone or tip_alone
            else [with_its_clocks(wire_span(r, path), r, path) for r in self.wires]
        )
        recordings[:] = with_counting(recordings, spans)
        key = "gearbox_states" if servo_alone else "joint_states"
        seen = [s.joints for s in spans] or [common_joints(r, model, r.require(key)) for r in recordings]
        self.joints = seen[0]
        if any(joints != self.joints for joints in seen):
            raise RecordingError("the recordings have different joints: they are not of one arm")
        self.model, self.path = model.for_joints(self.joints), path.for_joints(self.joints)
        self.spans = (
            spans
            if against is None
            else [shifted(s, against.context("wire", r)) for s, r in zip(spans, recordings, strict=True)]
        )
        self.result = Diagnosis({}, [], [], [], self.model)
        self.result.provenance = {"model_hash": model.hash()}
        self.effects: dict[str, Values] = {}
        self.left: dict[str, Error] = {}  # by the fit of the wires, of each joint
        self.went: tuple[Array, ...] = ()
        """How far the motors went: standard deviation, least and most (joints,) rad on the joints' side."""
        self.lasting: dict[str, tuple[float, float]] = {}
        """Joint noise [rad] that lasts from sample to sample, and how long [s] it stays the same."""

    def run(self) -> Diagnosis:
        """All stages."""
        self.result.stages["servo"] = {"compared": False, "joints": {}}  # comes first in what is said
        self.wire()
        with aside(self.size, self.result.plots):
            self.servo()  # with the payload that the wires show
            self.tip()
            self._conclude()
        return self.result

    def _conclude(self) -> None:
        """What is said of all stages together, and of the recordings."""
        self.result.findings = together(self.result.findings, self.model.arm)
        self._say_what_is_mixed_up()
        self._refuse_if_nothing_was_seen()
        judged = {s for s, told in self.result.stages.items() if told["compared"]}
        kept = {n: v for n, v in self.model.effects.items() if effect(n).stage not in judged} | self.effects
        own = replace(self.model, effects=kept, duration=max(r.duration for r in self.recordings))
        self.result.model = self._with_limits(drawn_from(own, *self.recordings))
        self.result.quality = quality_by_name(self.recordings, self.model, self.mixed, self.result.model)

    def _with_limits(self, model: Model) -> Model:
        """The model with what it left, and how far the motors went; as it is where no wire was compared."""
        if not self.left:
            return model
        left = ({j: getattr(e, name) for j, e in self.left.items()} for name in ("usual", "zero"))
        told = (*left, *(dict(zip(self.joints, one, strict=True)) for one in self.went))
        error, zero, *went = (np.array([one.get(joint, 0.0) for joint in model.arm.joints]) for one in told)
        reach, lowest, highest = went
        zero = zero if len(self.recordings) > 1 else np.empty(0)
        return replace(model, error=error, zero=zero, reach=reach, lowest=lowest, highest=highest)

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
            still = f"no joint moves for {LEAST} samples or more: "
            still += "record a motion that moves the joints, over a longer time"
            say = (of_one_stamp, hidden_by_gaps, partial(of_few_rests, least=LEAST))
            why = next(filter(None, (each(r) for r in self.recordings for each in say)), still)
            raise RecordingError(f"{', '.join(r.name for r in self.recordings)}: {why}")

    def servo(self) -> None:
        """Setpoint to gearbox, where setpoints were recorded, by another simulator as well."""
        other, recorded = self.against, driven(self.recordings, self.model, self.joints)
        if not recorded or (other is not None and not other.has_servo):
            return
        self.say("servo")
        before, self.model = self.model, self._with_servos(recorded)
        spans = [servo_span(r, self.model) for r in recorded]
        if other is not None:
            spans = [shifted(s, other.context("servo", r)) for s, r in zip(spans, recorded, strict=True)]
        found = replace(self.model, effects={**self.model.effects, **self.effects})
        identified = self.model.arm is not before.arm and not before.says_its_servos
        filled = how_far_off(recorded, self.joints)
        del recorded
        with aside(self.size, self.recordings, self.wires):
            self._stage(ServoStage(spans, found, self.units, filled, identified))
            spans.clear()
        if identified and self.servos is None:
            self.model, self.effects, said = with_other_numbers(self.model, self.effects)
            self.result.findings = [f for f in self.result.findings if f.effect not in said]

    def found_servos(self) -> Servos:
        """Those of joints of which the model says nothing and the recordings tell."""
        recorded = driven(self.recordings, self.model, self.joints)
        return Servos.of(self.model, self._with_servos(recorded) if recorded else self.model)

    def _with_servos(self, recorded: list[Recording]) -> Model:
        """The model with what it does not say of its servos, from these recordings."""
        if self.against is not None and self.against.learned:
            return replace(self.model, setpoints=with_its_servo(self.model, recorded).setpoints)
        if self.model.says_its_servos:
            return self.model if self.against else as_it_runs(self.model, recorded)
        return with_its_servo(self.model, recorded, self.servos)

    def wire(self) -> None:
        """Gearbox to joint, where the joints have sensors."""
        if not self.spans:
            self.result.stages["wire"] = {"compared": False, "joints": {}}
            return
        self.say("wire")
        with aside(self.size, self.recordings, self.wires):
            seen = self._wires()  # all else of the stage is gone when the recordings come back
        for some in (self.recordings, self.wires):
            some[:] = [r if one is None else one.put_right(r) for r, one in zip(some, seen, strict=True)]

    def _wires(self) -> list[Beside | None]:
        """What was seen of each recording beside the physics of its wires."""
        wires = np.concatenate([s.gearbox * self.path.arm.only(self.joints).ratio for s in self.spans])
        self.went = np.std(wires, axis=0), wires.min(axis=0), wires.max(axis=0)
        del wires
        seen = [as_if_standing(*each) for each in zip(self.spans, self.mixed, strict=True)]
        stage, self.spans = WireStage(seen, self.path, self.units), []
        del seen
        state = self._stage(stage)
        if state is None:
            return [None] * len(stage.views)
        self.lasting, turned = lasting_of(state.context), turned_loads(state, self.cells)
        self.mixed = [[*found, *turned] for found in self.mixed]
        return [*beside(state)]

    def _stage(self, stage: Stage) -> Fit | None:
        give_back()
        done = judged(stage, self.settle, lambda text: self.say(f"{stage.name}: {text}"))
        if done is None:
            self.result.stages[stage.name] = {"compared": False, "joints": {}, "silent": [*stage.joints]}
            return None
        state, context, found, std, errors = done.state, done.context, done.found, done.std, done.errors
        context.forget()
        give_back()
        if stage.name == "wire":
            self.left = {stage.joints[c]: e for c, e in errors.items()}
        self.result.stages[stage.name] = done.told()
        new = all_findings(state, found, std, MODEL if self.against is None else SIMULATION)
        effects, said = state.hypothesis.model_effects(len(stage.joints)), names_said(state.hypothesis, new)
        had = {name: v for name, v in self.model.effects.items() if effect(name).stage == stage.name}
        self.effects |= on_the_arm(effects, had, stage.joints, self.model.arm.joints, said)
        run = honest(free_run(context, state.hypothesis), state.hypothesis)
        rests = left_over(run, state.hypothesis, errors)
        self.result.unexplained += rests
        strong = {stage.joints[c] for c, p in powers(run, state.hypothesis).items() if p > 1.0}
        told = {j for f in new if not f.named for j in f.joints}
        nameless = [rest for rest in rests if (strong - told) & set(rest.joints)]
        self.result.findings += without_a_name(nameless, new)
        self.result.plots |= drawn(context, state.hypothesis)
        seen = [f.effect for f in new if f.equivalents and f.evidence["gain"]]
        self._experiment(done.part, {name: found[name] for name in seen})
        return state

    def _experiment(self, state: Fit, found: dict[str, Evidence]) -> None:
        """The motion that tells what was found from its equivalents."""
        if not self.experiments:
            return
        stage = state.context.stage.name
        self.say(f"{stage}: experiment")
        done, file = experiment(state, found), f"experiment_{stage}.yaml"
        if done is not None:
            told = proposals(done, file, self.units)
            self.result.experiments += told
            if any(entry["trajectory"] for entry in told):
                self.result.trajectories[file] = done.motion

    def tip(self) -> None:
        """Joint to tip."""
        give_back()
        late = lateness(self.effects)
        model = replace(self.path, effects={**self.path.effects, **self.effects})
        best = fitted_tip(self.wires, model, late, self.lasting) if self.against is None else None
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
