PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Processes that test; each takes a row of tests, and when it is done half of what another has left.
WORKERS ?= 2
PARALLEL := -n $(WORKERS) --dist worksteal
# A test that hangs for 15 minutes has failed: its process ends with a traceback, the others go on.
PYTEST := $(BIN)/pytest $(PARALLEL) -o faulthandler_timeout=900 -o faulthandler_exit_on_timeout=true
# Tests of other Pythons and packages: all that compile nothing, and these of those that do.
SMOKE := tests/unit tests/loop/simulation
# Those whose numbers hang on a processor's instructions.
NUMERIC := $(addprefix tests/loop/,attainable controllers identify objectives plants search simulation stability)
ISA ?= AVX
# What makes other environments, pins and releases.
TOOLS := .venv-tools
UV := $(TOOLS)/bin/uv
VERSION ?= 3.14
OTHER := .venv-$(notdir $(VERSION))
UPLOT := 1.6.32
UPLOT_SHA512 := 2883159c6ebccefbb95d751b0b82d010f9e1c0ec41b8bc96d401eda66e882935c89a46cb824332fa369b8cb8122cc6ac36e186cd09bf7a9ded3a4c93c6989023
INSTALL := $(UV) pip install -q --require-hashes --python
# Tests start Python hundreds of times; what it has compiled is kept, whatever a user has set.
unexport PYTHONDONTWRITEBYTECODE

# One list for every system and every Python that the project runs on, without addresses.
LOCK := UV_CUSTOM_COMPILE_COMMAND="make lock" $(UV) pip compile -q --universal \
	--python-version 3.11 --fork-strategy fewest --generate-hashes --no-annotate

# Every extra but the peers, which want packages that nothing else here does.
EXTRAS := --extra dev --extra bench

.PHONY: design test short published style types test-bare test-isa wording test-lowest test-python lint interop docs notebooks attack bench bench-accelerator dist audit lock uplot reference clean

design: $(VENV)/installed
	$(BIN)/hfc design

# mypy, which is one process, runs beside the tests.
test: $(VENV)/installed style
	$(MAKE) --no-print-directory -j2 types short

short: $(VENV)/installed
	$(PYTEST) tests/unit tests/loop

# What make test leaves out, programs from outside PyPI apart: whole published experiments, processes
# that are killed again and again, clusters of workers. Files stay whole: tests of one file share
# what is dear.
published: $(VENV)/installed
	$(PYTEST) --dist loadfile tests/published

# The numeric tests of make test with code for other processors, AVX, AVX2 or AVX512, and a cache of
# its own: make test-isa ISA=AVX2
test-isa: $(VENV)/installed
	XLA_FLAGS=--xla_cpu_max_isa=$(ISA) XDG_CACHE_HOME=$${XDG_CACHE_HOME:-$(CURDIR)/.cache}/$(ISA) \
		$(PYTEST) $(NUMERIC)

# Writes tests/wording.txt, all that users read where something is refused; look at its difference.
wording: $(VENV)/installed
	HFC_WORDING=write $(PYTEST) tests/unit tests/loop

interop: $(VENV)/installed
	tests/interop/install.sh
	$(PYTEST) tests/interop

# The documentation as a site, build/site/index.html; any warning fails. What the variable silences is
# no warning of the pages but news of the theme: see docs/development.md.
docs: $(VENV)/installed .venv-docs/installed
	$(BIN)/python docs/site/stage.py build/docs
	NO_MKDOCS_2_WARNING=1 .venv-docs/bin/mkdocs -q build --strict -f docs/site/mkdocs.yml
	@echo build/site/index.html

