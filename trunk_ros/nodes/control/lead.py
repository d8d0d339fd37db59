"""Setpoints that have a servo be where it should be in time, and cross a dead band faster than it would."""

from __future__ import annotations

import numpy as np

from trunk_ros.compiled import Array, compiled
from trunk_ros.effects.servo.loop import fresh, servo_loop, unlimited

QUICKER = 2.0  # times the servo's own pace: setpoints then run ahead by up to its square of what they would
PERIODS = 50  # that a mean is taken of
SPEED = 0.4  # of a speed over the pace, beside an angle: one setpoint cannot bring about both
SAME = 0.01  # of a period: as good as the same
TRIED = 1e-4  # rad, far from the top speed


class Lead:
    """The servo's equations run backward behind a filter of second order.

    The motors go over to where they are wanted as m'' = w^2 (wanted - m) - 2 w m', critically damped; the
    setpoint is the one that brings the servo next to that in a period. m is where it stands by its equations
    under the setpoints that really went out, after its delay: what a limit held back is caught up with, not
    overshot.
    """

    def __init__(
        self,
        at: Array,
        gain: Array,
        tau_v: float | Array,
        tops: Array,
        fed: float | Array = 0.0,
        ahead: float = 0.0,
        delay: float | Array = 0.0,
        ki: float | Array = 0.0,
    ):
        """``at`` (joints,) rad: where the motors stand; the servo as in `use`."""
        self._wanted = self._sent = self._last = at
        self._slope = np.zeros_like(at)
        self._servo = fresh(at, self._slope)
        self._period, self._periods, self._seen, self._still = 0.0, 0, 0.0, 0.0
        self.use(gain, tau_v, tops, fed, ahead, delay, ki)

    def use(
        self,
        gain: Array,
        tau_v: float | Array,
        tops: Array,
        fed: float | Array = 0.0,
        ahead: float = 0.0,
        delay: float | Array = 0.0,
        ki: float | Array = 0.0,
    ) -> None:
        """``gain`` (joints,) 1/s of the position loop, ``tau_v`` s, ``tops`` (2, joints) rad/s upwards and
        downwards, the share of the setpoints' speed that the loop is ``fed``, how fast it runs, ``ahead``
        as in `servo_loop`, the ``delay`` in s of its setpoints, and ``ki`` as in `servo_loop`.
        """
        self._early = np.asarray(fed / gain)  # s of the setpoints' motion that it sees beforehand
        self.pace = QUICKER * np.sqrt(gain / tau_v)
        none, row = np.zeros_like(gain), np.zeros((1, len(gain)))
        self._late, self._answered = 2.0 / self.pace, 0.0
        self._delay = np.maximum(delay, 0.0)
        self._most = float(np.mean(self._late + self._delay))
        up, down = tops
        law = gain[None], row + tau_v, row + up, row + down, row, row, row, row, row, none, row
        self._law = *law, np.zeros((3, 1, len(gain))), unlimited(len(gain))
        self._ki, self._ahead = row + ki, ahead

    @property
    def sight(self) -> float:
        """s from now for which it should be told where the motors are wanted: until the next setpoint, and in
        motion as far as filter and delay are late, lest what `ahead` adds turns back at the end.
        """
        return self._period + self._seen

    def elapse(self, dt: float) -> None:
        """The last setpoint has been out for ``dt`` s."""
        self._servo = self._after(self._servo, self._sent, self._sent - self._last, dt)
        usual = self._period or dt
        late = min(max(dt - usual, -usual), usual)  # a setpoint holds until the next one comes
        self._began = self._wanted + self._slope * late
        if dt > 0.0:
            self._periods = min(self._periods + 1, PERIODS)
            self._period = usual + late / self._periods

    def ahead(self, velocity: Array, acceleration: Array) -> Array:
        """How far motors that are wanted with these derivatives (joints,) have to run ahead for the filter,
        which takes them to go straight for each period, and the delay, besides what is in sight.
        """
        seen = self._seen - self._delay
        late = self._late - seen
        bend = self._late**2 / 4.0 - seen * late - (seen**2 / 2.0 + self._period**2 / 12.0)
        self._still = 0.0 if velocity.any() or acceleration.any() else self._still + self._period
        if self._still == 0.0:
            self._seen = min(self._seen + self._period, self._most)
        elif self._still >= self._seen:  # the end is not only in sight: nothing turns back to it
            self._seen = 0.0
        return late * velocity + bend * acceleration

    def setpoint(self, wanted: Array) -> Array:
        """What brings the motors in a period to where they are ``wanted`` (joints,) rad by then."""
        if self._period == 0.0:
            return wanted
        self._slope, self._wanted = (wanted - self._began) / self._period, wanted
        goal = np.empty((2, len(wanted)))
        filtered(self._servo, self._began, self._slope, self.pace, self._period, goal)
        beside = self._share * (goal[0] - self._last)
        comes = self._after(self._servo, goal[0], beside, self._period)[:2]
        asked = goal[0] + (self._answer() * (goal - comes)).sum(0)
        early = self._early / self._period
        return np.asarray((asked + early * self._last) / (1.0 + early))

    def _answer(self) -> Array:
        """(2, joints): what a setpoint that is to change angle [rad] and speed [rad/s] in a period has to be
        more.
        """
        if abs(self._period - self._answered) > SAME * self._period:
            rest, tried = np.zeros_like(self._servo), TRIED + 0.0 * self.pace
            comes = self._after(rest, tried, self._share * tried, self._period)[:2] / TRIED
            weighed = comes * [np.ones_like(self.pace), (SPEED / self.pace) ** 2]
            self._answered, self._answers = self._period, weighed / (weighed * comes).sum(0)
        return self._answers

    def follow(self, wanted: Array) -> Array:
        """The same of motors that go where they are ``wanted`` by themselves."""
        self._wanted, self._slope, self._seen = wanted, np.zeros_like(wanted), 0.0
        return wanted

    def sent(self, setpoint: Array) -> Array:
        """What goes out."""
        moved = (setpoint - self._last) / self._period if self._period > 0.0 else np.zeros_like(setpoint)
        self._sent, self._last = setpoint + self._early * moved, setpoint
        return setpoint

    @property
    def _share(self) -> Array:
        """(joints,) of what the loop is told that its speed is, and not the setpoint."""
        return self._early / (self._period + self._early)

    def _after(self, servo: Array, setpoint: Array, beside: Array, dt: float) -> Array:
        """The ``servo``'s state ``dt`` s later, with what a ``setpoint`` (joints,) is fed ``beside``."""
        after, held = servo.copy(), np.array([setpoint, setpoint])
        fed = np.array([beside, beside])
        servo_loop(
            held,
            np.array([0.0, dt]),
            *self._law,
            self._ki,
            fed,
            self._ahead,
            1,
            after,
            np.empty((1, len(setpoint))),
        )
        return after


@compiled
def filtered(servo: Array, began: Array, slope: Array, pace: Array, period: float, goal: Array) -> None:
    """Angle and speed (2, columns) to which the filter takes motors in a ``period`` in which they are wanted
    from ``began`` on with a ``slope`` (columns,).
    """
    for j in range(len(began)):
        w = pace[j]
        stays = began[j] - 2.0 * slope[j] / w
        lag, gains = servo[0, j] - stays, servo[1, j] - slope[j]
        gains += w * lag
        left = np.exp(-w * period)
        goal[0, j] = stays + slope[j] * period + (lag + gains * period) * left
        goal[1, j] = slope[j] + (gains - w * (lag + gains * period)) * left
