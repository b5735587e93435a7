"""From the nanostructure of a bird's feather to its reflectance, its BRDF and its picture.

    structure ──► waves ──► statistics ──► material ──► picture

Names open as on the command line: `barbule.open("starling:pink")`, a stack such as `air/keratin:595/air`, or files.
Lengths are µm in structures, nm for films and vacuum wavelengths; angles are degrees. Directions are unit vectors in the barbule's frame
(x across, y along, z up) that point away from the surface.
"""

from __future__ import annotations

from . import distributed, vision
from ._atlas import Forecast, Outcome, atlas, foretell
from ._colour import colours, delta_e_2000
from ._export import Written, export
from ._inverse import Fitted, Size, Solution, fit_structure
from ._make import characterize, fit, simulate
from ._material import Material
from ._measured import Measured, compare, intervals, measured
from ._native import Picture, Section, Structure, species, version
from ._optics import AngleLaw, Heights, Interval, angle_law, crystal, far_fields, film, spectrum
from ._opening import open
from ._progress import Bar
from ._labels import Arrays, Axis, Quantity
from ._scene import Scene, presets, render
from ._trace import Traced, trace
from ._validate import ValidateOptions, validate
from .vision import birds, see
from .errors import BarbuleError, DoubtWarning, InputError, MachineError, NotSettledError

__version__ = version()

__all__ = [
    "AngleLaw",
    "Arrays",
    "Axis",
    "Bar",
    "BarbuleError",
    "DoubtWarning",
    "Fitted",
    "Forecast",
    "Heights",
    "InputError",
    "Interval",
    "MachineError",
    "Material",
    "Measured",
    "NotSettledError",
    "Outcome",
    "Picture",
    "Quantity",
    "Scene",
    "Section",
    "Size",
    "Solution",
    "Structure",
    "Traced",
    "ValidateOptions",
    "Written",
    "angle_law",
    "atlas",
    "birds",
    "characterize",
    "colours",
    "compare",
    "crystal",
    "delta_e_2000",
    "distributed",
    "export",
    "far_fields",
    "film",
    "fit",
    "fit_structure",
    "foretell",
    "intervals",
    "measured",
    "open",
    "presets",
    "render",
    "see",
    "simulate",
    "species",
    "spectrum",
    "trace",
    "validate",
    "vision",
]
