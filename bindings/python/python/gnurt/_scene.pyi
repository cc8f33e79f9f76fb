# SPDX-License-Identifier: GPL-3.0-or-later
from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import Picture

__all__ = ["Camera", "Scene", "load", "read_volume"]

class Camera:
    eye: tuple[float, ...]
    target: tuple[float, ...]
    up: tuple[float, ...]
    fov: float
    name: str
    projection: str
    view_height: float | None
    aperture: float
    focus: float | None
    shift: tuple[float, ...]
    def __init__(
        self,
        eye: Sequence[float],
        target: Sequence[float],
        up: Sequence[float] = (0.0, 1.0, 0.0),
        fov: float | None = None,
        name: str = "",
        *,
        projection: Literal["perspective", "orthographic", "fisheye", "panorama"] = "perspective",
        view_height: float | None = None,
        aperture: float = 0.0,
        focus: float | None = None,
        shift: Sequence[float] = (0.0, 0.0),
        lens: float | None = None,
        sensor: float = 24.0,
    ) -> None: ...
    def __eq__(self, other: object) -> bool: ...
    __hash__: None  # type: ignore[assignment]

class Scene:
    def __new__(cls) -> Self: ...
    def __getstate__(self) -> dict[str, Any]: ...
    def __setstate__(self, state: dict[str, Any]) -> None: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[int, Any]) -> Self: ...
    @property
    def materials(self) -> list[str]: ...
    @property
    def instances(self) -> list[str]: ...
    @property
    def animations(self) -> list[str]: ...
    @property
    def cameras(self) -> list[Camera]: ...
    def add_material(self, name: str = "", **properties: Any) -> int: ...
    def set_material(self, material: int, name: str = "", **properties: Any) -> None: ...
    def shade(
        self,
        material: str,
        shader: str | PathLike[str],
        *,
        parameters: dict[str, Any] | None = None,
        textures: dict[str, int] | None = None,
    ) -> list[int]: ...
    def add_medium(self, name: str = "", **properties: Any) -> int: ...
    def set_medium(self, medium: int, name: str = "", **properties: Any) -> None: ...
    def add_texture(
        self,
        source: str | PathLike[str] | ArrayLike,
        *,
        name: str | None = None,
        colorspace: Literal["srgb", "linear"] = "srgb",
        wrap: str | tuple[str, str] = "repeat",
        filter: Literal["linear", "nearest"] = "linear",
    ) -> int: ...
    def set_texture(
        self,
        texture: int,
        source: str | PathLike[str] | ArrayLike,
        *,
        name: str | None = None,
        colorspace: Literal["srgb", "linear"] = "srgb",
        wrap: str | tuple[str, str] = "repeat",
        filter: Literal["linear", "nearest"] = "linear",
    ) -> None: ...
    def add_mesh(
        self,
        vertices: Any,
        faces: ArrayLike | None = None,
        *,
        name: str | None = None,
        normals: ArrayLike | None = None,
        texcoords: ArrayLike | None = None,
        tangents: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        attributes: Mapping[str, ArrayLike] | None = None,
        face_attributes: Mapping[str, ArrayLike] | None = None,
        material: int | Sequence[int] | None = None,
        face_materials: ArrayLike | None = None,
        transform: ArrayLike | None = None,
        rays: Sequence[str] | None = None,
        moments: Mapping[str, Sequence[ArrayLike]] | None = None,
    ) -> int: ...
    def add_curves(
        self,
        vertices: ArrayLike,
        radii: ArrayLike,
        *,
        counts: Sequence[int] | None = None,
        basis: str = "bspline",
        form: str = "round",
        normals: ArrayLike | None = None,
        texcoords: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        attributes: Mapping[str, ArrayLike] | None = None,
        name: str | None = None,
        material: int | None = None,
        transform: ArrayLike | None = None,
        rays: Sequence[str] | None = None,
    ) -> int: ...
    def add_points(
        self,
        vertices: ArrayLike,
        radii: ArrayLike,
        *,
        texcoords: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        attributes: Mapping[str, ArrayLike] | None = None,
        name: str | None = None,
        material: int | None = None,
        transform: ArrayLike | None = None,
        rays: Sequence[str] | None = None,
    ) -> int: ...
    def set_mesh(
        self,
        instance: int,
        vertices: Any,
        faces: ArrayLike | None = None,
        *,
        name: str | None = None,
        normals: ArrayLike | None = None,
        texcoords: ArrayLike | None = None,
        tangents: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        attributes: Mapping[str, ArrayLike] | None = None,
        face_attributes: Mapping[str, ArrayLike] | None = None,
        material: int | Sequence[int] | None = None,
        face_materials: ArrayLike | None = None,
        moments: Mapping[str, Sequence[ArrayLike]] | None = None,
    ) -> None: ...
    def add_instance(self, instance: int, transform: ArrayLike) -> int: ...
    def update(
        self,
        instance: int,
        *,
        transform: ArrayLike | None = None,
        visible: bool | None = None,
        vertices: ArrayLike | None = None,
        material: int | None = None,
        rays: Sequence[str] | None = None,
    ) -> None: ...
    def add_light_shader(
        self,
        shader: str | PathLike[str],
        *,
        parameters: dict[str, Any] | None = None,
        textures: dict[str, int] | None = None,
    ) -> int: ...
    def set_light_shader(
        self,
        light: int,
        shader: str | PathLike[str],
        *,
        parameters: dict[str, Any] | None = None,
        textures: dict[str, int] | None = None,
    ) -> None: ...
    def add_light(self, kind: str, **properties: Any) -> int: ...
    def set_light(self, light: int, kind: str, **properties: Any) -> None: ...
    def set(self, change: str) -> None: ...
    def add_camera(self, camera: Camera) -> int: ...
    def save(self, path: str | PathLike[str]) -> None: ...
    def render(
        self,
        width: int = 640,
        height: int = 480,
        *,
        progress: Callable[[float], object] | Literal[True] | None = None,
        **options: Any,
    ) -> Picture: ...
    def frames(
        self,
        numbers: range,
        width: int = 640,
        height: int = 480,
        *,
        fps: float = 24.0,
        animation: str | None = None,
        denoise_window: int | None = None,
        progress: Callable[[float], object] | Literal[True] | None = None,
        **options: Any,
    ) -> Iterator[Picture]: ...
    def accumulate(
        self,
        width: int = 640,
        height: int = 480,
        *,
        progress: Callable[[float], object] | Literal[True] | None = None,
        **options: Any,
    ) -> Iterator[Picture]: ...

def load(source: str | PathLike[str]) -> Scene: ...
def read_volume(
    path: str | PathLike[str], names: Sequence[str] | None = None
) -> dict[str, tuple[NDArray[np.float32], NDArray[np.float64]]]: ...
