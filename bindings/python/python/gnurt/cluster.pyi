# SPDX-License-Identifier: GPL-3.0-or-later
from collections.abc import Callable, Iterable, Sequence
from typing import Any

__all__ = ["Job", "main", "render"]

class Job:
    output: str
    look: list[str]
    pieces: int
    program: str | None
    frames: list[int | None]
    words: list[str]
    archive: bytes
    name: str
    def __init__(
        self,
        scene: str,
        output: str,
        options: Iterable[str] = (),
        look: Iterable[str] = (),
        pieces: int = 16,
        frames: tuple[int, int] | None = None,
        program: str | None = None,
    ) -> None: ...
    def tasks(self) -> list[tuple[int | None, int]]: ...
    def join(self, folder: str, frame: int | None) -> str: ...

def render(
    job: Job, client: Any, progress: Callable[[int, int], object] | None = None, threads: int | None = None
) -> list[str]: ...
def main(words: Sequence[str] | None = None) -> int: ...
