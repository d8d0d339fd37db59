"""``make demo``: an arm with hidden physics is driven over DDS, recorded, diagnosed; its model tried again.

What is hidden is drawn from a seed in the arm's own process; here it is looked at only after the verdict.
"""

from __future__ import annotations

import argparse
import json
import shutil
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import yaml
from rich.console import Console

from test.concealed.catalogue import CATALOGUE
from test.concealed.demo_picture import Comparison, draw
from test.concealed.demo_runs import Arm, DemoError, drive, followed, other_motion, trunk
from test.concealed.demo_table import answers, table
from test.concealed.hide import NOISE, hide
from test.concealed.nominal import Array
from test.concealed.removed import read_angles

SEED = 211
REST = 1.0  # s after a motion
OWN = ("run_*", "nominal", "fitted", "motion_*.yaml", "diagnosis*", "model.yaml", "report.html", "demo.png",
       "experiment*")  # fmt: skip
T = TypeVar("T")


def main(argv: list[str] | None = None) -> int:
    """0 where all that was hidden is named, 1 where not or a step failed, 130 after Ctrl-C."""
    asked = parser().parse_args(argv)
    ended = Ended()
    demo = Demo(Arm(asked.seed, asked.effects), Path(asked.output), asked.seconds)
    try:
        demo.check()
        good = demo.run()
        if asked.compensate:
            demo.compensate()
        ended.tell()
    except DemoError as error:
        print(f"demo: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("demo: ended by hand", file=sys.stderr)
        return 130
    return 0 if good else 1


class Ended:
    """Raises KeyboardInterrupt at SIGINT and SIGTERM, and remembers it: raised in a finalizer it is lost."""

    def __init__(self) -> None:
        self._asked = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._end)

    def _end(self, *_: Any) -> None:
        self._asked = True
        raise KeyboardInterrupt

    def tell(self) -> None:
        """Raise KeyboardInterrupt where a signal has come."""
        if self._asked:
            raise KeyboardInterrupt


def parser() -> argparse.ArgumentParser:
    """The arguments."""
    parse = argparse.ArgumentParser(prog="python -m test.concealed.demo", description=__doc__)
    add = parse.add_argument
    add("--seed", type=int, default=SEED, help=f"which arm; {SEED} by default")
    add(
        "--effects",
        default="",
        help=f"what to hide, comma separated, in place of drawn ones: {', '.join(CATALOGUE)}",
    )
    add("--seconds", type=float, default=30.0, help="length of each run, 30 by default")
    add("--output", default="demo-output", help="folder; what an earlier demo left in it is replaced")
    add(
        "--compensate",
        action="store_true",
        help="run the second motion again with the fitted model in the compensator",
    )
    return parse


