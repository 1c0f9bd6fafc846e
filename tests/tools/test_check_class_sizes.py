"""The rule about large classes finds them, and takes their reason."""

import check_class_sizes


def unexplained(source: str) -> list[str]:
    (size,) = check_class_sizes.sizes(source)
    return size.unexplained()


def of_methods(count: int, comment: str = "") -> str:
    methods = "".join(f"  void act_{i}(int how);\n" for i in range(count))
    return f"{comment}class Arm final : public Thing {{\n public:\n{methods}}};\n"


def of_members(count: int, comment: str = "") -> str:
    members = "".join(f"  int part_{i}_ = 0;\n" for i in range(count))
    return f"{comment}struct Arm {{\n{members}}};\n"


def test_counts_up_to_the_limit() -> None:
    assert unexplained(of_methods(27)) == []
    assert unexplained(of_methods(28)) == ["28 methods"]
    assert unexplained(of_members(16)) == []
    assert unexplained(of_members(17)) == ["17 members"]


def test_takes_a_reason_that_stands_in_front_of_the_class() -> None:
    why = "/// Moves an arm. Has more methods\n/// than other classes, because it is one.\n"
    assert unexplained(of_methods(40, why)) == []
    assert unexplained(of_members(40, why)) == ["40 members"]
    assert unexplained(why + "\n" + of_methods(40)) == ["40 methods"]
    both = "/// Has more methods and members than other classes, for it is a contract.\n"
    assert unexplained(of_methods(40, both)) == unexplained(of_members(40, both)) == []


def test_counts_what_is_declared_in_the_class_itself() -> None:
    (size,) = check_class_sizes.sizes(
        "class Box {\n public:\n"
        "  Box(const Box&) = delete;\n  using Lid = int;\n  friend class Cat;\n"
        "  int width() const {\n    int w = 3;\n    return w;\n  }\n"
        "  struct Inner {\n    int a;\n    void b();\n  };\n\n"
        " private:\n  int high_ GECOS_GUARDED_BY(mutex_) = 0;  // (two words)\n"
        "  Inner inner_{};\n};\n"
    )
    assert (size.methods, size.members) == (1, 2)
