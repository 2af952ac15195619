import subprocess
import sys

PROGRAM = """
import sys
import numpy as np
from robot_agent.perception.kalman import KalmanFilter

heavy = [name for name in ("scipy.stats", "scipy.ndimage") if name in sys.modules]
filter = KalmanFilter(dim_x=1, dim_z=1)
filter.H = np.eye(1)
filter.predict()
filter.update(np.ones(1))
likelihood = filter.log_likelihood

import scipy.ndimage
import scipy.stats
print(heavy, float(likelihood), scipy.stats.norm.logpdf(1.0, scale=3.0**0.5))
print(scipy.ndimage.shift([1.0, 2.0], 1).tolist())
"""


def test_deferred_scipy_modules_are_imported_on_use():
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True
    )
    first, second = done.stdout.splitlines()
    heavy, likelihood, expected = first.split(" ")
    assert heavy == "[]"
    assert abs(float(likelihood) - float(expected)) < 1e-9
    assert second == "[0.0, 1.0]"
