# `make` alone lists the targets. All paths are relative, because make cannot spell a path with spaces.

# The interpreter that .venv is made from: make PYTHON=python3.12 paper
PYTHON ?= python3
# Options for the command behind a target: make paper ARGS="--figures 1.6", make test ARGS="-k gap_map"
ARGS =

RUN := .venv/bin/python -m
PYTEST := $(RUN) pytest -n 2 --dist worksteal

# These would put another package in front of ours, or send what pip installs somewhere else than into .venv.
# The index, proxy and certificate settings of the user stay as they are. Bytecode is kept: without it every worker
# compiles the tests anew.
unexport PYTHONDONTWRITEBYTECODE PYTHONPATH PYTHONHOME PYTHONOPTIMIZE PIP_CONSTRAINT PIP_PREFIX PIP_PYTHON PIP_ROOT PIP_TARGET
export PIP_USER := 0
# No window is opened, and what is worth keeping between runs is kept here: the home may be read-only.
export MPLBACKEND := Agg
export MPLCONFIGDIR ?= $(CURDIR)/.venv/matplotlib
export GRAZING_CACHE ?= $(CURDIR)/.venv/kernels

.PHONY: help prepared paper test test-long coverage check lint types types-page layers bench docs explorer clean

help: ## list these targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-10s %s\n", $$1, $$2 }' Makefile

paper: prepared ## draw the figures of the paper and check its claims
	$(RUN) grazing paper $(ARGS)

test: .venv/ready-test prepared ## run the tests and every example in the documentation strings
	$(PYTEST) -rs $(ARGS)

test-long: .venv/ready-test prepared ## run the tests that take long, and those of properties with all examples
	$(PYTEST) -m "long or hypothesis" --hypothesis-profile=thorough $(ARGS)

coverage: .venv/ready-test prepared ## run the tests and report the share of lines that they run; of kernels, as Python
	$(PYTEST) --cov --cov-report=term $(ARGS)

test-numba: .venv/ready-test ## run the tests of kernels with the oldest numba that is allowed, and with the newest
	@sh scripts/numba.sh oldest $(ARGS)
	@sh scripts/numba.sh newest $(ARGS)

check: lint types layers ## lint, types and import direction together

lint: .venv/ready-test ## style and common mistakes (ruff), and whether docs/api.md is current
	$(RUN) ruff check .
	$(RUN) ruff format --check .
	.venv/bin/python docs/make_api.py --check

types: .venv/ready-test types-page ## type annotations (mypy, strict), and those of the page
	$(RUN) mypy

types-page: ## type annotations of the explorer's page (tsc, strict); where no npm is, it says so
	@sh scripts/page.sh types

layers: .venv/ready-test ## the direction of imports
	$(RUN) pytest -q tests/test_layers.py

bench: .venv/ready ## compare speed and missed impacts with other programs (ARGS="--quick", --json FILE, --help)
	$(RUN) benchmarks $(ARGS)

docs: .venv/ready ## write docs/api.md from the documentation strings
	.venv/bin/python docs/make_api.py

prepared: .venv/ready ## compile the kernels of the package before their first use
	@$(RUN) grazing.prepare || echo "grazing: kernels are compiled at their first use"

explorer: .venv/ready ## compile the kernels of the explorer to WebAssembly (needs lld or ziglang; ARGS=--check compares)
	$(RUN) grazing.explorer.build $(ARGS)

clean: ## remove .venv and all caches; results stay
	rm -rf .venv .venv-numba-* node_modules .mypy_cache .pytest_cache .ruff_cache .hypothesis build dist
	find src tests -name __pycache__ -prune -exec rm -rf {} +

# ---- the environment. Its stamp is written last, so an interrupted installation leaves none and is done again.

# A checkout that was copied or moved, or whose Python has been replaced, has a stamp but no working environment.
ifneq ("$(shell .venv/bin/python -I -c 'import pip' 2>/dev/null && cat .venv/folder)","$(CURDIR)")
.PHONY: .venv/ready
endif

.venv/ready: pyproject.toml constraints.txt
	@PYTHON="$(PYTHON)" sh scripts/environment.sh runtime

.venv/ready-test: .venv/ready
	@PYTHON="$(PYTHON)" sh scripts/environment.sh test
