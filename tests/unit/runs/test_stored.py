"""What made a checkpoint: another version, file or own part does not go on unasked."""

import importlib.metadata

from own_strategies import MODULE
from sledge import hfc


def test_the_package_of_an_own_part(own, monkeypatch):
    from hfc_design.core import plugins

    (own / "hunt.py").write_text(MODULE)
    monkeypatch.setattr(plugins, "_distributions", lambda: {"hunt": ["jax"]})
    hfc("list", "strategies", "--strategy", "hunt:CLIMB")
    version = importlib.metadata.version("jax")
    used = [("strategy", "climb"), ("strategy", "race")]
    assert plugins.origins(used) == {"strategy 'climb'": f"jax {version}"}
