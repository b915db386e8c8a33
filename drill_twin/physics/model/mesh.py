# SPDX-License-Identifier: Apache-2.0
"""Mesh of the string: node places and element constants from the tube sections, shape functions, places in the mesh.

The shape functions are cubic Hermite polynomials, at the two Gauss points of an element. With unknowns r and r' at the
nodes the centre line is C1, so curvature exists everywhere, and two points integrate a straight beam's bending energy
exactly. Stretch is sampled elsewhere (`drill_twin.physics.model.strain`).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from drill_twin.core.arrays import Array, Integers

_XI = np.array([0.5 - 0.5 / np.sqrt(3.0), 0.5 + 0.5 / np.sqrt(3.0)])


def hermite(xi: Array, h: ArrayLike) -> Array:
    """Values, first and second derivatives by arc length of the four shape functions.

    Args:
        xi: Place in the element, 0 to 1, shape (m,).
        h: Element length [m], one or of each place.

    Returns:
        Shape (m, 3, 4): derivative order 0, 1, 2 for r_0, r'_0, r_1, r'_1.
    """
    x, h = (np.asarray(each) for each in np.broadcast_arrays(xi, h))
    value = [1 - 3 * x**2 + 2 * x**3, h * (x - 2 * x**2 + x**3), 3 * x**2 - 2 * x**3, h * (x**3 - x**2)]
    first = [(6 * x**2 - 6 * x) / h, 1 - 4 * x + 3 * x**2, (6 * x - 6 * x**2) / h, 3 * x**2 - 2 * x]
    second = [(12 * x - 6) / h**2, (6 * x - 4) / h, (6 - 12 * x) / h**2, (6 * x - 2) / h]
    return np.stack([np.stack(row, -1) for row in (value, first, second)], 1)


def gauss_places() -> Array:
    """Places of the two Gauss points in an element, 0 to 1, shape (2,); each weighs half the element."""
    return _XI.copy()


def element_mass(h: float) -> Array:
    """Consistent mass of a unit line density for r_0, r'_0, r_1, r'_1, shape (4, 4)."""
    return (h / 420.0) * np.array(
        [
            [156.0, 22.0 * h, 54.0, -13.0 * h],
            [22.0 * h, 4.0 * h * h, 13.0 * h, -3.0 * h * h],
            [54.0, 13.0 * h, 156.0, -22.0 * h],
            [-13.0 * h, -3.0 * h * h, -22.0 * h, 4.0 * h * h],
        ]
    )


SPIN = 6  # column of psi in a node's row (r, r', psi)


class Tube(NamedTuple):
    """Uniform tube, a piece of the string."""

    length: float  # [m]
    outer_diameter: float  # [m]
    inner_diameter: float  # [m]
    youngs_modulus: float  # [Pa]
    poisson_ratio: float
    density: float  # [kg/m3]


class Rod(NamedTuple):
    """Meshed string, n elements; the order of the fields is part of the kernels' signature."""

    arc: Array  # node places from the bit [m], shape (n + 1,)
    length: Array  # element lengths [m], shape (n,)
    shape: Array  # shape functions at the Gauss points, shape (n, 2, 3, 4)
    middle: Array  # r' at mid-element from r_0, r'_0, r_1, r'_1, shape (n, 4)
    inner: Array  # r' at the inner sample of stretch, likewise, shape (n, 4)
    inner_pairs: Array  # its products of two, times the weight of the sample, shape (n, 16)
    samples: Array  # weights of stretch at both ends and at the inner sample [m], shape (n, 3)
    pairs: Array  # weighted products r r, r' r', r' r'', r'' r', r'' r'' at the Gauss points, shape (n, 2, 5, 16)
    spin_shape: Array  # linear shape functions at the Gauss points, shape (2, 2)
    axial: Array  # EA [N], shape (n,)
    bending: Array  # EI [N m2], shape (n,)
    torsion: Array  # GJ [N m2], shape (n,)
    mass: Array  # consistent mass for r and r' [kg, kg m, kg m2], shape (n, 4, 4)
    spin_mass: Array  # polar inertia of the element [kg m2], shape (n,)
    line_mass: Array  # mass per length [kg/m], shape (n,)
    outer_radius: Array  # [m], shape (n,)

    def __eq__(self, other: object) -> bool:
        """True for the same mesh of the same string, so that results can be kept by mesh."""
        return isinstance(other, Rod) and all(map(np.array_equal, self, other))

    def __hash__(self) -> int:
        """Hash of the places of the nodes."""
        return hash(self.arc.tobytes())


