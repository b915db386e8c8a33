"""Campbell diagram beside that of ROSS (extra `bench`), which has rotary inertia, gyroscopic moments and shear too."""

import math

import numpy as np
import pytest
from rod_scenes import DENSITY, DIAMETER, LENGTH, SHEAR, YOUNG, quiet_scene

from drill_twin.dynamics.rotordynamics.campbell import campbell
from drill_twin.dynamics.rotordynamics.equations import EquationsOfMotion
from drill_twin_evidence.verify.dynamics.modes import SET

try:
    import ross
except ImportError:
    pytest.skip("ross-rotordynamics of the extra bench is not installed", allow_module_level=True)
except ValueError:
    pytest.skip("ross-rotordynamics 2.3 cannot be imported with plotly 7; install plotly<7", allow_module_level=True)

ELEMENTS, MODES = 24, 8
SPEEDS = math.tau * np.array([0.0, 1.0, 2.0, 4.0, 8.0])
STEEL = {"youngs_modulus": 210e9, "poisson_ratio": 0.3, "density": 7850.0}
"""A drill collar of 8 in by 2 13/16 in between a bit and a clamp 30 m above it."""
COLLAR = {"outer_diameter": 0.2032, "inner_diameter": 0.0714375, **STEEL}


def theirs(length, outer, inner, young, shear, density, *, whole):
    """Frequencies of ROSS's beam, clamped at the top and pinned at the bit, over `SPEEDS` [rad/s], smallest first."""
    material = ross.Material("own", rho=density, E=young, G_s=shear)
    extra = {"shear_effects": whole, "rotary_inertia": whole, "gyroscopic": whole}
    beam = [ross.ShaftElement(length / ELEMENTS, inner, outer, material=material, **extra) for _ in range(ELEMENTS)]
    rotor = ross.Rotor(beam, [], [ross.BearingElement(0, kxx=1.0, cxx=0.0), ross.BearingElement(1, kxx=1.0, cxx=0.0)])
    # bearings are springs: the constraints are put into the matrices instead
    stiffness = rotor.K(0) - sum(spring(rotor, node) for node in (0, 1))
    width = stiffness.shape[0] // (ELEMENTS + 1)
    lateral = [width * node + k for node in range(ELEMENTS + 1) for k in (0, 1, *((3, 4) if width == 6 else (2, 3)))]
    free = np.setdiff1d(lateral, [0, 1, *range(width * ELEMENTS, width * (ELEMENTS + 1))])
    part = np.ix_(free, free)
    mass, stiffness, gyroscopic = (matrix[part] for matrix in (rotor.M(), stiffness, rotor.G()))
    found = []
    for speed in SPEEDS:
        lower = -np.linalg.solve(mass, np.hstack([stiffness, speed * gyroscopic]))
        state = np.vstack([np.hstack([np.zeros_like(mass), np.eye(free.size)]), lower])
        values = np.linalg.eigvals(state).imag
        found.append(np.sort(values[values > 1e-9])[:MODES])
    return np.array(found)


def spring(rotor, node):
    """Stiffness of the unit springs of a bearing in the matrix of a rotor."""
    matrix = np.zeros_like(rotor.K(0))
    width = matrix.shape[0] // (ELEMENTS + 1)
    matrix[width * node, width * node] = matrix[width * node + 1, width * node + 1] = 1.0
    return matrix


def ours(**rod):
    """Frequencies over `SPEEDS` [rad/s], smallest first, forward and backward."""
    scene = quiet_scene({}, of=SET, form="lateral", bit_end="pinned", elements=ELEMENTS, **rod)
    return np.sort(np.abs(campbell(EquationsOfMotion(scene), 0.0, SPEEDS, MODES).eigenvalues.imag), axis=1)


@pytest.mark.parametrize(
    ("rod", "beam"),
    [
        ({}, (LENGTH, DIAMETER, 0.0, YOUNG, SHEAR, DENSITY)),
        ({"length": 30.0, "sections": [COLLAR]}, (30.0, 0.2032, 0.0714375, 210e9, 210e9 / 2.6, 7850.0)),
    ],
    ids=["rod", "collar"],
)
def test_campbell_diagram(rod, beam):
    """The same beam within 1e-6; what ROSS adds changes the rod by less than 1e-3, the collar by less than 3e-3."""
    own = ours(**rod)
    assert own == pytest.approx(theirs(*beam, whole=False), rel=1e-6)
    change = np.abs(theirs(*beam, whole=True) / own - 1.0).max()
    assert 1e-7 < change < (1e-3 if not rod else 3e-3)
