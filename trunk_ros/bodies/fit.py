"""The fit: which parameters the motion shows, their values, and what they are worth on unseen blocks."""

from __future__ import annotations

import numpy as np

from trunk_ros.arm import Arm
from trunk_ros.arm.pinocchio import library
from trunk_ros.bodies.found import UNITS, Bodies, Centre, Value
from trunk_ros.bodies.rows import Rows
from trunk_ros.bodies.squares import Squares
from trunk_ros.compiled import Array
from trunk_ros.errors import RecordingError

OWN = tuple(UNITS)
PER_JOINT = len(OWN)
OFFSET = OWN.index("offset")
LINK = ("mass", "centre x", "centre y", "centre z")
SEEN = 4.0  # standard deviations from 0
MASS, CENTRE = 0.25, 0.1  # deviation of the mass over the mass, of the centre over the link's reach: at most
EMPTY = 1e-20  # of the largest column's square
FORM = 0.003  # of a value: what sampling and filters leave in it, seen on MuJoCo's arms
TURNS = 20  # of the mass and centre, whose moments of inertia are not linear in them
LIGHTEST = 0.2  # of the mass before, in one turn
NOTHING = 0.01  # of the arm's mass, where to begin from a last link that has none
TURNED = 0.2  # times what the model's masses ask for, below 0: then the torque has the other sign
SCALE = 20.0  # times what the model's masses ask for: then the torque has another unit

UNSEEN = "not seen in this motion"
NEVER = "comes out as {:.3g} ± {:.2g}, which none can be: check the model's masses"
IDLE = "does not lower the error on unseen blocks"


class Fit:
    """One regression; ``active`` says which unknowns are in it: OWN of each joint, then LINK."""

    def __init__(self, rows: Rows, arm: Arm):
        self.rows, self.arm, joints = rows, arm, rows.joints
        self.body = arm.body.last_link
        self.told = np.asarray(self.body.toDynamicParameters())
        self.usual = float(self.body.mass) or NOTHING * arm.body.mass
        self.mass, self.first = self.usual, self.usual * np.array(self.body.lever)
        self.known_turn = np.array(self.body.inertia)  # about the centre: kept
        self.active = np.ones(PER_JOINT * joints + len(LINK), dtype=bool)
        self.reasons: dict[int, str] = {}
        self._own = np.zeros((*rows.torque.shape, PER_JOINT * joints))
        for j in range(joints):
            self._own[:, j, PER_JOINT * j : PER_JOINT * j + OFFSET] = rows.joint[:, j]
            self._own[:, j, PER_JOINT * j + OFFSET] = 1.0
        self.squares = self.at_the_models = self._squares()
        empty = np.einsum("bjpp->p", self.squares.gram)
        self.filled = np.asarray(empty > EMPTY * empty.max())
        for k in np.flatnonzero(~self.filled):
            self.leave_out(int(k))

    def parameters(self) -> Array:
        """(10,) of the last link at the present mass and centre, as Pinocchio orders them."""
        centre = self.first / self.mass
        inertia = library().Inertia(self.mass, centre, self.known_turn)
        return np.asarray(inertia.toDynamicParameters())

    def leave_out(self, unknown: int, reason: str = UNSEEN) -> None:
        """Take an unknown out; a mass or centre is the model's then."""
        self.active[unknown] = False
        self.reasons[unknown] = reason
        if self.name(unknown) == LINK[0]:
            self.first, self.mass = self.first * self.usual / self.mass, self.usual
        if unknown > len(self.active) - len(LINK):
            axis = unknown - len(self.active) + len(LINK) - 1
            self.first[axis] = self.mass * self.body.lever[axis]

    def converge(self) -> None:
        """Mass and centre at which the torque is met best, moments of inertia about the centre kept."""
        for _ in range(TURNS):
            self.squares = self._squares()
            weight = self.squares.weights(self.active)
            change = self.squares.solve(self.active, weight)[-len(LINK) :]
            held = self.first / self.mass  # what is left out stays where it is, whatever the mass
            mass = max(self.mass + change[0], LIGHTEST * self.mass)
            first = np.where(self.active[-len(LINK) + 1 :], self.first + change[1:], held * mass)
            step = abs(mass - self.mass) / self.mass
            self.mass, self.first = float(mass), first
            if step < 1e-9 and np.all(np.abs(change[1:]) < 1e-9 * self.mass):
                break
        self.squares = self._squares()

    def solution(self) -> tuple[Array, Array, Array]:
        """Values, standard deviations (unknowns,), those of LINK as mass and centre; joints' weights."""
        weight = self.squares.weights(self.active)
        values = self.squares.solve(self.active, weight)
        deviations, one_less = self.squares.deviations(self.active, weight)
        values[-len(LINK) :] = [self.mass, *(self.first / self.mass)]
        mass = self.mass + one_less[:, -len(LINK)]
        centres = (self.first + one_less[:, 1 - len(LINK) :]) / np.where(mass == 0.0, np.nan, mass)[:, None]
        spread = centres - centres.mean(axis=0)
        jack = np.sqrt((len(mass) - 1) / len(mass) * (spread**2).sum(axis=0))
        white = deviations[1 - len(LINK) :] / self.mass
        moves = self.active[1 - len(LINK) :]
        deviations[1 - len(LINK) :] = np.where(moves, np.fmax(jack, np.minimum(white, 1e300)), np.inf)
        deviations = np.hypot(deviations, FORM * np.abs(values))
        return values, deviations, weight

    def name(self, unknown: int) -> str:
        """What it is called, without its joint."""
        own = PER_JOINT * self.rows.joints
        return OWN[unknown % PER_JOINT] if unknown < own else LINK[unknown - own]

    def joint_of(self, unknown: int) -> str:
        """Its joint."""
        own = PER_JOINT * self.rows.joints
        arm = self.arm
        return arm.joints[unknown // PER_JOINT if unknown < own else arm.body.last]

    def _squares(self) -> Squares:
        """At the present mass and centre: the columns of LINK are of a change of mass and first moments."""
        columns = np.concatenate([self._own, self.rows.link @ self._slope()], axis=2)
        torque = self.rows.torque - self.rows.asked - self.rows.link @ (self.parameters() - self.told)
        return Squares.of(columns, torque, self.rows.known, self.rows.block)

    def _slope(self) -> Array:
        """(10, 4) of the parameters with mass and first moments; what is left out keeps its place on the
        link, whatever the mass.
        """
        out = np.zeros((10, len(LINK)))
        moments, centre = self.first, self.first / self.mass
        for k, turn in enumerate(np.eye(3)):
            out[4:, 1 + k] = _six(
                (2.0 * moments @ turn * np.eye(3) - np.outer(turn, moments) - np.outer(moments, turn))
                / self.mass
            )
            out[1 + k, 1 + k] = 1.0
        out[0, 0] = 1.0
        out[4:, 0] = -_six(centre @ centre * np.eye(3) - np.outer(centre, centre))
        for axis in np.flatnonzero(~self.active[1 - len(LINK) :]):
            out[:, 0] += centre[axis] * out[:, 1 + axis]
        return out


def _six(matrix: Array) -> Array:
    """xx, xy, yy, xz, yz, zz."""
    return np.array([matrix[i, j] for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))])


