# One command for each habit; every target sets up what it needs.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
READY  := $(VENV)/.ready
TOOLS  := $(VENV)/.tools
BOOK   := $(VENV)/.book
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -c constraints.txt
JOBS   ?= 2

.PHONY: help demo test nightly installed gates lint format bench diagnosis-bench mutants docs pictures constraints clean

help:  ## list the targets
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed 's/:.*## /\t/'

$(READY): pyproject.toml constraints.txt setup.py nesting.py pytest_magbench.py
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "magbench needs Python 3.11 or newer: make PYTHON=/path/to/python3.11"; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(INSTALL) -e .
	@touch $@

$(TOOLS): $(READY)
	$(INSTALL) -e '.[test,lint,cluster]'
	@touch $@

$(BOOK): $(TOOLS)
	$(INSTALL) -e '.[docs]'
	@touch $@

demo: $(READY)  ## run the main job: an AUV in circles, from simulation to report
	$(BIN)/magbench run auv-spiral-excited -o out/demo
	@echo "look at out/demo/report.html, or: $(BIN)/magbench show out/demo"

test: $(TOOLS)  ## the test run (a few minutes)
	$(BIN)/pytest -n $(JOBS) --dist worksteal -m 'not slow'

nightly: $(TOOLS)  ## all tests, the slow ones too
	$(BIN)/pytest -n $(JOBS)

installed: $(TOOLS)  ## the wheel and an editable installation beside another project's packages of the same names
	$(BIN)/pytest tests/installed

gates: $(TOOLS)  ## the project's own accuracy gates
	$(BIN)/magbench gate gates.toml -o out/gates --strict

lint: $(TOOLS)  ## style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(TOOLS)  ## put the code into the project's format
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(TOOLS)  ## speed as ratios within one run
	$(BIN)/python -m benchmarks

diagnosis-bench: $(TOOLS)  ## the diagnosis against hidden effects (hours; resumes)
	$(BIN)/python -m benchmarks.diagnosis --jobs $(JOBS) -o out/diagnosis-bench

mutants: $(TOOLS)  ## does the test run notice a mistake? random ones (hours; resumes)
	$(BIN)/python -m benchmarks.mutants -o out/mutants.jsonl

docs: $(BOOK)  ## build the site of docs in out/site, without network; a warning fails
	PYTHONPATH=. $(BIN)/python docs/book.py
	@echo "open out/site/index.html"

pictures: $(TOOLS)  ## make the pictures and tables of README and docs anew
	PYTHONPATH=. $(BIN)/python docs/pictures.py

constraints: $(TOOLS)  ## pin what is installed now
	$(BIN)/python -m pip freeze --exclude-editable | grep '==' > constraints.txt

clean:  ## remove what the targets made
	rm -rf $(VENV) out build *.egg-info .pytest_cache .mypy_cache .ruff_cache
