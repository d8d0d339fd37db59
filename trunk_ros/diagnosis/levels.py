"""What counts as certain, as enough and as little: levels that many files judge by, each once."""

CHANCE = 0.01
"""Probability with which chance may pass for something, over all places where it was looked for."""
NOTABLE = 2.0
"""Standard deviations that chance seldom makes: enough where little is lost by an error."""
SURE = 4.0
"""Standard deviations that chance does not make, also where they are only roughly known."""
CERTAIN = 6.0
"""Standard deviations from which on a recording is changed: nobody looks at it unchanged afterwards."""
