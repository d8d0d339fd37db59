"""Runs of the tests beside each other."""

import subprocess
import sys

from test.nodes.graph import ROOT, new_domain


def test_two_runs_at_the_same_time_use_different_domains():
    mine = {new_domain() for _ in range(10)}
    script = "from test.nodes.graph import new_domain; print(*(new_domain() for _ in range(61)))"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert not mine & {int(domain) for domain in done.stdout.split()}
