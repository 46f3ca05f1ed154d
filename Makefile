# Two commands matter: `make verify` and `make test`. Both set up .venv on first use; then .venv/bin/swarmproof is there.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_CONSTRAINT=$(CURDIR)/constraints.txt $(BIN)/python -m pip install --quiet
# `make verify ARGS="--uavs 2 --cus 2"` verifies a part of the matrix
ARGS ?=

.PHONY: verify test margins flights experiments bench deep hostile mutants lint wheel record clean

verify: $(VENV)/.installed
	$(BIN)/swarmproof verify --matrix --report out/verify $(ARGS)
	@echo 'To call swarmproof: $(BIN)/swarmproof --help, or in this shell: export PATH="$(CURDIR)/$(BIN):$$PATH"'

test: $(VENV)/.installed
	$(BIN)/python -m pytest -m "not deep and not hostile" -n auto --dist worksteal $(ARGS)

# Δd_min,cont around the published parameters, with certificates; a second run only checks them. (26) fails for some: 1.
margins: $(VENV)/.installed
	$(BIN)/swarmproof margin --sweep reading=as-sampled:whole-motion:initial-state --sweep T_c=0.01:0.02:0.05 \
	  --sweep v_max=0.5:1 --sweep theta_inverse=1 --sweep d_hat_min=0.35 --sweep j_max=100 --sweep order=2 \
	  --changes 2 --results out/margins --plot out/margins.svg $(ARGS) || test $$? -eq 1

# the circle with 3 CUs without loss, with 10 % loss and with a jam of 10 rounds: every claim, a page each. The last is
# the baseline that ignores loss, which collides: exit code 1
flights: $(VENV)/.installed
	$(BIN)/swarmproof fly circle --cus 3 --report out/flights/none $(ARGS)
	$(BIN)/swarmproof fly circle --cus 3 --loss iid:0.1 --report out/flights/iid $(ARGS)
	$(BIN)/swarmproof fly circle --cus 3 --loss jam:3,10 --report out/flights/jam $(ARGS)
	$(BIN)/swarmproof fly circle --cus 3 --loss jam:3,10 --semantics ignore-loss --report out/flights/jam-ignored $(ARGS) || test $$? -eq 1

# the paper's experiments in a small version, with a page each; `QUICK=` flies them in full, which takes hours and can be
# stopped. Some statements do not agree (1), few seeds decide little (3)
EXPERIMENTS ?= fig3b fig3c fig4 loss
QUICK ?= --quick
experiments: $(VENV)/.installed
	for name in $(EXPERIMENTS); do \
	  $(BIN)/swarmproof reproduce $$name $(QUICK) --results out/results --report out/experiments/$$name $(ARGS); \
	  code=$$?; test $$code -eq 0 -o $$code -eq 1 -o $$code -eq 3 || exit $$code; \
	  test -s out/experiments/$$name/index.html || exit 1; \
	done

# how long plans and flights take, against other solvers and forms of the problem; one core
bench: $(VENV)/.installed
	$(BIN)/python -m tests.bench.planner $(ARGS)

# exhaustive cross-checks of the engine against brute force; minutes
deep: $(VENV)/.installed
	$(BIN)/python -m pytest -m deep -n auto --dist worksteal $(ARGS)

# the program in environments that fail: full disks, closed streams, encodings, kills at any moment; minutes
hostile: $(VENV)/.installed
	$(BIN)/python -m pytest -m hostile -n auto --dist worksteal tests/hostile $(ARGS)

# the modules that soundness rests on with every single place changed, and the tests that notice (docs/mutants.md); resumes
mutants: $(VENV)/.installed
	$(BIN)/python -m tests.quality.run_mutants $(ARGS)

lint: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# build the wheel, install it elsewhere, and run what users run
wheel: $(VENV)/.installed
	rm -rf dist out/wheel
	PIP_DISABLE_PIP_VERSION_CHECK=1 $(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir dist .
	$(BIN)/python -m venv out/wheel 2>/dev/null || $(BIN)/python -m virtualenv --quiet out/wheel
	PIP_DISABLE_PIP_VERSION_CHECK=1 out/wheel/bin/python -m pip install --quiet -c constraints.txt dist/swarmproof-*.whl
	cd out && wheel/bin/swarmproof verify --semantics guarded --report wheel-report
	cd out && wheel/bin/swarmproof fly crossing --loss iid:0.1
	cd out && wheel/bin/swarmproof audit --report wheel-audit
	cd out && wheel/bin/swarmproof margin --set T_c=0.05 --certificate wheel-margin.json
	cd out && wheel/bin/swarmproof margin --check wheel-margin.json

# record the matrix anew; read the difference before you commit it
record: $(VENV)/.installed
	$(BIN)/python -m swarmproof.dmpc_swarm.record > out-matrix.toml
	mv out-matrix.toml checks/swarmproof/dmpc_swarm/matrix.toml

# a Python without ensurepip gets its environment from virtualenv
$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV) 2>/dev/null || { rm -rf $(VENV) && \
	  $(PYTHON) -m pip install --quiet --target .bootstrap virtualenv && \
	  PYTHONPATH=.bootstrap $(PYTHON) -m virtualenv --quiet $(VENV); }

$(VENV)/.installed: pyproject.toml constraints.txt | $(VENV)/bin/python
	$(PIP) --editable '.[bench,plots,test]'
	touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(PIP) --editable '.[bench,dev,plots,test]'
	touch $@

clean:
	rm -rf $(VENV) .bootstrap dist out .pytest_cache .mypy_cache .ruff_cache .hypothesis
