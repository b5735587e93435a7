"""`ds.barbule`: colours and plots of results that are xarray datasets. Importing it registers the accessor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray
from numpy.typing import NDArray

from . import _native
from .errors import doubt

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Variables that are reflectances over `wavelength`, the first that is there counts.
REFLECTANCES = ("reflectance", "R")


@xarray.register_dataset_accessor("barbule")  # type: ignore[no-untyped-call]
class BarbuleAccessor:
    """What feathers' spectra are looked at for.

    Example:
        >>> import barbule
        >>> ds = barbule.film("air/keratin:595/air", range(400, 701, 10), [0, 45])
        >>> ds.barbule.colours().shape
        (2, 3)
    """

    def __init__(self, dataset: xarray.Dataset) -> None:
        self._dataset = dataset

    def reflectance(self) -> xarray.DataArray:
        """The unpolarized reflectance, with `wavelength` as the last dimension."""
        dataset = self._dataset
        for name in REFLECTANCES:
            if name in dataset:
                return dataset[name].transpose(..., "wavelength")
        if "R_s" in dataset and "R_p" in dataset:
            return ((dataset["R_s"] + dataset["R_p"]) / 2).transpose(..., "wavelength")
        raise KeyError("the dataset has no reflectance: none of reflectance, R, or R_s and R_p")

    def colours(self, illuminant: str = "D65") -> NDArray[np.uint8]:
        """The sRGB bytes that a screen shows of the reflectance, `[..., 3]`, under an illuminant."""
        said = _native.colour_doubt(np.asarray(self.reflectance()["wavelength"].values, dtype=np.float64))
        if said is not None:
            doubt(said)
        return self._shown(illuminant)

    def _shown(self, illuminant: str) -> NDArray[np.uint8]:
        """The colours, however little of what the eye sees is known."""
        reflectance = self.reflectance()
        values = np.ascontiguousarray(reflectance.values, dtype=np.float64)
        rows = values.reshape(-1, values.shape[-1])
        nm = np.asarray(reflectance["wavelength"].values, dtype=np.float64)
        _, _, shown = _native.xyz_of(nm, rows, illuminant)
        return np.asarray(shown).reshape(*values.shape[:-1], 3)

    def plot(self, axes: Axes | None = None, **style: Any) -> Axes:
        """Draws the reflectance over the wavelength with matplotlib, each curve in its own colour and line style."""
        import matplotlib.pyplot as plt

        axes = plt.gca() if axes is None else axes
        reflectance = self.reflectance()
        rest = [dim for dim in reflectance.dims if dim != "wavelength"]
        curves = reflectance.stack(curve=rest).transpose("curve", "wavelength") if rest else reflectance.expand_dims("curve")
        colours = self._shown("D65").reshape(-1, 3) / 255
        strokes = ("-", "--", "-.", ":")
        for number, (curve, colour) in enumerate(zip(curves, colours, strict=True)):
            label = ", ".join(f"{dim} {float(curve[dim]):g}" for dim in rest)
            settings: dict[str, Any] = {"color": colour, "linestyle": strokes[number % 4], "label": label, **style}
            axes.plot(reflectance["wavelength"].values, curve.values, **settings)
        axes.set_xlabel("vacuum wavelength (nm)")
        axes.set_ylabel("reflectance")
        return axes
