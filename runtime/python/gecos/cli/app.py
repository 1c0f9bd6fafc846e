"""The commands of `gecos` and their options. The module `report` prints their output."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from typing import Annotated, TypeVar

import typer

import gecos
from gecos import _core
from gecos.cli import report
from gecos.cli.laboratory import entries, find
from gecos.termination_signals import TerminationSignals

T = TypeVar("T")
Name = Annotated[str, typer.Argument(help="Name under which the object is served, as RX90")]
BrokerAddress = Annotated[
    str | None,
    typer.Option("--broker", help="Address of the broker; default: GECOS_BROKER, else this host"),
]

app = typer.Typer(
    help="Lists, shows and stops the objects of a robot laboratory, and runs a broker.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


@app.command("ls")
def list_objects(broker: BrokerAddress = None) -> None:
    """Lists the objects that are online."""
    with gecos.Lab(broker) as lab:
        report.objects(entries(lab))


@app.command()
def describe(name: Name, broker: BrokerAddress = None) -> None:
    """Shows the type and the state of an object."""
    with gecos.Lab(broker) as lab:
        report.description(gecos.describe(find(lab, name)).result())


@app.command()
def holders(name: Name, broker: BrokerAddress = None) -> None:
    """Shows the clients that hold actor or master status of an object."""
    with gecos.Lab(broker) as lab:
        report.holders(name, gecos.holders(find(lab, name)).result())


@app.command()
def stop(name: Name, broker: BrokerAddress = None) -> None:
    """Stops an object for all clients: ends all leases, drops the queue, interrupts handlers."""
    with gecos.Lab(broker) as lab:
        gecos.stop(find(lab, name)).result()
        print(f"{name}: stopped")


@app.command("broker")
def run_broker() -> None:
    """Runs this host's broker until Ctrl-C."""
    with TerminationSignals() as signals, gecos.Lab() as lab, gecos.Broker(lab):
        print("broker: ready", flush=True)
        others = threading.Thread(target=_core.warn_of_other_brokers)
        others.start()
        signals.wait()
        others.join()


def run() -> int:
    return _reporting(lambda: app(standalone_mode=False))


def _reporting(command: Callable[[], object]) -> int:
    """Runs `command` and returns the exit code; prints the reason of a failure in one line."""
    try:
        code = command()
    except KeyboardInterrupt:
        return 130
    except (ConnectionError, RuntimeError, PermissionError) as error:
        print(f"gecos: {error}", file=sys.stderr)
        return 1
    except typer.Exit as end:
        return end.exit_code
    except Exception as error:
        show = getattr(error, "show", None)  # click's usage errors print themselves
        if show is None:
            raise
        show()
        return 2
    return code if isinstance(code, int) else 0
