"""What both languages write and refuse as JSON: type of everything.gidl, text, outcome."""

from __future__ import annotations

from type_values import Case

WRITTEN = [
    ("Grows", "{}", '{"first": 0, "second": 2.5, "third": null, "fourth": "x"}'),
    ("Choice", '{"tag": 2, "value": "two"}', '{"tag": 2, "value": "two"}'),
    ("Gap", '{"tag": 7}', '{"tag": 7}'),
    (
        "Masks",
        '{"lit": ["TOP", "LEFT"], "bits": {"mode": 5}, "level": "HIGH"}',
        '{"lit": ["LEFT", "TOP"], "broad": [], "bits": {"mode": 5, "on": false, "offset": 0},'
        ' "level": "HIGH"}',
    ),
    (
        "Maps",
        '{"places": [[2, {"x": 1}], [-1, {}]], "names": [["BLUE", ["b"]]]}',
        '{"counts": [], "places": [[-1, {"x": 0.0, "y": 0.0, "z": 0.0}],'
        ' [2, {"x": 1.0, "y": 0.0, "z": 0.0}]], "names": [["BLUE", ["b"]]]}',
    ),
    (
        "Limits",
        '{"both": -0.5, "lower": "inf", "few": 2}',
        '{"both": -0.5, "lower": "inf", "upper": 0, "share": 0, "few": 2}',
    ),
    (
        "Words",
        '{"pass": "hunter2", "value": 1e300}',
        '{"class": 0, "def": 0, "encode": 0, "size": 0, "to": 0, "pass": "***", "value": 1e300}',
    ),
]

REFUSED = [
    ("Numbers", "{", "not JSON: "),
    ("Numbers", "[]", "an object is expected, a list is there"),
    ("Numbers", '{"i8": 128}', "i8: 128 is not a whole number from -128 to 127"),
    ("Numbers", '{"u64": -1}', "u64: -1 is not a whole number from 0 to 2**64 - 1"),
    ("Numbers", '{"i32": 1.0}', "i32: 1.0 is not a whole number from -2147483648 to"),
    ("Numbers", '{"u16": 2.5}', "u16: 2.5 is not a whole number from 0 to 65535"),
    ("Numbers", '{"i32": true}', "i32: a whole number is expected, a boolean is there"),
    ("Numbers", '{"flag": 1}', "flag: a boolean is expected, a number is there"),
    ("Numbers", '{"twice": "1"}', "twice: a number is expected, a text is there"),
    ("Numbers", '{"letter": "ab"}', "letter: one character of Latin-1 is expected"),
    ("Numbers", '{"wide": 1}', "wide: unknown member; the known members are flag, raw, letter, "),
    ("Holds", '{"one": {"first": null}}', "one.first: a whole number is expected, null is there"),
    ("Holds", '{"many": [{}, {"fourth": 1}]}', "many[1].fourth: a text is expected, a number"),
    ("Holds", '{"pair": [{}]}', "pair: 2 elements are expected, 1 are there"),
    ("Holds", '{"form": {"tag": "RED", "value": "x"}}', "form.value: a number is expected"),
    ("Holds", '{"form": {"value": 1}}', "form: the union's discriminator is missing: tag"),
    (
        "Holds",
        '{"form": {"tag": "RED"}}',
        "form: the member 'value' is missing: the tag of this union selects an arm, and each "
        "arm has a value",
    ),
    (
        "Gap",
        '{"tag": 7, "value": 1}',
        "value: the tag of this union allows no member of this name",
    ),
    ("Sequences", '{"colours": ["PINK"]}', "colours[0]: unknown name PINK; the known names are R"),
    ("Masks", '{"lit": ["LEFT", "UP"], "level": "LOW"}', "lit[1]: unknown name UP; "),
    ("Maps", '{"counts": [["a", 1], ["a", 2]]}', "counts[1]: the map already has this key"),
    ("Maps", '{"counts": [["a"]]}', "counts[0]: a pair of key and value is expected"),
    ("Arrays", '{"grid": [[1, 2, 3], [1, 2]]}', "grid[1]: 3 elements are expected, 2 are there"),
    ("Limits", '{"few": 0}', "Limits.few: 0 is outside [1, 3]; give at least 1"),
    (
        "Limits",
        '{"few": 1, "share": 101}',
        "Limits.share: 101 is outside [0, 100]; give at most 100",
    ),
]

BOTH_REFUSE = [
    ("Numbers", '{"twice": 1e999}', "not JSON: 1e999 is too large for a number"),
    ("Numbers", '{"i64": 1' + "0" * 5000 + "}", "not JSON: 1000000000000000000000000000000000000"),
    ("Numbers", '{"single": 1e39}', "single: 1e+39 is not a number that fits in single precision"),
    ("Numbers", '{"i8": 1, "i8": 2}', "i8: the member occurs twice"),
    ("Numbers", "\ufeff{}", "not JSON: "),
    ("Numbers", '{"twice": NaN}', "not JSON: NaN"),
    ("Numbers", '{"letter": "\u0100"}', "letter: one character of Latin-1 is expected"),
    ("Words", '{"pass": "***"}', "pass: the text stands for a secret that was left out"),
    ("Words", '{"pass": "a\\u0000b"}', "Words.pass: "),
    ("Sequences", '{"few": [1, 2, 3, 4]}', "Sequences.few: 4 elements, at most 3 are allowed"),
    ("Sequences", '{"poses": [{"orientation": {"w": "nan"}}]}', "poses[0]: not a valid value of"),
    ("Tree", '{"below": [' * 60 + "{}" + "]}" * 60, "nested deeper than 100"),
    ("Tree", '{"below": [' * 2000 + "{}" + "]}" * 2000, "nested deeper than 100"),
]


def without_nan(case: Case) -> bool:
    return "nan" not in repr(case.value)
