"""The lines of the architecture, held by reading every import."""

import pytest

from test.packaging.imports import ROOT, imported, modules, reached, within

ROS = ("rclpy", "launch", "launch_ros", "ament_index_python", "sensor_msgs", "std_msgs", "trajectory_msgs")


@pytest.mark.parametrize("path", modules("trunk_ros"), ids=lambda path: str(path.relative_to(ROOT)))
def test_only_nodes_import_ros(path):
    if "nodes" not in path.parts:
        assert not within(imported(path), *ROS)


def test_what_proves_the_diagnosis_shares_no_physics_with_it():
    plants = modules("test/concealed")
    assert plants
    assert not within(reached(plants), "trunk_ros.effects", "trunk_ros.chain")


def test_no_file_of_the_package_has_grown_beyond_300_lines():
    lengths = {str(path.relative_to(ROOT)): path.read_text().count("\n") for path in modules("trunk_ros")}
    assert {name: length for name, length in lengths.items() if length > 300} == {}


def test_reading_imports_sees_through_functions_packages_and_import_module(tmp_path):
    seen = tmp_path / "seen.py"
    seen.write_text("import a.b\ndef f():\n    from c import d\n    importlib.import_module('e')\n")
    assert imported(seen) == {"a.b", "c", "c.d", "e"}
    assert within({"rclpy.node", "rclpython"}, "rclpy") == ["rclpy.node"]
