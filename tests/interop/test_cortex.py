"""The C code on a Cortex-M4 with its unit for single precision, which QEMU emulates."""

import re
import shutil
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from cortex import BOARD, DESIGNS, case, compiled, program, stepped, symbols
from cortex_sizes import NAMES, row

from hfc_design.controllers.hierarchical.code import lookup
from hfc_design.formats import saving

pytestmark = [pytest.mark.interop, pytest.mark.usefixtures("tools")]
POINTS = 257
TABULATED = [name for name, design in DESIGNS.items() if design.kind.lookup]
#: What a kind needs of the library in single precision; a machine's for square roots alone.
NEEDS = {"pd+hierarchical-fuzzy": {"expf"}, "neural": {"tanhf"}}
NEEDS |= {"cross-coupled": {"sqrtf"}, "dynamic-compensation": {"sqrtf"}}
#: A compiler may copy and clear memory with these wherever it likes.
MEMORY = {"memcpy", "memset"}
#: Arithmetic that the processor has no instructions for, and functions in double precision.
DOUBLE = re.compile(r"__aeabi_.*|exp|tanh|sqrt|pow|log")
HEAP = re.compile(r"_*((m|c|re)alloc|free|s?brk)(_r)?")

PAGE = (Path(__file__).parents[2] / "docs" / "c.md").read_text(encoding="utf-8")
#: Name, points of a lookup table, numbers.
DOCUMENTED = re.findall(r"^\| `([\w-]+)`(?:, `--lookup (\d+)`)? \| (.* / .*) \|$", PAGE, re.M)

expectations = cache(lambda name: case(DESIGNS[name]))


@pytest.fixture(scope="module")
def tools():
    for name in ("arm-none-eabi-gcc", "qemu-system-arm"):
        if shutil.which(name) is None:
            pytest.skip(f"{name} is not installed; make interop installs it")


def own_and_linked(name, folder, *flags, lookup=None):
    """What the objects of a design need from elsewhere, and the program."""
    objects = compiled(DESIGNS[name], folder, *flags, lookup=lookup)
    needed = set().union(*(symbols(folder / one, "-u") for one in objects))
    own = set().union(*(symbols(folder / one, "--defined-only") for one in objects))
    real = np.float32 if "-DHFC_FLOAT" in flags else np.float64
    samples = expectations(name)[0].astype(real)
    return needed - own - MEMORY, program(DESIGNS[name], folder, objects, samples, *flags)


def deviation(name, elf):
    """The largest one in float from the runtime, and the largest command."""
    found, expected = stepped(elf, np.float32).commands, expectations(name)[1]
    np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
    return np.nanmax(np.abs(found - expected)), np.nanmax(np.abs(expected))


@pytest.mark.parametrize("name", DESIGNS)
def test_float_without_heap_or_double(name, tmp_path):
    needed, elf = own_and_linked(name, tmp_path / "c", "-DHFC_FLOAT")
    kind = DESIGNS[name].controller.kind
    assert needed == NEEDS.get(kind, set())
    assert not [x for x in symbols(elf) if DOUBLE.fullmatch(x) or HEAP.fullmatch(x)]
    off, largest = deviation(name, elf)
    assert 0.0 < off < (5e-6 if saving.learns(DESIGNS[name]) else 1e-6) * largest


@pytest.mark.parametrize("name", DESIGNS)
def test_double_equals_the_runtime(name, tmp_path):
    _, elf = own_and_linked(name, tmp_path / "c")
    assert any(x.startswith("__aeabi_d") for x in symbols(elf))  # where float had none
    assert not [x for x in symbols(elf) if HEAP.fullmatch(x)]
    found = stepped(elf, np.float64).commands
    assert np.isnan(found).sum() == 2 * found.shape[1]  # the faulty samples
    np.testing.assert_allclose(found, expectations(name)[1], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", TABULATED)
def test_a_table_needs_no_library(name, tmp_path):
    needed, elf = own_and_linked(name, tmp_path / "c", "-DHFC_FLOAT", lookup=POINTS)
    assert not needed
    assert not [x for x in symbols(elf) if "exp" in x]
    off, largest = deviation(name, elf)
    named = lookup(DESIGNS[name].controller, POINTS).deviation
    assert 0.1 * named < off < named + 1e-6 * largest


def test_all_sizes_are_documented_with_the_flags_of_the_test():
    assert [name for name, points, _ in DOCUMENTED if not points] == list(NAMES)
    (command,) = re.findall(r"^arm-none-eabi-gcc .*?```", PAGE, re.M | re.S)
    ours = (BOARD / "flags").read_text(encoding="ascii").split()
    linking = {"--specs=nano.specs", "-nostartfiles", "-Wl,--gc-sections"}
    assert set(ours) - linking <= set(command.split())


@pytest.mark.parametrize(("name", "points", "numbers"), DOCUMENTED)
def test_the_documented_sizes_are_true(name, points, numbers):
    """The state's to the byte, others as far as another version of gcc may give."""
    found = row(name, int(points or 0))
    assert found[1] == numbers.split(" | ")[0]
    for ours, theirs in zip(found[2:], numbers.split(" | ")[1:], strict=True):
        pairs = zip(*(map(count, x.split(" / ")) for x in (ours, theirs)), strict=True)
        assert all(one == pytest.approx(other, rel=0.1, abs=16) for one, other in pairs)


def count(text):
    return int(text.replace(",", ""))
