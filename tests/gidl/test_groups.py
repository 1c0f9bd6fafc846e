"""Long generated lines are broken where their views say so."""

from __future__ import annotations

from gidl.targets.groups import group, laid_out_groups, without_marks

LONG = "x" * 60


def test_a_group_that_fits_stays_on_its_line() -> None:
    text = f"f{group(['a', 'g' + group(['b'], '[', ']')])};"
    assert laid_out_groups(text, closes_alone=False) == "f(a, g[b]);"


def test_an_empty_group_is_a_pair_of_brackets() -> None:
    assert laid_out_groups(f"f{group([])};", closes_alone=False) == "f();"


def test_cpp_closes_after_the_last_part() -> None:
    text = f"  f{group([LONG, LONG])};"
    assert laid_out_groups(text, closes_alone=False) == f"  f(\n      {LONG},\n      {LONG});"


def test_python_closes_on_a_line_of_its_own() -> None:
    text = f"f{group([LONG, LONG])} -> None:"
    expected = f"f(\n    {LONG},\n    {LONG},\n) -> None:"
    assert laid_out_groups(text, closes_alone=True) == expected


def test_a_group_inside_is_broken_when_its_part_is_too_long() -> None:
    text = f"f{group(['a', 'g' + group([LONG, LONG])])}"
    expected = f"f(\n    a,\n    g(\n        {LONG},\n        {LONG},\n    ),\n)"
    assert laid_out_groups(text, closes_alone=True) == expected


def test_commas_and_brackets_in_texts_break_nothing() -> None:
    text = f"f{group([f'say({LONG}, [', LONG])}"
    assert laid_out_groups(text, closes_alone=False).split("\n")[1] == f"    say({LONG}, [,"


def test_text_of_a_user_holds_no_group() -> None:
    assert without_marks(f"a{group(['b'])}") == "a(b)"
