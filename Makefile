# The project's commands; `make help` lists them.
PYTHON ?= python3
DATA ?=
ESTIMATOR ?=
SECONDS ?= 600
SEED ?=
ROOM ?= force
SINCE ?=
BEFORE ?= .
AFTER ?= .
N ?= 60
ALL ?=
SPEED := dynamics smoothing study
EXCEPT = and not thorough
REAL_TIME = MAKEFLAGS= OMP_NUM_THREADS=1 pytest -m "real_time $(EXCEPT)" --numprocesses 1 -o cache_dir=.pytest_cache/real_time $$(grep -lr mark.real_time tests)
unexport PYTHONDONTWRITEBYTECODE # else each process compiles all that it imports
export PATH := $(CURDIR)/.venv/bin:$(PATH)
PIP := .venv/bin/python -m pip --quiet --quiet --disable-pip-version-check
# torch has no hash: its small CPU build is another file than that of its release elsewhere. pyproject.toml pins it.
FREEZE := .venv/bin/python -m pip freeze --all --exclude pip --exclude arm-force-lab --exclude torch
LOCKED := install --require-hashes --no-deps --requirement
SBOM := .venv/bin/pipx run --spec cyclonedx-bom==7.5.0 cyclonedx-py environment --output-reproducible
HASH := .venv/bin/pipx run uv pip compile --quiet --no-deps --generate-hashes --no-header --no-annotate

all: .venv/ready ## set up, simulate and build the default study, name its report
	snakemake

thesis: .venv/ready ## fetch the thesis's recordings (DATA=folder copies them), build its study
	ur5 fetch thesis $(if $(DATA),--from "$(DATA)")
	snakemake --configfile workflow/studies/thesis.yaml

