"""What another simulator does itself, found from its own recording before the arm is compared with it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.data.align import servo_span, wire_span
from trunk_ros.data.motion_content import top_speed
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.simulators.other_simulator import on_the_clock
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.effects import effect
from trunk_ros.errors import RecordingError
from trunk_ros.levels import HALF, SLIGHT, SOME, TENFOLD
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import Recording
from trunk_ros.recording.topics import COMPARED
from trunk_ros.transmission import ratio_of

SERVO = set(COMPARED["servo"])

Diagnose = Callable[[Recording, Model], Diagnosis]


@dataclass(frozen=True)
class Simulator:
    """Another simulator: what it recorded, and the model of what it does."""

    recording: Recording
    model: Model
    found: Diagnosis
    learned: bool = False
    """Whether its servos were found, as nothing is said of them."""

    @property
    def has_servo(self) -> bool:
        """Whether its servos can be compared."""
        return set(self.recording.series) >= SERVO

    def context(self, stage: str, recording: Recording) -> Context:
        """A stage of the simulator's own recording, on the clock of the arm's."""
        own = on_the_clock(self.recording, recording)
        if stage == "servo":
            return first_look(ServoStage([servo_span(own, self.model)], self.model))
        return first_look(WireStage([wire_span(own, self.model)], self.model))


def nominal_for(joints: Sequence[str]) -> Model:
    """The model that is taken where none is given: the nominal arm for its own joints, else ``direct``."""
    trunk = load_model("trunk")
    return trunk if set(joints) <= set(trunk.arm.joints) else load_model("direct")


def identified(
    other: Recording, recordings: Sequence[Recording], model: Model, diagnose: Diagnose
) -> Simulator:
    """What a simulator does, from its recording: its ratio, and all else as effects of the model.

    Unless it does what ``model`` says, its play is looked for from none at all, so that too much of it can be
    told as well. Raises RecordingError where it lacks joints of the arm's recordings.
    """
    arm = recordings[0]
    own = on_the_clock(with_gearbox(other, arm), arm)
    span = wire_span(arm, model)
    missing = [joint for joint in span.joints if joint not in own.require("joint_states").joints]
    if missing:
        raise RecordingError(
            f"{other.name}: no joint_states of {', '.join(missing)}: joints go by their names"
        )
    noise = dict(zip(span.joints, (n.std for n in first_look(WireStage([span], model)).noise), strict=True))
    own = dithered(own, noise)
    base = with_room(model.for_joints(span.joints), [own, arm])
    base = base if follows(own, base, noise) else without_play(base)
    found = diagnose(own, base)
    learned = found.model.arm.servo_stated and not base.arm.servo_stated
    return Simulator(own, with_own_ratio(found.model), found, learned)


def with_room(model: Model, recordings: Sequence[Recording]) -> Model:
    """The model with no top speed to speak of, where a gearbox was faster than that: it is not theirs."""
    driven = [r.series["gearbox_states"] for r in recordings if "gearbox_states" in r.series]
    fastest = max((top_speed(series.stamp, series.position) for series in driven), default=0.0)
    if fastest <= (1.0 + SLIGHT) * np.max(model.arm.v_max):
        return model
    return replace(model, arm=replace(model.arm, v_max=TENFOLD * fastest))


def with_gearbox(other: Recording, arm: Recording) -> Recording:
    """A simulator's recording without gearbox angles takes those of the arm, which it was driven with."""
    if "gearbox_states" in other.series or "gearbox_states" not in arm.series:
        return other
    gearbox = on_the_clock(arm, other).series["gearbox_states"]
    return replace(other, series={**other.series, "gearbox_states": gearbox})


def dithered(own: Recording, noise: dict[str, float]) -> Recording:
    """Joint readings with some of the arm's noise: a search for what no noise hides would have no end."""
    shown = own.series["joint_states"].select(tuple(noise))
    size = SOME * np.array(list(noise.values()))
    position = shown.position + size * np.random.default_rng(0).standard_normal(shown.position.shape)
    return replace(own, series={**own.series, "joint_states": replace(shown, position=position)})


def follows(own: Recording, model: Model, noise: dict[str, float]) -> bool:
    """Whether a simulator does what a model says: it errs by less than half of the arm's noise."""
    context = first_look(WireStage([wire_span(own, model)], model))
    limit = HALF * np.array([noise[joint] for joint in context.joints])
    return bool(np.all([_rms(context, c) < limit[c] for c in context.columns]))


def _rms(context: Context, column: int) -> float:
    rest: Array = context.residual(0, context.known, column)
    return float(np.sqrt(np.sum(rest**2) / max(context.count(column), 1)))


def without_play(model: Model) -> Model:
    """The model of an ideal transmission with the arm's ratios, geometry and masses."""
    compliance = model.arm.compliance
    arm = replace(model.arm, dead_band=np.zeros_like(model.arm.dead_band), wire=None, compliance=compliance)
    return replace(model, arm=arm, effects={})


def with_own_ratio(model: Model) -> Model:
    """The same with the ratios that were found as the arm's own."""
    effects = {name: values for name, values in model.effects.items() if effect(name).changes != "ratio"}
    return replace(model, arm=replace(model.arm, ratio=ratio_of(model)), effects=effects)
