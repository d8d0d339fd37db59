"""What counts as certain, as enough and as little: levels that many files judge by, each once."""

CHANCE = 0.01
"""Probability with which chance may pass for something, over all places where it was looked for."""
CLEARLY = 1.5
"""Times as much as a level: clearly more than that."""
NOTABLE = 2.0
"""Standard deviations that chance seldom makes: enough where little is lost by an error."""
SURE = 4.0
"""Standard deviations that chance does not make, also where they are only roughly known."""
CERTAIN = CLEARLY * SURE
"""Standard deviations from which on a recording is changed: nobody looks at it unchanged afterwards."""
SCATTER = 2.0
"""Times the standard deviation of a fit: steps of encoders and of time are not in the noise."""
FEWEST = 20
"""Readings: of fewer nothing is told of a sensor."""
ENOUGH = 100
"""Samples: of fewer nothing is told of a motion."""
ROWS = 5000
"""Samples that are enough: of more some are looked at."""
ROUGH = 1e-3
"""Of a size: fits, integration and interpolation are no more exact."""
LITTLE = 0.02
"""Of a misfit: forms of the same physics differ by so much."""
SEVERAL = 2
"""Of joints, effects or waves that each show something by themselves: so many are no accident."""
JOINTS = 3
"""Of joints that show one size alike: so many are no accident."""
REFITTED = 3
"""Of the best by a first look that are fitted in full, where a fit is dear."""
TURNS = 4
"""Of what is fitted alternately: each leaves little of what the other had to follow."""
MOST = 0.6
"""Share that is most of something: more than half, so that little does not tip it."""
PART = 0.1
"""Share of something: what is less is a small part of it, or none."""
NEARLY = 1.0 - PART
"""Share that is nearly all of something."""
SLIGHT = 0.05
"""Share of something: what is less, or differs by less, makes no difference."""
HARDLY = 0.01
"""Share of something that is hardly any of it: rounded, guessed or interpolated."""
OUTLIERS = HARDLY
"""Share of samples at an end of a range that may be outliers."""
SOME = 0.3
"""Share of something: what is less tells nothing of the whole."""
HALF = 0.5
"""Share of something: what is more is more than all the rest."""
ROUGHLY = 0.25
"""Share by which two looks at one thing may differ, where each is rough."""
FAR_OFF = 0.2
"""Of a ratio: so far off it was not known, and what it makes is no misfit of formulas; or it is a gear."""
THREEFOLD = 3.0
"""Times as much: no more a matter of how it was measured."""
TENFOLD = 10.0
"""Times as much: another thing altogether."""
TOGETHER = 0.5
"""s: on several joints it is one event."""
