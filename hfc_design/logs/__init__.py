"""Recordings of machines: files of scopes and programs, as columns of numbers.

``columns.py`` defines a log, further modules each read the format of a program, ``reading.py``
selects the reader; ``signals.py`` converts columns to signals of a drive, in its units and evenly
sampled.
"""
