"""bringup: all nodes with a trajectory, recorded; in one process or several, real or simulated time."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable
from typing import Any

from trunk_ros.console.console import Level, asked
from trunk_ros.console.console import say as tell
from trunk_ros.errors import TrunkError
from trunk_ros.nodes.graph.losses import left_out
from trunk_ros.nodes.run.arguments import PARTS
from trunk_ros.nodes.run.plan import PUBLISHED, Plan, plan_of
from trunk_ros.recording.bag.metadata import read_metadata

LAG = 500  # messages of a topic that the recorder may be behind
CHAIN = [part for part in PARTS if part != "recorder"]


def main(argv: list[str]) -> int:
    """Run and record: 0 when done or asked to end; 2 when the trajectory was refused, or a node gave up for a
    reason outside of it, such as a full disk; 1 for any other. Raises TrunkError at first.
    """
    plan = plan_of(argv)
    from trunk_ros.nodes.graph.process import start_ros
    from trunk_ros.nodes.graph.ros import rclpy
    from trunk_ros.nodes.stop import Stop

    if plan.trajectory is not None and plan.trajectory.duration > plan.seconds:
        note(f"the trajectory takes {plan.trajectory.duration:.4g} s, the run ends after {plan.seconds:g} s")
    stop = Stop()
    start_ros(plan.ros_arguments)
    try:
        fault, code = run_apart(plan, stop) if plan.apart else run_together(plan, stop)
    finally:
        stop.ignore()
        rclpy.try_shutdown()
    summarise(plan)
    if fault:
        say(f"ended early: {fault}")
    return code if fault else 0


def say(text: str) -> None:
    """One line for the user: why it ended early."""
    print(f"bringup: {text}", file=sys.stderr, flush=True)


def note(text: str) -> None:
    """One line on how the run goes, unless the command was asked to be quiet."""
    if asked() > Level.QUIET:
        say(text)


def make_pacer(plan: Plan) -> Any:
    """The node that gives the run its time."""
    from trunk_ros.arm.urdf import urdf
    from trunk_ros.nodes.graph.progress import Ledger
    from trunk_ros.nodes.run.pacer import NEEDED, Pace, Pacer

    foreign = tuple(topic for part, topic in PUBLISHED.items() if part not in plan.parts)
    description = "" if "wire_elasticity" in plan.parts else urdf(plan.arm)
    arm = plan.arm if NEEDED in foreign and not plan.simulated else None
    pace = Pace(plan.seconds, plan.rate, plan.simulated, plan.trajectory, foreign, description, arm)
    pacer = Pacer(pace, Ledger([]), note)
    names = {part: pacer.own(part) for part in plan.parts}
    pacer.ledger.nodes += names.values()
    if "recorder" in names:
        pacer.ledger.lagging[names["recorder"]] = LAG
    return pacer


def run_together(plan: Plan, stop: Any) -> tuple[str, int]:
    """All nodes in this process; returns why it ended early, "" otherwise, and the exit code for that."""
    from trunk_ros.nodes.graph.managed import end, retire, start
    from trunk_ros.nodes.graph.process import DELIVERY, serve_for
    from trunk_ros.nodes.graph.ros import EventsExecutor

    make_room(plan)
    pacer = make_pacer(plan)
    executor = EventsExecutor()
    executor.add_node(pacer)
    nodes: dict[str, Any] = {}
    try:
        for part in plan.parts:
            nodes[part] = make_node(part, plan.parameters(part))
            nodes[part].report.listener = pacer.note
            start(nodes[part])
            executor.add_node(nodes[part])
        pump(executor, pacer, stop, lambda: first_fault(nodes), lambda: pacer.phase == "done")
        for part in CHAIN:
            if part in nodes:
                retire(nodes[part])
        serve_for(DELIVERY, executor, pacer)
    finally:
        for part in [*CHAIN, "recorder"]:
            if part in nodes:
                end(nodes[part], DELIVERY)
    given_up = first_fault(nodes)
    return pacer.fault or given_up, 2 if given_up or pacer.refused else 1


def make_node(part: str, parameters: dict[str, Any]) -> Any:
    """One of the nodes with parameters."""
    from trunk_ros.nodes.compensator import Compensator
    from trunk_ros.nodes.graph.ros import Parameter
    from trunk_ros.nodes.recorder import Recorder
    from trunk_ros.nodes.servo_driver import ServoDriver
    from trunk_ros.nodes.wire_elasticity import WireElasticity

    kinds = {kind.NAME: kind for kind in (ServoDriver, WireElasticity, Compensator, Recorder)}
    return kinds[part](
        parameter_overrides=[Parameter(name, value=value) for name, value in parameters.items()]
    )


def run_apart(plan: Plan, stop: Any) -> tuple[str, int]:
    """Each node in a process of its own; returns why it ended early, "" otherwise, and the exit code."""
    from trunk_ros.nodes.graph.ros import EventsExecutor
    from trunk_ros.nodes.run.child_processes import Processes

    make_room(plan)
    pacer = make_pacer(plan)
    executor = EventsExecutor()
    executor.add_node(pacer)
    processes = Processes(plan.ros_arguments)
    try:
        for part in plan.parts:
            if part != "recorder":
                processes.start(part, plan.parameters(part))
        pump(executor, pacer, stop, processes.ended, lambda: pacer.ledger.missing() == recorder_of(pacer))
        if "recorder" in plan.parts:
            processes.start("recorder", plan.parameters("recorder"))
        pump(executor, pacer, stop, processes.ended, lambda: pacer.phase == "done")
        if stop.asked:
            note("asked to end: closing the recording")
        processes.stop(CHAIN)
        processes.stop(["recorder"])
    finally:
        processes.close()
    return str(pacer.fault), 2 if pacer.refused else processes.code


def first_fault(nodes: dict[str, Any]) -> str:
    """Why a node gave up, "" where none did."""
    return next((str(node.fault) for node in nodes.values() if node.fault), "")


def recorder_of(pacer: Any) -> list[str]:
    """The recorder's name, in a list, where there is one."""
    return list(pacer.ledger.lagging)


