# The two commands that matter: `make demo` runs the main job, `make test` passes the tests.
# Both set up everything they need in .venv, from Python >= 3.11 alone.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PACKAGES := keyed_random values links laws scenarios bus vehicles channel world analysis fleet studies cli
DEMO := runs/demo

.PHONY: setup demo test check docs site diagrams mutants bench chaos soak conformance studio external-cpp picture proto clean

setup: $(VENV)/.ready

$(VENV)/.ready: pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Zenvoy needs Python 3.11 or later")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	mkdir -p .typing/zenvoy
	for file in zenvoy/*.py zenvoy/py.typed; do ln -sfn ../../$$file .typing/zenvoy/; done
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
	$(BIN)/mypy -p zenvoy
	$(BIN)/mypy tests benchmarks examples/neighbourhood docs/site

# Makes docs/api.md from the docstrings of `import zenvoy`, and the tables of keys in docs/scenarios.md with
# their JSON Schema, and then the site. Tests fail when they are stale.
docs: setup
	$(BIN)/python -m tests.api_page
	$(BIN)/python -m tests.scenario_reference
	$(MAKE) --no-print-directory site

# Builds the documentation as a site in build/site, for reading without internet.
site: setup
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build

# Draws new diagrams of docs/ with npm's Mermaid. Needs Node >= 20 and Chromium.
MERMAID := build/mermaid
diagrams: setup
	PUPPETEER_SKIP_DOWNLOAD=1 npm install --no-package-lock --no-audit --no-fund --silent --prefix $(MERMAID) \
		@mermaid-js/mermaid-cli@11
	$(BIN)/python -m docs.site.diagrams $(MERMAID)/node_modules/.bin/mmdc

# Hits the processes of 500 runs with signals at random moments, and compares their ends with
# docs/ends.md. Run it on an idle machine, because it also judges how long an end takes.
chaos: setup
	$(BIN)/python -m tests.chaos --runs 500

# Tests that take minutes: 10,000 connections at the doors of a run, and all commands of the documentation.
soak: setup
	$(BIN)/pytest -q -s tests/fleet/soak_intrusions.py tests/cli/soak_page_commands.py

# Changes 10,000 scenarios at random: each is refused with a message, or runs for 2 s without a NaN.
mutants: setup
	$(BIN)/python -m tests.mutants 10000

bench: $(VENV)/.bench
	$(BIN)/python -m benchmarks

$(VENV)/.bench: $(VENV)/.ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[bench]'
	touch $@

# Reads a log with an independent reader, npm's @mcap/core. Needs Node >= 20.
conformance: setup
	npm install --no-package-lock --ignore-scripts --no-audit --no-fund --silent \
		--fetch-retries 1 --fetch-timeout 30000 --prefix tests/conformance
	rm -rf runs/conformance
	$(BIN)/zenvoy run quickstart --out runs/conformance
	node tests/conformance/check.mjs runs/conformance/run.mcap

# Opens a log and a run in Foxglove Studio with the layout of docs/, in headless Chromium, and takes
# pictures of it. Version 1.48 is the last that npm has. Needs Node >= 20 and Chromium.
STUDIO := build/studio
studio: setup
	command -v chromium || command -v chromium-browser || { echo 'make studio needs Chromium' >&2; exit 1; }
	npm install --no-package-lock --ignore-scripts --no-audit --no-fund --silent --prefix $(STUDIO) \
		@foxglove/studio-base@1.48.0 react@17.0.2 react-dom@17.0.2
	ZENVOY_STUDIO=$(STUDIO)/node_modules $(BIN)/pytest -q tests/analysis/view/studio_panels.py

# Builds the vehicle in C++ against zenoh-c and drives it in a fleet. Needs g++, Debian's
# libprotobuf-dev, protobuf-compiler, nlohmann-json3-dev and python3-dev. zenoh-c has no
# package of its own here: its library comes from a Python extension module that exports it.
CPP := runs/external-cpp
external-cpp: setup
	rm -rf $(CPP) && mkdir -p $(CPP)
	$(BIN)/python -m pip download --quiet --disable-pip-version-check --no-deps --dest $(CPP) \
		rainbow-rb-zenoh==0.10.3
	cd $(CPP) && $(abspath $(BIN))/python -m zipfile -e *.whl . && cp rainbow/rb_zenoh/_core*.so libzenohc.so
	protoc -I bus --cpp_out=$(CPP) messages.proto
	g++ -std=c++17 -O1 -Wall -I tests/zenoh_c -I $(CPP) -o $(CPP)/vehicle \
		examples/external_vehicle/vehicle.cpp $(CPP)/messages.pb.cc -L $(CPP) -lzenohc \
		$$(python3-config --ldflags --embed) -lprotobuf -Wl,-rpath,'$$ORIGIN'
	ZENVOY_VEHICLE_CPP=$(CPP)/vehicle $(BIN)/pytest tests/fleet/external_cpp.py

# The picture of the README, from the log of the demo.
picture:
	$(BIN)/zenvoy analyze $(DEMO)/run.mcap
	cp $(DEMO)/run-analysis/overview.png docs/case-15.png

proto: setup
	cd bus && ../$(BIN)/python -m grpc_tools.protoc -I . --plugin=../$(BIN)/protoc-gen-mypy \
		--python_out=. --mypy_out=. messages.proto
	$(BIN)/python -m tests.scene_schema

clean:
	rm -rf $(VENV) .typing runs build *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis
