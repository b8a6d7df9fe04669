# Every target sets up what it needs first: a bare machine wants only python3 (3.11-3.13), git and make.
#   PYTHON=python3.12 make test    takes that interpreter
#   make test ARGS="-k friction" passes arguments to pytest
VENV ?= .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.bootstrapped
SOURCES := text2sim tests $(wildcard benchmarks)
# Size of the path-traced film of the demo.
DEMO ?= 480x270
export VENV

# What starts neither the engine nor the path tracer, a browser or npm, and one whole run: tests/conftest.py marks them.
QUICK := smoke or not (engine or tracer or browser or npm or slow)
# One process a core; the tests of a file share what they set up.
PYTEST := $(BIN)/python -m pytest -n logical --dist loadfile --no-loadscope-reorder

.PHONY: help demo test test-all test-changed check lint format fuzz bench setup clean

help:
	@echo 'make demo          set up, run cases/brick_wall, path trace its film, print where film and report are'
	@echo 'make test          set up, run the quick tests: seven minutes on two cores, the first time twelve'
	@echo 'make test-all      set up, run all tests: engine, path tracer, browser'
	@echo 'make test-changed  of the others, those that the changes since SINCE concern, and a share that rotates'
	@echo 'make check         set up; format, lint, types, quick tests: what a change must pass'
	@echo 'make format        set up, put the source in its canonical format'
	@echo 'make fuzz          set up, read 10,000 hostile documents'
	@echo 'make bench         set up, measure'
	@echo 'make clean         remove the environment and the caches'

demo:
	@echo '1 of 4: set-up. Half a minute, and as long as it takes to download 1.5 GB, unless it is done already.'
	@$(MAKE) --no-print-directory setup
	@echo '2 of 4: simulation, verdict, preview. Three minutes on two cores; one, once the physics kernels are compiled.'
	@$(BIN)/text2sim run cases/brick_wall || [ $$? -eq 3 ] # without OpenGL there is no preview, and yet a film
	@echo '3 of 4: a path-traced film of the hit. Half a minute with LLVM, four minutes without.'
	@$(BIN)/text2sim render cases/brick_wall --resolution $(DEMO) --fps 10 --during 0.1:0.9
	@echo '4 of 4: one picture in final quality. A quarter of a minute with LLVM, two minutes without.'
	@$(BIN)/text2sim render cases/brick_wall --resolution 640x360 --quality still --during 0.15:0.35
	@echo "Open $$(ls -td runs/brick_wall-*/report.html | head -1); text2sim render cases/brick_wall makes the whole film."

test: $(STAMP)
	$(PYTEST) -m "$(QUICK)" $(ARGS)

test-all: $(STAMP)
	$(PYTEST) $(ARGS)

SINCE ?= HEAD~1
MINUTES ?= 10
test-changed: $(STAMP)
	$(PYTEST) -m "not ($(QUICK))" --since $(SINCE) --minutes $(MINUTES) $(ARGS) || [ $$? -eq 5 ] # 5: there are none

lint: $(STAMP)
	$(BIN)/ruff format --check $(SOURCES)
	$(BIN)/ruff check $(SOURCES)
	$(BIN)/lint-imports
	$(BIN)/pyright

check: lint test

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