def fitted(rows: Rows, arm: Arm, recordings: tuple[str, ...]) -> Bodies:
    """All that the rows show, with what it is worth on unseen blocks.

    Raises RecordingError where torque and model are of different units or signs.
    """
    _check_scale(rows, arm)
    fit = Fit(rows, arm)
    while True:
        fit.converge()
        values, deviations, weight = fit.solution()
        worst = _least_seen(fit, values, deviations)
        if worst is not None:
            never = fit.name(worst) in OWN and values[worst] < -SEEN * deviations[worst]
            fit.leave_out(worst, NEVER.format(values[worst], deviations[worst]) if never else UNSEEN)
            continue
        idle = _helps_least(fit, weight)
        if idle is None:
            break
        for unknown in idle:
            fit.leave_out(unknown, IDLE)
    return _bodies(fit, values, deviations, weight, recordings)


def _least_seen(fit: Fit, values: Array, deviations: Array) -> int | None:
    """The unknown to leave out first, if any: of LINK before the joints' own, whose sum a mass may be."""
    reach = max(float(np.linalg.norm(fit.first / fit.mass)), _reach(fit.arm))
    doubt = np.zeros(len(values))
    own = len(values) - len(LINK)
    for k in np.flatnonzero(fit.active):
        name = fit.name(int(k))
        if name in OWN:
            doubt[k] = 0.0 if name == OWN[OFFSET] else _over(SEEN * deviations[k], values[k])
        elif name == LINK[0]:
            doubt[k] = _over(deviations[k], MASS * values[k])
        else:
            doubt[k] = _over(deviations[k], CENTRE * reach)
    for begin, part in ((own, doubt[own:]), (0, doubt[:own])):
        if (part >= 1.0).any():
            return begin + int(np.argmax(part))
    return None


