# Everything runs from the root of the repository in its own environment, .venv.

PYTHON ?= python3
CORES ?= 2
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.locked
PAPERS := walton gallas silbert

.DEFAULT_GOAL := help
.PHONY: help setup figures paper $(PAPERS:%=paper-%) test long lint docs clean

help:  ## this list
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-9s%s\n", $$1, $$2 }' $(MAKEFILE_LIST)

setup: $(STAMP)  ## install what studies need into .venv (nothing to do while requirements.lock stands)

$(STAMP): requirements.lock
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "Talus needs Python 3.11 or newer, and '$(PYTHON)' is not: make PYTHON=python3.12 ..." >&2; exit 2; }
	@$(PYTHON) -m venv $(VENV) || { \
	  echo "'$(PYTHON) -m venv' failed: install the venv module of this Python (python3-venv on Debian)" >&2; exit 2; }
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --requirement requirements.lock
	@# Else every job compiles what it imports where PYTHONDONTWRITEBYTECODE is set.
	@$(BIN)/python -m compileall -q -j 0 -x '/tests?/' $(VENV)/lib sim >/dev/null || true
	@printf '#!/bin/sh\nexec "%s/python" "%s/talus.py" "$$@"\n' '$(CURDIR)/$(BIN)' '$(CURDIR)' > $(BIN)/talus
	@chmod +x $(BIN)/talus
	@touch $(STAMP)
	@echo 'ready: . $(VENV)/bin/activate'

figures: setup  ## the quick study: figures and report into results/quick
	$(BIN)/snakemake --cores $(CORES)

paper: $(PAPERS:%=paper-%)  ## all papers in full, published into results/published (hours: see config/README.md)

$(PAPERS:%=paper-%): paper-%: setup
	$(BIN)/python -m sim $(if $(shell grep '^decide:' config/paper_$*.yaml),decide,study) config/paper_$*.yaml --cores $(CORES)
	$(BIN)/python -m sim publish config/paper_$*.yaml

test: $(STAMP)-dev  ## the whole test suite
	@# With a worker restarted after a crash, pytest-xdist waits without end.
	$(BIN)/python -m pytest -n $(CORES) --dist loadfile --no-loadscope-reorder --max-worker-restart 0

long: $(STAMP)-dev $(STAMP)-long  ## tests that take long: published results computed anew, more examples
	$(BIN)/python -m pytest -m long

lint: $(STAMP)-dev  ## ruff, mypy, snakefmt and snakemake --lint
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/snakefmt --check Snakefile workflow
	$(BIN)/snakemake --lint

docs: $(STAMP)-docs  ## the documentation as a site, into build/site
	$(BIN)/python -m mkdocs build --strict --quiet
	@echo 'open build/site/index.html; searching needs: python3 -m http.server -d build/site'

$(STAMP)-%: $(STAMP) requirements-%.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --requirement requirements-$*.lock
	@touch $@

clean:  ## remove .venv and caches; results stay, and .snakemake, which knows what made them
	rm -rf $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
