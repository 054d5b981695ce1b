"""C in single precision on a Cortex-M4 and on an ATmega328P, as QEMU and simavr emulate them."""

import re
from functools import cache

import numpy as np
import pytest
from board_samples import DESIGNS, ON_UNO, case
from board_sizes import BUILT, FLOAT, POINTS, SIZES, TABLES, row
from boards import CORTEX, HERE, UNO, compiled, firmware, stepped, symbols
from places import ROOT

from hfc_design.controllers.hierarchical.code import tabulated
from hfc_design.formats import saving

TABULATED = [name for name in BUILT if DESIGNS[name].kind.lookup]
#: What a kind needs of the library in single precision; a machine's for square roots alone.
NEEDS = {"pd+hierarchical-fuzzy": {"expf"}, "neural": {"tanhf"}}
NEEDS |= {"cross-coupled": {"sqrtf"}, "dynamic-compensation": {"sqrtf"}}
#: A compiler may copy and clear memory with these wherever it likes.
MEMORY = {"memcpy", "memset"}
#: Arithmetic that a Cortex-M4 has no instructions for, and functions in double precision.
DOUBLE = re.compile(r"__aeabi_.*|exp|tanh|sqrt|pow|log")
HEAP = re.compile(r"_*((m|c|re)alloc|free|s?brk)(_r)?")
PAGE = (ROOT / "docs" / "c.md").read_text(encoding="utf-8")
RAM_OF_UNO = 2048

expectations = cache(lambda name: case(DESIGNS[name]))


@pytest.fixture
def board(program, request):
    """A board whose compiler and emulator are here."""
    for name in (f"{request.param.prefix}gcc", request.param.emulator.split()[0]):
        program(name)
    return request.param


cortex = pytest.mark.parametrize("board", [CORTEX], ids=["cortex"], indirect=True)
uno = pytest.mark.parametrize("board", [UNO], ids=["uno"], indirect=True)


def own_and_linked(board, name, folder, *flags, lookup=0):
    """What the objects of a design need from elsewhere, and the program."""
    objects = compiled(board, DESIGNS[name], folder, *flags, lookup=lookup)
    needed, own = (
        set().union(*(symbols(board, folder / one, which) for one in objects))
        for which in ("--undefined-only", "--defined-only")
    )
    samples = expectations(name)[0].astype(np.float32 if flags else np.float64)
    return needed - own - MEMORY, firmware(board, DESIGNS[name], folder, objects, samples, *flags)


def deviation(board, name, elf):
    """The largest one in float from the runtime, and the largest command."""
    found, expected = stepped(board, elf, np.float32).commands, expectations(name)[1]
    np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
    assert np.isnan(found).sum() == 2 * found.shape[1]  # the faulty samples
    return np.nanmax(np.abs(found - expected)), np.nanmax(np.abs(expected))


def close_to(name):
    """Single precision; with an adaptation small differences grow."""
    return 5e-6 if saving.learns(DESIGNS[name]) else 1e-6


@cortex
@pytest.mark.parametrize("name", BUILT)
def test_float_without_heap_or_double(board, name, tmp_path):
    needed, elf = own_and_linked(board, name, tmp_path / "c", *FLOAT)
    assert needed == NEEDS.get(DESIGNS[name].controller.kind, set())
    assert not [x for x in symbols(board, elf) if DOUBLE.fullmatch(x) or HEAP.fullmatch(x)]
    off, largest = deviation(board, name, elf)
    assert 0.0 < off < close_to(name) * largest


@cortex
@pytest.mark.parametrize("name", BUILT)
def test_double_equals_the_runtime(board, name, tmp_path):
    _, elf = own_and_linked(board, name, tmp_path / "c")
    assert any(x.startswith("__aeabi_d") for x in symbols(board, elf))  # where float had none
    assert not [x for x in symbols(board, elf) if HEAP.fullmatch(x)]
    found = stepped(board, elf, np.float64).commands
    np.testing.assert_allclose(found, expectations(name)[1], rtol=1e-12, atol=1e-12)


@cortex
@pytest.mark.parametrize("name", TABULATED)
def test_a_table_needs_no_library(board, name, tmp_path):
    needed, elf = own_and_linked(board, name, tmp_path / "c", *FLOAT, lookup=POINTS)
    assert not needed
    assert not [x for x in symbols(board, elf) if "exp" in x]
    off, largest = deviation(board, name, elf)
    named = tabulated(DESIGNS[name].controller, POINTS)["deviation"]
    assert 0.1 * named < off < named + 1e-6 * largest


@uno
@pytest.mark.parametrize("name", [name for name in BUILT if name in ON_UNO])
def test_float_on_an_uno(board, name, tmp_path):
    _, elf = own_and_linked(board, name, tmp_path / "c", *FLOAT)
    assert not [x for x in symbols(board, elf) if HEAP.fullmatch(x)]
    off, largest = deviation(board, name, elf)
    assert 0.0 < off < close_to(name) * largest


def documented():
    """Last heading of a table, its rows: name, points of a lookup table, cells."""
    rows = {}
    for line in PAGE.splitlines():
        cells = line.strip("| ").split(" | ")
        title = re.fullmatch(r"`([\w-]+)`(?:, `--lookup (\d+)`)?", cells[0])
        if cells[1:-1] == list(SIZES):
            table = rows[cells[-1]] = []
        elif title and rows:
            table.append((title[1], int(title[2] or 0), cells[1:]))
    return rows


def test_the_tables_and_the_flags_of_the_page_are_those_of_the_tests():
    found = {unit: [row[:2] for row in rows] for unit, rows in documented().items()}
    assert found == {unit: rows for unit, (_, _, rows) in TABLES.items()}
    for board in (CORTEX, UNO):
        (command,) = re.findall(rf"^{board.prefix}gcc .*?\.c$", PAGE, re.M | re.S)
        ours = (HERE / board.name / "flags").read_text(encoding="ascii").split()
        linking = {"--specs=nano.specs", "-nostartfiles", "-Wl,--gc-sections"}
        assert set(ours) - linking <= set(command.split())


@pytest.mark.parametrize(
    ("board", "unit", "name", "points", "cells"),
    [
        pytest.param(TABLES[unit][0], unit, *one, id=f"{unit} of {one[0]} {one[1]}")
        for unit, rows in documented().items()
        for one in rows
    ],
    indirect=["board"],
)
def test_the_documented_sizes_are_true(board, unit, name, points, cells):
    """The state's to the byte, others as far as another version of gcc may give."""
    found = row(unit, name, points)
    assert found[0] == cells[0]
    for one, other in zip(numbers(found), numbers(cells), strict=True):
        assert one == pytest.approx(other, rel=0.1, abs=16)
    if board is UNO:
        state, constants, _, _, stack, _ = numbers(found)
        assert state + constants + stack < RAM_OF_UNO


def numbers(cells):
    return [int(x) for x in " / ".join(cells).replace(",", "").split(" / ")]
