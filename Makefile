# Every target sets up what it needs first: a bare machine wants only python3 (3.11-3.13), git and make.
#   PYTHON=python3.12 make test    takes that interpreter
#   make test ARGS="-m 'not slow'" passes arguments to pytest
VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.bootstrapped
SOURCES := text2sim tests $(wildcard benchmarks)
# Of the path-traced film of the demo: a few seconds per picture without LLVM.
DEMO ?= 480x270
export VENV

.PHONY: help demo test check format fuzz bench setup clean

help:
	@echo 'make demo    set up, run cases/brick_wall, path trace its film, print where film and report are'
	@echo 'make test    set up, run the tests'
	@echo 'make check   set up; format, lint, types, tests: what a change must pass'
	@echo 'make format  set up, put the source in its canonical format'
	@echo 'make fuzz    set up, read 10,000 hostile documents'
	@echo 'make bench   set up, measure'
	@echo 'make clean   remove the environment and the caches'

demo: $(STAMP)
	@$(BIN)/text2sim run cases/brick_wall || [ $$? -eq 3 ] # without OpenGL there is no preview, and yet a film
	@$(BIN)/text2sim render cases/brick_wall --resolution $(DEMO)

test: $(STAMP)
	$(BIN)/python -m pytest $(ARGS)

check: $(STAMP)
	$(BIN)/ruff format --check $(SOURCES)
	$(BIN)/ruff check $(SOURCES)
	$(BIN)/pyright
	$(BIN)/python -m pytest $(ARGS)

format: $(STAMP)
	$(BIN)/ruff check --fix-only $(SOURCES)
	$(BIN)/ruff format $(SOURCES)

fuzz: $(STAMP)
	$(BIN)/python tests/fuzz/trial.py --count 10000 $(ARGS)

bench: $(STAMP)
	$(BIN)/python benchmarks/run.py $(ARGS)

setup: $(STAMP)

# bootstrap compares contents, so a checkout that only touched the files costs a fraction of a second.
$(STAMP): pyproject.toml constraints.txt scripts/bootstrap
	@scripts/bootstrap

clean:
	rm -rf $(VENV) build dist *.egg-info .pytest_cache .ruff_cache .hypothesis