def pump(executor: Any, pacer: Any, stop: Any, trouble: Callable[[], str], over: Callable[[], bool]) -> None:
    """Serve callbacks until it is over, somebody asks to end, or something is wrong."""
    from trunk_ros.nodes.graph.process import serve

    def ended() -> bool:
        pacer.fault = pacer.fault or trouble()
        return bool(over() or stop.asked or pacer.fault)

    if not ended():
        serve(executor, pacer, ended)


def make_room(plan: Plan) -> None:
    """Remove the recording that is to be replaced."""
    if plan.output is None or not plan.overwrite:
        return
    if plan.output.is_symlink() or plan.output.is_file():
        plan.output.unlink()
    elif plan.output.exists():
        shutil.rmtree(plan.output)


def summarise(plan: Plan) -> None:
    """Say where the bag is, what it holds, and what was lost."""
    if plan.output is None:
        return
    try:
        bag = read_metadata(plan.output)
    except (OSError, TrunkError) as error:
        say(f"no whole recording at {plan.output}: {error}")
        return
    losses = json.loads(bag.custom.get("trunk_ros.loss", "{}"))
    tell(f"{plan.output}: {sum(bag.messages.values())} messages")
    wide = max(map(len, bag.messages), default=0)
    for topic, count in sorted(bag.messages.items()):
        lost = losses.get(topic, {})
        missing = int(lost.get("lost", 0) + lost.get("dropped", 0))
        tell(f"  {topic:{wide}} {count:8d}" + (f"   lost {missing} of {count + missing}" if missing else ""))
        if others := left_out(lost):
            tell(f"  {topic:{wide}} {others}")
    tell(f"lost: {sum(int(each['lost'] + each['dropped']) for each in losses.values())}")
