"""Runs of the tests beside each other."""

import subprocess
import sys
from contextlib import ExitStack

from test.nodes.domains import COUNT, own_domain
from test.nodes.graph import ROOT, Peer, needs_ros


def test_two_runs_at_the_same_time_use_different_domains():
    script = (
        "from contextlib import ExitStack\n"
        "from test.nodes.domains import COUNT, own_domain\n"
        "with ExitStack() as stack:\n"
        "    print(*(stack.enter_context(own_domain()) for _ in range(COUNT // 4)))\n"
    )
    with ExitStack() as stack:
        mine = {stack.enter_context(own_domain()) for _ in range(COUNT // 4)}
        done = subprocess.run(
            [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True
        )
    theirs = {int(domain) for domain in done.stdout.split()}
    assert len(mine) == len(theirs) == COUNT // 4
    assert not mine & theirs


@needs_ros
def test_a_peer_that_has_closed_is_not_on_its_domain_any_more(domain, peer):
    from trunk_ros.nodes.graph.ros import JointState

    topic = "/trunk/gearbox_states"
    with Peer(domain) as former:  # whose name keeps it alive, as a test's frame does
        former.publisher(JointState, topic)
        former.listen(JointState, topic)
        former.spin_once()
        peer.until(lambda: peer.node.count_publishers(topic) and peer.node.count_subscribers(topic))
    peer.until(lambda: not peer.node.count_publishers(topic) and not peer.node.count_subscribers(topic))
