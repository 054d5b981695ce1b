"""What a log tells of a machine: its parameters, how sure they are, and what to record next.

``free.py`` is what is asked, ``replay.py`` what was recorded and the plant under it; ``fit.py``
finds the parameters, ``certainty.py`` says how well they are known, ``identified.py`` does it all.
"""
