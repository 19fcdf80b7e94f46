"""Progress of long calls: a function of the caller, or a progress bar of tqdm."""

from __future__ import annotations

import importlib
from collections.abc import Callable


class _Callback:
    """Calls a function of (done, total)."""

    def __init__(self, function: Callable[[int, int], object], total: int) -> None:
        self._function = function
        self._total = total

    def __call__(self, done: int) -> None:
        self._function(done, self._total)

    def close(self) -> None:
        pass


class _Bar:
    """Moves a progress bar of tqdm. Without tqdm, it shows nothing."""

    def __init__(self, total: int) -> None:
        try:
            tqdm = importlib.import_module("tqdm.auto").tqdm
        except ImportError:
            self._bar = None
        else:
            self._bar = tqdm(total=total)

    def __call__(self, done: int) -> None:
        if self._bar is not None:
            self._bar.update(done - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


def shown(progress: bool | Callable[[int, int], object], total: int) -> _Callback | _Bar:
    """Creates a callable that receives the number of completed parts. The caller closes it at the end."""
    if progress is True:
        return _Bar(total)
    if callable(progress):
        return _Callback(progress, total)
    raise TypeError(f"progress must be True, False, None or a function of (done, total), but is {progress!r}")
