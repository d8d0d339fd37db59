"""Guards of arithmetic: they keep divisions and inverses from failing, and no result hangs on them."""

TINY = 1e-300  # divides in the place of nothing
FADED = 1e-150  # what fades is gone: numbers whose squares have no full digits take a hundred times as long
ROUNDED = 1e-12  # of a size: what rounding leaves of it
SAME = 1e-6  # of a size: two computed numbers that are nearer to each other are one
BLIND = 1e-10  # of the largest curvature: what has less cannot be told
ROUNDS = 20  # of an iteration that has settled by then
