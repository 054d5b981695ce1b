"""Setup of JAX: CPU cores as devices, float64 allowed, compiled programs kept on the disk.

``configure`` must run before anything starts JAX. If it runs later, it warns: JAX is then slower.
"""

import itertools
import os
import warnings
from functools import cache
from pathlib import Path
from typing import Any

import jax

from hfc_design.core.numbers import FEWEST_DEVICES, cores
from hfc_design.core.records import UserError

_LOOPS = (
    # A loop below this many bytes is compiled into one function, not into a call per operation.
    # A step of 16 individuals then costs as little per individual as a step of 512.
    "xla_cpu_small_while_loop_byte_threshold=1000000000",
    # With these, a step of four vectors is half as much code, which fits the first-level cache.
    "xla_cpu_disable_loop_unrolling",
    "xla_cpu_disable_slp_vectorizer",
)

#: Compiler options for a program that runs only briefly: it compiles in a fifth of the time.
QUICKLY = {"xla_backend_optimization_level": 0, "xla_llvm_disable_expensive_passes": True}

LATE = (
    "JAX was started before hfc_design was imported: simulations are slower and use one "
    "core; import hfc_design.api before the first computation with JAX"
)


@cache
def configure() -> None:
    """Set JAX up once; later calls do nothing."""
    flags = os.environ.get("XLA_FLAGS", "")
    if "xla_backend_extra_options" not in flags:
        os.environ["XLA_FLAGS"] = f"{flags} --xla_backend_extra_options={','.join(_LOOPS)}".strip()
    config: Any = jax.config
    config.update("jax_enable_x64", True)
    if (chosen := config.jax_num_cpu_devices) < FEWEST_DEVICES:  # -1: nobody has chosen yet
        count = max(FEWEST_DEVICES, cores() if chosen == -1 else chosen)
        try:
            config.update("jax_num_cpu_devices", count)
        except RuntimeError:
            warnings.warn(LATE, stacklevel=2)
    if config.jax_compilation_cache_dir is None:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"  # of the user
        config.update("jax_compilation_cache_dir", str(Path(base) / "hfc-design" / "xla"))
        config.update("jax_persistent_cache_min_compile_time_secs", 0.5)


#: Files: memory maps of this process, and the most that Linux allows (with more, it kills it).
MAPPED, MOST_MAPPED = Path("/proc/self/maps"), Path("/proc/sys/vm/max_map_count")
#: Only every so many simulations ``make_room`` counts the maps.
SELDOM = 32
_SIMULATIONS = itertools.count()


def make_room() -> None:
    """Forget all compiled programs if they use half of the memory maps; called at each simulation.

    A program takes 100 to 200 maps; Linux allows 65,530 by default. A forgotten program that is
    needed again is loaded from the disk.
    """
    if next(_SIMULATIONS) % SELDOM == 0 and crowded():
        jax.clear_caches()


def crowded() -> bool:
    """Return whether over half of the allowed memory maps are used; False if there is no count."""
    try:
        most = int(MOST_MAPPED.read_text("ascii"))
        with MAPPED.open("rb") as lines:
            return sum(1 for _ in lines) > most // 2
    except OSError:
        return False


def compiler_options() -> dict[str, int]:
    """Return the compiler options of every loop: on a CPU, 512-bit vectors where it has them.

    Raises:
        UserError: JAX has nothing to compute on.
    """
    try:
        backend = jax.default_backend()
    except (RuntimeError, AssertionError) as error:  # the latter: the platform has no plug-in
        wanted = f"JAX_PLATFORMS={os.environ.get('JAX_PLATFORMS', '')}"
        raise UserError(f"{wanted}: JAX cannot start: {error}".removesuffix(": ")) from None
    return {"xla_cpu_prefer_vector_width": 512} if backend == "cpu" else {}
