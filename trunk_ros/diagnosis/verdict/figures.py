"""Figures of a diagnosis, as they stand in the report."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from trunk_ros.diagnosis.verdict.answer import Answer


class Figures:
    """Each call makes a matplotlib figure."""

    def __init__(self, result: Answer) -> None:
        self._result = result

    def before_after(self) -> Figure:
        """Error of each signal on samples that the fit did not see, over its noise, before and after."""
        from trunk_ros.diagnosis.report.errors import figure_before_after

        return figure_before_after(self._result)

    def over_time(self) -> Figure:
        """Error over the first recording, of the nominal arm and with what was found."""
        from trunk_ros.diagnosis.report.errors import figure_over_time, shown_over_time

        return figure_over_time(shown_over_time(self._result))

    def signature(self, effect: str) -> Figure | None:
        """What shows an effect, over what it depends on; None where nothing was drawn. ValueError for an
        effect that was not found.
        """
        from trunk_ros.diagnosis.report.signature import figure_signature

        found = {finding.effect: finding for finding in self._result.findings}
        if effect not in found:
            raise ValueError(f"no finding {effect!r}: there are {', '.join(found) or 'none'}")
        return figure_signature(self._result, found[effect])
