"""How JAX is set up: all CPU cores as devices, float64 allowed, compiled programs kept.

Import this before anything starts JAX; afterwards it still works, only slower.
"""

import os
from functools import cache
from pathlib import Path
from typing import Any

import jax

# Loops below this many bytes are compiled into one function instead of one call an operation.
# With it a step of 16 individuals costs as little per individual as one of 512.
_WHOLE_LOOP = "xla_cpu_small_while_loop_byte_threshold=1000000000"


@cache
def configure() -> None:
    """Set JAX up once; later calls do nothing."""
    flags = os.environ.get("XLA_FLAGS", "")
    if "xla_backend_extra_options" not in flags:
        os.environ["XLA_FLAGS"] = f"{flags} --xla_backend_extra_options={_WHOLE_LOOP}".strip()
    config: Any = jax.config
    config.update("jax_enable_x64", True)
    if config.jax_num_cpu_devices == -1:  # nobody has chosen yet
        config.update("jax_num_cpu_devices", len(os.sched_getaffinity(0)))
    if config.jax_compilation_cache_dir is None:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"  # the user's
        config.update("jax_compilation_cache_dir", str(Path(base) / "hfc-design" / "xla"))
        config.update("jax_persistent_cache_min_compile_time_secs", 0.5)


def compiler_options() -> dict[str, int]:
    """Options of every compiled loop: 512-bit vectors, where the processor has them."""
    return {"xla_cpu_prefer_vector_width": 512} if jax.default_backend() == "cpu" else {}
