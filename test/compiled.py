"""``python -m test.compiled``: numba compiles what a diagnosis takes, once for all processes that come: each
of those that begin together would do it.
"""

import numpy as np

from test.diagnosis.arms import diagnose, recorded

if __name__ == "__main__":
    lifted = {"compliance": np.full(5, 0.03), "payload": 0.1, "payload_from": 3.0}
    diagnose([recorded({"load_elasticity": lifted}, 8.0)])
