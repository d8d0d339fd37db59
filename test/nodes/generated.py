"""control_msgs for tests where it is not installed: its interfaces, as far as the nodes use them, generated
with the rosidl wheels and compiled into one library.

PyPI has the generators but neither control_msgs nor ament_cmake, so the generators are called one by one.
"""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

PACKAGE = "control_msgs"
NEEDED = ("rosidl_adapter", "rosidl_generator_py", "rosidl_typesupport_fastrtps_c", "lark", "em")
KINDS = ("rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c")
DEPENDENCIES = (
    "trajectory_msgs", "std_msgs", "geometry_msgs", "builtin_interfaces",
    "unique_identifier_msgs", "service_msgs", "action_msgs",
)  # fmt: skip
POINT, MULTI = "trajectory_msgs/JointTrajectoryPoint", "trajectory_msgs/MultiDOFJointTrajectoryPoint"


def lines(*kinds_and_names: tuple[str, str]) -> str:
    """Fields, one a line; a name with commas stands for several of the kind."""
    return "\n".join(f"{kind} {name}" for kind, names in kinds_and_names for name in names.split(", "))


DEFINITIONS = {
    "msg/JointTolerance.msg": lines(("string", "name"), ("float64", "position, velocity, acceleration")),
    "msg/JointComponentTolerance.msg": lines(
        ("string", "joint_name"), ("uint16", "component"), ("float64", "position, velocity, acceleration")
    ),
    "msg/JointTrajectoryControllerState.msg": lines(
        ("std_msgs/Header", "header"),
        ("string[]", "joint_names"),
        (POINT, "reference, feedback, error, output"),
        ("string[]", "multi_dof_joint_names"),
        (MULTI, "multi_dof_reference, multi_dof_feedback, multi_dof_error, multi_dof_output"),
        ("float64", "speed_scaling_factor"),
    ),
    "action/FollowJointTrajectory.action": "\n---\n".join(
        [
            lines(
                ("trajectory_msgs/JointTrajectory", "trajectory"),
                ("trajectory_msgs/MultiDOFJointTrajectory", "multi_dof_trajectory"),
                ("JointTolerance[]", "path_tolerance"),
                ("JointComponentTolerance[]", "component_path_tolerance"),
                ("JointTolerance[]", "goal_tolerance"),
                ("JointComponentTolerance[]", "component_goal_tolerance"),
                ("builtin_interfaces/Duration", "goal_time_tolerance"),
            ),
            lines(
                ("int32", "error_code"),
                ("int32", "SUCCESSFUL=0, INVALID_GOAL=-1, INVALID_JOINTS=-2, OLD_HEADER_TIMESTAMP=-3"),
                ("int32", "PATH_TOLERANCE_VIOLATED=-4, GOAL_TOLERANCE_VIOLATED=-5"),
                ("string", "error_string"),
            ),
            lines(
                ("std_msgs/Header", "header"),
                ("string[]", "joint_names"),
                (POINT, "desired, actual, error"),
                ("string[]", "multi_dof_joint_names"),
                (MULTI, "multi_dof_desired, multi_dof_actual, multi_dof_error"),
            ),
        ]
    ),
}


def lacking() -> str:
    """What is missing to generate it, "" where nothing is."""
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    missing += [name for name in ("gcc", "g++") if shutil.which(name) is None]
    if not Path(sysconfig.get_paths()["include"], "Python.h").exists():
        missing.append("Python.h")
    return ", ".join(missing)


def generate(folder: Path) -> None:
    """Put the package ``control_msgs`` into a folder for sys.path."""
    command = [sys.executable, "-m", "test.nodes.generated", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=Path(__file__).parents[2])
    assert done.returncode == 0, done.stderr


