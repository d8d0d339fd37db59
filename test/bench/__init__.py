"""What `make bench` measures: one file, one section, found by name.

A section is a module of this folder with a docstring that says what it measures and a function
``measure() -> Iterator[Row]``; rows are printed as they come.
"""
