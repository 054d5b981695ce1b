"""What a log tells of a machine: its parameters, how sure they are, and what to record next.

``request.py`` is what is asked, ``recording.py`` what was recorded, ``replay.py`` the plant under
it; ``fit.py`` finds the ``parameters.py``, ``identifiability.py`` says how well they are known,
``advice.py`` what to record next, ``response.py`` what the model lacks; ``identified.py`` does it
all. What comes of it is an ``outcome.py``: its tables, its scenario, its page.
"""
