"""Cycles of the directions of a ball between three discs without a kick, where speed sets the scale of time only."""

from math import atan2

import numpy as np

import grazing as gz
from grazing.maps.collide import in_three, slopes
from grazing.theory import Cycle
from tests.billiard.tables import three_discs


def cycles_of_directions(distance, r, length):
    """The cycles of place and angle at restitution r: from the elastic ones, by Newton's method on differences."""
    corners = np.array([(0.0, 0.0), (distance, 0.0), (0.5 * distance, 0.75**0.5 * distance)])
    for orbit in gz.periodic_orbits(gz.collision_map(three_discs(distance)), range(2, length + 1)):
        n, discs, u = orbit.period, corners[list(orbit.surfaces)], orbit.along.copy()

        def legs(u, discs=discs):
            normal = np.stack([np.cos(u), np.sin(u)], 1)
            way = np.roll(discs + normal, -1, 0) - discs - normal
            far = np.hypot(*way.T)
            return normal, way / far[:, None], far

        def bent(u, legs=legs):
            """The tangent of the angle grows by 1/r at each impact."""
            normal, out, _far = legs(u)
            along, come = np.stack([-normal[:, 1], normal[:, 0]], 1), np.roll(out, 1, 0)
            return -r * (along * out).sum(1) * (normal * come).sum(1) - (along * come).sum(1) * (normal * out).sum(1)

        for _ in range(20):
            J = np.array([(bent(u + 1e-6 * e) - bent(u - 1e-6 * e)) / 2e-6 for e in np.eye(n)]).T
            u -= np.linalg.solve(J, bent(u))
        assert np.abs(bent(u)).max() < 1e-12
        normal, out, far = legs(u)
        J = np.eye(3)
        for i in range(n):
            k, (nx, ny), (mx, my), (wx, wy) = (i + 1) % n, normal[i], normal[(i + 1) % n], out[i]
            speeds = wx * mx + wy * my, -r * (wx * mx + wy * my), wy * mx - wx * my, mx, my, 1.0, 0.0, 0.0, 0.0
            angle, before = atan2(wy * nx - wx * ny, wx * nx + wy * ny), (*(discs[k] + normal[k]), wx, wy)
            frame = nx, ny, 1.0, 0.0, 0.0, 0.0
            step = in_three(slopes(angle, 1.0, frame, far[i], before, speeds, -r, 0.0))
            J = np.array(step).reshape(3, 3) @ J
        yield Cycle(n, float(n), tuple(np.linalg.eigvals(J[:2, :2]).tolist()))