def _over(deviation: float, size: float) -> float:
    """How many times too large a deviation is for its value; a value that none can have is in doubt."""
    return float(np.inf) if size <= 0.0 else deviation / size


def _reach(arm: Arm) -> float:
    """m from the last joint to the tip."""
    place, _ = arm.body.places(np.zeros((1, len(arm.joints))))
    return float(np.linalg.norm(place[0, -1] - place[0, arm.body.last]))


def _helps_least(fit: Fit, weight: Array) -> list[int] | None:
    """The group of unknowns without which unseen blocks are met best, if they are met as well without it."""
    own = PER_JOINT * fit.rows.joints
    groups = [[int(k)] for k in np.flatnonzero(fit.active[:own]) if fit.name(int(k)) != OWN[OFFSET]]
    link = [int(k) + own for k in np.flatnonzero(fit.active[own:])]
    groups += [link] if link else []
    best, whole = None, float(weight @ fit.squares.unseen(fit.active, weight))
    for group in groups:
        less = fit.active.copy()
        less[group] = False
        squares = fit.squares if group != link else fit.at_the_models
        without = float(weight @ squares.unseen(less, weight))
        if without <= whole:
            best, whole = group, without
    return best


def _check_scale(rows: Rows, arm: Arm) -> None:
    """Torque of another unit or sign is none that a mass explains."""
    fit = Fit(rows, arm)
    fit.active[-len(LINK) :] = False
    fit.active[-len(LINK)] = True
    columns = np.concatenate([fit._own, rows.asked[..., None], np.zeros((*rows.asked.shape, 3))], axis=2)
    squares = Squares.of(columns, rows.torque, rows.known, rows.block)
    weight = squares.weights(fit.active)
    values = squares.solve(fit.active, weight)
    scale, deviation = values[-len(LINK)], squares.deviations(fit.active, weight)[0][-len(LINK)]
    if scale < -SEEN * deviation and scale < -TURNED:
        raise RecordingError(
            "effort has the sign of the load: on gearbox_states it is the torque that the motor applies, "
            "against the load"
        )
    if scale > SCALE and deviation < 0.1 * scale:
        raise RecordingError(
            f"effort is {scale:.3g} times what the model's masses ask for: give it in N m, and masses in kg"
        )


def _bodies(fit: Fit, values: Array, deviations: Array, weight: Array, recordings: tuple[str, ...]) -> Bodies:
    arm, own = fit.arm, PER_JOINT * fit.rows.joints
    joints: dict[str, dict[str, Value]] = {}
    for j, joint in enumerate(arm.joints):
        slides = int(joint in arm.units)
        joints[joint] = {
            name: Value(short(values[k]), short(deviations[k]), UNITS[name][slides])
            for name, k in ((name, PER_JOINT * j + i) for i, name in enumerate(OWN))
            if fit.active[k]
        }
    mass = Value(short(fit.mass), short(deviations[own]), "kg") if fit.active[own] else None
    seen = fit.active[own + 1 :]
    centre = None
    if seen.any() or mass is not None:
        x, y, z = (short(value) for value in values[own + 1 :])
        stds = [short(s) if one else None for s, one in zip(deviations[own + 1 :], seen, strict=True)]
        centre = Centre((x, y, z), (stds[0], stds[1], stds[2]), short(fit.mass))
    left = [f"{fit.joint_of(k)}: {fit.name(k)} {why}" for k, why in sorted(fit.reasons.items())]
    return Bodies(
        recordings, joints, arm.joints[arm.body.last], mass, centre, tuple(left), _held_out(fit, weight)
    )


def short(value: float) -> float:
    """As many digits as a file needs."""
    return float(f"{value:.6g}")


def _held_out(fit: Fit, weight: Array) -> dict[str, dict[str, float | str]]:
    """Rms torque error on unseen blocks by joint, of the model's bodies alone and with what was found."""
    bare = np.zeros_like(fit.active)
    bare[OFFSET : PER_JOINT * fit.rows.joints : PER_JOINT] = True
    count = fit.squares.count.sum(axis=0)
    before, after = (
        np.sqrt(squares.unseen(active & fit.filled, weight) / np.maximum(count, 1))
        for squares, active in ((fit.at_the_models, bare), (fit.squares, fit.active))
    )
    return {
        joint: {
            "before": short(before[j]),
            "after": short(after[j]),
            "unit": UNITS["offset"][int(joint in fit.arm.units)],
        }
        for j, joint in enumerate(fit.arm.joints)
        if count[j]
    }
