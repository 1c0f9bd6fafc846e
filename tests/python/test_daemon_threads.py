"""A program ends while daemon threads of it are inside calls of ours, as it would without them."""

from __future__ import annotations

import gecos
import pytest
from lamp import Lamp, PlainLamp
from test_close import comes_true
from test_process import running

# The main thread ends once the calls have begun. What a module holds dies when the interpreter no
# longer gives the GIL to other threads; it lets them want it back for longer than a slice of
# waiting (0.1 s) lasts. A module of its own, as frames of the threads keep what the main one names.
PROGRAM = """
import sys, threading, time, types
import gecos
from lamp import Lamp, PlainLamp

class Late:
    def __del__(self, linger=time.sleep):
        linger(0.3)
        print("the end", flush=True)

sys.modules["late"] = types.ModuleType("late")
sys.modules["late"].late = Late()
lab = gecos.Lab()
lamp = lab.create(Lamp, "LAMP", medium="shm")
begun = threading.Semaphore(0)

{call}

def run():
    begun.release()
    try:
        call()
    except Exception:  # what a closed Lab says: nobody is left to tell
        pass

threads = [threading.Thread(target=run, daemon=True) for _ in range(4)]
for thread in threads:
    thread.start()
for thread in threads:
    begun.acquire()
"""

CALLS = {
    "iterates over a stream": """
def call():
    for sample in lamp.level.stream():
        pass
""",
    "waits for a sample without end": """
def call():
    while True:
        lamp.level.stream().next()
""",
    "waits for samples with a time-out": """
def call():
    stream = lamp.level.stream()
    while True:
        try:
            stream.next(0.001)
        except TimeoutError:
            pass
""",
    "iterates over a stream in a task": """
import asyncio

async def read():
    async for sample in lamp.level.stream():
        pass

def call():
    asyncio.run(read())
""",
    "has a function called for each sample": """
def call():
    lamp.level.stream().listen(lambda sample: None)
    threading.Event().wait()
""",
    "calls one operation after the other": """
def call():
    while True:
        lamp.label().result()
""",
    "waits for a command": """
lease = gecos.actor(lamp)
burning = lamp.burn_in()
burning.detach()

def call():
    burning.wait()
""",
    "waits for a command's result": """
lease = gecos.actor(lamp)
burning = lamp.burn_in()
burning.detach()

def call():
    burning.result(1000.0)
""",
    "waits in a callback": """
lease = gecos.actor(lamp)
burning = lamp.burn_in()
burning.detach()

def call():
    lamp.label().add_done_callback(lambda command: burning.wait())
""",
    "creates proxies": """
def call():
    while True:
        with gecos.Lab() as own:
            own.create(Lamp, "LAMP", medium="shm").label().result()
""",
    "takes and gives back a lease": """
def call():
    while True:
        with gecos.actor(lamp):
            pass
""",
    "opens and closes streams": """
def call():
    while True:
        lamp.level.stream().close()
""",
    "looks for an object that nobody serves": """
def call():
    lab.create(Lamp, "NONE", patience=1000.0)
""",
    "serves": """
server = gecos.Server(lab)
server.add("CHILD", PlainLamp(), media=["shm"])
child = gecos.Lab().create(Lamp, "CHILD", medium="shm")

def call():
    while True:
        child.label().result()
""",
}


@pytest.mark.parametrize("call", CALLS)
def test_a_program_ends_in_order_while_a_daemon_thread(
    call: str, lamp: Lamp, servant: PlainLamp
) -> None:
    program = PROGRAM.replace("{call}", CALLS[call])
    for _ in range(3):
        with running(program) as client:
            out, err = client.communicate(timeout=60)
            assert (out, err, client.returncode) == ("the end\n", "", 0)
        servant.finish.set()  # what it had begun
        assert comes_true(lambda: not gecos.holders(lamp).result())
        servant.finish.clear()
