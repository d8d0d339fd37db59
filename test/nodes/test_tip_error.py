"""The tip's path beside a model's, and RViz's view of it."""

import itertools

import numpy as np
import yaml

from test.nodes.graph import ROOT, needs_ros

pytestmark = needs_ros
SECOND = 10**9
OFF = np.array([0.003, 0.0, 0.0])  # m


def view():
    tree = yaml.safe_load((ROOT / "config" / "trunk.rviz").read_text())
    displays = tree["Visualization Manager"]["Displays"]
    return {display["Name"].split("'")[0].strip(): display for display in displays}


def line(stamp):
    """A tip on a straight line."""
    return np.array([0.0, 0.1, 0.2]) * stamp / SECOND


def test_each_pose_is_compared_once_with_what_the_model_had_then():
    from trunk_ros.nodes.tip_error import Beside

    rng = np.random.default_rng(2)
    seen = [(int(stamp), "seen") for stamp in np.cumsum(rng.integers(1, 30, 100)) * 10**6]
    model = [(int(stamp), "model") for stamp in np.arange(-1, 200) * 10**7]
    beside, found = Beside(), []
    for stamp, which in sorted(seen + model):
        if which == "seen":
            found += beside.seen(stamp, stamp, line(stamp) + OFF)
        else:
            found += beside.predicted(stamp, line(stamp))
    assert [header for header, _, _ in found] == [stamp for stamp, _ in seen]
    np.testing.assert_allclose([error for _, _, error in found], 0.003, atol=1e-12)


def test_poses_from_before_the_model_are_left_out_and_time_may_be_set_back():
    from trunk_ros.nodes.tip_error import Beside

    beside = Beside()
    assert beside.seen(SECOND, "early", line(SECOND)) == []
    assert beside.predicted(2 * SECOND, line(2 * SECOND)) == []
    assert len(beside.seen(2 * SECOND, "same", line(0))) == 1
    assert beside.predicted(SECOND, line(SECOND)) == []
    ((header, _, error),) = beside.seen(SECOND, "again", line(SECOND))
    assert (header, error) == ("again", 0.0)


def test_the_cloud_has_the_error_where_rviz_looks_for_it():
    from trunk_ros.nodes.graph.ros import PoseStamped
    from trunk_ros.nodes.tip_error import cloud

    message = cloud(PoseStamped().header, np.array([0.1, 0.2, 0.3]), 0.004)
    kind = np.dtype(
        {
            "names": [field.name for field in message.fields],
            "formats": ["<f4"] * 4,
            "offsets": [field.offset for field in message.fields],
            "itemsize": message.point_step,
        }
    )
    (point,) = np.frombuffer(bytes(message.data), kind)
    path = view()["tip"]
    assert path["Color Transformer"] == "Intensity"
    assert point[path["Channel Name"]] == np.float32(0.004)
    assert [point[axis] for axis in "xyz"] == [np.float32(value) for value in (0.1, 0.2, 0.3)]


def test_rviz_shows_topics_and_frames_that_the_launch_file_makes():
    from trunk_ros.nodes.tip_error import TipError
    from trunk_ros.nodes.wire_elasticity import WireElasticity

    launch = (ROOT / "launch" / "rviz.launch.py").read_text()
    models = {name: view()[name] for name in ("measured", "nominal", "fitted")}
    for name, each in itertools.islice(models.items(), 1, None):
        assert f'"{name}"' in launch
        assert each["TF Prefix"] == name
        assert each["Description Topic"]["Value"] == f"/{name}/robot_description"
    assert models["measured"]["TF Prefix"] == ""
    assert view()["tip"]["Topic"]["Value"] == "/trunk/tip_error"
    assert {each.name: each.default for each in TipError.OWN}["predicted"] == "fitted/trunk/tip_pose"
    frame = {each.name: each.default for each in WireElasticity.OWN}["base_frame"]
    assert f'"--frame-id", "{frame or "base_link"}"' in launch
