# The two commands that matter: `make demo` runs the main job, `make test` passes the tests.
# Both set up everything they need in .venv, from Python >= 3.11 alone.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PACKAGES := scenarios bus vehicles channel world analysis cli
DEMO := runs/demo

.PHONY: setup demo test check bench conformance picture proto clean

setup: $(VENV)/.ready

$(VENV)/.ready: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Zenvoy needs Python 3.11 or later")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	mkdir -p .typing/zenvoy
	for package in $(PACKAGES); do ln -sfn ../../$$package .typing/zenvoy/$$package; done
	touch $@

demo: setup
	rm -rf $(DEMO)
	$(BIN)/zenvoy run paper/case-15 --out $(DEMO)

test: check
	$(BIN)/pytest -n 2 --dist loadfile

check: setup
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy $(foreach package,$(PACKAGES),-p zenvoy.$(package))
	$(BIN)/mypy tests benchmarks

bench: $(VENV)/.bench
	$(BIN)/python -m benchmarks

$(VENV)/.bench: $(VENV)/.ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[bench]'
	touch $@

# Reads a log with the reader of another house: npm's @mcap/core. Needs Node >= 20.
conformance: setup
	npm install --no-package-lock --ignore-scripts --no-audit --no-fund --silent \
		--fetch-retries 1 --fetch-timeout 30000 --prefix tests/conformance
	rm -rf runs/conformance
	$(BIN)/zenvoy run quickstart --out runs/conformance
	node tests/conformance/check.mjs runs/conformance/run.mcap

# The picture of the README, from the log of the demo.
picture:
	$(BIN)/zenvoy analyze $(DEMO)/run.mcap
	cp $(DEMO)/run-analysis/overview.png docs/case-15.png

proto: setup
	cd bus && ../$(BIN)/python -m grpc_tools.protoc -I . --plugin=../$(BIN)/protoc-gen-mypy \
		--python_out=. --mypy_out=. messages.proto

clean:
	rm -rf $(VENV) .typing runs build *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
