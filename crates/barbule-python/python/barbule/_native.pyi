"""What the package is made of, in Rust. Private: `barbule` has the functions that people call."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

_Watch = Callable[[str, int, int], Any] | None
_Media = Sequence[tuple[str, str]]
_Curve = tuple[NDArray[np.float64], NDArray[np.float64]]

def run(arguments: Sequence[str]) -> int: ...
def version() -> str: ...
def open(text: str, media: _Media, threads: int | None, progress: _Watch) -> Structure | Material: ...
def species() -> dict[str, list[str]]:
    """All species with their variants, the usual one first.

    Example:
        >>> import barbule
        >>> "pink" in barbule.species()["starling"]
        True
    """

def presets() -> list[tuple[str, str]]: ...
def film(
    stack: str,
    wavelengths_nm: NDArray[np.float64],
    angles_deg: NDArray[np.float64],
    instances: int,
    seed: int,
    media: _Media,
    threads: int | None,
    progress: _Watch,
) -> dict[str, NDArray[Any]]: ...
def film_gradients(
    stack: str,
    wavelengths_nm: NDArray[np.float64],
    angles_deg: NDArray[np.float64],
    media: _Media,
    threads: int | None,
) -> list[NDArray[np.complex128]]: ...
def spectra(
    structure: Structure,
    wavelengths_nm: NDArray[np.float64],
    theta_deg: NDArray[np.float64],
    phi_deg: NDArray[np.float64],
    instances: int,
    seed: int,
    cone_deg: float | None,
    polarization: Sequence[float],
    threads: int | None,
    progress: _Watch,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]: ...
def readings(
    structure: Structure,
    wavelengths_nm: NDArray[np.float64],
    angles_deg: NDArray[np.float64],
    instrument: str,
    along: bool,
    turn_deg: float,
    tilt_deg: tuple[float, float],
    instances: int,
    seed: int,
    polarization: Sequence[float],
    threads: int | None,
    progress: _Watch,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]: ...
def material_readings(
    material: Material,
    wavelengths_nm: NDArray[np.float64],
    angles_deg: NDArray[np.float64],
    instrument: str,
    along: bool,
    turn_deg: float,
    tilt_deg: tuple[float, float],
    threads: int | None,
    progress: _Watch,
) -> NDArray[np.float64]: ...

_Ends = tuple[float, float, float | None]

def angle_law(
    angles_deg: NDArray[np.float64], peaks_nm: Sequence[float]
) -> tuple[_Ends, _Ends | None, float, _Ends, _Ends, float]: ...
def eye_names() -> list[str]: ...

_Cone = tuple[str, float, float, str, NDArray[np.float64]]

def eye(bird: str) -> tuple[str, str, list[_Cone], _Cone | None, list[float], list[str]]: ...
def catches(
    wavelengths_nm: NDArray[np.float64], reflectance: NDArray[np.float64], bird: str, illuminant: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def jnd(
    catches: NDArray[np.float64], ratio: NDArray[np.float64], weber: float, is_rarest: bool
) -> NDArray[np.float64]: ...
def tetrahedral(catches: NDArray[np.float64]) -> NDArray[np.float64]: ...
def things(
    text: str,
    each_sample: bool,
    wavelengths_nm: NDArray[np.float64],
    angle_deg: NDArray[np.float64],
    instances: int,
    seed: int,
    media: _Media,
    threads: int | None,
    progress: _Watch,
) -> list[tuple[str, NDArray[np.float64], NDArray[np.float64], bool]]: ...
def fit_structure(
    files: Sequence[str],
    wavelengths_nm: NDArray[np.float64],
    reflectance: NDArray[np.float64],
    angles_deg: NDArray[np.float64],
    model: str,
    stack: str | None,
    free: Sequence[str],
    instrument: str | None,
    along: bool,
    range_nm: Sequence[float] | None,
    column: str | None,
    fixed: bool,
    offset: bool,
    solutions: int,
    instances: int,
    seed: int,
    media: _Media,
    threads: int | None,
    progress: _Watch,
) -> tuple[str, str]: ...
def measured(
    places: Sequence[str], column: str | None, is_percent: bool | None
) -> list[tuple[float | None, list[str], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], str]]: ...
def compare(
    wavelengths_nm: NDArray[np.float64],
    mean: NDArray[np.float64],
    individuals: NDArray[np.float64],
    measured_nm: NDArray[np.float64],
    samples: NDArray[np.float64],
    peak_range_nm: Sequence[float] | None,
) -> str: ...
def intervals(
    text: str,
    wavelengths_nm: NDArray[np.float64],
    theta_deg: NDArray[np.float64],
    phi_deg: NDArray[np.float64],
    instances: int,
    seed: int,
    uncertain: Sequence[str],
    media: _Media,
    threads: int | None,
    progress: _Watch,
) -> str: ...
def far_fields(
    section: Section,
    wavelengths_nm: NDArray[np.float64],
    theta_deg: NDArray[np.float64],
    phi_deg: NDArray[np.float64],
    azimuths: int,
    window: str,
    solver: str,
    elements_per_wavelength: float,
    memory_bytes: int,
    threads: int | None,
    progress: _Watch,
) -> dict[str, Any]: ...
def crystal(
    text: str,
    wavelengths_nm: NDArray[np.float64],
    theta_deg: float,
    phi_deg: NDArray[np.float64],
    solver: str,
    media: _Media,
    threads: int | None,
    progress: _Watch,
) -> NDArray[np.float64]: ...
def xyz_of(
    wavelengths_nm: NDArray[np.float64], reflectance: NDArray[np.float64], illuminant: str
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.uint8]]: ...
def colour_doubt(wavelengths_nm: NDArray[np.float64]) -> str | None: ...
def delta_e_2000(one: Sequence[float], other: Sequence[float]) -> float: ...
def characterize(
    structure: Structure,
    options: str,
    halo: bool,
    sigma: float | None,
    store: Path | None,
    cache: Path | None,
    memory_bytes: int | None,
    threads: int | None,
    progress: _Watch,
) -> Material: ...
def simulate(
    structure: Structure,
    path: Path,
    options: str,
    keep_fields_nm: Sequence[float],
    shard: tuple[int, int],
    cache: Path | None,
    memory_bytes: int | None,
    threads: int | None,
    progress: _Watch,
) -> tuple[int, int]: ...
def atlas(
    plan: Path,
    store: Path,
    shard: tuple[int, int],
    seed: int,
    media: _Media,
    simd: str | None,
    cache: Path | None,
    allowed_bytes: int | None,
    page: Path | None,
    picture: Path | None,
    threads: int | None,
    progress: _Watch,
) -> tuple[int, int, int, list[tuple[int, float]]]: ...
@final
class AtlasUnits:
    """An atlas with its store, whose units workers compute one by one."""

    def __new__(cls, plan: Path, store: Path, seed: int, media: _Media, simd: str | None) -> AtlasUnits: ...
    @staticmethod
    def simd_of(store: Path) -> str | None: ...
    def foretell(self, threads: int, progress: _Watch) -> tuple[float, int]: ...
    def is_done(self, unit: int) -> bool: ...
    def run(self, unit: int, threads: int | None = 1, progress: _Watch = None) -> None: ...
    def end(self) -> None: ...
    def __len__(self) -> int: ...
def foretell_atlas(
    plan: Path, seed: int, media: _Media, threads: int | None, progress: _Watch
) -> tuple[int, int, int, int, int, int, list[float], float]: ...
def simd() -> list[str]: ...
@final
class Comparison:
    """The fast simulation against full waves or segments, with the folder of its figures."""

    def __new__(
        cls,
        structure: Structure,
        folder: Path,
        against: str,
        options: str,
        with_material: bool,
        material: str | None,
        media: _Media,
        simd: str | None,
        cache: Path | None,
        memory_bytes: int | None,
    ) -> Comparison: ...
    @property
    def is_pinned(self) -> bool: ...
    def costs(self, threads: int) -> list[tuple[float, int]]: ...
    def missing(self) -> list[int]: ...
    def run(self, unit: int, threads: int | None, progress: _Watch) -> None: ...
    def check_memory(self, threads: int | None, memory_bytes: int | None) -> None: ...
    def finish(self, threads: int | None, progress: _Watch) -> str: ...
    def __len__(self) -> int: ...

@final
class Campaign:
    """A campaign in portions of a few seconds, with its store."""

    def __new__(
        cls,
        structure: Structure,
        store: Path,
        options: str,
        keep_fields_nm: Sequence[float],
        simd: str | None,
        seconds: float,
        cache: Path | None,
        memory_bytes: int | None,
    ) -> Campaign: ...
    @staticmethod
    def simd_of(store: Path) -> str | None: ...
    @property
    def name(self) -> str: ...
    @property
    def simd(self) -> str: ...
    @property
    def portions(self) -> list[tuple[int, float]]: ...
    def memory_bytes(self, threads: int | None, progress: _Watch) -> int: ...
    def is_done(self, portion: int) -> bool: ...
    def prepare(self, threads: int | None, progress: _Watch) -> None: ...
    def run(self, portion: int, threads: int | None = 1, progress: _Watch = None) -> tuple[int, int]: ...
    def files(self, portion: int) -> list[list[str]]: ...
    def own_files(self) -> list[str]: ...
    @property
    def halo_count(self) -> int: ...
    def halo_bytes(self, threads: int | None) -> int: ...
    def is_halo_done(self, unit: int) -> bool: ...
    def run_halo(self, unit: int, threads: int | None, progress: _Watch) -> None: ...
    def check(self, sigma: float | None) -> None: ...
    def material(self, sigma: float | None, halo: bool, threads: int | None, progress: _Watch) -> Material: ...
    def leave(self) -> None: ...
    def end(self) -> None: ...
    def __len__(self) -> int: ...

def fit(store: Path, sigma: float | None, threads: int | None, progress: _Watch) -> Material: ...
@final
class Structure:
    """What a barbule is made of: a species, a stack, given sections or a lattice.

    In notebooks its first individual is drawn.

    Example:
        >>> import barbule
        >>> mallard: barbule.Structure = barbule.open("mallard")
        >>> mallard.instance(0).width_um
        40.0
    """

    @property
    def name(self) -> str: ...
    @property
    def width_um(self) -> float: ...
    @property
    def count(self) -> int | None: ...
    @property
    def is_lower_side(self) -> bool: ...
    @property
    def hash(self) -> str: ...
    def underside(self) -> Structure: ...
    def instance(self, index: int = 0, seed: int = 1) -> Section: ...
    def _repr_svg_(self) -> str: ...

@final
class Section:
    """A barbule's cross section; lengths in µm.

    Example:
        >>> import barbule
        >>> section: barbule.Section = barbule.open("starling").instance(0)
        >>> section.media_at([0.0, 0.0], [5.0, -0.3])[0]
        'air'
    """

    @property
    def name(self) -> str: ...
    @property
    def width_um(self) -> float: ...
    @property
    def boundaries(self) -> list[_Curve]: ...
    @property
    def media(self) -> list[str]: ...
    @property
    def inclusions(self) -> list[dict[str, Any]]: ...
    def media_at(
        self, x_um: Sequence[float] | NDArray[np.floating[Any]], z_um: Sequence[float] | NDArray[np.floating[Any]]
    ) -> list[str]: ...
    def json(self) -> str: ...
    def save(self, path: str | Path) -> None: ...
    def figure(self, format: str = "svg") -> bytes: ...
    def _repr_svg_(self) -> str: ...

def read_tables(path: str | Path) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]: ...
def keratin_boundary(roughness: float, index: float) -> tuple[list[float], float]: ...

class Material:
    @staticmethod
    def open(
        text: str,
        media: _Media,
        cache: Path | None,
        seed: int | None,
        may_compute: bool,
        reciprocity: str | None,
        sigma: float | None,
        polarization: int | None,
        threads: int | None,
        progress: _Watch,
    ) -> Material: ...
    def eval_rows(
        self,
        wavelengths_nm: NDArray[np.float64],
        wi: NDArray[np.float64],
        wo: NDArray[np.float64],
        instance: NDArray[np.uint64] | None,
        count: int,
        threads: int | None,
    ) -> NDArray[np.float32]: ...
    def shares_rows(
        self, place: float, wi: NDArray[np.float64], wo: NDArray[np.float64], count: int
    ) -> NDArray[np.float64]: ...
    def pdf_rows(
        self,
        wavelengths_nm: NDArray[np.float64],
        wi: NDArray[np.float64],
        wo: NDArray[np.float64],
        count: int,
        threads: int | None,
    ) -> NDArray[np.float64]: ...
    def sample_rows(
        self,
        wavelength_nm: NDArray[np.float64],
        wi: NDArray[np.float64],
        u: NDArray[np.float64],
        count: int,
        threads: int | None,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def albedo_rows(
        self, wavelength_nm: NDArray[np.float64], wi: NDArray[np.float64], count: int, threads: int | None
    ) -> NDArray[np.float64]: ...
    def tables(self) -> dict[str, NDArray[Any]]: ...
    def header(self) -> dict[str, Any]: ...
    def to_bytes(self) -> bytes: ...
    def save(self, path: Path) -> None: ...
    def info_json(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def hash(self) -> str: ...
    @property
    def source(self) -> str: ...
    @property
    def wavelengths_nm(self) -> NDArray[np.float64]: ...
    @property
    def cos_theta_i(self) -> NDArray[np.float64]: ...
    @property
    def cos_phi_i(self) -> NDArray[np.float64]: ...
    @property
    def sigma(self) -> float: ...
    @property
    def halo_sigmas(self) -> list[float]: ...

@final
class Scene:
    @staticmethod
    def open(text: str, model: str | None, media: _Media, progress: _Watch) -> Scene: ...
    @staticmethod
    def parse(toml: str, folder: Path) -> Scene: ...
    def with_material(self, name: str) -> Scene: ...
    def frames(self, count: int, arcs: Sequence[tuple[str, float]]) -> list[Scene]: ...
    @property
    def folder(self) -> Path: ...
    def toml(self) -> str: ...
    @property
    def size(self) -> tuple[int, int] | None: ...
    def mitsuba(
        self,
        folder: Path,
        size: Sequence[int],
        samples: int,
        seed: int,
        without: Sequence[str],
        media: _Media,
        cache: Path | None,
        progress: _Watch,
    ) -> str: ...
    def render(
        self,
        size: Sequence[int],
        samples: int | None,
        noise: float | None,
        quality: str | None,
        seed: int,
        spectral_nm: Sequence[float],
        compositing: bool,
        denoise: bool,
        library: Path | None,
        tone: str | None,
        white_balance: str | None,
        media: _Media,
        cache: Path | None,
        threads: int | None,
        progress: _Watch,
    ) -> Picture: ...

@final
class Parts:
    """A picture in parts of its tiles, each a file beside it."""

    def __new__(
        cls,
        scene: Scene,
        output: Path,
        size: Sequence[int],
        samples: int | None,
        noise: float | None,
        quality: str | None,
        seed: int,
        spectral_nm: Sequence[float],
        compositing: bool,
        denoise: bool,
        library: Path | None,
        tone: str | None,
        white_balance: str | None,
        tiles: int | None,
        media: _Media,
        cache: Path | None,
        threads: int | None,
        progress: _Watch,
    ) -> Parts: ...
    @property
    def name(self) -> str: ...
    def is_there(self, number: int) -> bool: ...
    def prepare(self, threads: int | None, progress: _Watch) -> None: ...
    def run(self, number: int, threads: int | None = 1, progress: _Watch = None) -> bool: ...
    def join(self, threads: int | None, progress: _Watch) -> tuple[Picture | None, list[int]]: ...
    def delete(self) -> None: ...
    def __len__(self) -> int: ...

def export(
    what: Material | Scene | str,
    to: str,
    path: Path,
    size_mb: float,
    picture: Sequence[int] | None,
    samples: int,
    without: list[str],
    seed: int,
    media: _Media,
    cache: Path | None,
    threads: int | None,
    progress: _Watch,
) -> str: ...

@final
class Picture:
    """A rendered picture, drawn in notebooks.

    Example:
        >>> import barbule
        >>> picture: barbule.Picture = barbule.render("starling", size=(16, 12), samples=1)
        >>> picture.planes()["normal"].shape
        (12, 16, 3)
    """

    def rgb(self) -> NDArray[np.uint8]: ...
    def planes(self) -> dict[str, NDArray[Any]]: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def spectral_nm(self) -> list[float]: ...
    @property
    def lamps(self) -> list[tuple[str, str, float | None]]: ...
    def save(self, path: str | Path) -> None: ...
    def _repr_png_(self) -> bytes: ...

@final
class Heights:
    @staticmethod
    def of(height_um: NDArray[np.float64], size_um: Sequence[float]) -> Heights: ...
    @staticmethod
    def open(path: Path, pitch_um: float | None, range_um: float | None) -> Heights: ...
    @staticmethod
    def sample(name: str, seed: int) -> Heights: ...
    @property
    def height_um(self) -> NDArray[np.float64]: ...
    @property
    def size_um(self) -> list[float]: ...
    def spectrum(
        self,
        wavelengths_nm: NDArray[np.float64],
        wi: Sequence[float],
        wo: Sequence[float],
        coherence_um: float | None,
        index: float | None,
        threads: int | None,
        progress: _Watch,
    ) -> NDArray[np.float64]: ...

def trace(
    image: NDArray[np.float32] | Path,
    nm_per_px: float,
    thresholds: Sequence[float] | None,
    classes: Sequence[str] | None,
    kind: str | None,
    cortex_nm: float | None,
    crop: Sequence[int] | None,
    media: _Media,
) -> Traced: ...
@final
class Traced:
    def json(self) -> str: ...
    @property
    def flat(self) -> NDArray[np.float32]: ...
    @property
    def rods_px(self) -> NDArray[np.float64]: ...
    def text(self, is_json: bool) -> str: ...
    def save(self, path: Path, is_json: bool) -> None: ...
    def figure(self, format: str) -> bytes: ...
