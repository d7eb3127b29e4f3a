"""Where runs happen makes no difference to what comes out."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time

import pytest

from dmil.errors import DmilError, InputError, UnknownNameError
from dmil.parallel.executors import LocalExecutor, available_cores, make_executor


def square(number):
    return number * number


def process_of(_):
    time.sleep(0.05)
    return os.getpid()


def die(number):
    if number == 1:
        os._exit(1)
    return number


@pytest.mark.parametrize("jobs", [1, 2])
def test_every_item_is_done_once(jobs):
    assert sorted(LocalExecutor(jobs).map(square, range(10))) == [n * n for n in range(10)]


def test_one_job_stays_in_this_process():
    assert set(LocalExecutor(1).map(process_of, range(3))) == {os.getpid()}


def test_two_jobs_are_two_other_processes():
    used = set(LocalExecutor(2).map(process_of, range(6)))
    assert os.getpid() not in used
    assert 1 <= len(used) <= 2


def test_as_a_context_manager_it_keeps_its_processes():
    with LocalExecutor(2) as executor:
        first, second = (set(executor.map(process_of, range(8))) for _ in range(2))
        assert len(first | second) <= 2
        assert multiprocessing.active_children()
    assert not multiprocessing.active_children()


def test_a_kept_executor_that_was_stopped_begins_anew():
    with LocalExecutor(2) as executor:
        results = executor.map(process_of, range(20))
        next(results)
        results.close()
        assert sorted(executor.map(square, range(5))) == [0, 1, 4, 9, 16]
    assert not multiprocessing.active_children()


def test_closing_leaves_no_worker_behind():
    results = LocalExecutor(2).map(process_of, range(20))
    next(results)
    results.close()
    assert not multiprocessing.active_children()


def test_closing_waits_for_nothing():
    results = LocalExecutor(2).map(time.sleep, [0.0, 0.0, 86400.0, 86400.0])
    next(results)
    results.close()
    assert not multiprocessing.active_children()


def test_a_killed_worker_is_one_clear_error():
    with pytest.raises(DmilError, match=r"worker process was killed.*--jobs 1"):
        list(LocalExecutor(2).map(die, range(4)))


PARENT = """
import multiprocessing, sys, time
from dmil.parallel import LocalExecutor

for _ in LocalExecutor(2).map(time.sleep, [0.0, 0.0, 600.0, 600.0]):
    print(*(child.pid for child in multiprocessing.active_children()), flush=True)
"""


def test_workers_end_with_a_killed_parent():
    parent = subprocess.Popen([sys.executable, "-c", PARENT], stdout=subprocess.PIPE, text=True)
    lines = [parent.stdout.readline() for _ in range(2)]
    parent.kill()
    parent.wait()
    parent.stdout.close()
    workers = [int(pid) for pid in lines[-1].split()]
    assert len(workers) == 2
    for _ in range(2400):  # two minutes: the machine may be busy
        if not any(map(lives, workers)):
            break
        time.sleep(0.05)
    assert not any(map(lives, workers))


def lives(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_while_workers_begin_waits_for_them(number):
    """A pool that is interrupted half begun cannot be shut down."""
    asked = []

    def items():
        os.kill(os.getpid(), number)
        for item in range(4):
            asked.append(item)
            yield item

    class Items(list):
        def __iter__(self):
            return items()

    def interrupt(number, frame):
        raise KeyboardInterrupt

    before = signal.signal(number, interrupt)
    try:
        with pytest.raises(KeyboardInterrupt):
            list(LocalExecutor(2).map(square, Items(range(4))))
    finally:
        signal.signal(number, before)
    assert asked == [0, 1, 2, 3]
    assert not multiprocessing.active_children()


def test_jobs_default_to_the_cores_that_are_ours():
    assert LocalExecutor().jobs == available_cores() >= 1


def test_wrong_choices_are_refused():
    with pytest.raises(InputError, match="0 jobs"):
        LocalExecutor(0)
    with pytest.raises(UnknownNameError, match="Did you mean 'local'"):
        make_executor("locale")
    with pytest.raises(InputError, match="--executor ray"):
        make_executor("local", address="somewhere:1")
    assert isinstance(make_executor("local", jobs=3), LocalExecutor)


def test_a_cluster_that_does_not_answer_is_one_clear_error():
    pytest.importorskip("ray", reason="the extra 'ray' is not installed")
    with pytest.raises(InputError, match="no Ray cluster answers"):
        make_executor("ray", address="127.0.0.1:1")
