"""Feathers in Mitsuba 3: whole scenes, and the BSDFs they are made of.

Choose a variant first, then import this module; later variants are served too::

    import mitsuba as mi
    mi.set_variant("llvm_ad_spectral")
    import barbule.mitsuba
    picture = mi.render(mi.load_dict(barbule.mitsuba.scene("starling", size=(640, 400))))
    bsdf = mi.load_dict({"type": "barbule", "material": "starling", "instances": "uv", "cells": 40.0})

``barbule`` is a feather's material on any surface, ``barbule_film`` a smooth thin film; ``barbule_ribbon`` and ``barbule_keratin`` are
what scenes wear. How all are used stands in ``docs/guide/mitsuba.md``.
"""

from __future__ import annotations

from ._base import dr, mi
from ._feather import jit_class, scalar_class
from ._film import film_class
from ._keratin import keratin_class
from ._ribbon import ribbon_class
from ._scene import scene

__all__ = ["register", "scene"]

_known: set[str] = set()


def register() -> None:
    """Makes all BSDFs known to the variant that is set; importing this module does it."""
    variant = mi.variant()
    if variant is None:
        raise ImportError('set a variant before barbule.mitsuba is imported, as in mitsuba.set_variant("llvm_ad_spectral")')
    if variant in _known:
        return
    _known.add(variant)
    mi.register_bsdf("barbule", jit_class() if dr.is_jit_v(mi.Float) else scalar_class())
    mi.register_bsdf("barbule_film", film_class())
    mi.register_bsdf("barbule_keratin", keratin_class())
    mi.register_bsdf("barbule_ribbon", ribbon_class())


register()
mi.detail.add_variant_callback(lambda before, after: register())
