"""Identification of a machine from a log: parameters, their certainty, experiments for it.

``request.py`` has the task, ``recording.py`` the recorded motion. ``replay.py`` simulates the plant
under it, ``fit.py`` fits the parameters (``parameters.py``), ``identifiability.py`` finds how
certain they are, ``profiles.py`` how good their intervals, ``response.py`` what the model lacks.
``identified.py`` runs all of these; ``outcome.py`` and ``page.py`` show the result.
``experiment.py`` makes a log that tells more, ``checking.py`` compares one with the model.
"""
