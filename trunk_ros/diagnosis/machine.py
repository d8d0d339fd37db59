"""What fits into memory and caches: no answer depends on these, only how fast it comes and what it needs."""

NUMBER = 4
"""Bytes of a number that processes hand each other."""
PIECE = 2048
"""Rows that stay in the processor's cache."""
CELLS = 2**17
"""Samples that are computed together: of long recordings more would not fit into memory."""
LOOKED = 2**17
"""Rows at which what is known of the whole arm is kept."""
KEPT = 8
"""Surroundings of each joint and span that are kept."""
FACTORS = 8
"""Sizes of which one logarithm is taken: a product of more might be no number."""
BOUND = 64
"""Blocks of one joint kept: what a fit leaves as it is is not made anew."""
