"""Arms with known physics, looked at through one hypothesis: where a move begins."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from test.diagnosis.arms import on, recorded
from trunk_ros.data.align import wire_span
from trunk_ros.diagnosis.context import Context
from trunk_ros.diagnosis.discrepancy.curves import curve_fit
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis, Term
from trunk_ros.diagnosis.search.descent import Desk, Move
from trunk_ros.diagnosis.search.fit import Fit, refit
from trunk_ros.diagnosis.search.greedy import begun
from trunk_ros.diagnosis.search.score import score
from trunk_ros.diagnosis.stages.wire import WireStage
from trunk_ros.effects.curve import VALUES
from trunk_ros.model import load_model

ROUGH = np.random.default_rng(4).normal(size=len(VALUES)) * 2e-3  # rad along the way of joint 2
ARMS: dict[str, dict[str, dict[str, Any]]] = {
    "clean": {},
    "backlash": {"backlash": {"half_width": on(3, 1.5e-3)}},
    "two": {"backlash": {"half_width": on(3, 1.5e-3)}, "ratio_error": {"relative": on(3, 0.02)}},
    "rings": {
        "link_resonance": {
            "frequency": np.array([1e6, 1e6, 3.5, 1e6, 4.7]),
            "damping": np.full(5, 0.03),
            "form": "absolute",
        }
    },
    "all looser": {"backlash": {"half_width": 1e-5 * np.array([21.0, 23.8, 17.8, 20.6, 21.1])}},
    "alike": {
        "backlash": {"half_width": on(2, 1.5e-3) + on(4, 1e-3)},
        "ratio_error": {"relative": on(2, 0.02) + on(4, 0.015)},
    },
    "unknown wheel": {"ratio_error": {"relative": on(3, -1.9)}, "zero_offset": {"offset": on(3, 1.2)}},
    "slip": {"wire_slip": {"step": on(2, 2e-3), "onset": np.full(5, 17.0)}},
    "slips twice": {
        "wire_slip": {
            "step": on(2, 2e-3),
            "onset": np.full(5, 12.0),
            "from_2": np.full(5, 25.0),
            "times_2": np.full(5, 1.6),
        }
    },
    "wears": {
        "friction_wear": {
            "form": "travel",
            "rate": 1e-5 * np.array([4.0, 0.0, 0.0, 6.0, 8.0]),
            "speed": np.full(5, 0.1),
        }
    },
    "graded": {"load_elasticity": {"compliance": np.array([0.001, 0.004, 0.016, 0.064, 0.256])}},
    "sag": {"load_elasticity": {"compliance": np.full(5, 0.02)}},
    "rubbing": {
        "load_elasticity": {"compliance": np.full(5, 0.03)},
        "load_dependent_friction": {"gain": on(5, 0.03)},
    },
    "gripping": {
        "load_elasticity": {"compliance": np.full(5, 0.05), "upstream": 1.0},
        "load_dependent_friction": {"gain": np.full(5, 1.2e-3)},
    },
    "loosened": {"backlash": {"half_width": on(3, 1.5e-3), "from": np.full(5, 12.0)}},
    "picked up": {
        "load_elasticity": {"compliance": np.full(5, 0.03), "payload": 0.1, "payload_from": 9.0},
    },
    "two give way": {
        "load_elasticity": {"compliance": on(2, 0.03) + on(5, 0.2), "from": np.full(5, 15.0)},
    },
    "slack": {
        "wire_slack": {
            "compliance": np.array([0.05, 0.05, 0.05, 0.05, 0.3]),
            "threshold": np.array([0.04, 0.03, 0.02, 0.01, 2e-3]),
        },
    },
    "upstream": {"load_elasticity": {"compliance": np.full(5, 0.05), "upstream": 1.0}},
    "heavy upstream": {
        "load_elasticity": {"compliance": np.full(5, 0.08), "damping": np.full(5, 0.1), "form": "held"}
    },
    "hardens upstream": {
        "wire_stiffening": {
            "compliance": np.full(5, 0.05),
            "moment": np.array([0.08, 0.05, 0.036, 0.024, 0.011]),
            "upstream": 1.0,
        }
    },
    "payload": {"load_elasticity": {"compliance": np.full(5, 0.03), "payload": 0.08}},
    "gaussian": {
        "stribeck_friction": {"amplitude": on(2, 4e-3), "velocity": on(2, 0.04), "form": "gaussian"}
    },
    "creeping under friction": {
        "viscoelastic_creep": {
            "gain": on(3, 0.004),
            "rubbing": on(3, 0.05),
            "time_constant": 4.5,
            "form": "upstream",
        }
    },
    "giving way": {
        "viscoelastic_creep": {
            "compliance": np.full(5, 0.02),
            "upstream": 1.0,
            "time_constant": 4.0,
            "form": "load",
        }
    },
    "creeping like a rope": {
        "viscoelastic_creep": {
            "gain": on(3, 0.03),
            "time_constant": 60.0,
            "time_constant_2": 0.5,
            "form": "spectrum",
        }
    },
    "oiled": {
        "stribeck_friction": {
            "amplitude": on(2, 4e-3),
            "velocity": np.full(5, 0.03),
            "memory": np.full(5, 0.15),
            "form": "film",
        }
    },
    "oiled on two": {
        "stribeck_friction": {
            "amplitude": on(2, 4e-3) + on(4, 3e-3),
            "velocity": np.full(5, 0.03),
            "memory": np.full(5, 0.15),
            "form": "film",
        }
    },
    "coupled": {"joint_coupling": {"gain": on(4, 0.03), "source": ["", "", "", "joint_2", ""]}},
    "rippled": {
        "transmission_ripple": {
            "amplitude": on(3, 6e-5),
            "cycles_per_rev": on(3, 20.0),
            "phase": on(3, 0.5),
            "form": "sine",
        }
    },
    "late and soft": {
        "sensor_delay": {"delay": 0.02},
        "load_elasticity": {"compliance": np.full(5, 0.1)},
    },
    "loose": {"backlash": {"half_width": np.full(5, 1e-3)}},
    "loose beside a zero": {
        "backlash": {"half_width": np.full(5, 1e-3)},
        "zero_offset": {"offset": on(3, 0.1)},
    },
    "late, and one lags": {
        "sensor_delay": {"delay": 0.006},
        "viscous_lag": {"time_constant": on(3, 0.03)},
    },
    "late and loose": {"sensor_delay": {"delay": 0.02}, "backlash": {"half_width": on(3, 1e-3)}},
    "tension": {"tension_error": {"factor": 3.0}},
    "loose, and worn on two": {
        "tension_error": {"factor": 0.5},
        "friction_wear": {"rate": on(2, 1.5e-5) + on(3, 1.5e-5), "form": "straight"},
    },
    "wearing": {
        "unknown_gain": {
            "low": on(3, 0.0),
            "high": on(3, 40.0),
            "on": ["", "", "time", "", ""],
            **{p.name: on(3, 2e-3 * k / len(VALUES)) for k, p in enumerate(VALUES)},
        }
    },
    "rough": {
        "unknown": {
            "low": on(2, -0.5),
            "high": on(2, 0.5),
            "on": ["", "position", "", "", ""],
            **{p.name: on(2, float(height)) for p, height in zip(VALUES, ROUGH, strict=True)},
        }
    },
}


def knowing(now: Context, known: Hypothesis) -> Context:
    """The same recordings, looked at by a model that has effects."""
    model = replace(now.stage.model, effects=known.model_effects(len(now.joints)))
    return replace(now, stage=type(now.stage)([view.span for view in now.views], model))


LONG = ("clean", "sag", "two", "creeping like a rope", "oiled on two")
"""Arms whose claims take 40 s of motion; 28 s do for the others."""


@cache
def context(arm: str) -> Context:
    """The wires of an arm, weighed by what the nominal model leaves."""
    model, seconds = load_model("trunk"), 40.0 if arm in LONG else 28.0
    return begun(first_look(WireStage([wire_span(recorded(ARMS[arm], seconds), model)], model))).context


def fitted(arm: str, *terms: Term) -> Fit:
    """A hypothesis about an arm, fitted."""
    hypothesis = Hypothesis({term.effect: term for term in terms})
    there = refit(context(arm), hypothesis)
    return refit(there.context.seen_with(there.hypothesis).weighed(there.hypothesis), there.hypothesis)


def best_of(move: Move, now: Fit) -> Fit | None:
    """The best trial that a move makes."""
    trials = [trial for group in move.groups(now, Desk()) for trial in group.trials()]
    return min(trials, key=score, default=None)


def drawn_beside_a_ratio() -> Fit:
    """A curve on the joint that needs one, beside a ratio that it can make up for."""
    wrong = fitted("rough")
    ratio = Hypothesis({"ratio_error": Term("ratio_error", own={1: {"relative": 0.01}})})
    drawn = curve_fit(wrong.context, ratio, 1)
    assert drawn is not None
    return Fit(drawn.hypothesis, wrong.cost | drawn.cost, wrong.context)
