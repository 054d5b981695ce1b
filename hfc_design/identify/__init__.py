"""Identification of a machine from a log: parameters, their certainty, and what to record next.

``request.py`` is the task, ``recording.py`` the recorded motion, ``replay.py`` the plant under it;
``fit.py`` fits the ``parameters.py``, ``identifiability.py`` determines their certainty,
``advice.py`` what to record next, ``response.py`` what the model lacks; ``identified.py`` combines
all of these. The result is an ``outcome.py``: its tables, its scenario, its page.
"""
