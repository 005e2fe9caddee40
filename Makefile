.PHONY: setup tools demo test quick newest lint packages wheel-check fuzz mutants bench scans tables site figures model scan-model clean

BIN := .venv/bin

# Bytecode is kept whatever the environment says: tests start hundreds of processes, each of which would compile all anew.
export PYTHONDONTWRITEBYTECODE :=

setup:
	@./setup.sh

demo: setup  ## evaluate the built-in catalogue, classify a few objects, and write demo/report.html
	@$(BIN)/spherefunc demo --out demo

tools:  ## what tests, style and documents need beside what runs
	@./setup.sh --tests

# Files of tests to two processes, in the order of tests/conftest.py.
TWO := -n 2 --dist loadfile --no-loadscope-reorder

test: tools lint  ## style and all tests
	@$(BIN)/python -m pytest $(TWO)

quick: tools  ## the tests that are not marked as slow
	@$(BIN)/python -m pytest $(TWO) -m "not slow"

lint: tools  ## style, imports that run one way, and the types of the public names
	@$(BIN)/ruff check -q .
	@$(BIN)/ruff format -q --check .
	@rm -rf build/installed && mkdir -p build/installed
	@cp -r spherefunc_bullet build/installed/ && cp -r fast_sim scenes compare build/installed/spherefunc_bullet/
	@cd build/installed && ../../$(BIN)/lint-imports --config ../../pyproject.toml --no-cache > lint.txt || (cat lint.txt; exit 1)
	@cd build/installed && ../../$(BIN)/mypy --strict --follow-imports=silent --no-error-summary ../../tests/support/typed_script.py

PYTHON ?= python3
PACKAGES := *

packages: tools  ## wheel and source package, in build/packages
	@rm -rf build/packages build/bdist.* build/lib && mkdir -p build/packages  # also what an interrupted run left
	@$(BIN)/python -m pip wheel -q --no-deps -w build/packages .
	@$(BIN)/python -c "import setuptools.build_meta as b; b.build_sdist('build/packages')" >/dev/null 2>&1

wheel-check: packages  ## each of PACKAGES (*.whl, *.tar.gz, or both) in an empty environment of PYTHON, outside the checkout
	@rm -rf build/elsewhere && mkdir -p build/elsewhere
	@set -e; cd build/elsewhere; for package in ../packages/$(PACKAGES); do \
		echo "$$package, $$($(PYTHON) -V)"; $(PYTHON) -m venv --clear ../empty; ../empty/bin/pip install -q "$$package"; \
		../empty/bin/spherefunc dataset build household objects --seed 7; \
		../empty/bin/spherefunc classify objects/mug_02.ply; ../empty/bin/spherefunc backends; done

# The newest Python of this machine, if one is newer than the oldest that is supported.
NEWEST = $(shell for python in /usr/bin/python3.1? /usr/local/bin/python3.1? ~/.pyenv/versions/3.1*/bin/python3; do \
	$$python -c 'import sys; v = sys.version_info[:2]; v > (3, 11) and print(*v, sys.executable)' 2>/dev/null; \
	done | sort -k1,1n -k2,2n | tail -n 1 | cut -d " " -f 3)

# What another Python or newer packages may change: compiled kernels, files that are read and written, and what
# scikit-learn asks and gives. It needs no PyBullet, which has no wheel there, and no checkout around it. One process,
# since each would compile all kernels.
LIKELY := clouds/test_cloud.py fast_sim/test_roller.py formats learning/test_classifier.py \
	learning/test_estimators.py::test_scikit_learn_contract learning/test_learnt_models.py learning/test_model_file.py \
	settling/test_drops.py settling/test_simulation_cache.py

newest: packages  ## the source package in an empty environment of the newest Python here, and there what may differ
	@newest=$(NEWEST); if [ -z "$$newest" ]; then echo "no Python newer than 3.11 here: no tests with one"; else set -e; \
		$$newest -V; $$newest -m venv --clear build/newest; \
		build/newest/bin/pip install -q --no-compile --disable-pip-version-check \
			"$$(ls build/packages/*.tar.gz)[formats]" pytest hypothesis; \
		mkdir -p build/elsewhere; cd build/elsewhere; \
		../newest/bin/pytest -c ../../pyproject.toml -m "not slow" $(addprefix ../../tests/,$(LIKELY)); fi

FILES := 10000

fuzz: tools  ## damaged files of every format, FILES of them, for every reader
	@$(BIN)/python tests/support/fuzzing.py --files $(FILES)

SAMPLE := 400

mutants: tools  ## small changes to the code, SAMPLE of them, and which the tests notice: an hour or two; not in CI
	@$(BIN)/python -m pip install -q --disable-pip-version-check -e ".[mutation]"
	@mkdir -p build/mutants
	@$(BIN)/python tests/support/mutating.py --sample $(SAMPLE) | tee build/mutants/table.txt

SCANS := ../shared/data/scenes

