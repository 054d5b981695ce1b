"""Recordings of machines: files of scopes and programs, as columns of numbers.

``columns.py`` defines a log. ``texts.py`` and ``scopes.py`` read texts, ``libraries.py`` is a
program that reads other files, and ``reading.py`` selects the reader. ``signals.py`` converts
columns to signals of a drive, evenly sampled and in its units; ``sensors.py`` finds the properties
of sensors in them.
"""
