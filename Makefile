# make report   everything from nothing: environment, pictures, comparisons, reports/html/index.html
# make test     the tests
# make bench    how fast, as ratios to others; takes its time, and wants the machine to itself
# make clean    removes what the two made; the next run starts from nothing

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin

.PHONY: report test bench clean

report: $(VENV)/installed
	@# exit code 1 says that something differs, which is what the report is for
	@$(BIN)/raytruth compare || [ $$? -eq 1 ]
	@$(BIN)/raytruth stability || [ $$? -eq 1 ]
	@$(BIN)/raytruth report
	@echo "open reports/html/index.html"

test: $(VENV)/installed
	$(BIN)/python -m pytest

bench: $(VENV)/installed
	$(BIN)/python -m comparisons.bench

$(VENV)/installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "raytruth needs Python 3.11 or later; name one: make PYTHON=python3.12 ..."; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[test]'
	@touch $@

clean:
	rm -rf $(VENV) results reports/html
