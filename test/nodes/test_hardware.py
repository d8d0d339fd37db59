"""The bus in docs/hardware.md drives motors that are not ours."""

import re
import signal
import socket
import threading

import numpy as np
import pytest

from test.nodes.graph import JOINTS, ROOT, ended, needs_ros, running, words

pytestmark = needs_ros


class Box:
    """What stands at the other end of the page's bus: motors that are where they are asked to be."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.port = self.socket.getsockname()[1]
        self.angle, self.heard, self.deaf = np.full(5, 0.05), [], False
        self.thread = threading.Thread(target=self.serve)
        self.thread.start()

    def serve(self):
        while (text := self.socket.recvfrom(4096))[0] != b"end":
            question, client = text[0].decode(), text[1]
            self.heard.append(question)
            if self.deaf:
                continue
            if question not in ("?", "hold"):
                self.angle = np.array(question.split(), dtype=float)
            answer = np.concatenate([self.angle, np.zeros(5), np.full(5, 0.01)])
            self.socket.sendto(" ".join(map(str, answer)).encode(), client)

    def close(self):
        self.socket.sendto(b"end", ("127.0.0.1", self.port))
        self.thread.join()
        self.socket.close()


@pytest.fixture
def box(tmp_path, monkeypatch):
    """A box, and the page's bus as a module that leads to it."""
    there = Box()
    code = re.search(r"```python\n(.*?)```", (ROOT / "docs" / "hardware.md").read_text(), re.DOTALL).group(1)
    (tmp_path / "my_arm.py").write_text(code.replace("9870", str(there.port)))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    yield there
    there.close()


def test_the_bus_of_the_page_drives_motors_survives_their_silence_and_leaves_them_holding(box, domain, peer):
    from trunk_ros.nodes.graph.ros import DiagnosticArray, JointState

    out = peer.publisher(JointState, "trunk/setpoints")
    states = peer.listen(JointState, "trunk/gearbox_states")
    said = peer.listen(DiagnosticArray, "diagnostics")
    with running("servo_driver", "--ros-args", "-p", "bus:=my_arm:UdpBus", domain=domain) as process:
        peer.meets(out, node="servo_driver")
        peer.until(lambda: states)
        np.testing.assert_allclose(states[-1].position, 0.05)
        np.testing.assert_allclose(states[-1].effort, 0.01)
        message = JointState(name=JOINTS, position=[0.1, 0.2, 0.3, -0.1, 0.0])
        message.header.stamp = peer.now()
        out.publish(message)
        peer.until(lambda: states[-1].position[2] == pytest.approx(0.3))
        box.deaf = True
        peer.until(lambda: "the motors do not answer" in words(said, "servo_driver"))
        box.deaf = False
        peer.more(states, 10)
        code, _, error = ended(process, signal.SIGTERM)
    assert code == 0, error
    peer.until(lambda: box.heard[-1] == "hold")


@pytest.mark.parametrize("name", ["nowhere:Bus", "trunk_ros.nodes.bus:Nothing", "motors"])
def test_a_bus_that_there_is_not_is_refused_in_one_line(command, name):
    done = command("servo_driver", "--ros-args", "-p", f"bus:={name}")
    assert done.returncode == 2
    assert "neither simulated nor MODULE:CLASS" in done.stderr
    assert len(done.stderr.splitlines()) == 1, done.stderr
