"""What machines have recorded: files of scopes and programs, as columns of numbers.

``columns.py`` says what a log is, a module each reads what programs write, ``reading.py`` tells
them apart; ``signals.py`` makes signals of a drive of the columns, in its units and evenly sampled.
"""