def main(folder: Path) -> None:
    """Generate, compile and link."""
    package, apart = folder / PACKAGE, folder / "apart" / PACKAGE
    sources = generated_code(translated(package), package, apart)
    library = f"{PACKAGE}_s__rosidl_typesupport_c{sysconfig.get_config_var('EXT_SUFFIX')}"
    link(package / library, [compiled(source, folder) for source in sources] + libraries())
    # rmw loads a library by the name of each kind of type support: an empty one that leads to the real one
    stubs = [f"lib{PACKAGE}__{kind}.so" for kind in KINDS]
    for stub in stubs:
        link(package / stub, ["-Wl,--no-as-needed", "-Wl,-rpath,$ORIGIN", str(package / library)])
    (package / "__init__.py").write_text(
        "import ctypes, pathlib\n"
        f"for stub in {stubs!r}:\n    ctypes.CDLL(str(pathlib.Path(__file__).parent / stub))\n"
    )


def translated(package: Path) -> list[str]:
    """The definitions as IDL files, named as the generators want it."""
    from rosidl_adapter import convert_to_idl

    named = []
    for name, text in DEFINITIONS.items():
        path = package / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text + "\n")
        convert_to_idl(package, PACKAGE, Path(name), package)
        named.append(f"{package}:{Path(name).with_suffix('.idl')}")
    return named


def generated_code(idl: list[str], package: Path, apart: Path) -> list[Path]:
    """C and C++ sources; introspection goes apart, as its files have the names of others."""
    from rosidl_generator_c.cli import GenerateC
    from rosidl_generator_py.cli import GeneratePython
    from rosidl_generator_type_description.cli import HashTypeDescription
    from rosidl_typesupport_c.cli import GenerateCTypesupport
    from rosidl_typesupport_fastrtps_c.cli import GenerateFastRTPSCTypesupport
    from rosidl_typesupport_introspection_c.cli import GenerateIntrospectionCTypesupport

    common = (PACKAGE, idl, [str(Path(sys.prefix, "share")), str(package.parent)])
    hashes = HashTypeDescription("hash").generate_type_hashes(*common, package)
    GenerateC("c").generate(*common, package, hashes)
    GenerateFastRTPSCTypesupport("fastrtps").generate(*common, package)
    GenerateCTypesupport("c", typesupport_implementations=list(KINDS)).generate(*common, package)
    GeneratePython("py", typesupport_implementations=["rosidl_typesupport_c"]).generate(*common, package)
    GenerateIntrospectionCTypesupport("introspection").generate(*common, apart)
    found = [path for each in (package, apart) for path in sorted(each.rglob("*"))]
    return [path for path in found if path.suffix in (".c", ".cpp")]


def compiled(source: Path, folder: Path) -> str:
    """The object file of a source."""
    import numpy as np

    include = Path(sys.prefix, "include")
    places = [include, *sorted(include.iterdir()), folder, folder / "apart"]
    places += [Path(sysconfig.get_paths()["include"]), Path(np.get_include())]
    out = f"{source}.o"
    compiler = "g++" if source.suffix == ".cpp" else "gcc"
    options = ["-c", "-O0", "-fPIC", "-w", *(f"-I{place}" for place in places)]
    subprocess.run([compiler, *options, str(source), "-o", out], check=True)
    return out


def libraries() -> list[str]:
    """What the code refers to, from the wheels."""
    place = Path(sys.prefix, "lib")
    kinds = ("rosidl_generator_c", "rosidl_generator_py", "rosidl_typesupport_c", *KINDS)
    own = [str(place / f"lib{package}__{kind}.so") for package in DEPENDENCIES for kind in kinds]
    names = ("rosidl_runtime_c", "rosidl_typesupport_c", *KINDS, "rosidl_typesupport_fastrtps_cpp", "fastcdr")
    return [*own, f"-L{place}", *(f"-l{name}" for name in names), "-lrcutils", f"-Wl,-rpath,{place}"]


def link(library: Path, parts: list[str]) -> None:
    """A shared library of parts, found by its name once it is loaded."""
    command = ["g++", "-shared", f"-Wl,-soname,{library.name}", "-o", str(library), *parts]
    subprocess.run(command, check=True)


if __name__ == "__main__":
    from trunk_ros.nodes.graph import ros  # noqa: F401  finds the wheels' packages

    main(Path(sys.argv[1]))