def tube_constants(tube: Tube) -> tuple[float, float, float, float, float]:
    """EA [N], EI [N m2], GJ [N m2], mass per length [kg/m], polar inertia per length [kg m]."""
    area = np.pi / 4.0 * (tube.outer_diameter**2 - tube.inner_diameter**2)
    second_moment = np.pi / 64.0 * (tube.outer_diameter**4 - tube.inner_diameter**4)
    shear_modulus = tube.youngs_modulus / (2.0 * (1.0 + tube.poisson_ratio))
    return (
        tube.youngs_modulus * area,
        tube.youngs_modulus * second_moment,
        shear_modulus * 2.0 * second_moment,
        tube.density * area,
        tube.density * 2.0 * second_moment,
    )


def elements_per_section(lengths: Array, elements: int) -> list[int]:
    """Number of elements per section, by length, at least one each, so that changes of section fall on nodes."""
    counts = [max(1, round(elements * length / float(lengths.sum()))) for length in lengths]
    while sum(counts) > max(elements, len(counts)):
        longest = max((i for i in range(len(counts)) if counts[i] > 1), key=lambda i: counts[i])
        counts[longest] -= 1
    while sum(counts) < elements:
        coarsest = max(range(len(counts)), key=lambda i: lengths[i] / counts[i])
        counts[coarsest] += 1
    return counts


def shape_pairs(shape: Array, weight: Array) -> Array:
    """Products of two shape functions in the element tangent, times the weight of the point.

    Args:
        shape: Shape functions, shape (n, 2, 3, 4).
        weight: Weight of a Gauss point [m], shape (n,).

    Returns:
        Shape (n, 2, 5, 16): r r, r' r', r' r'', r'' r', r'' r''.
    """
    orders = ((0, 0), (1, 1), (1, 2), (2, 1), (2, 2))
    pairs = np.stack([np.einsum("npi,npj->npij", shape[:, :, a], shape[:, :, b]) for a, b in orders], 2)
    return np.ascontiguousarray(weight[:, None, None, None] * pairs.reshape(*pairs.shape[:3], 16))


def stretch_samples(stiffness: Array, counts: list[int]) -> tuple[Array, Array]:
    """Inner sample of the stretch in each element, 0 to 1, and the weights of lower end, upper end and inner sample.

    Simpson's rule, but in an element whose one end is a change of axial stiffness: there the strain jumps, and the
    end, which shares r' with the other section, has the weight 1 / 6 n, with n the elements of the piece. The inner
    sample lies where the rule is still exact for a quadratic strain; with n its place goes to the place of Radau's
    rule, 2/3 off the other end, and the error of the elongation falls as 1 / n^2 (`drill_twin.physics.model.strain`).

    Args:
        stiffness: EA of each uniform piece [N], shape (pieces,).
        counts: Elements of each.

    Returns:
        Shapes (n,) and (n, 3), over the length of the element.
    """
    number = np.repeat(np.arange(len(counts)), counts)
    many = np.repeat(np.asarray(counts, float), counts)
    jump = np.concatenate([[False], np.diff(stiffness[number]) != 0.0, [False]])
    lower, upper = jump[:-1] & ~jump[1:], jump[1:] & ~jump[:-1]
    off = (2.0 * many - 1.0) / (3.0 * many - 1.0)  # from the end that has no jump
    place = np.where(upper, off, np.where(lower, 1.0 - off, 0.5))
    light, heavy = 1.0 / (6.0 * many), 0.5 - 1.0 / (6.0 * off)
    ends = [np.where(lower, light, np.where(upper, heavy, 1.0 / 6.0)),
            np.where(upper, light, np.where(lower, heavy, 1.0 / 6.0))]  # fmt: skip
    inner = np.where(lower | upper, 1.0 / (6.0 * off * (1.0 - off)), 2.0 / 3.0)
    return place, np.stack([*ends, inner], -1)


