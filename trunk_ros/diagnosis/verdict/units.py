"""Units of what is said of a joint."""


def unit_of(unit: str, joint: str) -> str:
    """A parameter's unit on a joint whose position is in the unit ``joint``: on a slide moments are
    forces.
    """
    return unit if joint == "rad" else unit.replace("rad", joint).replace("(N*m)", "N").replace("N*m", "N")