class Demo:
    """The steps, each with a line."""

    def __init__(self, arm: Arm, folder: Path, seconds: float):
        self.arm, self.folder, self.seconds = arm, folder.absolute(), seconds
        wide = None if sys.stdout.isatty() else 120
        self.console = Console(highlight=False, soft_wrap=True, width=wide)
        self.found = self.folder / "diagnosis"
        self.began = time.monotonic()

    def check(self) -> None:
        """Raises DemoError for an arm that cannot be; makes room for the output."""
        try:
            hide(self.arm.seed, self._effects())
        except ValueError as error:
            raise DemoError(str(error)) from None
        self.folder.mkdir(parents=True, exist_ok=True)
        for pattern in OWN:
            for old in self.folder.glob(pattern):
                shutil.rmtree(old) if old.is_dir() else old.unlink()

    def _effects(self) -> list[str]:
        return self.arm.effects.split(",") if self.arm.effects else []

    def step(self, words: str, what: Callable[[], T]) -> T:
        """Do something, and say how long it took."""
        began = time.monotonic()
        with self.console.status(words):
            out = what()
        self.console.print(f"[green]✓[/] {words} [dim]({time.monotonic() - began:.0f} s)[/]")
        return out

    def run(self) -> bool:
        """The whole demo; whether all that was hidden is named."""
        self.console.print(f"[bold]A wire-driven arm with hidden physics[/] (seed {self.arm.seed})")
        self.record()
        verdict = self.step("diagnose it against the nominal simulation", self.diagnose)
        self.say(verdict)
        verdict = self.decide(verdict)
        good = self.reveal(verdict["findings"])
        self.judge(verdict)
        self.console.print(f"[dim]{time.monotonic() - self.began:.0f} s in all[/]")
        return good

    def record(self) -> None:
        """Two runs of the same arm with different motions."""
        out, motion = self.folder, self.folder / "motion_2.yaml"
        other_motion(motion, self.arm.seed, self.seconds)
        self.step(
            f"drive it over DDS with the real compensator, record {self.seconds:.0f} s of it",
            lambda: drive(self.arm, out / "run_1", self.seconds, 1),
        )
        self.step(
            "record a second run, another motion, to judge on",
            lambda: drive(self.arm, out / "run_2", self.seconds, 2, "--trajectory", motion),
        )

    def diagnose(self, *runs: str) -> dict[str, Any]:
        """diagnosis.json of the first run, or of ``runs``. Its folder stays where it was written, since the
        report's commands name it.
        """
        self.found = self.folder / ("diagnosis_2" if runs else "diagnosis")
        trunk("diagnose", *(self.folder / run for run in runs or ("run_1",)), "--output", self.found)
        verdict: dict[str, Any] = json.loads((self.found / "diagnosis.json").read_text())
        return verdict

    def decide(self, verdict: dict[str, Any]) -> dict[str, Any]:
        """Where the diagnosis proposes a motion that decides between equivalents, the hidden arm plays it;
        the verdict on both runs.
        """
        doubts = verdict["experiments"]
        for one in doubts:
            open_ = f"no motion within the limits tells {' from '.join(map(str, one['separates']))}"
            self.console.print(f"  {'proposed: ' + one['statement'] if one['trajectory'] else open_}")
        told = [one for one in doubts if one["trajectory"]]
        if not told:
            return verdict
        motion = self.found / told[0]["trajectory"]
        seconds = float(yaml.safe_load(motion.read_text())["points"][-1]["time_from_start"]) + REST
        self.console.print()
        self.step(
            f"play the proposed motion ({seconds:.0f} s) on the hidden arm",
            lambda: drive(self.arm, self.folder / "run_decisive", seconds, 3, "--trajectory", motion),
        )
        decided = self.step("diagnose both runs", lambda: self.diagnose("run_1", "run_decisive"))
        self.say(decided)
        for one in doubts:
            self.console.print(f"  [bold]{outcome(one['separates'], decided['findings'])}[/]")
        return decided

    def say(self, verdict: dict[str, Any]) -> None:
        """The verdict in its own words."""
        self.console.print(f"\n[bold]Verdict: {verdict['verdict'].replace('_', ' ')}[/]")
        for finding in verdict["findings"]:
            names = " or ".join([finding["effect"], *map(joined, finding["equivalents"])])
            sure = f"{finding['confidence']:.0%}" + (" that it is one of these" if " or " in names else "")
            self.console.print(f"  [cyan]{names}[/] ({sure}): {finding['statement']}")
        for rest in verdict["unexplained"]:
            self.console.print(f"  unexplained: {rest['statement']}")

    def reveal(self, findings: list[dict[str, Any]]) -> bool:
        """What was hidden beside what was said."""
        given, extra = answers([h.told() for h in hide(self.arm.seed, self._effects())], findings)
        self.console.print("\n[bold]What was hidden[/]")
        self.console.print(table(given))
        for one in extra:
            self.console.print(f"  [yellow]{one['effect']}[/] was said, but is not there")
        return all(answer.finding is not None for answer in given)

    def judge(self, verdict: dict[str, Any]) -> None:
        """The fitted model on the second run, in numbers and as a picture."""
        servo = any(finding["stage"] == "servo" for finding in verdict["findings"])
        source = "setpoints" if servo else "gearbox_states"
        self.console.print()
        comparison = self.step("simulate the second run, nominal and fitted", lambda: self.compare(source))
        draw(comparison, self.folder / "demo.png")
        before, after = (pooled(comparison.rms(x)) for x in (comparison.nominal, comparison.fitted))
        self.console.print(
            f"  error of the joint angles, mrad rms: "
            f"[bold]{1e3 * before:.3f} before, {1e3 * after:.3f} after[/]; "
            f"noise of the sensors {1e3 * NOISE:.3f}"
        )
        for path in (self.folder / "demo.png", self.found / "report.html", self.found / "model.yaml"):
            self.console.print(f"  {shown(path)}")

    def compare(self, source: str) -> Comparison:
        """Runs both models over the second run."""
        run = self.folder / "run_2"
        for name, model in (("nominal", "trunk"), ("fitted", self.found / "model.yaml")):
            trunk("simulate", run, "--model", model, "--output", self.folder / name, "--from", source)
        measured, nominal, fitted = (
            read_angles(bag, "joint_states") for bag in (run, self.folder / "nominal", self.folder / "fitted")
        )
        kept = np.isin(measured.stamp, nominal.stamp) & np.isin(measured.stamp, fitted.stamp)
        stamp = measured.stamp[kept]
        a, b, c = (x.angle[np.isin(x.stamp, stamp)] for x in (measured, nominal, fitted))
        return Comparison((stamp - stamp[0]) * 1e-9, a, b, c, NOISE)

    def compensate(self) -> None:
        """The second motion once more, with the fitted model in the compensator."""
        motion = ("--trajectory", self.folder / "motion_2.yaml", "--model", self.found / "model.yaml")
        words = "run the second motion again with the fitted model in the compensator"
        self.step(words, lambda: drive(self.arm, self.folder / "run_3", self.seconds, 4, *motion))
        before, after = (self.true_error(name) for name in ("run_2", "run_3"))
        self.console.print(
            f"  true joint angle less reference, mrad rms: "
            f"[bold]{1e3 * before:.3f} before, {1e3 * after:.3f} after[/]"
        )

    def true_error(self, run: str) -> float:
        """Of the true joint angle against the reference, rad rms."""
        wanted, true = followed(self.folder / run)
        return float(np.sqrt(((true - wanted) ** 2).mean()))


def joined(equivalent: str | list[str]) -> str:
    """An equivalent in words: one effect, or several together."""
    return equivalent if isinstance(equivalent, str) else " + ".join(equivalent)


def outcome(rivals: list[str], findings: list[dict[str, Any]]) -> str:
    """What a further run has decided between two effects."""
    for finding in findings:
        if finding["effect"] in rivals:
            (other,) = (name for name in rivals if name != finding["effect"])
            if other in map(joined, finding["equivalents"]):
                return f"Not decided: {finding['effect']} or {other}"
            return f"Decided: {finding['effect']}, not {other}"
    return f"Decided: neither {' nor '.join(rivals)}"


def pooled(rms: Array) -> float:
    """Over all joints."""
    return float(np.sqrt((rms**2).mean()))


def shown(path: Path) -> str:
    """As short as it can be."""
    here = Path.cwd()
    return str(path.relative_to(here)) if path.is_relative_to(here) else str(path)


if __name__ == "__main__":
    sys.exit(main())