def build_rod(tubes: list[Tube], elements: int) -> Rod:
    """Mesh the string by length; changes of section fall on nodes."""
    return rod_of(tubes, elements_per_section(np.array([tube.length for tube in tubes]), elements))


def rod_of(tubes: list[Tube], counts: list[int]) -> Rod:
    """Mesh of uniform pieces with a number of elements each."""
    sizes = [tube.length / count for tube, count in zip(tubes, counts, strict=True)]
    places = gauss_places()

    def along(of_each: list[Array]) -> Array:
        """A value of each section at each of its elements."""
        return np.repeat(np.stack(of_each), counts, axis=0)

    h = np.repeat(sizes, counts)
    constants = along([np.array(tube_constants(tube)) for tube in tubes])
    shape = along([hermite(places, size) for size in sizes])
    inner_at, weights = stretch_samples(np.array([tube_constants(tube)[0] for tube in tubes]), counts)
    inner = hermite(inner_at, h)[:, 1].copy()
    samples = weights * h[:, None]
    return Rod(
        arc=np.concatenate([[0.0], np.cumsum(h)]),
        length=h,
        shape=shape,
        middle=along([hermite(np.array([0.5]), size)[0, 1] for size in sizes]),
        inner=inner,
        inner_pairs=(samples[:, 2, None, None] * inner[:, :, None] * inner[:, None, :]).reshape(-1, 16),
        samples=samples,
        pairs=shape_pairs(shape, 0.5 * h),
        spin_shape=np.stack([1.0 - places, places], -1),
        axial=constants[:, 0].copy(),
        bending=constants[:, 1].copy(),
        torsion=constants[:, 2].copy(),
        mass=constants[:, 3, None, None] * along([element_mass(size) for size in sizes]),
        spin_mass=constants[:, 4] * h,
        line_mass=constants[:, 3].copy(),
        outer_radius=np.repeat([0.5 * tube.outer_diameter for tube in tubes], counts),
    )


def element_unknowns(rows: Array) -> Array:
    """Gather r_0, r'_0, r_1, r'_1 of each element from node rows, shape (..., n, 4, 3)."""
    return np.concatenate([rows[..., :-1, :6], rows[..., 1:, :6]], -1).reshape(*rows.shape[:-2], -1, 4, 3)


def youngs_modulus(rod: Rod) -> Array:
    """Young's modulus [Pa], shape (n,): EI over I, from EI, EA and the outer radius."""
    ratio = rod.bending / rod.axial  # (r_o^2 + r_i^2) / 4
    return np.asarray(rod.axial / (np.pi * (2.0 * rod.outer_radius**2 - 4.0 * ratio)))


def part_of(rod: Rod, first: int, last: int) -> Rod:
    """The elements `first` to `last` - 1 of a mesh; arrays are views, and arc lengths count along the whole mesh."""
    return Rod(*(field if field is rod.spin_shape else field[first : last + (field is rod.arc)] for field in rod))


class MeshPlaces(NamedTuple):
    """Elements that hold p places, and the shape functions there."""

    element: Integers
    """Shape (p,)."""
    xi: Array
    """Place in the element, 0 to 1, shape (p,)."""
    shape: Array
    """Shape functions and their derivatives by arc length, as of `hermite`; shape (p, 3, 4)."""


def locate(rod: Rod, arc: ArrayLike) -> MeshPlaces:
    """Locate arc lengths from the bit [m], shape (p,), in the mesh of a string."""
    at = np.asarray(arc, dtype=float).reshape(-1)
    element = np.clip(np.searchsorted(rod.arc, at, side="right") - 1, 0, rod.length.size - 1)
    xi = (at - rod.arc[element]) / rod.length[element]
    return MeshPlaces(element.astype(np.int64), xi, hermite(xi, rod.length[element]))
