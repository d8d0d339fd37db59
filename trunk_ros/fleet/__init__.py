"""Many recordings of many arms: diagnosed on Dask, looked at together; and one arm that is watched.

``inputs`` finds the recordings, ``run`` diagnoses them, ``together`` says what changes, ``report`` shows it;
``watch`` holds the statistics of the node of that name.
"""