studies: .venv/ready ## build the default study and every other whose recordings are in raw/
	@failed=; for study in config.yaml $$(grep -l '^study:' workflow/studies/*.yaml); do \
		missing=$$(grep -o 'folder: *raw/[^,} ]*' "$$study" | sed 's/folder: *//' | sort -u \
			| while read folder; do test -d "$$folder" || echo "$$folder"; done | head -n 1); \
		if [ "$$missing" ]; then \
			printf '%s is skipped: %s is missing; ur5 fetch %s\n' "$$study" "$$missing" "$$(printf %s "$$missing" | cut -d/ -f2)"; \
		else snakemake --configfile "$$study" || failed="$$failed $$study"; fi; \
	done; [ -z "$$failed" ] || { echo "failed:$$failed"; exit 1; }

test: .venv/dev ## check style and types, and show every result, command and format, as .ci/run does: some ten minutes
	$(MAKE) tests

test-all: .venv/dev ## the same with the tests marked thorough: installed packages, Slurm, benchmarks, devices in all their faults
	$(MAKE) tests EXCEPT=

tests:
	rm -rf .pytest_cache/late .pytest_cache/studies
	python -m tests.clock
	$(MAKE) --jobs 3 lint test-others test-real-time
	# what did not keep up beside the others is tried again, alone
	test ! -e .pytest_cache/late || $(REAL_TIME) --last-failed --reruns 2 --reruns-delay 5
	python -m tests.clock  # times of two runs compare in units of it

test-others:
	MAKEFLAGS= OMP_NUM_THREADS=1 nice -n 19 pytest -m "not real_time $(EXCEPT)"  # two processes share the work already

test-real-time:
	$(REAL_TIME) || touch .pytest_cache/late

test-fast: lint ## check style and types, and run the tests that are not marked slow: without many arms and designs, studies, devices in real time
	OMP_NUM_THREADS=1 pytest -m "not slow"

test-changed: lint ## check style and types, and run the tests that the change since the branch left origin/main can reach; says what is left out
	OMP_NUM_THREADS=1 python -m tests.changed $(if $(SINCE),--since $(SINCE))

# what has not changed since another clone was checked is not checked again
lint: export MYPY_CACHE_DIR ?= $(or $(XDG_CACHE_HOME),$(HOME)/.cache)/ur5lib/mypy
lint: .venv/dev ## check style and types
	MAKEFLAGS= nice -n 19 pre-commit run --all-files

fuzz: .venv/dev ## damage recordings, studies, arms, models, streams and controllers for SECONDS (600) of the processor; SEED repeats a run
	OMP_NUM_THREADS=1 python -m tests.fuzz --seconds $(SECONDS) $(if $(SEED),--seed $(SEED))

mutants: .venv/dev ## change N (60) operators, signs, numbers or axes of ROOM (force), or of lines new since a commit SINCE, one by one, and list those that no test that reaches them notices; SEED repeats a run
	OMP_NUM_THREADS=1 python -m tests.mutants $(if $(SINCE),--since $(SINCE),$(ROOM)) --number $(N) $(if $(SEED),--seed $(SEED))

bench: .venv/dev ## measure speed side by side: some ten minutes, the default study included
	python -m tests.clock
	for name in $(SPEED); do echo "benchmarks/$$name.py"; python -m benchmarks.$$name || exit 1; done
	python -m tests.clock

times: .venv/dev ## list the processor time of steps and of the slowest tests, of the clones BEFORE and AFTER (this one) side by side
	python -m tests.clock $(BEFORE) $(AFTER)

leaderboard: .venv/ready ## compare all force estimators on the built studies thesis and ur10e, write docs/benchmark.md; ESTIMATOR=package.module:Class adds another
	python -m benchmarks.leaderboard --page $(if $(ESTIMATOR),--estimator "$(ESTIMATOR)")

pictures: .venv/dev ## build the default study and the lesson's, draw the documents' pictures and tables from them anew
	snakemake
	ur5 fetch ur10-bag $(if $(DATA),--from "$(DATA)")
	snakemake --configfile workflow/studies/ur10-bag.yaml
	ur5 excite --robot ur5e --output results/excited
	python -m benchmarks.pages expected pictures

pages: studies ## build the studies whose recordings are in raw/, and from them each number, table and picture of the documents that takes minutes; ALL=--all those of hours, too
	ur5 excite --robot ur5e --output results/excited
	python -m benchmarks.pages $(ALL)

docs: .venv/dev ## build the site, .site/html: documents, notebook, reference, reports of public recordings that are built (make studies)
	rm -rf .site && mkdir -p .site/pages
	cp -RL *.md CITATION.cff LICENSE Snakefile config.yaml docs site ur5lib workflow .site/pages
	python site/pages.py .site/pages
	PROJECT_HOME="$$(python site/pages.py --home)" zensical build --clean --strict >.site/log 2>&1 || { cat .site/log >&2; exit 1; }
	@echo "site: .site/html/index.html"

release: export SOURCE_DATE_EPOCH = $(shell git log -1 --format=%ct)
release: .venv/dev ## build wheel, sdist, site, SBOM and hashes of the last commit in dist, twice alike, and try the wheel in an empty environment
	@test -z "$$(git status --porcelain)" || { echo "a release is of a commit alone: commit or remove what git status lists"; exit 1; }
	rm -rf dist .release && mkdir -p dist .release/source
	git archive HEAD | tar -x -C .release/source
	for folder in dist .release/again; do \
		(cd .release/source && python -m hatchling build --directory "$(CURDIR)/$$folder") || exit 1; done
	diff -r dist .release/again
	$(PYTHON) -m venv .release/empty
	.release/empty/bin/python -m pip --quiet $(LOCKED) requirements.lock
	.release/empty/bin/python -m pip --quiet install dist/*.whl
	cd .release && empty/bin/ur5 --version && empty/bin/ur5 new lab && cd lab && ../empty/bin/ur5 run config.yaml
	$(SBOM) .release/empty/bin/python --output-file dist/sbom.cdx.json
	$(MAKE) docs
	tar --create --sort=name --mtime="@$$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner -C .site html | gzip --no-name >dist/site.tar.gz
	cd dist && sha256sum * >SHA256SUMS && cat SHA256SUMS
	python -m benchmarks.installed --wheel dist/*.whl
	@$(MAKE) --no-print-directory owner

owner: .venv/dev ## say what of a release only the project's owner can do, and is not done
	@grep -q '^repository-code:' CITATION.cff || echo "CITATION.cff has no repository-code, the project's address"
	@grep -q '^doi:' CITATION.cff || echo "CITATION.cff has no doi"
	@! grep -q '^  - name:' CITATION.cff || echo "CITATION.cff names a group and no people as authors"
	@version=v$$(python -c 'import ur5lib; print(ur5lib.__version__)'); \
		git tag --points-at HEAD | grep -qx "$$version" || echo "this commit has no tag $$version"

schema: .venv/ready ## write the schema and the table of a study's settings anew
	ur5 schema > workflow/study.schema.json
	ur5 schema contract > workflow/contract.schema.json
	ur5 settings > docs/settings.md

lock: ## pin the newest versions that pyproject.toml allows, with the hashes of all their files
	rm -rf .venv && $(PYTHON) -m venv .venv
	$(PIP) install hatchling --editable '.[record]'
	$(FREEZE) > .venv/users
	$(PIP) install --editable '.[dev]'
	$(FREEZE) | grep --invert-match --line-regexp --fixed-strings --file .venv/users > .venv/developers
	$(HASH) .venv/users --output-file requirements.lock
	$(HASH) .venv/developers --output-file requirements-dev.lock

clean: ## remove results and the environment; recordings stay
	rm -rf .venv .snakemake results dist .release .pytest_cache .ruff_cache .hypothesis

help: ## list these commands
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "make %-11s %s\n", $$1, $$2}' Makefile

.venv/ready: requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { echo \
		"Python 3.11 or newer is needed; name one: make PYTHON=python3.11"; exit 1; }
	@echo "setting up .venv: $$(grep -c == requirements.lock) packages, some 2 GB; this takes a minute or two"
	@$(PYTHON) -m venv --clear .venv || { echo \
		"$(PYTHON) cannot make .venv; install its venv module, free the disk, or name another: make PYTHON=..."; exit 1; }
	@$(PIP) $(LOCKED) requirements.lock && $(PIP) install --no-build-isolation --editable . || { echo \
		"the packages of requirements.lock cannot be installed; check the network and the disk, or name another Python: make PYTHON=python3.11"; exit 1; }
	@touch $@

.venv/dev: .venv/ready requirements-dev.lock
	@echo "adding what the tests need: $$(grep -c == requirements-dev.lock) packages"
	@$(PIP) $(LOCKED) requirements-dev.lock || { echo \
		"the packages of requirements-dev.lock cannot be installed; check the network and the disk"; exit 1; }
	@touch $@

.PHONY: all thesis studies test test-all tests test-others test-real-time test-fast test-changed lint fuzz mutants bench times leaderboard pictures pages docs release owner schema lock clean help
