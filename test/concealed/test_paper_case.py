"""Claims about the paper's own table as a case."""

from __future__ import annotations

import pytest

from test.concealed.paper_case import PRINTED, paper_rows, read_page


def test_the_page_explains_every_printed_digit_of_table_2_and_says_how() -> None:
    rows = paper_rows()
    assert [row.quantity for row in rows] == list(PRINTED)
    for row in rows:
        assert row.formulas_off > 5e-3
        assert row.corrected_off < 3e-4  # the last printed digit
    swapped = {row.quantity: row.said for row in rows}
    assert "mu1 = 0.03" in swapped["k_i·100 / %"]
    assert "swapped" in swapped["Δθ_i / arcmin"]


def test_a_page_without_the_table_is_no_answer() -> None:
    with pytest.raises(ValueError, match="no table"):
        read_page("Table 3\n\nnothing")
