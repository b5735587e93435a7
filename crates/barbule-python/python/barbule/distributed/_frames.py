"""Pictures on a cluster: each frame a file of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path
from typing import Any, Union

from .._opening import Name
from .._progress import ProgressLike
from .._scene import Scene
from ..errors import InputError, MachineError
from ._engine import asked, compute, refuse_unlike
from ._notes import is_noted, note
from ._work import Watch, identity_of, placed, placed_media

#: Memory that a frame is counted with where nothing else is said, bytes.
USUAL_BYTES = 2 << 30

#: What a scene is: its name, or the text of a scene file with the folder in which its files lie.
Sent = tuple[str, Union[str, None]]


@dataclass(frozen=True)
class FramesWork:
    """Frames as they are sent to workers; an item is a frame."""

    scenes: tuple[Sent, ...]
    files: tuple[str, ...]
    media: tuple[tuple[str, str], ...]
    cache: str | None
    #: Arguments of `Scene.render`.
    how: tuple[tuple[str, Any], ...]

    label = "frames"

    @property
    def identity(self) -> str:
        """A hash of what is rendered and where it goes."""
        return identity_of(**asdict(self))

    def frame_identity(self, number: int) -> str:
        """A hash of all that decides a frame, but for what lies in files that its scene names."""
        return identity_of(scene=self.scenes[number], media=self.media, how=self.how)

    def prepare(self, folder: Path, slots: int) -> PreparedFrames:
        """Nothing is shared between frames but what the cache has."""
        return PreparedFrames(self)


class PreparedFrames:
    """Frames on a worker."""

    def __init__(self, work: FramesWork) -> None:
        self._work = work

    def run(self, item: int, threads: int, watch: Watch) -> None:
        """Renders a frame, unless it is there."""
        work = self._work
        if is_there(work, item):
            return
        scene = opened(work.scenes[item], work.media, watch)
        picture = scene.render(media=dict(work.media), cache=work.cache, threads=threads, progress=watch, **dict(work.how))
        path = Path(work.files[item])
        picture.save(path)
        note(path, work.frame_identity(item))

    def close(self) -> None:
        """Nothing stays open."""


def is_there(work: FramesWork, number: int) -> bool:
    """Whether a frame's file is there, is whole, and is of this scene."""
    return is_noted(Path(work.files[number]), work.frame_identity(number))


def render_frames(
    scenes: Sequence[Scene | Name],
    output: Union[str, "PathLike[str]"],
    *,
    client: Any,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    noise: float | None = None,
    quality: str | None = None,
    seed: int = 1,
    compositing: bool = False,
    tone: str | None = None,
    white_balance: Union[str, float, None] = None,
    media: Mapping[str, Name] | None = None,
    cache: Union[str, "PathLike[str]", None] = None,
    memory_bytes: int = USUAL_BYTES,
    threads: int = 1,
    retries: int = 3,
    progress: ProgressLike = True,
) -> list[Path]:
    """Renders frames on a cluster, each into a file of its own: the pictures of `Scene.render`, to the same bits.

    A frame that is there and of the same scene is not rendered again. What says so is a small file beside it, ``.F-0000.png.json``.

    Args:
        scenes: A scene for each frame, as `Scene.frames` gives them, or whatever `Scene.load` opens; files lie where all workers see
            them.
        output: Where frames go, a place that all workers see: ``F.png`` makes ``F-0000.png``, ``F-0001.png`` …
        client: A `distributed.Client`.
        size: Width and height, pixels; the scene's own, or 1280 by 800, without.
        samples: As for `Scene.render`, and so the next ones.
        noise: As for `Scene.render`.
        quality: As for `Scene.render`.
        seed: As for `Scene.render`.
        compositing: As for `Scene.render`.
        tone: As for `Scene.render`.
        white_balance: As for `Scene.render`.
        media: Media of your own by name, each a file of n and k that all workers see.
        cache: Folder of computed materials that all workers see: a material that must be made is then made once.
        memory_bytes: What a frame is counted with.
        threads: Threads of each frame; workers should have as many slots as cores, and frames one thread.
        retries: How often a failed frame is tried again.
        progress: True for a bar, False for none, or a function ``(label, done, total)``.

    Returns:
        The files.

    Raises:
        InputError: No scene, or what a worker refuses of one.
        MachineError: A frame failed too often, or is not there in the end.
    """
    if not scenes:
        raise InputError("'scenes' is empty; give at least one")
    path = checked_output(output)
    how = {
        "size": size,
        "samples": samples,
        "noise": noise,
        "quality": quality,
        "seed": seed,
        "compositing": compositing,
        "tone": tone,
        "white_balance": white_balance,
    }
    work = FramesWork(
        scenes=tuple(sent(scene) for scene in scenes),
        files=tuple(str(path.with_name(f"{path.stem}-{number:04}{path.suffix}")) for number in range(len(scenes))),
        media=placed_media(media),
        cache=None if cache is None else str(Path(cache).absolute()),
        how=tuple(how.items()),
    )
    cluster = asked(client)
    refuse_unlike(cluster, "pictures")
    tasks = [range(number, number + 1) for number in _missing(work)]
    compute(work, tasks, cluster, memory_bytes=memory_bytes, threads=threads, retries=retries, progress=progress)
    missing = _missing(work)
    if missing:
        raise MachineError(
            f"{len(missing)} of {len(scenes)} frames are missing although their tasks ended well, the first {work.files[missing[0]]}; "
            "look whether all workers see the same folder"
        )
    return [Path(file) for file in work.files]


def _missing(work: FramesWork) -> list[int]:
    return [number for number in range(len(work.files)) if not is_there(work, number)]


def checked_output(output: Union[str, "PathLike[str]"]) -> Path:
    """The whole path of a picture.

    Raises:
        InputError: It has no ending, or there is no such folder.
    """
    path = Path(output).absolute()
    if not path.suffix or not path.parent.is_dir():
        raise InputError(f"'output' is {output}; give the name of a picture in a folder that is there, as in F.png")
    return path


def sent(scene: Scene | Name) -> Sent:
    """A scene as it goes to workers."""
    if isinstance(scene, Scene):
        return scene.toml(), str(Path(scene.folder).absolute())
    return placed(scene), None


def opened(scene: Sent, media: Sequence[tuple[str, str]], watch: Watch | None) -> Scene:
    """The same scene again."""
    text, folder = scene
    if folder is not None:
        return Scene.parse(text, folder)
    return Scene.load(text, media=dict(media), progress=watch or False)