bench: tools  ## the simulators' speed, beside a naive PyBullet script and MuJoCo
	@$(BIN)/python -m spherefunc_bullet.compare.bench
	@$(BIN)/python -m spherefunc_bullet.compare.bench peers
	@$(BIN)/python -m spherefunc_bullet.compare.bench mechanics
	@$(if $(wildcard $(SCANS)),$(BIN)/python -m spherefunc_bullet.compare.bench scene_stages $(SCANS))

scans: tools  ## the benchmark of real scans: by object and by place, by function and source, with intervals
	@$(BIN)/python -m spherefunc_bullet.compare.rooms.real_scans $(SCANS)

site: tools  ## the documents as pages, in build/site, without the network
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

figures: setup  ## the pictures in docs/images
	@$(BIN)/python -m spherefunc_bullet.compare.demo --out docs/images

MODELS := spherefunc_bullet/learning/models
LIKE_HOUSEHOLD := build/household-1 build/household-2 build/household-3 build/household-4 build/household-5

# Objects by other people; those whose licence allows it are learnt too.
OTHERS := $(wildcard ../shared/data/models)
WHOLE := household build/impaired $(LIKE_HOUSEHOLD) $(if $(OTHERS),build/others)
# Copies of these are many: the more, the better tables in use are known (docs/in_use.md).
COPIES := $(patsubst %,build/household-%-impaired,1 3 4) $(if $(OTHERS),build/others-impaired)
FEWER_COPIES := $(filter %-1-impaired %/others-impaired,$(COPIES))  # bullet takes hours for these
VARIETY := build/variety-1 build/variety-2 build/variety-3 build/variety-1-impaired
DRAWN := $(patsubst scenes/drawn/%.zip,build/%,$(wildcard scenes/drawn/drawn-*.zip))

model: setup $(filter build/%,$(WHOLE) $(COPIES) $(VARIETY) $(DRAWN))  ## those that ship with the package
	@$(BIN)/spherefunc train $(WHOLE) $(COPIES) $(VARIETY) $(DRAWN) --backend fast --out $(MODELS)/household-fast.npz
	@$(BIN)/spherefunc train $(WHOLE) $(FEWER_COPIES) $(filter-out %-impaired,$(VARIETY)) $(DRAWN) --backend bullet \
		--out $(MODELS)/household-bullet.npz

CATALOGUE := $(shell find scenes/household scenes/impairment -name '*.py')  # what is made of older ones is stale

build/impaired: $(CATALOGUE)  ## copies of some objects of household: useless, harmlessly changed, in use, as sensed
	@rm -rf $@ && $(BIN)/spherefunc dataset impair household $@ --copied 12

build/household-%-impaired: build/household-%
	@rm -rf $@ && $(BIN)/spherefunc dataset impair $< $@ --copied 30 --seed $*

build/variety-%-impaired: build/variety-% $(CATALOGUE)
	@rm -rf $@ && $(BIN)/spherefunc dataset impair $< $@ --copied 30 --seed $*

$(filter-out %-impaired,$(VARIETY)) $(DRAWN) build/exam: build/%: scenes/drawn/%.zip  ## sets of objects, each drawn in another style; the exam is never learnt
	@rm -rf $@ && $(BIN)/python -m zipfile -e $< $@

build/others: $(OTHERS)/manifest.csv  ## what other people's licences allow to learn from
	@rm -rf $@ && $(BIN)/spherefunc dataset select $(OTHERS) $@ --permissive

build/others-impaired: build/others $(CATALOGUE)  ## copies of some of these
	@rm -rf $@ && $(BIN)/spherefunc dataset impair build/others $@ --copied 24

SCAN_ROOMS := 182
JOBS := 1
# The model before this one, which has learnt 224 other rooms: its trees vote as well.
EARLIER := 5b95c01:spherefunc_bullet/learning/models/household-scans-fast.npz

scan-model: setup $(LIKE_HOUSEHOLD) $(DRAWN)  ## the one for scans, which learns proposals in virtual rooms, and whole models
	@git show $(EARLIER) > build/earlier-scans-fast.npz
	@$(BIN)/python -m spherefunc_bullet.compare.rooms.scan_model household $(LIKE_HOUSEHOLD) $(DRAWN) --rooms $(SCAN_ROOMS) \
		--join build/earlier-scans-fast.npz --keep build/scan-rooms --jobs $(JOBS) --out build/scans-fast.npz
	@$(BIN)/python -m spherefunc_bullet.compare.rooms.screening household $(LIKE_HOUSEHOLD) $(DRAWN) \
		--model build/scans-fast.npz --keep build/scan-rooms --jobs $(JOBS) --out $(MODELS)/household-scans-fast.npz

build/household-%: $(CATALOGUE)  ## another catalogue like household; from 4 on in other proportions as well
	@rm -rf $@ && $(BIN)/spherefunc dataset build household $@ --seed $* --stretch $(if $(filter 1 2 3,$*),0,0.15)

ONLY :=
ALL :=

tables: tools build/impaired $(LIKE_HOUSEHOLD)  ## measures what is older than its code (ONLY some, or ALL), and writes tables
	@$(BIN)/python -m spherefunc_bullet.compare.documents $(ONLY) $(if $(ALL),--all)

clean:
	rm -rf .venv build demo *.egg-info
