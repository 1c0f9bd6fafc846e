"""Checks whether packets of lcm can be sent, how far they go, and whether sockets have enough
memory for them."""

from __future__ import annotations

import re

from gecos.cli.doctor.broker import BrokerPlace
from gecos.cli.doctor.finding import Finding, fine, warning, wrong

WANTED_BYTES = 2 * 1024 * 1024  # LcmOptions::receive_buffer_bytes
_RMEM_MAX = "/proc/sys/net/core/rmem_max"
_ADVICE = re.compile(r"no multicast route\? run as root: +([^)]*)\)")


def multicast_route(reason: str | None, needed: bool) -> Finding:
    """Checks the route of multicast packets. `reason` says why no broker answers over lcm; it is
    None if a broker answers. `needed` is True if the settings of this program ask for lcm."""
    advice = _ADVICE.search(reason or "")
    if advice is None:
        return fine("multicast route", "packets of lcm can be sent")
    level = wrong if needed else warning
    cause = (reason or "")[: advice.start()].rpartition("lcm: ")[2].rstrip(" (")
    what = f"lcm is not usable: {cause}"
    if not needed:
        what += "; programs of one user on one host do not need it"
    return level("multicast route", what, "network interfaces", f"sudo sh -c '{advice[1]}'")


def reach_of_packets(ttl: int, broker: BrokerPlace) -> Finding:
    """Checks how far packets of lcm go. `ttl` is the value of GECOS_LCM_TTL. `broker` says where
    programs look for the broker; an address of lcm may mean a broker on another host."""
    if ttl > 0:
        return fine("lcm reach", f"packets pass up to {ttl} routers", "GECOS_LCM_TTL")
    if not broker.address.startswith("lcm"):
        return fine("lcm reach", "packets stay on this host", "GECOS_LCM_TTL")
    what = (
        f"packets stay on this host, but {broker.source} names lcm: other hosts cannot be reached"
    )
    mend = "export GECOS_LCM_TTL=1 for each program, on each host"
    return warning("lcm reach", what, "GECOS_LCM_TTL", mend)


def socket_buffers(granted: int) -> Finding:
    """Checks the buffers of sockets. `granted` is the number of bytes that a socket gets when it
    asks for WANTED_BYTES."""
    if granted >= WANTED_BYTES:
        return fine("socket buffers", f"a socket gets {granted} bytes", _RMEM_MAX)
    what = f"a socket gets only {granted} of the {WANTED_BYTES} bytes that lcm asks for: "
    what += "if packets are many or large, some are lost and sent again"
    mend = f"sudo sysctl -w net.core.rmem_max={WANTED_BYTES}"
    return warning("socket buffers", what, _RMEM_MAX, mend)
