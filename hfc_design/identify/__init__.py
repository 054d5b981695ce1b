"""Identification of a machine from a log: parameters, their certainty, and what to record next.

``request.py`` has the task, ``recording.py`` the recorded motion. ``replay.py`` simulates the plant
under it, ``fit.py`` fits the parameters (``parameters.py``), ``identifiability.py`` finds how
certain they are, ``response.py`` what the model lacks, ``advice.py`` what to record next.
``identified.py`` runs all of these; ``outcome.py``, ``result.py`` and ``page.py`` show the result.
"""