# Runs the notebooks and stores what comes out.
notebooks: $(VENV)/installed
	$(BIN)/python docs/notebooks/run.py docs/notebooks/*.ipynb

# What make test tries a few times, tried as often as docs/reliability.md says: hours.
attack: $(VENV)/installed
	HFC_ATTACK=full $(PYTEST) --dist loadfile tests/published/attack tests/interop/attack

lint: style types

style: $(VENV)/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/installed
	$(BIN)/mypy

bench: $(VENV)/installed
	$(BIN)/python benchmarks/evaluator.py
	$(BIN)/python benchmarks/controllers.py
	$(BIN)/python benchmarks/drives.py
	$(BIN)/python benchmarks/populations.py
	$(BIN)/python benchmarks/ensembles.py
	$(BIN)/python benchmarks/gradients.py
	$(BIN)/python benchmarks/runtime.py

# A card, if there is one, beside the processor; see benchmarks/README.md.
bench-accelerator: $(VENV)/installed
	mkdir -p build
	$(BIN)/python benchmarks/accelerator.py --out build/accelerator.json

# With the oldest packages that pyproject.toml admits on the oldest Python. Old packages on new ones
# that they use warn; that is not for this project to mend. Their part of a refusal's words is theirs.
test-lowest: .venv-lowest/installed
	HFC_WORDING=any .venv-lowest/bin/pytest $(PARALLEL) -W ignore::DeprecationWarning $(SMOKE)

# The same with the packages of make test on another Python: make test-python VERSION=3.13, or the
# path of an interpreter. A version that is not here is fetched by uv. BARE=1: without what Windows lacks.
test-python: $(OTHER)/installed
	HFC_WORDING=any $(if $(BARE),HFC_BARE=1) $(OTHER)/bin/pytest $(PARALLEL) $(SMOKE)

# Without what Windows lacks, see tests/helpers/bare.py; and the types for other systems.
test-bare: $(VENV)/installed
	$(BIN)/mypy --platform win32 --cache-dir .mypy_cache/win32
	$(BIN)/mypy --platform darwin --cache-dir .mypy_cache/darwin
	HFC_BARE=1 $(PYTEST) tests/unit $(addprefix tests/loop/,batch calls cli core runs)

# The wheel, the source archive and a list of what an install of it holds (CycloneDX), in dist/; the
# wheel works outside this folder.
dist: $(TOOLS)/installed
	rm -rf dist
	SOURCE_DATE_EPOCH=$$(git log -1 --format=%ct) $(TOOLS)/bin/python -m build --no-isolation -o dist
	$(UV) venv -q --clear --python $(PYTHON) .venv-dist
	$(INSTALL) .venv-dist -r requirements/runtime.txt
	$(UV) pip install -q --python .venv-dist --no-deps dist/*.whl
	for wheel in dist/*.whl; do $(TOOLS)/bin/cyclonedx-py environment .venv-dist \
		--pyproject pyproject.toml --output-reproducible -o $${wheel%%-py3*}.cdx.json; done
	folder=$$(mktemp -d) && cd "$$folder" && hfc=$(CURDIR)/.venv-dist/bin/hfc && $$hfc --version && \
		$$hfc list scenarios >list && $$hfc design c-axis-ramp --population 16 --generations 2 \
		--set simulation.duration_s=0.1 --out run >design && $$hfc export run --to c --out c >export && \
		rm -r "$$folder"

# Asks the advisories of the Python package index about every pinned package that is installed; not
# answered is failed.
audit: $(TOOLS)/installed
	$(TOOLS)/bin/pip-audit --strict --require-hashes --disable-pip -s pypi \
		$(addprefix -r requirements/,locked.txt peers.txt tools.txt docs.txt fuzzylite.txt st.txt fmpy.txt pymoo.txt)

# What hfc show, hfc init and the documentation tell of keys, units and defaults, from the code.
reference: $(VENV)/installed
	$(BIN)/python -m hfc_design.schema

# Pins what pyproject.toml and requirements/*.in ask for, with the hashes of all files of a release;
# what is pinned stays. Newer releases of everything: make lock UPGRADE=--upgrade
lock: $(TOOLS)/installed
	$(LOCK) $(UPGRADE) $(EXTRAS) --group build pyproject.toml -o requirements/locked.txt
	$(LOCK) $(UPGRADE) -c requirements/locked.txt pyproject.toml -o requirements/runtime.txt
	$(LOCK) $(UPGRADE) -c requirements/locked.txt --extra peers --group build pyproject.toml \
		-o requirements/peers.txt
	$(LOCK) --upgrade --resolution lowest-direct $(EXTRAS) --group build pyproject.toml \
		-o requirements/lowest.txt
	for name in tools docs fuzzylite st fmpy pymoo; do \
		$(LOCK) $(UPGRADE) requirements/$$name.in -o requirements/$$name.txt || exit; done
	$(LOCK) $(UPGRADE) --no-deps requirements/sources.in -o requirements/sources.txt

# The files of a release of uPlot as npm has them, which pages of hfc compare hold. Needs npm.
uplot:
	folder=$$(mktemp -d) && cd "$$folder" && npm pack --silent uplot@$(UPLOT) && \
		echo "$(UPLOT_SHA512)  uplot-$(UPLOT).tgz" | sha512sum -c - && tar xzf uplot-$(UPLOT).tgz && \
		cd package && cp LICENSE dist/uPlot.iife.min.js dist/uPlot.min.css \
		$(CURDIR)/hfc_design/report/uplot && rm -r "$$folder"

# An environment is complete when this file is there: first every package, checked against its
# hash, then this project with the pinned build backend.
$(VENV)/installed: pyproject.toml requirements/locked.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install -q --require-hashes -r requirements/locked.txt
	$(BIN)/pip install -q --no-deps --no-build-isolation -e .
	touch $@

$(TOOLS)/installed: requirements/tools.txt
	$(PYTHON) -m venv $(TOOLS)
	$(TOOLS)/bin/pip install -q --require-hashes -r $<
	touch $@

.venv-lowest/installed: pyproject.toml requirements/lowest.txt $(TOOLS)/installed
	$(UV) venv -q --clear --python 3.11 $(@D)
	$(INSTALL) $(@D) -r requirements/lowest.txt
	$(UV) pip install -q --python $(@D) --no-deps --no-build-isolation -e .
	touch $@

.venv-docs/installed: requirements/docs.txt
	$(PYTHON) -m venv $(@D)
	$(@D)/bin/pip install -q --require-hashes -r $<
	touch $@

$(OTHER)/installed: pyproject.toml requirements/locked.txt $(TOOLS)/installed
	$(UV) venv -q --clear --python $(VERSION) $(@D)
	$(INSTALL) $(@D) -r requirements/locked.txt
	$(UV) pip install -q --python $(@D) --no-deps --no-build-isolation -e .
	touch $@

# Other optimizers beside this project, see experiments/search_power.
.venv-peers/installed: pyproject.toml requirements/peers.txt
	$(PYTHON) -m venv $(@D)
	$(@D)/bin/pip install -q --require-hashes -r requirements/peers.txt
	$(@D)/bin/pip install -q --no-deps --no-build-isolation -e .
	touch $@

clean:
	rm -rf $(VENV) .venv-*
