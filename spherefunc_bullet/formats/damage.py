"""One clear line for whatever a reader raises on a bad file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import InputError, OutOfMemory, one_line
from . import FormatError

# What only the extra ``formats`` brings.
OPTIONAL = ("collada", "lxml", "yourdfpy", "laspy", "lazrs")


@contextmanager
def refusing(path: Path) -> Iterator[None]:
    """Turn what is raised within into an InputError of one line that begins with the file's name."""
    name = one_line(path.name)
    try:
        yield
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in OPTIONAL:
            raise  # a broken installation, not a bad file
        needs = f"expected the extra 'formats' to read it, {error.name} is missing"
        raise InputError(f"{name}: {needs}; pip install 'spherefunc-bullet[formats]'") from error
    except (InputError, FormatError) as error:
        line = one_line(error)
        raise InputError(line if line.startswith(name) else f"{name}: {line}") from error
    except MemoryError as error:
        wanted = "expected to need no more memory to read it than there is"
        raise OutOfMemory(f"{name}: {wanted}; simplify it") from error
    except Exception as error:  # the one place where what readers raise on damaged bytes becomes the user's error
        detail = one_line(f"{type(error).__name__}: {error}")[:160]
        kind = path.suffix.lower()[1:].upper()
        raise InputError(f"{name}: expected a {kind} file, could not read it ({detail}); is it damaged?") from error
