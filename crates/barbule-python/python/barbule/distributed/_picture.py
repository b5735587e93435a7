"""One picture on a cluster, in parts of its tiles."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, Union

from numpy.typing import ArrayLike

from .. import _native
from .._labels import numbers
from .._opening import Name
from .._progress import ProgressLike, watched
from .._scene import Scene
from ..errors import InputError, MachineError
from ._engine import UNIT_SECONDS, Cluster, asked, compute, refuse_unlike
from ._fill import fill
from ._frames import USUAL_BYTES, Sent, checked_output, opened, sent
from ._notes import is_noted, note
from ._work import Watch, identity_of, placed_media

#: How often what is damaged or lost is rendered again before the call gives up.
MOST_REPAIRS = 2

#: The picture that this process renders parts of, by its identity: its tasks come in several rounds, and the scene stands through all of them.
_kept: dict[str, _native.Parts] = {}
_keeping = threading.Lock()


@dataclass(frozen=True)
class PictureWork:
    """A picture as it is sent to workers; an item is a part."""

    scene: Sent
    output: str
    media: tuple[tuple[str, str], ...]
    cache: str | None
    size: tuple[int, int] | None
    samples: int | None
    noise: float | None
    quality: str | None
    seed: int
    spectral_nm: tuple[float, ...]
    compositing: bool
    tone: str | None
    white_balance: str | None
    tiles: int | None
    #: What the client knows the picture by: a hash of the scene with all that it names, and of how it is rendered.
    name: str = ""

    label = "tiles"

    @property
    def identity(self) -> str:
        """A hash of what is rendered and where it goes."""
        return identity_of(**asdict(self))

    def parts(
        self,
        threads: int | None,
        watch: Watch | None,
        *,
        denoise: bool = False,
        library: Path | None = None,
    ) -> _native.Parts:
        """The parts, of a scene of which everything is read."""
        scene = opened(self.scene, self.media, watch)
        return _native.Parts(
            scene._native,
            Path(self.output),
            list(scene.pixels(self.size)),
            self.samples,
            self.noise,
            self.quality,
            self.seed,
            list(self.spectral_nm),
            self.compositing,
            denoise,
            library,
            self.tone,
            self.white_balance,
            self.tiles,
            list(self.media),
            None if self.cache is None else Path(self.cache),
            threads,
            watch,
        )

    def prepare(self, folder: Path, slots: int) -> PreparedPicture:
        """Reads the scene on a worker, once for all rounds; what stands in it is grown with the first part."""
        with _keeping:
            parts = _kept.get(self.identity)
            if parts is None:
                parts = self.parts(slots, None)
                if parts.name != self.name:
                    raise InputError(
                        f"the scene of {self.output} is another one on this worker than where the work began; "
                        "put its files on a file system that all of them see, or install the same version of barbule"
                    )
                _kept.clear()
                _kept[self.identity] = parts
        return PreparedPicture(parts, slots)


class PreparedPicture:
    """A picture on a worker."""

    def __init__(self, parts: _native.Parts, slots: int) -> None:
        self._parts = parts
        self._slots = slots

    def run(self, item: int, threads: int, watch: Watch) -> None:
        """Renders what a part lacks."""
        # The other slots have nothing to do before.
        self._parts.prepare(self._slots, watch)
        self._parts.run(item, threads, watch)

    def close(self) -> None:
        """The scene stands until `drop`."""


def drop(identity: str) -> None:
    """Gives back what a picture has taken of this process."""
    with _keeping:
        _kept.pop(identity, None)


def render(
    scene: Scene | Name,
    output: Union[str, "PathLike[str]"],
    *,
    client: Any,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    noise: float | None = None,
    quality: str | None = None,
    seed: int = 1,
    spectral_nm: ArrayLike = (),
    compositing: bool = False,
    denoise: Union[bool, str, "PathLike[str]"] = False,
    tone: str | None = None,
    white_balance: Union[str, float, None] = None,
    tiles: int | None = None,
    media: Mapping[str, Name] | None = None,
    cache: Union[str, "PathLike[str]", None] = None,
    memory_bytes: int = USUAL_BYTES,
    unit_seconds: float = UNIT_SECONDS,
    threads: int = 1,
    retries: int = 3,
    progress: ProgressLike = True,
) -> Path:
    """Renders one picture on a cluster, in parts of its tiles of 32 × 32 pixels: that of `Scene.render`, to the same bits.

    Parts are files beside the picture until they are joined, as ``barbule render --shard`` has them; the same call goes on with
    those that are there. Exposure, white and noise are seen to when they are joined, here. A picture that is there and of the same
    scene is not rendered again; what says so is a small file beside it.

    Args:
        scene: A scene, or whatever `Scene.load` opens; files lie where all workers see them.
        output: The picture, in a folder that all workers see.
        client: A `distributed.Client`.
        size: Width and height, pixels; the scene's own, or 1280 by 800, without.
        samples: As for `Scene.render`, and so the next ones.
        noise: As for `Scene.render`.
        quality: As for `Scene.render`.
        seed: As for `Scene.render`.
        spectral_nm: As for `Scene.render`.
        compositing: As for `Scene.render`.
        denoise: As for `Scene.render`; workers do not need the library.
        tone: As for `Scene.render`.
        white_balance: As for `Scene.render`.
        tiles: Tiles in a part; as many as make 256 parts without. Fewer for clusters with more slots than that.
        media: Media of your own by name, each a file of n and k that all workers see.
        cache: Folder of computed materials that all workers see: a material that must be made is then made once.
        memory_bytes: What a task is counted with.
        unit_seconds: What a task is to take at least, as measured with the first parts.
        threads: Threads of each task; workers should have as many slots as cores, and tasks one thread.
        retries: How often a failed task is tried again.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        The picture's file.

    Raises:
        InputError: A scene that workers see differently, or what a worker refuses of it.
        MachineError: A task failed too often, or parts are damaged or not there in the end.
    """
    path = checked_output(output)
    denoises = denoise is not False
    work = PictureWork(
        scene=sent(scene),
        output=str(path),
        media=placed_media(media),
        cache=None if cache is None else str(Path(cache).absolute()),
        size=None if size is None else (size[0], size[1]),
        samples=samples,
        noise=noise,
        quality=quality,
        seed=seed,
        spectral_nm=tuple(numbers(spectral_nm).tolist()),
        compositing=compositing or denoises,
        tone=tone,
        white_balance=None if white_balance is None else str(white_balance),
        tiles=tiles,
    )
    library = None if isinstance(denoise, bool) else Path(denoise)
    with watched(progress) as watch:
        parts = work.parts(None, watch, denoise=denoises, library=library)
    work = replace(work, name=parts.name)
    identity = identity_of(picture=work.name, denoise=str(denoise))
    if is_noted(path, identity):
        # Left by who was killed just before.
        parts.delete()
        return path
    cluster = asked(client)
    refuse_unlike(cluster, "pictures")
    how: dict[str, Any] = {"memory_bytes": memory_bytes, "threads": threads, "retries": retries, "progress": progress}

    def missing() -> list[int]:
        return [number for number in range(len(parts)) if not parts.is_there(number)]

    try:
        fill(work, missing, cluster, unit_seconds=unit_seconds, place=str(path), **how)
        picture = _joined(work, parts, cluster, how)
    finally:
        # A cluster that is gone keeps nothing.
        with suppress(Exception):
            client.run(drop, work.identity, on_error="ignore")
    picture.save(path)
    note(path, identity)
    parts.delete()
    return path


def _joined(work: PictureWork, parts: _native.Parts, cluster: Cluster, how: Mapping[str, Any]) -> _native.Picture:
    """The picture, after what is damaged has been rendered again."""
    lacking: Sequence[int] = ()
    for _ in range(MOST_REPAIRS + 1):
        compute(work, [range(number, number + 1) for number in lacking], cluster, **how)
        with watched(how["progress"]) as watch:
            picture, lacking = parts.join(None, watch)
        if picture is not None:
            return picture
    raise MachineError(
        f"{len(lacking)} of {len(parts)} parts of {work.output} are missing or damaged although their tasks ended well; "
        "look whether all workers see the same folder, and call the same function again to go on"
    )
