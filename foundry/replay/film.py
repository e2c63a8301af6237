"""Writes pictures as a film: MP4 with ffmpeg, GIF with Pillow."""

import io
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from foundry.errors import InputError, not_found
from foundry.replay.pictures import Picture

_GIF_COLOURS = 128


def check_film(path: Path, fps: float) -> None:
    """Raise InputError if a film cannot be written to this path at this rate, before any picture is drawn."""
    if path.suffix.lower() not in _WRITERS:
        raise not_found("Kind of film", path.suffix or path.name, _WRITERS, "Choose a kind by the file's ending.")
    if not path.parent.is_dir():
        raise InputError(f"--video {path}: there is no folder '{path.parent}'. Create it first.")
    if not 0 < fps <= 100:
        raise InputError(f"--fps must be above 0 and at most 100; got {fps:g}.")
    if path.suffix.lower() == ".mp4":
        _ffmpeg()


def write_film(path: Path, shown: Iterable[Picture], fps: float) -> None:
    """Write pictures of the same size as a film. While foundry writes the file, its name contains `.unfinished`."""
    unfinished = path.with_stem(f".{path.stem}.unfinished")
    try:
        _WRITERS[path.suffix.lower()](unfinished, shown, fps)
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)


def _ffmpeg() -> Any:
    try:
        import imageio_ffmpeg
    except ImportError as error:
        raise InputError("An MP4 needs an encoder: pip install 'foundry-worlds[video]', or write a .gif.") from error
    return imageio_ffmpeg


def _write_mp4(path: Path, shown: Iterable[Picture], fps: float) -> None:
    writer: Any = None
    try:
        for opened in _opened(shown):
            pixels = _even(np.asarray(opened, np.uint8))
            if writer is None:
                size = (pixels.shape[1], pixels.shape[0])
                # With the index at the front, a browser can start before it has the whole file.
                parameters = ["-movflags", "+faststart"]
                writer = _ffmpeg().write_frames(
                    str(path), size, fps=fps, codec="libx264", quality=7, macro_block_size=2,
                    ffmpeg_log_level="error", output_params=parameters,
                )  # fmt: skip
                writer.send(None)
            writer.send(pixels)
    finally:
        if writer is not None:
            writer.close()


def _even(pixels: Any) -> Any:
    """Repeat the last row or column of a picture (h, w, 3) if h or w is odd, because H.264 needs even sizes."""
    height, width = pixels.shape[:2]
    return np.ascontiguousarray(np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge"))


def _write_gif(path: Path, shown: Iterable[Picture], fps: float) -> None:
    reduce: Any = {"method": Image.Quantize.FASTOCTREE, "dither": Image.Dither.NONE}
    frames = (opened.quantize(_GIF_COLOURS, **reduce) for opened in _opened(shown))
    first = next(frames)
    first.save(path, save_all=True, append_images=frames, duration=max(round(1000 / fps), 10), loop=0)


def _opened(shown: Iterable[Picture]) -> Iterator[Image.Image]:
    return (Image.open(io.BytesIO(picture.png)).convert("RGB") for picture in shown)


_WRITERS: dict[str, Callable[[Path, Iterable[Picture], float], None]] = {".mp4": _write_mp4, ".gif": _write_gif}
