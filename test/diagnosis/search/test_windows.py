"""What windows of time gain is told from sums between their edges."""

import numpy as np
import pytest

from trunk_ros.diagnosis.search.windows import Prices, Sums, best_window
from trunk_ros.effects import effect
from trunk_ros.effects.effect import Now


def test_sums_until_each_edge_hold_all_samples_before_it() -> None:
    rng = np.random.default_rng(1)
    stamp = np.sort(rng.uniform(2.0, 60.0, 500))
    rest, d, q = rng.normal(size=500), rng.normal(size=500), rng.normal(size=(500, 3))
    edges = np.sort(
        np.concatenate([[-np.inf, 0.0, 61.0, np.inf], stamp[[7, 7, 499]], rng.uniform(0.0, 62.0, 700)])
    )
    seen = Sums.of(edges, stamp, rest, d, q)
    before = stamp[None, :] < edges[:, None]
    np.testing.assert_allclose(seen.rd, [before @ (rest * d), before @ (rest * d * stamp)], atol=1e-9)
    np.testing.assert_allclose(seen.dd[2], before @ (d * d * stamp**2), rtol=1e-12)
    np.testing.assert_allclose(seen.qd[1], before @ (q * (d * stamp)[:, None]), atol=1e-9)


@pytest.mark.parametrize(
    ("length", "at", "found"), [(3600.0, 25.0, True), (120.0, 5.0, True), (120.0, 2.5, False)]
)
def test_a_moment_is_told_from_20_s_on_or_from_a_small_share_of_short_recordings(
    length: float, at: float, found: bool
) -> None:
    stamp = np.arange(0.0, length, 0.1)
    noise, one = np.random.default_rng(2).normal(size=len(stamp)), np.ones((len(stamp), 1))
    d, acts = np.sin(stamp), 9.0 * (stamp > at)
    seen = (stamp, acts * d + noise, d, one[:, :0])
    window = best_window([seen], stamp, (0.1, 100.0), Prices(20.0, 20.0))
    assert window is None or (abs(window.moments["from"] - at) < 0.6) == found
    assert window is not None or not found
    now = Now(stamp, 0.1 * one[:, 0], one, one, one, one, one, ("joint_1",), np.ones(1))
    onsets = [start["onset"] for start in effect("wire_slip")({}, {}).starts(now, 0, acts + noise)]
    assert any(abs(onset - at) < 0.6 for onset in onsets) == found
