"""What windows of time gain is told from sums between their edges."""

import numpy as np

from trunk_ros.diagnosis.search.windows import Sums


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
