.PHONY: setup browser demo test lint fuzz bench figures model clean

BIN := .venv/bin

setup:
	@./setup.sh

demo: setup  ## evaluate the built-in catalogue, classify a few objects, and write demo/report.html
	@$(BIN)/python -m compare.demo --out demo

browser:
	@./setup.sh --browser

test: browser lint  ## everything that CI runs
	@$(BIN)/python -m pytest -n 2 --dist loadfile

lint: setup
	@$(BIN)/ruff check -q .
	@$(BIN)/lint-imports > /dev/null || $(BIN)/lint-imports

FILES := 10000

fuzz: setup  ## damaged files of every format, FILES of them, for every reader
	@$(BIN)/python tests/fuzzing.py --files $(FILES)

bench: setup  ## the simulators' speed, beside a naive PyBullet script
	@$(BIN)/python -m compare.bench

figures: setup  ## the pictures in docs/images
	@$(BIN)/python -m compare.gallery --out docs/images

model: setup  ## the models that ship with the package
	@$(BIN)/spherefunc train household --out spherefunc_bullet/models/household-fast.npz
	@$(BIN)/spherefunc train household --backend bullet --out spherefunc_bullet/models/household-bullet.npz

clean:
	rm -rf .venv build demo *.egg-info
