"""Python's lock is released while the library works, callbacks and Ctrl-C are heard, threads get the same results."""

import concurrent.futures
import os
import signal
import threading
import time

import numpy
import pinwarp
import pytest


@pytest.fixture
def long_solve():
    """A solve that takes a while: a dense lattice over many triangles, with pins that fold it."""
    side = 160
    y, x = numpy.mgrid[0:side, 0:side]
    points = numpy.stack([x.ravel(), y.ravel()], axis=1) / (side - 1)
    first = (y[:-1, :-1] * side + x[:-1, :-1]).ravel()
    lower = numpy.stack([first, first + 1, first + side], axis=1)
    upper = numpy.stack([first + 1, first + side + 1, first + side], axis=1)
    places = numpy.random.default_rng(7).random((40, 4))
    return lambda progress=None: pinwarp.solve(
        points, numpy.concatenate([lower, upper]), places, progress, dims=(40, 40), guard="limit"
    )


class Ticks:
    """A thread of Python's that notes when it runs."""

    def __enter__(self):
        self.times, self.is_over = [], False
        self.thread = threading.Thread(target=self.run)
        self.thread.start()
        return self

    def run(self):
        while not self.is_over:
            self.times.append(time.perf_counter())
            time.sleep(0.002)

    def __exit__(self, *_):
        self.is_over = True
        self.thread.join()


def test_other_threads_go_on(long_solve):
    with Ticks() as ticks:
        begun = time.perf_counter()
        try:
            long_solve(progress=lambda done, of: time.perf_counter() - begun < 1.0)
        except pinwarp.Cancelled:
            pass
        ended = time.perf_counter()
    inside = [tick for tick in ticks.times if begun < tick < ended]
    assert ended - begun > 0.2, "the solve is too short to tell"
    longest = max(after - before for before, after in zip(inside, inside[1:]))
    assert len(inside) > 20 * (ended - begun) and longest < 0.5, (len(inside), ended - begun, longest)


def test_false_cancels(long_solve):
    begun = time.perf_counter()
    asked = []

    def progress(done, of):
        asked.append((done, of))
        return time.perf_counter() - begun < 0.1

    with pytest.raises(pinwarp.Cancelled):
        long_solve(progress)
    assert asked[0] == (0, 1) and len(asked) > 1


def test_renders_and_checks_are_cancelled(teapot):
    shot = pinwarp.Shot(teapot, scale=8, samples=64)
    begun = time.perf_counter()
    with pytest.raises(pinwarp.Cancelled):
        shot.render(1, device="cpu", progress=lambda done, of: False)
    assert time.perf_counter() - begun < 20
    with pytest.raises(pinwarp.Cancelled):
        pinwarp.Shot(teapot).check(progress=lambda done, of: done < 2)
    small = pinwarp.Shot(teapot)
    report = small.write(device="cpu", progress=lambda done, of: done < 2)
    assert report["is_cancelled"] and 2 <= report["rendered"] < 24
    # And the shot goes on afterwards.
    assert small.render(1, device="cpu")["A"].max() > 0.9


def test_other_answers_do_not_cancel(teapot):
    for answer in (None, 0, True):
        assert pinwarp.Shot(teapot).check([1, 2], progress=lambda done, of: answer)["failures"] == []


def test_an_exception_of_the_callback_comes_back(long_solve):
    def progress(done, of):
        raise LookupError("of the callback")

    with pytest.raises(LookupError, match="of the callback"):
        long_solve(progress)


@pytest.fixture
def hears_control_c():
    """Whatever this process was told about Ctrl-C: background jobs ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_control_c_is_heard(teapot, hears_control_c):
    shot = pinwarp.Shot(teapot, scale=8, samples=64)
    timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    begun = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        shot.render(1, device="cpu")
    assert time.perf_counter() - begun < 20


def test_callbacks_run_on_the_thread_that_called(teapot):
    threads = set()
    pinwarp.Shot(teapot).write([1, 2], device="cpu", progress=lambda done, of: threads.add(threading.get_ident()))
    assert threads == {threading.get_ident()}


def test_threads_get_the_same_results(teapot, picture):
    shot = pinwarp.Shot(teapot)
    alone = [shot.render(frame, device="cpu")["R"] for frame in (1, 6, 12)]
    warped = pinwarp.warp(picture, [[0.9, 0.5, 1.0, 0.6]])
    with concurrent.futures.ThreadPoolExecutor(6) as pool:
        frames = list(pool.map(lambda frame: shot.render(frame, device="cpu")["R"], (1, 6, 12)))
        pictures = list(pool.map(lambda _: pinwarp.warp(picture, [[0.9, 0.5, 1.0, 0.6]]), range(6)))
    assert all(numpy.array_equal(one, other) for one, other in zip(alone, frames))
    assert all(numpy.array_equal(warped, other) for other in pictures)
