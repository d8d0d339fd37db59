"""What a diagnosis says, to people as well: with its table and its figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from trunk_ros.diagnosis.verdict.answer import Answer
from trunk_ros.diagnosis.verdict.figures import Figures
from trunk_ros.diagnosis.verdict.finding import Finding as Finding
from trunk_ros.diagnosis.verdict.table import ROW, rows_of, table_of


@dataclass(repr=False)
class Diagnosis(Answer):
    """The whole answer. ``stages`` is as in the JSON; ``model`` the nominal model with what was found."""

    def __repr__(self) -> str:
        """The verdict, and a table of what was found."""
        return table_of(self)

    @property
    def plot(self) -> Figures:
        """Figures of the diagnosis, for notebooks: ``result.plot.before_after()``."""
        return Figures(self)

    def to_dataframe(self) -> Any:
        """A pandas table with a row for each joint and parameter of a finding. Needs pandas."""
        import pandas as pd

        return pd.DataFrame(rows_of(self), columns=list(ROW))
