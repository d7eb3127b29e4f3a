# Every target makes the environment it needs in .venv; the second time that costs nothing.
# Another Python: make study PYTHON=/path/to/python3

PYTHON ?= python3
BIN := .venv/bin
STUDY ?= study
ROADS ?= resco
MEMORIES ?= memories

# The packages come uncompiled: a shell that forbids Python to keep what it compiles, as those of
# containers often do, would have every process compile them anew, which takes seconds each.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help study resco memories test coverage compiled quick check lint bench release clean

help: ## Show the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / {printf "make %-8s %s\n", $$1, $$2}' Makefile

study: .venv/run.stamp ## Run the paper's study and write its report
	@$(BIN)/dmil study paper --out $(STUDY)
	@echo "The report: $(STUDY)/report.html"

resco: .venv/dev.stamp ## Run the study on the RESCO benchmark in SUMO (half an hour on two cores)
	@$(BIN)/dmil study resco --out $(ROADS)

memories: .venv/dev.stamp ## Run the study of memories, deep rivals too (an hour or two on two cores)
	@$(BIN)/dmil study memories --out $(MEMORIES)

# Half of the tests each: what a file of tests prepares, mostly one worker alone prepares.
WORKERS := -n 2 --dist worksteal
# The core: no SUMO, no networks of neurons, no commands, no studies.
CORE := tests/golden $(addprefix tests/unit/,controllers demand memory network scenarios simulation symmetry training)

test: .venv/dev.stamp compiled ## Run the tests
	$(BIN)/pytest $(WORKERS)

coverage: .venv/dev.stamp compiled ## Run the tests and see that they cover at least 90 % of the lines
	@$(BIN)/coverage erase
	$(BIN)/coverage run -m pytest $(WORKERS)
	@$(BIN)/coverage combine --quiet
	@$(BIN)/coverage report

# Before, so that no two workers compile the same kernels.
compiled: .venv/dev.stamp
	@$(BIN)/python tests/compiled.py

quick: .venv/dev.stamp ## Run the tests of the core; with compiled kernels that takes less than a minute
	$(BIN)/pytest -q $(WORKERS) -m 'not slow' -k 'not sumo' --ignore tests/unit/controllers/deep $(CORE)

check: lint test ## Run everything that must be green before a change goes in

lint: .venv/dev.stamp ## Check format, style, types and who imports whom
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: .venv/run.stamp ## Measure the simulator's and the learner's speed; AGAINST=DIR: beside another checkout
	@$(BIN)/dmil bench $(if $(AGAINST),--against "$(AGAINST)")

release: .venv/dev.stamp ## Build wheel and sdist and try both in environments of their own
	@PYTHON="$(PYTHON)" scripts/release.sh

clean: ## Remove the environment and caches; results of studies stay
	rm -rf .venv .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	rm -rf .coverage .coverage.* build dist
	find src tests scripts -name __pycache__ -type d -prune -exec rm -rf {} +

.venv/run.stamp: constraints.txt pyproject.toml scripts/environment.sh
	@PYTHON="$(PYTHON)" scripts/environment.sh run
	@touch $@

.venv/dev.stamp: constraints.txt constraints-dev.txt constraints-torch.txt pyproject.toml scripts/environment.sh
	@PYTHON="$(PYTHON)" scripts/environment.sh dev
	@touch $@ .venv/run.stamp
