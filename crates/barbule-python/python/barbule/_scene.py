"""Scenes and pictures."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Union

from numpy.typing import ArrayLike

from . import _native
from ._labels import media_of, numbers, text_of
from ._native import Picture
from ._opening import Name
from ._progress import ProgressLike, watched
from .errors import idle


def presets() -> dict[str, str]:
    """The names of the presets, and what each shows.

    Example:
        >>> import barbule
        >>> "starling" in barbule.presets()
        True
    """
    return dict(_native.presets())


class Scene:
    """A scene: feathers, coats, meshes, light and camera, as in a scene file.

    Example:
        >>> import barbule
        >>> closer = barbule.Scene.parse('preset = "starling"\\n[camera]\\nwidth_mm = 1.2\\n')
        >>> closer.render(size=(24, 16), samples=1).shape
        (16, 24)
    """

    def __init__(self, native: _native.Scene) -> None:
        self._native = native

    @classmethod
    def load(
        cls,
        name: Name,
        *,
        model: str | None = None,
        media: Mapping[str, Name] | None = None,
        progress: ProgressLike = True,
    ) -> Scene:
        """Opens what ``barbule render`` takes: a preset, a scene file, a material or a structure.

        Args:
            name: The preset, file, material or structure.
            model: One of the models of a preset that has several: of ``peacock`` ``film-2005``, ``film`` or ``barbule``.
            media: Media of your own by name, each a file of n and k.
            progress: True for a bar, False for none, or a function ``(label, done, total)``.

        Raises:
            barbule.InputError: An unknown name, or a model of what has none.
        """
        with watched(progress) as watch:
            return cls(_native.Scene.open(text_of("name", name), model, media_of(media), watch))

    @classmethod
    def parse(cls, toml: str, folder: Union[str, "PathLike[str]"] = ".") -> Scene:
        """A scene from the text of a scene file, which may begin with a preset; the files that it names lie in `folder`."""
        return cls(_native.Scene.parse(toml, Path(folder)))

    def with_material(self, name: Name) -> Scene:
        """The same scene with another material on its barbules: a file, or a structure."""
        return Scene(self._native.with_material(text_of("name", name)))

    def frames(self, count: int, arcs: Mapping[str, float] | None = None) -> list[Scene]:
        """The scenes of a sequence, as ``barbule render --frames`` makes it.

        Args:
            count: How many, 1 to 9999.
            arcs: How far ``light``, ``camera`` or ``feather`` swing about where they stand, degrees; 360 goes once round. The light
                by 40 without.

        Raises:
            barbule.InputError: Something else that moves, or an arc over ten turns.

        Example:
            >>> import barbule
            >>> len(barbule.Scene.load("starling").frames(5, {"light": 40}))
            5
        """
        moves = [(name, float(degrees)) for name, degrees in (arcs or {}).items()]
        return [Scene(native) for native in self._native.frames(count, moves)]

    @property
    def folder(self) -> Path:
        """The folder in which the files lie that it names."""
        return self._native.folder

    def pixels(self, size: tuple[int, int] | None = None) -> tuple[int, int]:
        """Width and height of its picture: those asked for, else its own, else 1280 by 800.

        Example:
            >>> import barbule
            >>> barbule.Scene.parse('preset = "starling"\\nsize = [48, 30]\\n').pixels()
            (48, 30)
        """
        own = self._native.size if size is None else size
        return (1280, 800) if own is None else (own[0], own[1])

    def toml(self) -> str:
        """The text of a scene file: every key with its value."""
        return self._native.toml()

    def __repr__(self) -> str:
        worn = [line.split('"')[1] for line in self.toml().splitlines() if line.startswith('material = "')]
        return f"<barbule.Scene of {', '.join(worn) or 'no material'}>"

    def render(
        self,
        size: tuple[int, int] | None = None,
        samples: int | None = None,
        *,
        noise: float | None = None,
        quality: str | None = None,
        seed: int = 1,
        spectral_nm: ArrayLike = (),
        compositing: bool = False,
        denoise: Union[bool, str, "PathLike[str]"] = False,
        tone: str | None = None,
        white_balance: Union[str, float, None] = None,
        media: Mapping[str, Name] | None = None,
        cache: Union[str, "PathLike[str]", None] = None,
        threads: int | None = None,
        progress: ProgressLike = True,
    ) -> Picture:
        """Renders it; the same bits on any number of threads.

        Args:
            size: Width and height, pixels; the scene's own, or 1280 by 800, without.
            samples: Samples per pixel; the most, where `noise` is given. 16, or 4096 with `noise`.
            noise: Ends tiles whose relative standard error is below this.
            quality: Samples and noise by a word: ``"draft"``, ``"good"`` or ``"final"``; `samples` and `noise` hold beside it.
            seed: Seed of feather, individuals and samples.
            spectral_nm: Wavelengths about which radiance itself is kept (plane ``spectrum``).
            compositing: Whether the albedo of first hits is kept.
            denoise: True takes the noise away with the system's Open Image Denoise, a path with that library (plane
                ``denoised_xyz``; ``xyz`` stays as it was sampled).
            tone: ``"plain"`` or ``"filmic"`` in place of the scene's.
            white_balance: ``"none"``, ``"auto"`` or a colour temperature in K in place of the scene's.
            media: Media of your own by name, each a file of n and k.
            cache: Folder of computed materials; that of the command line without one.
            threads: Threads; all cores without a number.
            progress: True for a bar, False for none, or a function ``(label, done, total)``.

        Returns:
            A picture: ``rgb()``, ``planes()``, ``save(path)``, ``lamps``.
        """
        bands = numbers(spectral_nm).tolist()
        folder = None if cache is None else Path(cache)
        library = None if isinstance(denoise, bool) else Path(denoise)
        white = None if white_balance is None else str(white_balance)
        with watched(progress) as watch:
            return self._native.render(
                list(self.pixels(size)),
                samples,
                noise,
                quality,
                seed,
                bands,
                compositing,
                denoise is not False,
                library,
                tone,
                white,
                media_of(media),
                folder,
                threads,
                watch,
            )


def render(
    scene: Scene | Name,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    *,
    noise: float | None = None,
    quality: str | None = None,
    seed: int = 1,
    spectral_nm: ArrayLike = (),
    compositing: bool = False,
    model: str | None = None,
    denoise: Union[bool, str, "PathLike[str]"] = False,
    tone: str | None = None,
    white_balance: Union[str, float, None] = None,
    media: Mapping[str, Name] | None = None,
    cache: Union[str, "PathLike[str]", None] = None,
    threads: int | None = None,
    progress: ProgressLike = True,
) -> Picture:
    """Renders a scene or a preset; arguments as for `Scene.render`, and the preset's `model` as for `Scene.load`.

    Example:
        >>> import barbule
        >>> picture = barbule.render("starling", size=(24, 16), samples=1)
        >>> picture.rgb().shape
        (16, 24, 3)
    """
    if isinstance(scene, Scene) and model is not None:
        idle("model", "the scene is open already; Scene.load takes it")
    opened = scene if isinstance(scene, Scene) else Scene.load(scene, model=model, media=media, progress=progress)
    return opened.render(
        size,
        samples,
        noise=noise,
        quality=quality,
        seed=seed,
        spectral_nm=spectral_nm,
        compositing=compositing,
        denoise=denoise,
        tone=tone,
        white_balance=white_balance,
        media=media,
        cache=cache,
        threads=threads,
        progress=progress,
    )
