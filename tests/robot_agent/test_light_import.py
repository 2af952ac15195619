"""What an agent takes from filterpy and scikit-fuzzy brings no SciPy with it."""

import subprocess
import sys

AGENT = """
import sys
import tools.deploy.onboard_process
print([name for name in sys.modules if name.partition(".")[0] in ("scipy", "matplotlib")])
"""
OPTIONS = """
import sys
import tools.commands.agent
print([name for name in ("numpy", "cv2", "msgspec") if name in sys.modules])
"""
FILTER = """
import numpy as np
from robot_agent.perception.kalman import KalmanFilter

filter = KalmanFilter(dim_x=1, dim_z=1)
filter.H = np.eye(1)
filter.predict()
filter.update(np.ones(1))
likelihood = filter.log_likelihood

import scipy.ndimage
import scipy.stats
print(float(likelihood), scipy.stats.norm.logpdf(1.0, scale=3.0**0.5))
print(scipy.ndimage.shift([1.0, 2.0], 1).tolist())
"""
CLUSTERS = """
import numpy as np
from robot_agent.light_import import import_lightly

cluster = import_lightly("skfuzzy.cluster")
centers, *_ = cluster.cmeans(np.array([[0.0, 0.1, 5.0, 5.1]]), 2, 2.0, 1e-4, 100, seed=1)
print(np.allclose(np.sort(centers[:, 0]), (0.05, 5.05), atol=0.01))
"""


def output_of(code: str) -> list[str]:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def test_agent_imports_no_scipy():
    assert output_of(AGENT) == ["[]"]


def test_service_is_ready_before_the_heavy_imports():
    assert output_of(OPTIONS) == ["[]"]


def test_filter_imports_scipy_when_it_uses_it():
    figures, shifted = output_of(FILTER)
    likelihood, expected = figures.split(" ")
    assert abs(float(likelihood) - float(expected)) < 1e-9
    assert shifted == "[0.0, 1.0]"


def test_clustering_imports_scipy_when_it_uses_it():
    assert output_of(CLUSTERS) == ["True"]
