"""A material's tables as ``docs/formats/brdf-tables.md`` evaluates them, step by step, compiled by Dr.Jit; numbers of steps are that
page's."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._base import BELOW_1, GOLDEN, clip, dr, floats, held, mi, split_mix, split_mix_of

_POINTS = 1024
_BASES = 128
#: Rows of a base in `codes`: half a period and one.
_ROWS = 513
#: Numbers of a node as they are gathered, four at a time: m², R | M, A of both mean lobes | m², R, M, A of the steady part | the others.
_ORDER = (0, 1, 3, 4, 6, 7, 9, 10, 2, 5, 8, 11, 12, 13, 14, 15)
#: cosφ of the flatter direction from which on both tables are asked: of 80° and 85°.
_HORIZON = (math.cos(math.radians(80.0)), math.cos(math.radians(85.0)))
_LOBES, _ALIGNED, _STEADY, _REST, _SHARES, _ALONG = range(6)


class Axis:
    """Nodes of an axis, rising: where a number lies among them (step 2)."""

    def __init__(self, nodes: NDArray[np.float64]) -> None:
        self.last = len(nodes) - 2
        if self.last < 0:
            return
        gaps = np.diff(nodes)
        self.first, self.per_gap = float(nodes[0]), float(1.0 / gaps.mean())
        self.is_even = bool(np.all(np.abs(gaps * self.per_gap - 1.0) < 1e-9))
        if self.is_even:
            return
        # A guess for each of 1024 bins, then a step for each node that a bin may hold.
        edges = np.linspace(nodes[0], nodes[-1], 1025)
        guess = np.clip(np.searchsorted(nodes, edges, "right") - 1, 0, self.last)
        self.per_bin = float(1024.0 / (nodes[-1] - nodes[0]))
        self.steps = int(np.diff(guess).max())
        self.guess = held(mi.UInt32, guess[:-1].astype(np.uint32))
        self.low = floats(np.stack([nodes[:-1], 1.0 / gaps], axis=-1))

    def find(self, x: Any) -> tuple[Any, Any]:
        """The place below x, and the share of the next, 0 to 1."""
        if self.last < 0:
            return mi.UInt32(0), mi.Float(0.0)
        if self.is_even:
            at = (x - self.first) * self.per_gap
            low = clip(dr.floor(at), 0.0, self.last)
            return mi.UInt32(low), clip(at - low, 0.0, 1.0)
        place = dr.gather(mi.UInt32, self.guess, mi.UInt32(clip((x - self.first) * self.per_bin, 0.0, 1023.0)))
        for step in range(self.steps + 1):
            node = dr.gather(mi.Vector2f, self.low, place)
            share = (x - node.x) * node.y
            if step < self.steps:
                place = dr.select((share >= 1.0) & (place < self.last), place + 1, place)
        return place, clip(share, 0.0, 1.0)


@dataclass
class _Light:
    """ω_i in its cell (steps 1 and 2); rows, columns: the nearer one first."""

    sign: Any
    tau: Any
    y: Any
    z: Any
    cos_theta: Any
    #: Number of the node at the nearer row and column and at the first wavelength, and the steps to the others'.
    node: Any
    to_column: Any
    theta: Any
    phi: Any
    c: tuple[Any, Any]
    t: tuple[Any, Any]


@dataclass
class _Corner:
    """A node that counts (step 3): its weight, its number, and whether it is in the farther row and column."""

    weight: Any
    at: Any
    far_row: Any
    far_column: Any

    def of(self, mask: Any, pair: tuple[Any, Any]) -> Any:
        """One of two numbers."""
        return pair[mask] if isinstance(mask, bool) else dr.select(mask, pair[1], pair[0])


@dataclass
class _View:
    """ω_o against the columns of the cell (step 4): τ, and of each column e and cosφ'."""

    tau: Any
    cos_phi: Any
    e: tuple[Any, Any]
    cosine: tuple[Any, Any]


