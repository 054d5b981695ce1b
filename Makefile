PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Marks of the tests that need a program from outside PyPI.
PROGRAMS := interop or browser

.PHONY: design test lint interop bench clean

design: $(VENV)/installed
	$(BIN)/hfc design

test: $(VENV)/installed lint
	$(BIN)/pytest -m "not ($(PROGRAMS))"

interop: $(VENV)/installed
	tests/interop/install.sh
	$(BIN)/pytest -m "$(PROGRAMS)"

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
