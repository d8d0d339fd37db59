"""The proof: arms that hide physics from the diagnosis. Shares no code with ``trunk_ros``."""
