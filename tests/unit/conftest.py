"""What is kept out of tests that begin at once: compiled programs."""

import jax
import pytest

COMPILED: list[str] = []


def pytest_configure():
    event = "/jax/core/compile/backend_compile_duration"
    jax.monitoring.register_event_duration_secs_listener(
        lambda name, _, **__: COMPILED.append(name) if name == event else None
    )


@pytest.fixture(autouse=True)
def nothing_is_compiled():
    """A test that compiles belongs to ``tests/loop``."""
    before = len(COMPILED)
    yield
    assert len(COMPILED) == before, "a test of tests/unit compiles"
