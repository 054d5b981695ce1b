"""What a log tells of a machine: its parameters, how sure they are, and what to record next.

``recording.py`` is what is replayed, ``replay.py`` the plant under it; ``free.py`` which of its
parameters are looked for, ``fit.py`` finds them, ``certainty.py`` says how well they are known.
"""
