# PYTHON_ARGCOMPLETE_OK
"""The commands: ``python -m trunk_ros NAME`` everywhere, ``ros2 run trunk_ros NAME`` where ROS is
installed.
"""

from __future__ import annotations

import importlib
import io
import os
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

from trunk_ros import __version__
from trunk_ros.commands.completion import complete, quick_help
from trunk_ros.console.arguments import did_you_mean
from trunk_ros.console.console import Level, ask_for
from trunk_ros.errors import TrunkError, fault_in, one_line
from trunk_ros.nodes.stop import Stop

COMMANDS: dict[str, tuple[str, str]] = {
    "diagnose": ("trunk_ros.commands.diagnose", "name the effects that a simulation is missing, fit them"),
    "simulate": ("trunk_ros.commands.simulate", "run a model over a recording"),
    "show": ("trunk_ros.commands.show", "see a recording and a model: the arm in 3D, residuals, findings"),
    "evaluate": ("trunk_ros.commands.evaluate", "score models, or other simulators, on recordings"),
    "bodies": ("trunk_ros.commands.bodies", "fit friction, armature and the last link's mass to torque"),
    "export": ("trunk_ros.commands.export", "write what was found into a simulator's file: MJCF, URDF, SDF"),
    "fleet": ("trunk_ros.commands.fleet", "diagnose many recordings of many arms; report what changes"),
    "info": ("trunk_ros.commands.info", "what a recording holds, and what can be diagnosed from it"),
    "check": ("trunk_ros.commands.check", "check a model file, a mapping or a trajectory"),
    "effects": ("trunk_ros.commands.effects", "the effect library"),
    "import": ("trunk_ros.commands.import_table", "turn a foreign CSV, or a bag of other topics, into a bag"),
    "recover": ("trunk_ros.commands.recover", "repair a bag whose recorder was killed"),
    "paper": ("trunk_ros.commands.paper", "the paper's tables and figures, as printed and as computed"),
    "bringup": ("trunk_ros.nodes.bringup", "run the simulated arm with a trajectory and record it"),
    "servo_driver": ("trunk_ros.nodes.servo_driver", "node: setpoints to motor-side angles"),
    "wire_elasticity": (
        "trunk_ros.nodes.wire_elasticity",
        "node: motor-side angles to joint angles, wires and tip",
    ),
    "compensator": ("trunk_ros.nodes.compensator", "node: wanted joint angles to setpoints"),
    "recorder": ("trunk_ros.nodes.recorder", "node: every topic into an MCAP bag"),
    "tip_error": ("trunk_ros.nodes.tip_error", "node: the tip's path beside a model's, for RViz"),
    "reality": ("trunk_ros.nodes.reality", "node: adds what a simulator lacks, on its topics"),
    "replay": ("trunk_ros.nodes.replay", "node: a bag back onto topics"),
    "compose": ("trunk_ros.nodes.compose", "several of these nodes in one process"),
    "watch": ("trunk_ros.nodes.watch", "node: reports within seconds what changes on a running arm"),
}

MEANT = {  # by who knows the word from other tools
    "compare": "evaluate", "score": "evaluate", "fit": "diagnose", "identify": "diagnose", "plot": "show",
    "view": "show", "play": "replay", "record": "recorder", "convert": "import", "predict": "simulate",
    "sysid": "bodies",
}  # fmt: skip

WHOLE = ("diagnose", "simulate", "import")  # what they write is there once all of it is


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; as an installed script its name is that of the script. Returns the exit code."""
    if "_ARGCOMPLETE" in os.environ:
        complete(COMMANDS)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # names of files need not be UTF-8
    arguments = list(sys.argv[1:] if argv is None else argv)
    script = Path(sys.argv[0]).name
    name = script if argv is None and script in COMMANDS else (arguments.pop(0) if arguments else "--help")
    if name in ("-h", "--help", "help"):
        print(usage())
        return 0
    if name == "--version":
        print(__version__)
        return 0
    if name not in COMMANDS:
        near = f": did you mean {MEANT[name]}?" if name in MEANT else did_you_mean(name, COMMANDS)
        return _refuse(f"unknown command {name!r}{near or ': choose from ' + ', '.join(COMMANDS)}")
    return _run(name, arguments)


def usage() -> str:
    """One line a command."""
    lines = [f"  {name:16}{what}" for name, (_, what) in COMMANDS.items()]
    return "\n".join(["usage: trunk_ros COMMAND [arguments]   (COMMAND --help says more)", "", *lines])


def _run(name: str, arguments: list[str]) -> int:
    if {"-h", "--help"} & set(arguments) and (text := quick_help(name)):
        print(text)
        return 0
    if COMMANDS[name][0].startswith("trunk_ros.nodes."):
        Stop()  # importing takes seconds on a busy machine
    ask_for(Level.NORMAL)
    try:
        module = importlib.import_module(COMMANDS[name][0])
        return int(module.main(arguments))
    except TrunkError as error:
        return _refuse(str(error))
    except KeyboardInterrupt:
        print(f"trunk_ros: interrupted{', nothing was written' if name in WHOLE else ''}", file=sys.stderr)
        return 130
    except BrokenPipeError:
        sys.stderr.close()
        return 0
    except ModuleNotFoundError as error:
        if (error.name or "").startswith("trunk_ros"):
            return _our_fault()
        return _refuse(without_a_package(error.name or str(error)))
    except OSError as error:  # of the machine: no room, no permission, a name that is too long
        where = f"{error.filename}: " if error.filename else ""
        return _refuse(one_line(f"{where}{error.strerror or error}"))
    except Exception as error:
        said = fault_in(error)
        return _our_fault() if said is None else _refuse(one_line(said))


def without_a_package(name: str) -> str:
    """How to get at the packages that this Python lacks."""
    here = Path(__file__).resolve().parents[1]
    if (here / ".venv" / "bin" / "activate").exists() and Path(sys.prefix) != here / ".venv":
        return f"{sys.executable} has no {name}: run `source {here / '.venv' / 'bin' / 'activate'}` first"
    return (
        f"{sys.executable} has no {name}: run `make setup` and `source .venv/bin/activate`, "
        "or `pip install .`"
    )


def _our_fault() -> int:
    traceback.print_exc()
    print("trunk_ros: this is a fault of ours, please report it with the lines above", file=sys.stderr)
    return 1


def _refuse(message: str) -> int:
    print(f"trunk_ros: {message}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
