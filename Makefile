# make report   everything from nothing: environment, pictures, comparisons, reports/html/index.html
# make test     the linter and the tests; most of them with kernels that compile in half the time, see tests/conftest.py
# make check    the linter, and the tests that take no time
# make fuzz     5000 hostile inputs against the command line; takes its time
# make enclosures  every number type against python-flint on a million arguments a function
# make docs     the pages under docs/ as HTML
# make bench    ratios to other programs; wants the machine to itself
# make clean    removes what the two made; the next run starts from nothing

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin

.PHONY: report test check fuzz enclosures docs bench clean

# what the report shows; each suite keeps what it has finished, and exit code 1 says that something differs
SUITES := "compare --largest 320 --jobs 3 --report reports/html" "transport --jobs 3" "stability" "attribute --wrong-on-purpose --jobs 6" \
          "chart figure-07-torus figure-reflection --growth samples --growth threads -o results" \
          "plan figure-05-sphere figure-07-torus effect-mixing --size 160x120 --results results"

report: $(VENV)/installed
	@for suite in $(SUITES); do echo "raytruth $$suite"; $(BIN)/raytruth $$suite || [ $$? -eq 1 ] || exit 1; \
	  [ -z "$$(find results -maxdepth 1 -name '*.json' ! -name times.json -newer reports/html/index.html)" ] || \
	  $(BIN)/raytruth report || exit 1; done
	@echo "open reports/html/index.html"

test: $(VENV)/installed
	$(BIN)/ruff check .
	@failed=0; \
	RAYTRUTH_NARROW_KERNELS=1 $(BIN)/python -m pytest -n 2 --dist loadfile -m "not wide" || failed=1; \
	$(BIN)/python -m pytest -n 2 --dist loadfile -m wide || failed=1; \
	exit $$failed

check: $(VENV)/installed
	$(BIN)/ruff check .
	$(BIN)/python -m pytest -n 2 --dist loadfile -m "not slow"

fuzz: $(VENV)/installed
	$(BIN)/python tests/fuzz/fuzz.py --inputs 5000

enclosures: $(VENV)/installed
	$(BIN)/python tests/reference_tracer/enclosures.py --count 1000000

docs: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[docs]'
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet
	@echo "open results/docs/index.html"

bench: $(VENV)/installed
	$(BIN)/raytruth bench

$(VENV)/installed: pyproject.toml setup.py constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "raytruth needs Python 3.11 or later; name one: make PYTHON=python3.12 ..."; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[test]'
	@touch $@

clean:
	rm -rf $(VENV) results reports/html
