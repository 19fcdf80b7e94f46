"""Child processes made by fork compute the same bits as their parent, and do not hang."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="this platform has no fork")

# Seconds. A child that waits for threads of its parent hangs. All calls together take a few seconds.
TIMEOUT = 120


def digest(way, threads):
    """Returns the digest that parent and children agree on."""
    environment = {name: value for name, value in os.environ.items() if name != "RAYON_NUM_THREADS"}
    if threads is not None:
        environment["RAYON_NUM_THREADS"] = str(threads)
    command = [sys.executable, str(Path(__file__).with_name("forks.py")), way]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=TIMEOUT)
    assert ended.returncode == 0 and ended.stdout.startswith(f"same {threads} "), ended.stderr
    return ended.stdout.split()[-1]


@pytest.mark.parametrize("way", ["process", "grandchild", "pool", "executor", "while_a_thread_works"])
def test_children_have_the_bits_of_their_parent_with_any_number_of_threads(way):
    assert len({digest(way, threads) for threads in (1, 4, None)}) == 1


@pytest.mark.torch
def test_workers_of_a_data_loader_have_the_bits_of_their_parent():
    pytest.importorskip("torch")
    assert len({digest("data_loader", threads) for threads in (1, 4, None)}) == 1
