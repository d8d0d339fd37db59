"""The source of the nominal arm, checked number by number, and its further work done."""
