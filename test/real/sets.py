"""The recordings, which of them are fitted, and which are predicted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from trunk_ros.recording.importing.bag import read_bag
from trunk_ros.recording.importing.csv import read_csv
from trunk_ros.recording.recording import Recording
from trunk_ros.share import config_path


@dataclass(frozen=True)
class RealSet:
    """One arm: recordings of a folder that are fitted, and those that are judged."""

    folder: str
    mapping: str
    fitted: tuple[str, ...]
    judged: tuple[str, ...]
    joints: tuple[str, ...]
    """Those of interest."""
    share: float = 1.0
    """Of each fitted recording that is fitted; the rest is judged as well."""

    def read(self, home: Path, name: str) -> Recording:
        """A recording by the name of its file."""
        mapping, bag = config_path(f"import/{self.mapping}"), home / self.folder / f"{name}.bag"
        if bag.exists():
            return read_bag(bag, mapping)
        return read_csv(home / self.folder / f"{name}.csv", mapping)

    def rows(self) -> Iterator[tuple[str, bool]]:
        """Names of what is judged, and whether only the part is that was not fitted."""
        if self.share < 1.0:
            yield from ((name, True) for name in self.fitted)
        yield from ((name, False) for name in self.judged)


SHEATH = "tendon-sheath"
PSM = tuple(f"outer_{j}" for j in ("yaw", "pitch", "insertion", "roll", "wrist_pitch", "wrist_yaw"))
TRAVEL = "EccA_load-square-wave-"
ECCENTRIC = f"{TRAVEL}full-travel-1Hz", f"{TRAVEL}half-travel-1Hz"
SLIDE = ("LinA_pp-square-wave-10mm-0.5Hz",)
SETS = (
    RealSet("dvrk-wrist", "dvrk-wrist", ("train_random",), ("exp1", "exp2", "exp4"), ("q4", "q5", "q6"), 0.7),
    RealSet(SHEATH, SHEATH, ("test0224",), ("odd_test",), ("bend",), 0.7),
    RealSet(SHEATH, "tendon-sheath-feedforward", ("aurora_ff",), ("ff",), ("bend",), 0.7),
    *(
        RealSet(SHEATH, SHEATH, (f"sheath_{angle}deg",), (), ("bend",), 0.7)
        for angle in ("000", "060", "120", "180", "240")
    ),
    RealSet("tip-compliance", "tip-compliance", ("z-0.105_28",), ("z-0.105_33", "z-0.105_59"), ("tip_z",)),
    RealSet("tip-compliance", "tip-compliance", ("z-0.205_20",), ("z-0.205_34", "z-0.205_57"), ("tip_z",)),
    RealSet("flexible-link", "flexible-link", ("flexarm_K1_6",), (), ("arm",), 0.7),
    RealSet("bent-probe", "bent-probe", ("motor1",), (), ("bend",), 0.7),
    RealSet("bent-probe", "bent-probe-sweep", ("antero_posterior",), (), ("bend",), 0.7),
    RealSet(
        "instrument-jaw", "instrument-jaw", ("t4_04", "t4_20", "t4_29", "t4_44"), ("t4_00", "t4_22"), ("jaw",)
    ),
    RealSet("psm-servo", "psm-servo", ("traj_01",), (), PSM, 0.7),
    RealSet("camber", "camber-eccentric", (f"{TRAVEL}full-travel-0.5Hz",), ECCENTRIC, ("ecc",), 0.7),
    RealSet("camber", "camber-slide", ("LinA_pp-sine-sweep-10mm-0.5Hz",), SLIDE, ("slide",), 0.7),
)
