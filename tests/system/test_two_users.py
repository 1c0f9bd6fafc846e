"""Two users of one host, one admitted and one not: the C++ tests that need root, for every user."""

import os
import subprocess
from pathlib import Path

BUILD = Path(os.environ.get("GECOS_BUILD", Path(__file__).resolve().parents[2] / "build"))
# Root of a namespace that has other users, too: those that /etc/subuid gives to this user.
USERS_OF_ITS_OWN = () if os.geteuid() == 0 else ("unshare", "--map-root-user", "--map-auto")
MISSING = (
    "this test needs two users of this host: run it as root, or allow user namespaces "
    "(sysctl -w kernel.unprivileged_userns_clone=1) and give this user others in /etc/subuid and "
    "/etc/subgid (usermod --add-subuids 100000-165535 --add-subgids 100000-165535 USER); "
    "newuidmap comes with the package uidmap"
)


def test_one_user_is_admitted_and_one_is_not() -> None:
    able = subprocess.run([*USERS_OF_ITS_OWN, "true"], capture_output=True, text=True, check=False)
    assert able.returncode == 0, f"{MISSING}: {able.stderr}"
    program = BUILD / "tests" / "cpp" / "session" / "two_users_test"
    ran = subprocess.run(
        [*USERS_OF_ITS_OWN, program], capture_output=True, text=True, timeout=120, check=False
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "NOT TRIED" not in ran.stdout
    assert "[  PASSED  ] 5 tests." in ran.stdout
