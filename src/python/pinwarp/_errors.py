"""The exceptions of this package."""

from __future__ import annotations

from collections.abc import Sequence


class Error(Exception):
    """Base class of all errors. The message says what is wrong, where, and what to do.

    file: path of the faulty file, or None.
    line: line in that file, counted from 1.
    key: key in the file ("layer[0].pin[2].keys[1].ease"), or the argument ("pins[3]").
    hint: what to do.
    faults: if a shot file has several faults, one exception for each.
    """

    def __init__(
        self,
        message: str,
        *,
        file: str | None = None,
        line: int | None = None,
        key: str | None = None,
        hint: str | None = None,
        faults: Sequence[Error] = (),
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.key = key
        self.hint = hint
        self.faults = list(faults)

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""

    def __reduce__(self):
        return _again, (type(self), str(self), self.__dict__.copy())


class InputError(Error, ValueError):
    """An argument, or the content of a file, is invalid."""


class FileError(Error, OSError):
    """A file cannot be read or written."""


class MissingFileError(FileError, FileNotFoundError):
    """A file does not exist."""


class Cancelled(Error):
    """A progress callback returned False."""


def _again(kind: type[Error], message: str, state: dict) -> Error:
    """Rebuilds a pickled exception, for example one from another process."""
    error = kind(message)
    error.__dict__.update(state)
    return error
