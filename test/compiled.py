"""``python -m test.compiled``: numba compiles what a diagnosis takes, once and for all processes to come, which
would each do it where they begin together.
"""

import numpy as np

from test.diagnosis.arms import diagnose, recorded

if __name__ == "__main__":
    lifted = {"compliance": np.full(5, 0.03), "payload": 0.1, "payload_from": 3.0}
    diagnose([recorded({"load_elasticity": lifted}, 8.0)])
