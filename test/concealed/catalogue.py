"""Every effect that can be hidden: those of the contract's table and strange ones, by name."""

from __future__ import annotations

from test.concealed import draw_drive, draw_friction, draw_load, draw_motion, draw_path
from test.concealed.draws import CATALOGUE as KNOWN_DRAWS
from test.concealed.draws import Draw
from test.concealed.strange import STRANGE

PARTS = (draw_path, draw_friction, draw_load, draw_motion, draw_drive)
CATALOGUE: dict[str, Draw] = {**KNOWN_DRAWS, **STRANGE}
