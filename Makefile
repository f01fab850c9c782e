# One command for each habit; every target sets up what it needs.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
READY  := $(VENV)/.ready
JOBS   ?= 2

.PHONY: help demo test nightly installed gates lint format bench diagnosis-bench mutants docs constraints clean

help:  ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed 's/:.*## /\t/'

$(READY): pyproject.toml constraints.txt setup.py nesting.py pytest_magbench.py
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "magbench needs Python 3.11 or newer: make PYTHON=/path/to/python3.11"; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[test,lint,cluster]'
	@touch $@

demo: $(READY)  ## run the main job: an AUV dive, from simulation to report
	$(BIN)/magbench run auv-dive -o out/auv-dive
	@echo "look at out/auv-dive/report.html, or: $(BIN)/magbench show out/auv-dive"

test: $(READY)  ## the test run (a few minutes)
	$(BIN)/pytest -n $(JOBS) --dist worksteal -m 'not slow'

nightly: $(READY)  ## all tests, the slow ones too
	$(BIN)/pytest -n $(JOBS)

installed: $(READY)  ## the wheel and an editable installation beside another project's packages of the same names
	$(BIN)/pytest tests/installed

gates: $(READY)  ## the project's own accuracy gates
	$(BIN)/magbench gate gates.toml -o out/gates --strict

lint: $(READY)  ## style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(READY)  ## put the code into the project's format
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(READY)  ## speed as ratios within one run
	$(BIN)/python -m benchmarks

diagnosis-bench: $(READY)  ## the diagnosis against hidden effects (hours; resumes)
	$(BIN)/python -m benchmarks.diagnosis --jobs $(JOBS) -o out/diagnosis-bench

mutants: $(READY)  ## does the test run notice a mistake? random ones (hours; resumes)
	$(BIN)/python -m benchmarks.mutants -o out/mutants.jsonl

docs: $(READY)  ## make the pictures of README and docs anew
	PYTHONPATH=. $(BIN)/python docs/pictures.py

constraints: $(READY)  ## pin what is installed now
	$(BIN)/python -m pip freeze --exclude-editable | grep '==' > constraints.txt

clean:  ## remove what the targets made
	rm -rf $(VENV) out build *.egg-info .pytest_cache .mypy_cache .ruff_cache
