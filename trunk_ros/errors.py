"""Errors that a user can do something about: one line that says what is wrong, where, and what to do."""

import traceback


def one_line(text: str) -> str:
    """The text without line breaks and control characters: names in foreign files may hold any."""
    return "".join(character if character.isprintable() else " " for character in text)


def printable(name: str) -> str:
    """A name with what cannot be shown written out, such as "\\x1b": figures and terminals trip over it."""
    return "".join(character if character.isprintable() else ascii(character)[1:-1] for character in name)


NOT_OURS: set[str] = set()
"""Modules of effects that users wrote, which ``effects`` notes as it loads them."""


def fault_in(error: BaseException) -> str | None:
    """File, line and words of an error in an effect that a user wrote; None for other errors."""
    steps = [(f.f_globals.get("__name__"), f, n) for f, n in traceback.walk_tb(error.__traceback__)]
    if not (inside := [(frame, line) for name, frame, line in steps if name in NOT_OURS]):
        return None
    frame, line = inside[-1]
    return f"{frame.f_code.co_filename}:{line}: {type(error).__name__}: {error} (an effect of your own)"


class TrunkError(Exception):
    """Bad input. The command line prints its one line and exits with 2."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class ArgumentError(TrunkError):
    """A command line argument or an output path cannot be used."""


class RecordingError(TrunkError):
    """A recording cannot be read, or lacks what was asked of it."""


class ForeignError(RecordingError):
    """A recording has no topic of an arm: a mapping may bring it in."""


class ModelError(TrunkError):
    """A model file or a parameter does not describe an arm."""
