"""Memory in the wire that no name fits."""

from trunk_ros.effects.bank import parameters_of, words_of
from trunk_ros.effects.drags import Drags


class UnknownMemory(Drags):
    """theta += sum of weight_i (s - play(s, reach_i)), s = r phi of the joint itself, or that and another's
    together, up to five of them; eight reaches in even ratios from low to high.
    """

    id = "unknown_memory"
    stage, place = "wire", 252
    signature = "The residual is a loop over the motion in a way that no named effect has."
    source = (
        "Kennedy & O'Hagan (2001), J. R. Stat. Soc. B 63(3): a discrepancy term beside the physics; its "
        "memory a Prandtl-Ishlinskii operator (Brokate & Sprekels 1996, Hysteresis and Phase Transitions)."
    )
    named = False
    sources, own = 5, True
    parameters = parameters_of(sources, "reach of the first play", "reach of the last one", "weight of play")
    texts = words_of(sources)
    confused_with = (
        ("presliding_hysteresis", "reverse with many amplitudes: its loops are of one shape"),
        ("coupling_drag", "let this joint rest while the other moves"),
    )
