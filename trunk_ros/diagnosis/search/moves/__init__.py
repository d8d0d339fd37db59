"""The changes that a search tries, cheap ones first; one file each."""

from trunk_ros.diagnosis.search.moves.add import ADD, FURTHER_JOINTS
from trunk_ros.diagnosis.search.moves.alike import ALIKE
from trunk_ros.diagnosis.search.moves.bend import BEND
from trunk_ros.diagnosis.search.moves.curve import CURVE, EARLY_CURVE
from trunk_ros.diagnosis.search.moves.drop import DROP
from trunk_ros.diagnosis.search.moves.event import EVENT
from trunk_ros.diagnosis.search.moves.form import FORM, SHAKE
from trunk_ros.diagnosis.search.moves.like import LIKE
from trunk_ros.diagnosis.search.moves.member import MEMBER
from trunk_ros.diagnosis.search.moves.onset import ONSET
from trunk_ros.diagnosis.search.moves.option import OPTION
from trunk_ros.diagnosis.search.moves.restart import RESTART
from trunk_ros.diagnosis.search.moves.source import SOURCE
from trunk_ros.diagnosis.search.moves.spell import SPELL
from trunk_ros.diagnosis.search.moves.swap import NAMED, SWAP
from trunk_ros.diagnosis.search.moves.swap_all import PLAINER, SWAP_ALL
from trunk_ros.diagnosis.search.moves.swap_many import SWAP_MANY

MOVES = (
    ONSET,
    FORM,
    BEND,
    MEMBER,
    LIKE,
    OPTION,
    SOURCE,
    EVENT,
    SPELL,
    DROP,
    EARLY_CURVE,
    SWAP_ALL,
    SWAP_MANY,
    SWAP,
    ALIKE,
    SHAKE,
    ADD,
    RESTART,
    CURVE,
)
"""In the order in which they are tried: what mends before what adds, what all joints share before
what each has, names before curves where names may do.
"""

__all__ = [
    "ADD",
    "CURVE",
    "DROP",
    "EARLY_CURVE",
    "FURTHER_JOINTS",
    "MOVES",
    "NAMED",
    "ONSET",
    "PLAINER",
    "SWAP",
    "SWAP_ALL",
]
