"""Recordings before they are explained: aligned, freed of faulty readings, with their noise."""
