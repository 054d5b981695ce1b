PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Marks of the tests that need a program from outside PyPI.
PROGRAMS := interop or browser
# Processes that test; each takes a row of tests, and when it is done half of what another has left.
WORKERS ?= 2
PYTEST := $(BIN)/pytest -n $(WORKERS) --dist worksteal

.PHONY: design test test-all lint interop attack bench clean

design: $(VENV)/installed
	$(BIN)/hfc design

test: $(VENV)/installed lint
	$(PYTEST) -m "not (slow or $(PROGRAMS))"

# Only what make test leaves out, programs from outside PyPI apart: whole published experiments,
# processes that are killed again and again, clusters of workers. Files stay whole: tests of one
# file share what is dear.
test-all: $(VENV)/installed
	$(PYTEST) --dist loadfile -m "slow and not ($(PROGRAMS))"

interop: $(VENV)/installed
	tests/interop/install.sh
	$(BIN)/pytest -m "$(PROGRAMS)"

# What make test tries a few times, tried as often as docs/reliability.md says: hours.
attack: $(VENV)/installed
	HFC_ATTACK=full $(PYTEST) --dist loadfile tests/attack

lint: $(VENV)/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

bench: $(VENV)/installed
	$(BIN)/pip install -q -c constraints.txt -e ".[bench]"
	$(BIN)/python benchmarks/evaluator.py
	$(BIN)/python benchmarks/controllers.py
	$(BIN)/python benchmarks/populations.py
	$(BIN)/python benchmarks/runtime.py

# The environment is complete when this file is there.
$(VENV)/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install -q -c constraints.txt -e ".[dev]"
	touch $@

clean:
	rm -rf $(VENV) .venv-*
