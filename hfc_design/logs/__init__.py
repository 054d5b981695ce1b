"""Recordings of machines: files of scopes and programs, as columns of numbers.

``columns.py`` defines a log. ``texts.py`` and ``mat.py`` read files of other programs, and
``reading.py`` selects the reader. ``signals.py`` converts columns to signals of a drive, evenly
sampled and in its units; ``sensors.py`` finds the properties of sensors in them.
"""
