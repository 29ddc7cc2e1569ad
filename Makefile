# Every verb sets up what it needs in .venv from the locked requirements, and is quick when nothing changed.

SHELL := bash
python := .venv/bin/python
# A browser and its server keep more than one processor busy, but not two all the time.
browser_workers := $(shell getconf _NPROCESSORS_ONLN)
# A second BLAS thread beside a busy neighbour makes small products many times slower.
export OPENBLAS_NUM_THREADS := 1

.PHONY: help serve test test-without-browser test-browser lint bench trials release release-image \
    release-replicas release-list release-audit init lock development
.DEFAULT_GOAL := help

help:
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "make %-8s %s\n", $$1, $$2 }' Makefile

serve: ## serve the laboratory on http://127.0.0.1:8050
	@scripts/environment.sh serve
	@exec $(python) app.py

# The browser tests are run whether or not the others pass, after them: beside them they would be slow and restless.
test: development ## run all tests
	@$(MAKE) --no-print-directory --keep-going -j1 test-without-browser test-browser

# Compiled once: otherwise each worker, and each server that a test starts, compiles the same loops.
test-without-browser: development
	$(python) -m tracker_core compile
	$(python) -m pytest -n auto --maxprocesses 8 --dist worksteal --ignore tests/browser

test-browser: development
	@chromium=$$(scripts/chromium.sh) || exit 1; \
	if [ -n "$$chromium" ]; then \
	    set -x; GAINSCOPE_CHROMIUM=$$chromium $(python) -m pytest -n $(browser_workers) --maxprocesses 4 --dist worksteal tests/browser; \
	else \
	    printf '\n*** THE BROWSER TESTS WERE NOT RUN: there is no Chromium, see above. ***\n\n'; \
	fi

lint: development ## check style, types and who imports whom
	$(python) -m ruff check
	$(python) -m ruff format --check
	$(python) -m mypy
	.venv/bin/lint-imports --no-logo

bench: development ## measure the program, beside C and other packages
	@scripts/environment.sh bench
	@chromium=$$(scripts/chromium.sh) || exit 1; \
	set -x; GAINSCOPE_CHROMIUM=$$chromium $(python) -m benchmarks

# About an hour and a half; the tests have the short version in them.
trials: development ## try what a server bears and survives: users, time, broken questions, kills
	@chromium=$$(scripts/chromium.sh) || exit 1; \
	set -x; GAINSCOPE_CHROMIUM=$$chromium $(python) -m trials $(TRIALS)

# BUILD: options for whatever builds the image, each as --option=...; AUDIT=--unasked-is-fine where no index can be asked.
release: development ## build the container image and try it, alone and behind a proxy; list and audit what is in it
	@scripts/environment.sh release .venv-release
	@$(MAKE) --no-print-directory --keep-going -j1 release-image release-replicas release-list release-audit

release-image:
	$(python) -m trials.container $(BUILD)

release-replicas:
	@chromium=$$(scripts/chromium.sh) || exit 1; \
	set -x; GAINSCOPE_CHROMIUM=$$chromium $(python) -m trials.replicas

release-list:
	@mkdir -p artifacts
	.venv-release/bin/cyclonedx-py requirements --pyproject pyproject.toml --output-reproducible --validate \
	    --output-format JSON --output-file artifacts/gainscope.cdx.json requirements/serve.txt

release-audit:
	.venv-release/bin/python scripts/audit.py $(AUDIT)

init: development ## set up everything for development
	@scripts/chromium.sh >/dev/null

development:
	@scripts/environment.sh dev

# After a change of the dependencies in pyproject.toml; `make lock UPGRADE=--upgrade` takes the newest of all. Needs uv.
locking := uv pip compile pyproject.toml --quiet --universal --python-version 3.11 --generate-hashes --no-header $(UPGRADE)

lock:
	$(locking) --extra web --extra cluster -o requirements/serve.txt
	$(locking) --extra web --extra cluster --group test --group lint -c requirements/serve.txt -o requirements/dev.txt
	$(locking) --group bench -c requirements/dev.txt -o requirements/bench.txt
	$(locking) --group release -c requirements/dev.txt -o requirements/release.txt
