"""Programs of ROS 1 in tests: a master that runs, and what listens to topics."""

import random
import socket
import subprocess
import time
from contextlib import contextmanager, suppress
from json import loads
from pathlib import Path
from xmlrpc.client import ServerProxy

LISTENER = Path(__file__).parent / "listen.py"
ATTEMPTS = 3


@contextmanager
def run_master(environment):
    """Yield the environment of ROS with a master that runs, and its process."""
    for _ in range(ATTEMPTS):
        address = f"http://localhost:{find_port()}"
        found = environment | {"ROS_MASTER_URI": address, "ROS_HOSTNAME": "localhost"}
        with start("roscore", "-p", address.rpartition(":")[2], env=found) as process:
            if has_started(process, address):
                yield found, process
                return
            process.terminate()
            print("roscore has not started:", process.communicate(timeout=600)[0])
    raise AssertionError(f"roscore has not started in {ATTEMPTS} attempts")


def has_started(process, address):
    with ServerProxy(address) as master, suppress(AssertionError):
        # The log is the last that roscore starts.
        wait_for(lambda: process.poll() is not None or "http" in str(master.lookupNode("/test", "/rosout")))
        return process.poll() is None
    return False


def find_port():
    """Return a port that nothing listens at, outside the range from which the system gives ports to others meanwhile."""
    while True:
        port = random.randrange(20_000, 32_000)
        with socket.socket() as free:
            if free.connect_ex(("localhost", port)) != 0:
                return port


@contextmanager
def start(*command, **options):
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "encoding": "utf-8"}
    process = subprocess.Popen(command, **pipes, **options)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.terminate()
            process.communicate(timeout=600)
        for pipe in (process.stdin, process.stdout, process.stderr):
            if pipe is not None:
                pipe.close()


def wait_for(happens, seconds=600.0):
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        try:
            if happens():
                return
        except OSError:
            pass
        time.sleep(0.1)
    raise AssertionError(f"{happens} has not happened within {seconds} s")


@contextmanager
def listen(environment, *arguments):
    """Yield a function that ends listening and returns what was received."""
    with start("/usr/bin/python3", str(LISTENER), *arguments, env=environment) as process:
        assert process.stdin is not None and process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield lambda: loads(process.communicate("end\n", timeout=600)[0])