@dataclass
class _Across:
    """What the nodes of a set say together (steps 5 and 10)."""

    mean: Any
    steady: Any
    inverse_length: Any
    gamma: Any
    fraction: Any
    fraction_slope: Any
    density: Any
    chance: Any


@dataclass
class _Draw:
    """An instance (step 7)."""

    shift: Any
    is_backward: Any
    is_achromatic: Any
    base: Any
    height: Any
    turn: Any
    own_turn: Any
    wing: Any


class Tables:
    """A material's tables on the variant's device, and what follows from them; `header` and `tables` as `Material` has them."""

    def __init__(self, header: Mapping[str, Any], tables: Mapping[str, NDArray[Any]]) -> None:
        # Opaque, so that materials which differ in nothing else share a kernel.
        self.height = dr.opaque(mi.Float, header["height_um"] / 1.5175)
        # Of names h' ≫ 48 below this are achromatic.
        self.achromatic = dr.opaque(mi.UInt32, min(math.ceil(65536.0 * header["achromatic"]), 65536))
        self.seed = dr.opaque(mi.UInt64, split_mix_of(int(header["seed"])))
        self.polarization, self.sets = header["polarization"], int(header["sets"])
        self.is_marginal, self.is_alike = header["kind"] == "marginal", header["sides"] == "alike"
        self.reciprocity = header["reciprocity"]
        if self.reciprocity == "steeper" and not self.is_alike:
            self.reciprocity = "mean"
        self.sigmas = [float(sigma) for sigma in (header["sigma"], *header["halo"]) if sigma > 0.0]
        self.phis, self.waves = int(header["phis"]), int(header["waves"])
        self.count = int(header["thetas"]) * self.phis * self.waves
        self.theta, self.phi = Axis(tables["theta"]), Axis(tables["phi"])
        self.nm = Axis(tables["wavelengths_nm"])
        columns = np.stack([tables["phi"] < 0.0, tables["tangents"]], axis=-1)
        self.columns, self.cosines = floats(columns), floats(tables["cos_theta"])

        sets = [""] if self.sets == 1 else ["p1.", "p2."]
        parts = [[tables[name + "nodes"][..., _ORDER], tables[name + "shares"]] for name in sets]
        self.has_halo = "along" in tables
        if self.has_halo:
            parts = [[*part, tables["along"]] for part in parts]
        self.width = 6 if self.has_halo else 5
        self.nodes = floats(np.concatenate([np.concatenate(part, axis=-1).ravel() for part in parts]))

        inverse_q = tables["inverse_q"]
        self.q_steps = len(inverse_q) - 1
        self.inverse_q = floats(_padded(inverse_q))
        self.student_steps = len(tables["student"]) - 1
        self.student = floats(tables["student"])
        self.slopes = floats(_padded(tables["slopes"]))
        # Two numbers of 16 bits in one of 32: a point of two bases is one load.
        self.codes = held(mi.Int32, np.ascontiguousarray(tables["codes"]).view(np.int32))
        self.rotations, self.wings = floats(tables["rotations"]), floats(tables["wings"])
        self.step_loss = dr.opaque(mi.Float, 1.0 - float(tables["autocovariance"][1]))

    # -- steps 1 to 5 --

    def _light(self, w: Any) -> _Light:
        cos_theta = dr.sqrt(dr.fma(w.x, w.x, w.z * w.z))
        inverse = dr.rcp(dr.fmax(cos_theta, 1e-12))
        sign = dr.select(w.x < 0.0, -1.0, 1.0) if self.is_alike else mi.Float(1.0)
        sine, cosine = sign * w.x * inverse, w.z * inverse
        row, theta = self.theta.find(cos_theta)
        column, phi = self.phi.find(dr.copysign(1.0 - cosine, sine))
        low, high = (dr.gather(mi.Vector2f, self.columns, column + k) for k in (0, 1))
        t, to_column = (low.y, high.y), mi.Int32(self.waves)
        if not self.is_alike:
            inwards = low.x > 0.5
            t = (dr.select(inwards, high.y, low.y), dr.select(inwards, low.y, high.y))
            column, phi = dr.select(inwards, column + 1, column), dr.select(inwards, 1.0 - phi, phi)
            to_column = dr.select(inwards, -self.waves, self.waves)
        c = (dr.gather(mi.Float, self.cosines, row), dr.gather(mi.Float, self.cosines, row + 1))
        node = (row * self.phis + column) * self.waves
        tau = _tau(sine, dr.fmax(cosine, 1e-4))
        return _Light(sign, tau, w.y, w.z, cos_theta, node, mi.Int32(to_column), theta, phi, c, t)

    def _view(self, light: _Light, sine: Any, cosine: Any) -> _View:
        cosine = dr.fmax(cosine, 1e-8)
        tau = light.tau * _tau(light.sign * sine, cosine)
        e = [dr.rsqrt(dr.fma(t, t, tau * tau)) for t in light.t]
        turned = [2.0 * (tau * e_) * (t * e_) for t, e_ in zip(light.t, e)]
        return _View(tau, cosine, (e[0], e[1]), (turned[0], turned[1]))

    def _corners(self, light: _Light, nm: Any) -> list[_Corner]:
        wave, g = self.nm.find(nm)
        a, b = light.theta, light.phi
        up_wave = 1 if self.waves > 1 else 0
        up_row, up_column = self.phis * self.waves, light.to_column
        high, low = dr.fmax(dr.fmax(a, b), g), dr.fmin(dr.fmin(a, b), g)
        middle = dr.fmax(dr.fmin(a, b), dr.fmin(dr.fmax(a, b), g))
        # Which axis is stepped up first and which last; of equal shares λ is first, then θ.
        row_first, column_first = (a > g) & (a >= b), (b > g) & (b > a)
        row_last, column_last = (g >= a) & (b > a), (g >= b) & (a >= b)
        nearest = mi.Int32(light.node + wave)
        farthest = nearest + up_column + (up_row + up_wave)
        first = dr.select(row_first, up_row, dr.select(column_first, up_column, up_wave))
        last = dr.select(row_last, up_row, dr.select(column_last, up_column, up_wave))
        return [
            _Corner(1.0 - high, mi.UInt32(nearest), False, False),
            _Corner(high - middle, mi.UInt32(nearest + first), row_first, column_first),
            _Corner(middle - low, mi.UInt32(farthest - last), ~row_last, ~column_last),
            _Corner(low, mi.UInt32(farthest), True, True),
        ]

    def _row(self, at: Any, number: int, of_set: int = 0) -> Any:
        return dr.gather(mi.Vector4f, self.nodes, (at + of_set * self.count) * self.width + number)

    def _across(
        self, of_set: int, light: _Light, corners: list[_Corner], view: _View, instanced: bool, dense: bool, valued: bool
    ) -> _Across:
        needs_rest = valued and (instanced or self.sets == 2 or self.polarization is not None)
        sums = [mi.Float(0.0) for _ in range(8)]
        for corner in corners:
            row = [self._row(corner.at, number, of_set) for number in (_LOBES, _ALIGNED)]
            e, t = corner.of(corner.far_column, view.e), corner.of(corner.far_column, light.t)
            cosine = corner.of(corner.far_column, view.cosine)
            z = corner.of(corner.far_row, light.c) * cosine
            weight, one = corner.weight * cosine, 1.0 - z * z
            shares = self._row(corner.at, _SHARES, of_set) if dense else None
            for lobe in (0, 1):
                m2, r, m, a = row[0][lobe], row[0][2 + lobe], row[1][lobe], row[1][2 + lobe]
                q = dr.fma(r, dr.square((view.tau - m) * e), m2)
                per_q2 = weight * dr.rcp(q * q)
                if valued:
                    aligned = (view.tau + m) * e * z if self.is_marginal else z
                    sums[0] += per_q2 * a * aligned * dr.rcp(z + dr.sqrt(dr.fma(m2, one, z * z)))
                if shares is not None:
                    sums[6] += per_q2 * shares[lobe] * (t + view.tau * m * dr.rcp(t)) * e
                    sums[7] += corner.weight * shares[2 + lobe]
            if instanced:
                m2, r, m, a = self._row(corner.at, _STEADY, of_set)
                q = dr.fma(r, dr.square((view.tau - m) * e), m2)
                sums[1] += corner.weight * a * dr.rcp(q * q)
            if needs_rest:
                rest = self._row(corner.at, _REST, of_set)
                for k in range(4):
                    sums[2 + k] += corner.weight * rest[k]
        per_cosine = dr.rcp(view.cos_phi)
        sums[0] *= per_cosine
        sums[1] = sums[0] * dr.fmin(sums[1], 1.0)
        sums[6] *= per_cosine
        return _Across(*sums)

    # -- step 6 --

    def _parts(self, corners: list[_Corner]) -> list[Any]:
        """H of each σ."""
        if not self.has_halo:
            return [mi.Float(1.0)]
        total = mi.Vector4f(0.0)
        for corner in corners:
            total += corner.weight * self._row(corner.at, _ALONG)
        return [total[g] for g in range(len(self.sigmas))]

    def _inverse_q(self, cos_theta: Any) -> list[Any]:
        at = dr.sqrt(dr.fmin(cos_theta, 1.0)) * float(self.q_steps)
        low = dr.fmin(dr.floor(at), float(self.q_steps - 1))
        share, k = at - low, mi.UInt32(low)
        row = [dr.gather(mi.Vector4f, self.inverse_q, k + step) for step in (0, 1)]
        return [dr.fma(share, row[1][g] - row[0][g], row[0][g]) for g in range(len(self.sigmas))]

    # -- steps 7 and 8 --

    def _draw(self, name: Any, sum_x: Any) -> _Draw:
        h = split_mix(self.seed ^ split_mix(name))
        more = h * mi.UInt64(GOLDEN)

        def bits(of: Any, by: int, mask: int) -> Any:
            return mi.UInt32((of >> by) & mask)

        base = mi.Float(bits(h, 0, _BASES - 1)) + mi.Float(bits(more, 40, 255)) * (1.0 / 256.0)
        is_achromatic = bits(more, 48, 0xFFFF) < self.achromatic
        turn = [dr.gather(mi.Vector2f, self.rotations, bits(h, by, _POINTS - 1)) for by in (40, 50)]
        wing = dr.gather(mi.Float, self.wings, dr.select(sum_x < 0.0, bits(h, 8, 255), bits(h, 28, 255)))
        shift = mi.Int32(bits(h, 16, _POINTS - 1))
        height = dr.select(is_achromatic, 0.0, self.height)
        return _Draw(shift, bits(h, 63, 1) == 1, is_achromatic, base, height, turn[0], turn[1], wing)

    def _noise(self, draw: _Draw, x: Any, sum_z: Any, nm: Any) -> tuple[Any, Any]:
        """q and q' at x, in lengths."""
        place = dr.fma(512.0, clip(x, -512.0, 512.0), -0.5)
        low = dr.floor(place)
        t, k = place - low, mi.Int32(low)
        layer = dr.fmin(dr.fma(draw.height * sum_z, 2000.0 * math.pi * dr.rcp(nm), draw.base), 32768.0)
        base = dr.floor(layer)
        u = layer - base
        first = (mi.UInt32(base) & (_BASES - 1)) * _ROWS
        numbers = [mi.Float(0.0) for _ in range(4)]
        for step, weight in ((0, 1.0 - t), (1, t)):
            j = dr.select(draw.is_backward, draw.shift - (k + step), draw.shift + (k + step)) & (_POINTS - 1)
            words = dr.gather(mi.Vector4i, self.codes, first + mi.UInt32(j & (_POINTS // 2 - 1)))
            is_second_half = j >= _POINTS // 2
            near, next_ = weight * (1.0 - u), weight * u
            for pair in (0, 1):
                here = dr.select(is_second_half, words[1 - pair], words[pair])
                there = dr.select(is_second_half, words[3 - pair], words[2 + pair])
                for at, left in ((2 * pair, 16), (2 * pair + 1, 0)):
                    code, next_code = (mi.Float((word << left) >> 16) for word in (here, there))
                    numbers[at] = dr.fma(near, code, dr.fma(next_, next_code, numbers[at]))
        scale = dr.rsqrt((1.0 - 2.0 * t * (1.0 - t) * self.step_loss) * (1.0 - 2.0 * u * (1.0 - u)))
        a, b, own_a, own_b = (number * scale for number in numbers)
        return _rotated(a, b, draw.turn), _rotated(own_a, own_b, draw.own_turn)

    def _slope(self, light: _Light) -> Any:
        """κ, g and 1/l of achromatic instances."""
        a, b = light.theta, light.phi
        high, low = dr.fmax(a, b), dr.fmin(a, b)
        nearest = mi.Int32(light.node) // self.waves
        to_column = dr.select(light.to_column < 0, -1, 1)
        first = dr.select(a >= b, self.phis, to_column)
        places = [nearest, nearest + first, nearest + to_column + self.phis]
        at = [dr.gather(mi.Vector4f, self.slopes, mi.UInt32(place)) for place in places]
        return (1.0 - high) * at[0] + (high - low) * at[1] + low * at[2]

    def _speckled(
        self, across: _Across, of_set: int, draw: _Draw, slope: Any, sum_: Any, nm: Any
    ) -> Any:
        """P of an instance."""
        inverse_length = dr.select(draw.is_achromatic, slope.z, across.inverse_length)
        first, own = self._noise(draw, sum_.x * inverse_length, sum_.z, nm)
        second = across.gamma * first + dr.sqrt(dr.fmax(1.0 - dr.square(across.gamma), 0.0)) * own
        polarization = of_set + 1 if self.sets == 2 else self.polarization
        if polarization is not None:
            value = _speckle(across.mean, across.steady, first if polarization == 1 else second)
        else:
            # ½ speckle(2F f̂, 2F s, q) = F speckle(f̂, s, q).
            one, two = (_speckle(across.mean, across.steady, q) for q in (first, second))
            value = dr.fma(across.fraction, one - two, two)
        a = 0.5 * dr.square(slope.x * sum_.x) * dr.rcp(sum_.z) * across.inverse_length
        a = dr.fmin(a, 1e6)
        a2 = a * a
        return value * (1.0 + slope.y * (draw.wing - 1.0) * a2 * dr.rcp(0.2 + 0.2 * a + 0.6 * a2 * a))

    # -- steps 6, 8 to 10 --

    def _one_way(
        self, wi: Any, wo: Any, nm: Sequence[Any], name: Any, contrast: Any, valued: bool, dense: bool
    ) -> tuple[list[Any], list[Any]]:
        """f z_o of each wavelength, and each one's density."""
        light = self._light(wi)
        cos_o = dr.sqrt(dr.fma(wo.x, wo.x, wo.z * wo.z))
        inverse = dr.rcp(dr.fmax(cos_o, 1e-12))
        view = self._view(light, wo.x * inverse, wo.z * inverse)
        sum_ = wi + wo
        cosine = light.cos_theta * cos_o - light.y * wo.y
        sine = dr.fma(light.y, cos_o, wo.y * light.cos_theta)
        t2 = dr.select(cosine > 0.0, dr.square(sine) / (2.0 + 2.0 * cosine), 0.5 * (1.0 - cosine))
        spread = [dr.exp(t2 * (-1.0 / sigma**2)) for sigma in self.sigmas]
        values_along = [e * q for e, q in zip(spread, self._inverse_q(light.cos_theta))] if valued else []
        density_along = []
        if dense:
            below, above = _ends(light.y)
            root = dr.sqrt(dr.fmax(1.0 - t2, 0.0)) * inverse
            for sigma, e in zip(self.sigmas, spread):
                mass = dr.erf(below * (1.0 / sigma)) + dr.erf(above * (1.0 / sigma))
                density_along.append(e * root / (sigma * math.sqrt(math.pi) * mass))
        instanced = valued and name is not None
        draw = self._draw(name, sum_.x) if instanced else None
        slope = self._slope(light) if instanced else None
        facet = clip(light.sign * sum_.x * dr.rcp(sum_.z), -1.0, 1.0)
        values, densities = [], []
        for wavelength in nm:
            corners = self._corners(light, wavelength)
            parts = self._parts(corners)
            p, density, chance = mi.Float(0.0), mi.Float(0.0), mi.Float(0.0)
            for of_set in range(self.sets):
                across = self._across(of_set, light, corners, view, instanced, dense, valued)
                across.fraction = clip(dr.fma(across.fraction_slope, facet, across.fraction), 0.0, 1.0)
                polarization = of_set + 1 if self.sets == 2 else self.polarization
                if polarization is not None:
                    own = 2.0 * (across.fraction if polarization == 1 else 1.0 - across.fraction)
                    across.mean, across.steady = across.mean * own, across.steady * own
                if draw is not None:
                    own = self._speckled(across, of_set, draw, slope, sum_, wavelength)
                    p += own if contrast is None else dr.fma(contrast, own - across.mean, across.mean)
                else:
                    p += across.mean
                density, chance = density + across.density, chance + across.chance
            if valued:
                values.append(p * _dot(parts, values_along) * (1.0 / self.sets))
            if dense:
                densities.append(density * dr.rcp(chance) * _dot(parts, density_along))
        return values, densities

    def evaluate(
        self,
        wi: Any,
        wo: Any,
        nm: Sequence[Any],
        name: Any = None,
        valued: bool = True,
        dense: bool = True,
        contrast: Any = None,
    ) -> tuple[list[Any], Any]:
        """f cosθ of each wavelength, 1/sr, and the density per sr, the mean over the wavelengths'.

        Args:
            wi, wo: ``Vector3f`` in the barbule's frame, both above it.
            nm: Vacuum wavelengths, ``Float`` each.
            name: Of the instance, ``UInt64``; the mean without.
            valued, dense: Whether values and the density are wanted.
            contrast: Share of the instance's departure from the mean that is seen; 1 without.
        """
        is_plain = self.reciprocity == "none" or not valued
        values, densities = self._one_way(wi, wo, nm, name, contrast, valued and self.reciprocity != "steeper", dense)
        if self.reciprocity == "steeper" and valued:
            across, back = dr.abs(wo.x) * wi.z, dr.abs(wi.x) * wo.z
            swapped = (across < back) | ((across == back) & (wo.z > wi.z))
            first, second = dr.select(swapped, wo, wi), dr.select(swapped, wi, wo)
            values, _ = self._one_way(first, second, nm, name, contrast, True, False)
            scale = wo.z * dr.rcp(second.z)
            values = self._leveled([value * scale for value in values], (second, first), wo.z, nm, name, contrast)
        elif not is_plain:
            back, _ = self._one_way(wo, wi, nm, name, contrast, True, False)
            scale = wo.z * dr.rcp(wi.z)
            values = [0.5 * dr.fma(there, scale, here) for here, there in zip(values, back)]
        density = sum(densities, mi.Float(0.0)) * (1.0 / len(nm))
        return values, density

    def _leveled(
        self, values: list[Any], order: tuple[Any, Any], z: Any, nm: Sequence[Any], name: Any, contrast: Any
    ) -> list[Any]:
        """f z by the steeper direction's tables, on the way to the geometric mean with those of the flatter, which is the first of `order`,
        where that one is near the horizon."""
        flatter = order[0]
        cosine = flatter.z * dr.rsqrt(dr.fma(flatter.x, flatter.x, flatter.z * flatter.z))
        begins, ends = _HORIZON
        horizon = clip((begins - cosine) * (1.0 / (begins - ends)), 0.0, 1.0)

        def with_both(values: list[Any], flatter: Any, steeper: Any, horizon: Any) -> list[Any]:
            others, _ = self._one_way(flatter, steeper, nm, name, contrast, True, False)
            scale = z * dr.rcp(steeper.z)
            means = [dr.sqrt(dr.fmax(value, 0.0)) * dr.sqrt(dr.fmax(other * scale, 0.0)) for value, other in zip(values, others)]
            return [dr.fma(horizon, mean - value, value) for value, mean in zip(values, means)]

        def as_they_are(values: list[Any], flatter: Any, steeper: Any, horizon: Any) -> list[Any]:
            return values

        found = dr.if_stmt((values, *order, horizon), horizon > 0.0, with_both, as_they_are)
        return list(found)

    # -- steps 11 to 14 --

    def sample(self, wi: Any, nm: Sequence[Any], u: Any, u1: Any, u2: Any) -> Any:
        """ω_o drawn by the mean of the wavelengths' densities; z ≤ 0 where nothing is drawn.

        The wavelength, the lobe and the σ are drawn with `u`, the azimuth with `u1`, the inclination with `u2`.
        """
        light = self._light(wi)
        place = u * float(len(nm))
        number = dr.fmin(dr.floor(place), float(len(nm) - 1))
        rest, wavelength = place - number, nm[0]
        for k in range(1, len(nm)):
            wavelength = dr.select(number == float(k), nm[k], wavelength)
        corners = self._corners(light, wavelength)

        chances = []
        for of_set in range(self.sets):
            for corner in corners:
                shares = self._row(corner.at, _SHARES, of_set)
                t = corner.of(corner.far_column, light.t)
                for lobe in (0, 1):
                    chances.append((corner.weight * shares[2 + lobe], corner.at + of_set * self.count, t, lobe))
        rest *= sum((chance for chance, *_ in chances), mi.Float(0.0))
        at, t, is_second = chances[0][1], chances[0][2], mi.Bool(False)
        left, is_drawn = mi.Float(0.0), mi.Bool(False)
        for chance, node, node_t, lobe in chances:
            # Where rounding leaves none, the last one with a chance stays.
            here = ~is_drawn & (chance > 0.0)
            at, t = dr.select(here, node, at), dr.select(here, node_t, t)
            is_second = dr.select(here, lobe == 1, is_second)
            left = dr.select(here, rest / chance, left)
            is_drawn |= here & (rest < chance)
            rest = dr.select(is_drawn, rest, rest - chance)
        left = clip(left, 0.0, BELOW_1)

        lobes, aligned = self._row(at, _LOBES), self._row(at, _ALIGNED)
        m2, m = dr.select(is_second, lobes.y, lobes.x), dr.select(is_second, aligned.y, aligned.x)
        sin_phi, cos_phi = self._azimuth(m2, m / t, t / light.tau, u1)
        sin_theta, cos_theta = self._inclination(light, self._parts(corners), left, u2)
        return mi.Vector3f(cos_theta * light.sign * sin_phi, sin_theta, cos_theta * cos_phi)

    def _azimuth(self, m2: Any, tau_eff: Any, back: Any, u: Any) -> tuple[Any, Any]:
        half = dr.rsqrt(2.0 + 2.0 * dr.square(tau_eff))
        sine, cosine = (1.0 - tau_eff) * half, (1.0 + tau_eff) * half
        low, high = math.sqrt(0.5) * (sine - cosine), math.sqrt(0.5) * (sine + cosine)
        a = dr.sqrt(m2 / dr.fmax(1.0 - m2, 1e-12))
        first, last = _student(low / a), _student(high / a)
        v = dr.lerp(first, last, u)
        h = dr.select(a > 1000.0, dr.lerp(low, high, u), a * self._student_quantile(v))
        h = clip(h, low, high)
        other = dr.sqrt(dr.fmax(1.0 - h * h, 0.0))
        # τ(φ) of φ/2 = asin h − φ_eff/2.
        sin_half, cos_half = h * cosine - other * sine, other * cosine + h * sine
        tau = (cos_half + sin_half) / dr.fmax(cos_half - sin_half, 1e-9) * back
        scale = dr.rcp(dr.fma(tau, tau, 1.0))
        return (tau - 1.0) * (tau + 1.0) * scale, 2.0 * tau * scale

    def _student_quantile(self, v: Any) -> Any:
        s = dr.cbrt(12.0 * math.pi * dr.fmax(0.5 - dr.abs(v), 0.0))
        # s is (6π)^⅓ where δ = π.
        gap = (6.0 * math.pi) ** (1.0 / 3.0) / self.student_steps
        at = s * (1.0 / gap)
        low = clip(dr.floor(at), 0.0, float(self.student_steps - 1))
        t, k = clip(at - low, 0.0, 1.0), mi.UInt32(low)
        here, there = (dr.gather(mi.Vector2f, self.student, k + step) for step in (0, 1))
        t2, t3 = t * t, t * t * t
        delta = (2.0 * t3 - 3.0 * t2 + 1.0) * here.x + (3.0 * t2 - 2.0 * t3) * there.x
        delta += gap * ((t3 - 2.0 * t2 + t) * here.y + (t3 - t2) * there.y)
        sine, cosine = dr.sincos(0.5 * dr.fmax(delta, 1e-6))
        return dr.copysign(cosine / sine, v)

    def _inclination(self, light: _Light, parts: list[Any], u: Any, u2: Any) -> tuple[Any, Any]:
        rest, sigma, is_drawn = u * sum(parts, mi.Float(0.0)), mi.Float(self.sigmas[0]), mi.Bool(False)
        for part, own in zip(parts, self.sigmas):
            sigma = dr.select(~is_drawn & (part > 0.0), own, sigma)
            is_drawn |= rest < part
            rest = rest - part
        below, above = _ends(light.y)
        per_sigma = dr.rcp(sigma)
        p = dr.lerp(-dr.erf(below * per_sigma), dr.erf(above * per_sigma), u2)
        t = clip(sigma * dr.erfinv(clip(p, -BELOW_1, BELOW_1)), -below, above)
        sine, cosine = 2.0 * t * dr.sqrt(dr.fmax(1.0 - t * t, 0.0)), 1.0 - 2.0 * t * t
        return sine * light.cos_theta - cosine * light.y, cosine * light.cos_theta + sine * light.y


def _padded(values: NDArray[Any]) -> NDArray[Any]:
    """Rows of four."""
    return np.concatenate([values, np.zeros((*values.shape[:-1], 4 - values.shape[-1]))], axis=-1)


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return sum((x * y for x, y in zip(a[1:], b[1:])), a[0] * b[0])


def _rotated(a: Any, b: Any, turn: Any) -> Any:
    return mi.Vector2f(a * turn.x - b * turn.y, a * turn.y + b * turn.x)


def _tau(sine: Any, cosine: Any) -> Any:
    """τ(φ), without cancellation on either side."""
    is_left = sine < 0.0
    return dr.select(is_left, cosine, 1.0 + sine) / dr.select(is_left, 1.0 - sine, cosine)


def _ends(y: Any) -> tuple[Any, Any]:
    return dr.sqrt(dr.fmax(0.5 - 0.5 * y, 0.0)), dr.sqrt(dr.fmax(0.5 + 0.5 * y, 0.0))


def _student(x: Any) -> Any:
    return (x / (1.0 + x * x) + dr.atan(x)) * (1.0 / math.pi)


def _speckle(mean: Any, steady: Any, q: Any) -> Any:
    steady = dr.fmin(steady, mean)
    half = 0.5 * (mean - steady)
    return dr.square(dr.sqrt(half) * q.x + dr.sqrt(steady)) + half * dr.square(q.y)
