"""Whatever files that compile look like, fmt, lint and breaking have an answer and no traceback."""

from pathlib import Path

from gidl.breaking import compare
from gidl.compile import compile_files
from gidl.fmt import UnreadableError, layout
from gidl.lint import lint
from hypothesis import HealthCheck, given, reject, settings
from hypothesis import strategies as st

HERE = Path(__file__).parent
IDL = HERE.parents[1] / "idl"
TEXTS = [
    p.read_text(encoding="utf-8")
    for folder in ("good", "lint", "fmt")
    for p in sorted((HERE / folder).rglob("*.gidl"))
]
SETTINGS = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@SETTINGS
@given(st.sampled_from(TEXTS), st.data())
def test_a_line_left_out_doubled_or_moved(tmp_path: Path, text: str, data: st.DataObject) -> None:
    lines = text.split("\n")
    start = data.draw(st.integers(0, len(lines) - 1))
    end = data.draw(st.integers(start, min(len(lines), start + 3)))
    copies = data.draw(st.sampled_from([0, 0, 2]))
    edited = [*lines[:start], *(lines[start:end] * copies), *lines[end:]]
    if data.draw(st.booleans()):
        edited.insert(data.draw(st.integers(0, len(edited))), data.draw(st.sampled_from(lines)))
    place = tmp_path / "some.gidl"
    models = []
    for version in (text, "\n".join(edited)):
        place.write_text(version, encoding="utf-8")
        compiled = compile_files([str(place)], [str(IDL)])
        if compiled.has_errors:
            reject()
        models.append(compiled.model)
        lint(compiled.model)
        try:
            assert layout(layout(version)) == layout(version)
        except UnreadableError as problem:
            assert 1 <= problem.line <= version.count("\n") + 1
    compare(models[0], models[1])
    compare(models[1], models[0])
    assert not compare(models[0], models[0])
