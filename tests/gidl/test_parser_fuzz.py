"""Some seconds' worth of tests/fuzz/parser_fuzz.py: the same inputs in every run."""

import importlib.util
from itertools import islice
from pathlib import Path

PROGRAM = Path(__file__).parents[1] / "fuzz" / "parser_fuzz.py"


def test_bent_files_give_findings_and_no_traceback(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("parser_fuzz", PROGRAM)
    assert spec is not None and spec.loader is not None
    fuzz = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(fuzz)
    for number, data in enumerate(islice(fuzz.inputs(1), 20)):
        try:
            fuzz.check(data, tmp_path / "some.gidl")
        except Exception as problem:
            raise AssertionError(f"input {number}: {data!r}") from problem
