"""`render`: a run as a picture, a film or a page, by the ending of the file's name. Never needs a display."""

from pathlib import Path

from holodrive.errors import InputError, did_you_mean
from holodrive.log.drawing import picture
from holodrive.log.run import Run
from holodrive.reports import film
from holodrive.reports.film import Pace, Progress
from holodrive.reports.page import report

KNOWN = (".gif", ".html", ".png", ".svg")
TABLES = (".csv", ".json", ".parquet")
_SIZES = {".gif": 480, ".png": 1200, ".svg": 640}  # px, the longer side


def render(
    run: Run,
    path: str | Path,
    *,
    size: int | None = None,
    fps: float = 10.0,
    speed: float | None = None,
    animate: bool = False,
    progress: Progress | None = None,
) -> Path:
    """Write a run as .gif (film), .png (picture), .svg (picture, or film with `animate`) or .html (report).

    Args:
        run: what to draw.
        path: where to; its ending says what.
        size: longer side of the picture [px].
        fps: frames a second of a film, 1 to 50.
        speed: run seconds in one second of film; real time, or faster for runs over 300 frames, when None.
        animate: for .svg, let it play.
        progress: called with the share done, 0 to 1.

    Raises:
        InputError: an ending, size or rate that cannot be.
    """
    path = Path(path)
    suffix = ending(path, KNOWN, "render", TABLES, "export")
    if size is not None and not 100 <= size <= 4000:
        raise InputError(f"a picture of {size} px cannot be drawn; choose a size from 100 to 4000")
    if not 1.0 <= fps <= 50.0:
        raise InputError(f"{fps:g} frames a second cannot be shown; choose 1 to 50")
    if speed is not None and not 0.01 <= speed <= 1000.0:
        raise InputError(f"a film cannot run at {speed:g} times real speed; choose 0.01 to 1000")
    if not len(run.time):
        raise InputError("the run has no ticks, so there is nothing to draw")
    try:
        _write(run, path, suffix, size or _SIZES.get(suffix, 0), Pace.of(run, fps, speed), animate, progress)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror or error}") from error
    if progress:
        progress(1.0)
    return path


def ending(path: Path, known: tuple[str, ...], verb: str, others: tuple[str, ...], other_verb: str) -> str:
    """The suffix of a path in lower case, if it is known.

    Raises:
        InputError: it is not; with what is, or with the verb that knows it.
    """
    suffix = path.suffix.lower()
    if suffix not in known:
        found = f"the ending {suffix!r}" if suffix else "no ending"
        hint = f"; {suffix} is written by {other_verb}" if suffix in others else did_you_mean(suffix, known)
        raise InputError(f"{path.name!r} has {found}, and {verb} writes {', '.join(known)}{hint if suffix else ''}")
    return suffix


def _write(run: Run, path: Path, suffix: str, size: int, pace: Pace, animate: bool, progress: Progress | None) -> None:
    if suffix == ".gif":
        film.gif(run, path, size, pace, progress)
    elif suffix == ".png":
        film.still(run, size).shown().save(path, format="PNG", optimize=True)
    elif suffix == ".svg":
        text = film.animated_svg(run, size, size, pace) if animate else picture(run, size, size)
        path.write_text(text + "\n", encoding="utf-8")
    else:
        report(run).save(path)
