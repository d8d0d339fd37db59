"""Another joint's motion drags this joint along, over several widths."""

from trunk_ros.effects.bank import parameters_of, words_of
from trunk_ros.effects.drags import Drags


class CouplingDrag(Drags):
    """theta += sum of weight_i (s - play(s, reach_i)), s = r phi of another joint, up to four of them: its
    wire takes this joint's along, contact after contact, and slides. Eight reaches in even ratios from low to
    high.
    """

    id = "coupling_drag"
    stage, place = "wire", 246
    signature = (
        "The residual is a rounded loop against another joint's angle, whether this joint moves or not."
    )
    source = (
        "Presliding friction between two wires as a sum of plays: Prandtl-Ishlinskii, in the form of "
        "Al Janaideh, Rakheja & Su (2011), IEEE/ASME Trans. Mechatronics 16(4), eq. (3)."
    )
    sources = 4
    parameters = parameters_of(
        sources,
        "half the motion after which the first contact slides",
        "likewise the last",
        "share of contact",
    )
    texts = words_of(sources)
    needs = ("several",)
    confused_with = (("coupling_curve", "pass one posture of the source in both directions"),)
