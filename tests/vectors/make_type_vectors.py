"""Writes types.json beside itself: values of interface types and their bytes, which C++, Python and
lcm-gen's code must agree on. The bytes come from `encoded` in tests/generated/type_values.py, which
shares no code with any of them. Run it after adding a case, and review the difference.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent / "generated"), str(HERE.parents[1] / "codegen")]

from type_values import encoded, load  # noqa: E402  (beside the tests that use it)

FRAME = {
    "position": {"x": 0.4521, "y": -0.15, "z": 0.4318},
    "orientation": {"w": 0.5, "x": -0.5, "y": 0.5, "z": 0.5},
}
NUMBERS = {
    "flag": True, "raw": 255, "letter": "\u00fc", "i8": -128, "u8": 200, "i16": -32768,
    "u16": 65535, "i32": -(2**31), "u32": 2**32 - 1, "i64": -(2**63), "u64": 2**64 - 1,
    "single": -0.15625, "twice": 0.1,
}  # fmt: skip
GROWN = {"first": -7, "second": 1.25, "third": "\u00e4", "fourth": ""}

CASES: list[tuple[str, str, Any]] = [
    ("gecos::Grant", "as made", {}),
    ("gecos::Grant", "master", {"status": "MASTER", "epoch": 2**63 + 5}),
    ("gecos::Subscription", "third stream", {"stream": 3, "newest": 2**63 + 7}),
    ("gecos::FeedReport", "as made", {}),
    (
        "gecos::FeedReport",
        "one is too old",
        {"admitted": 2**40, "too_old": 1, "last_refusal": "it is too old", "expired": True},
    ),
    ("gecos::OutcomeRecord", "as made", {}),
    ("gecos::OutcomeRecord", "stopped", {"detail": 16, "text": "stopped by ann"}),
    ("gecos::Holder", "somebody", {
        "status": "ACTOR", "user": "ada", "host": "lab", "program": "02_grip_block", "pid": 4711,
        "held_for": 12.5, "expires_in": 0.25, "releasing": True}),
    ("gecos::WaitingRequest", "somebody", {
        "id": 3, "wanted": "ACTOR", "user": "ada", "host": "lab", "program": "02_grip_block",
        "pid": 4711, "waited_for": 1.5, "expires_in": 58.5}),
    ("gecos::RosterChange", "silent", {
        "number": 2**52, "what": "ENDED", "holder": {"user": "ada", "pid": 4711}, "ago": 0.25,
        "why": "its holder has been silent for 500 ms"}),
    ("gecos::Roster", "nobody", {"newest": 2**52}),
    ("gecos::OutcomeCount", "done", {"detail": 5, "calls": 2**40}),
    ("gecos::OperationStats", "moves", {
        "operation": "move", "begun": 3, "ended": [{"detail": 5, "calls": 2}],
        "deadline_missed": 1, "start_by_missed": 4, "median": 0.5, "percentile_99": 2.0,
        "worst": 2.5}),
    ("gecos::StreamStats", "one reader", {
        "stream": "tool", "samples": 4, "bytes": 224, "dropped": 1, "readers": 1}),
    ("gecos::InwardStats", "nothing came", {"stream": "alter", "samples": {}}),
    ("gecos::SessionStats", "somebody", {
        "user": "ada", "host": "lab", "program": "lift.py", "pid": 4711, "medium": "shm",
        "connected_for": 1.5, "begun": 3, "ended": [{"detail": 9, "calls": 1}]}),
    ("gecos::ObjectStats", "new", {"served_for": 0.25}),
    ("gecos::RunningHandler", "one that waits", {
        "operation": "label", "running_for": 0.5, "user": "ada", "host": "lab",
        "program": "lift.py", "pid": 4711, "waits_for": "RX90.move"}),
    ("gecos::StatusRefused", "two holders", {
        "reason": "held", "holders": [{"user": "ada"}, {"status": "MASTER", "pid": -1}]}),
    ("gecos::Description", "an arm", {
        "name": "RX90", "interface_name": "robcl::Rx90", "version": "1.0",
        "interface_hash": 2**64 - 1, "simulated": True, "presence": "not required (simulated)",
        "epoch": 3, "queued": 2**32 - 1, "executing": "move", "pid": 1,
        "handlers": [{"operation": "move", "running_for": 2.5, "user": "ada", "waits_for": ""}]}),
    ("gecos::Entry", "with places", {
        "name": "RX90", "bases": ["robcl::SixAxis", "robcl::Device"], "boot": 2**63,
        "addresses": ["shm:/run/gecos/1f3a.sock", "lcm:239.255.76.67:20017/RX90"]}),
    ("gecos::Entry", "of a PID namespace", {"name": "RX90", "pid": 1, "pid_namespace": 4026531836}),
    ("gecos::SilentObject", "an arm", {
        "entry": {"name": "RX90", "interface_name": "robcl::Rx90", "pid": 4711},
        "silent_for": 4.25}),
    ("gecos::SilentObject", "an arm of another host", {
        "entry": {"name": "RX90"}, "silent_for": 4.25, "free_in": 5.75}),
    ("gecos::Registration", "as made", {}),
    ("gecos::Registration", "a silent arm", {
        "entry": {"name": "RX90", "pid": 4711}, "presence": "SILENT", "epoch": 2**63 + 5,
        "silent_for": 4.25}),
    ("gecos::ListRevision", "of a life", {"life": 2**64 - 1, "number": 1024}),
    ("gecos::ListChanges", "nothing new", {"revision": {"life": 7, "number": 3}}),
    ("gecos::ListChanges", "the whole list", {
        "revision": {"life": 7, "number": 3}, "whole": True, "running_for": 0.5,
        "changed": [{"entry": {"name": "RX90"}}, {"entry": {"name": "LDS"}, "epoch": 2}]}),
    ("gecos::KeptObject", "an arm", {
        "entry": {"name": "RX90", "pid": 4711}, "process_start": 2**40}),
    ("gecos::KeptList", "one", {"objects": [{"entry": {"name": "RX90"}, "process_start": 5}]}),
    ("gecos::Revocation", "a user of a host", {"owner": "anna@desk"}),
    ("gecos::RevocationList", "a key", {
        "number": 2**63 + 7, "changed": True, "revoked": [{"key": "5f" * 32}]}),
    ("gecos::RevocationState", "one is behind", {"listed": True, "behind": ["RX90"]}),
    ("gecos::AdmittedNames", "one user of all hosts", {
        "number": 2**63 + 3, "users": ["anna"], "hosts": ["*"]}),
    ("gecos::NameInUse", "a process lives", {"name": "RX90", "why": "its process runs"}),
    ("gecos::ZonePresence", "nobody", {"spell": 2**63 + 1, "why": "DOOR is open; close it"}),
    ("gecos::CheckInRefused", "wrong", {"reason": "the code is not the one that CELL shows"}),
    ("gecos::UnknownSource", "a window", {"name": "WINDOW", "known": ["DOOR", "T\u00fcr"]}),
    ("gecos::ObjectRef", "nil", {}),
    ("gecos::ObjectRef", "an arm", {
        "name": "RX90", "interface_hash": 2**64 - 1, "boot": 2**63 + 1,
        "where": "shm: uid 1000, pid 4711"}),
    ("gecos::UnknownName", "nobody", {"name": "RX91", "known": ["RX90", "St\u00e4ubli"]}),
    ("gecos::NameTaken", "taken", {"name": "RX90", "by": "ada@lab, pid 4711"}),
    ("robcl::Vector", "a point", {"x": 1.5, "y": -0.0, "z": 1e-300}),
    ("robcl::Quaternion", "a turn", {"w": 0.5, "x": 0.5, "y": 0.5, "z": 0.5}),
    ("robcl::Frame", "here", {"orientation": {"w": 1.0}}),
    ("robcl::Frame", "a grip", FRAME),
    ("robcl::MountRefused", "why", {"reason": "moving"}),
    ("robcl::GripperState", "holding", {"width": 0.05, "force": 20.0, "holding": True}),
    ("robcl::WidthOutOfRange", "too wide", {"value": 0.2, "upper": 0.1}),
    ("robcl::ForceOutOfRange", "too strong", {"value": 200.0, "upper": 100.0}),
    ("robcl::Distance", "measured", {
        "value": 0.731, "valid": True, "lower": 0.1, "upper": 2.0, "stamp": 1700000000.25}),
    ("robcl::SensorFault", "off", {"reason": "the laser is off"}),
    ("robcl::Trajectory", "as made", {}),
    ("robcl::Trajectory", "slow and straight", {
        "speed": 0.01, "acceleration": 0.5, "path": "STRAIGHT", "at_goal": "NOBREAK",
        "tool_speed": 0.25, "turn_speed": 1.5}),
    ("robcl::Trajectory", "gently", {"tool_acceleration": 0.5, "turn_acceleration": 1.25}),
    ("robcl::MotionProgress", "half", {"fraction": 0.5, "remaining": 1.75}),
    ("robcl::MotionProgress", "paused", {"fraction": 0.5, "speed_override": 0.0}),
    ("robcl::FollowLimits", "as made", {}),
    ("robcl::FollowLimits", "slow and near", {
        "tool_speed": 0.05, "turn_speed": 0.5, "distance": 0.01, "angle": 0.1}),
    ("robcl::FollowState", "holding", {
        "applied": 500, "dropped": 3, "distance_left": 0.02, "angle_left": 0.0, "limit_axis": 5}),
    ("robcl::CorrectionsStopped", "out of reach", {
        "state": {"applied": 7, "distance_left": 0.25, "out_of_reach": True}}),
    ("robcl::Manipulator::stood", "there", {"tool": FRAME}),
    ("robcl::JointLimit", "axis 3", {"axis": 3, "value": 2.9, "lower": -2.4, "upper": 2.4}),
    ("robcl::JointLimit", "on a line", {
        "axis": 5, "value": 1.79, "lower": -1.75, "upper": 1.75,
        "place": {"way": 0.05, "turn": 0.17},
        "configuration": {"arm": "RIGHTY", "bend": "ABOVE", "hand": "FLIP"}}),
    ("robcl::PlaceOnLine", "half a turn", {"way": 0.0, "turn": 3.14}),
    ("robcl::Singular", "a line", {"reason": "the line passes the wrist"}),
    ("robcl::OutOfReach", "at its bound", {"reason": "x" * 160}),
    ("robcl::Joints", "ready", {"position": [0.0, -1.5707963267948966, 0.5, 0.0, -0.0, 3.0]}),
    ("robcl::JointPositions", "of five joints", {"position": [0.0, -0.0, 0.5, -1.25, 3.0]}),
    ("robcl::Configuration", "a lefty", {"arm": "LEFTY", "bend": "BELOW", "hand": "FLIP"}),
    ("robcl::Body", "a block", {
        "name": "block", "pose": FRAME, "size": {"x": 0.04, "y": 0.05, "z": 0.06},
        "holders": ["G", "H"]}),
    ("robcl::RayHit", "a hit", {"hit": True, "range": 0.5, "body_name": "block"}),
    ("robcl::Contact", "none", {"width": 0.08}),
    ("robcl::UnknownBody", "none known", {"name": "x", "known": []}),
    ("everything::Numbers", "as made", {}),
    ("everything::Numbers", "extreme", NUMBERS),
    ("everything::Limits", "at the bounds", {
        "both": -1.0, "lower": 0.0, "upper": 10, "share": 100, "few": 3}),
    ("everything::Arrays", "filled", {
        "grid": [[1, -2, 3], [4, 5, -6]], "flags": [True, False, False, True],
        "block": [0, 127, 255], "names": ["a", "\u00f6"],
        "rows": [[0.5, 1.5, 2.5], [-0.5, -1.5, -2.5]],
        "corners": [{"x": 1.0}, {"z": -1.0}],
        "colours": [["RED", "GREEN"], ["BLUE", "RED"]], "ragged": [[1, -1], []]}),
    ("everything::Pixels", "as made", {}),
    ("everything::Pixels", "filled", {"patch": [[1, 2, 3], [253, 254, 255]]}),
    ("everything::Photo", "as made", {}),
    ("everything::Photo", "as large as it may be", {
        "width": 20, "pixels": [i % 256 for i in range(300)], "note": "at \u00e4", "scale": 7}),
    ("everything::Sequences", "as made", {}),
    ("everything::Sequences", "filled", {
        "reals": [i * 0.1 for i in range(40)], "few": [0.5, -0.25, 3.0], "blob": [1, 2, 255],
        "flags": [True, False, True], "words": ["abcd", ""], "colours": ["BLUE", "RED"],
        "rows": [[1, 65535], [], [7]], "poses": [FRAME], "percents": [0, 100],
        "short_text": "12345"}),
    ("everything::Optionals", "nothing", {}),
    ("everything::Optionals", "everything", {
        "number": -1, "part": 1.0, "text": "t", "many": [1, 2, 3], "all": NUMBERS,
        "line": [1.0, 2.0, 3.0], "tint": "RED"}),
    ("everything::Maps", "sorted", {
        "counts": [["", 0], ["a", 1], ["ab", -1], ["\u00e4", 2]],
        "places": [[-5, {"x": 1.0}], [0, {}], [7, {"z": 2.0}]],
        "names": [["RED", ["r", "s"]], ["BLUE", []]]}),
    ("everything::Shape", "a disc", {"tag": "RED", "arm": "radius", "value": 2.5}),
    ("everything::Shape", "a box", {"tag": "GREEN", "arm": "size", "value": {"x": 1.0, "y": 2.0}}),
    ("everything::Shape", "words", {"tag": "BLUE", "arm": "words", "value": ["a", "b"]}),
    ("everything::Choice", "second label", {"tag": 2, "arm": "text", "value": "two"}),
    ("everything::Choice", "negative label", {"tag": -3, "arm": "small", "value": 9}),
    ("everything::Choice", "by default", {"tag": 100, "arm": "other", "value": True}),
    ("everything::Gap", "held", {"tag": 2**64 - 1, "arm": "digit", "value": 9}),
    ("everything::Gap", "nothing", {"tag": 4}),
    ("everything::Answer", "yes", {"tag": True, "arm": "yes", "value": 1.0}),
    ("everything::Answer", "no", {"tag": False, "arm": "no", "value": "never"}),
    ("everything::Masks", "some", {
        "lit": ["LEFT", "TOP"], "broad": ["LAST"],
        "bits": {"mode": 5, "on": True, "offset": -200}, "level": "HIGH"}),
    ("everything::Grows", "as made", {}),
    ("everything::Grows", "grown", GROWN),
    ("everything::Holds", "nested", {
        "one": GROWN, "many": [{}, GROWN], "maybe": {"first": 1},
        "pair": [{"first": 2}, GROWN],
        "form": {"tag": "GREEN", "arm": "size", "value": {"x": 1.0}},
        "choices": [{"tag": 1, "arm": "text", "value": "one"}], "hole": {"tag": 0},
        "reply": {"tag": True, "arm": "yes", "value": 0.5}}),
    ("everything::Tree", "three levels", {
        "leaf": 1, "below": [{"leaf": 2, "below": [{"leaf": 3}]}, {"leaf": 4}]}),
    ("everything::Base", "alone", {"below": -7}),
    ("everything::Derived", "base first", {"below": 7, "above": "a"}),
    ("everything::Nothing", "nothing", {}),
    ("everything::Objects", "as made", {"pair": [{}, {}]}),
    ("everything::Objects", "some", {
        "one": {"name": "A", "boot": 1}, "perhaps": {"name": "B", "where": "here"},
        "many": [{"name": "C"}, {}], "named": [["left", {"name": "D"}], ["right", {}]],
        "pair": [{"name": "E", "interface_hash": 2**64 - 2}, {}]}),
    ("everything::Words", "all", {
        "class": 1, "def": 2, "encode": 3, "size": 4, "to": 5, "pass": "secret", "value": 6.5}),
    ("everything::Refused", "turned", {"reason": "too far", "angle": 3.5}),
]  # fmt: skip


def main() -> None:
    model = load()
    lines = [
        json.dumps(
            {"type": kind, "name": name, "value": value, "bytes": encoded(model, kind, value).hex()}
        )
        for kind, name, value in CASES
    ]
    text = "[\n " + ",\n ".join(lines) + "\n]\n"
    (HERE / "types.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
