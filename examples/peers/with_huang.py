"""The joint calibration of magnetometer and IMU by Huang, Hendeby and Skog (arXiv 2505.16662), written anew.

magbench compare standard-auv --exec 'huang=python3 examples/peers/with_huang.py joint_map {recording.csv} {result}'

The authors' program is for MATLAB; this one minimises what theirs does. Maximum a posteriori of every orientation
Q, of D and o of the magnetometer, the biases of gyro and accelerometer, and the field's inclination, by Gauss-Newton
without damping on

m = D Q h + o,  a = g Q z + e,  log(Q_next (exp(-[(w - b) dt]x) Q)^T) = 0,  h = (cos I, 0, sin I)

The noises are stated, white, the accelerometer's that of the sensor alone. As in the paper the start is an ellipsoid
turned to the gyro's axes; here it is the gyro's linear relation to the ellipsoid's directions that turns it.
The noises are those of magbench's standard case, and of its default instruments.
"""

import sys

import numpy as np
from columns import STRENGTH_NT, force, read, write
from scipy import sparse
from scipy.sparse.linalg import spsolve
from scipy.spatial.transform import Rotation

MAG_NT, GYRO_RAD_S, ACCEL_M_S2, GRAVITY_M_S2 = 10.0, 1e-3, 0.02, 9.81
MOST_STEPS, SMALL = 50, 1e-6
"""Steps, and the length of one at which the paper's stop."""


def crosses(v):
    """[v]x (n, 3, 3) of v (n, 3)."""
    return np.cross(v[:, None, :], np.eye(3)[None], axisa=2, axisb=2).transpose(0, 2, 1)


def ellipsoid(m):
    """Centre, and symmetric D with m = D u + centre and |u| = 1 nearly, by algebraic least squares."""
    x, y, z = m.T
    p = np.linalg.lstsq(
        np.c_[x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z, 2 * m], np.ones(len(m)), rcond=None
    )[0]
    A = np.array([[p[0], p[3], p[4]], [p[3], p[1], p[5]], [p[4], p[5], p[2]]])
    centre = -np.linalg.solve(A, p[6:])
    values, axes = np.linalg.eigh(A / (1.0 + centre @ A @ centre))
    return centre, axes / np.sqrt(np.maximum(values, 1e-12)) @ axes.T


def turned(u, rate, dt):
    """The rotation from the gyro's axes to those of directions u, by du/dt = u x (R w)."""
    mean = crosses((u[1:] + u[:-1]) / 2)
    rows = (mean[:, :, :, None] * rate[:, None, None, :]).reshape(-1, 9)
    R = np.linalg.lstsq(rows, (np.diff(u, axis=0) / dt[:, None]).ravel(), rcond=None)[0].reshape(3, 3)
    left, _, right = np.linalg.svd(R)
    return left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right


def attitudes(u, up, inclination):
    """Q (n, 3, 3) from the directions of field and force."""

    def triad(a, b):
        c = np.cross(a, b)
        c /= np.linalg.norm(c, axis=1)[:, None]
        return np.stack([a, c, np.cross(a, c)], axis=2)

    world = triad(np.array([[np.cos(inclination), 0.0, np.sin(inclination)]]), np.array([[0.0, 0.0, 1.0]]))
    return triad(u, up) @ world[0].T


def joint_map(mag_nT, rate_rad_s, time_s, accel_m_s2, strength_nT):
    """Offset, nT, and matrix of the field in units of the strength."""
    m, sigma, dt = mag_nT / strength_nT, MAG_NT / strength_nT, np.diff(time_s)
    rate, n = (rate_rad_s[1:] + rate_rad_s[:-1]) / 2, len(mag_nT)
    o, D = ellipsoid(m)
    u = (m - o) @ np.linalg.inv(D).T
    u /= np.linalg.norm(u, axis=1)[:, None]
    R = turned(u, rate, dt)
    D, u, up = D @ R, u @ R, accel_m_s2 / np.linalg.norm(accel_m_s2, axis=1)[:, None]
    inclination = np.arcsin(np.mean(np.sum(u * up, axis=1)))
    Q, e, bias = attitudes(u, up, inclination), np.zeros(3), np.zeros(3)
    for _ in range(MOST_STEPS):
        h = np.array([np.cos(inclination), 0.0, np.sin(inclination)])
        dh = np.array([-np.sin(inclination), 0.0, np.cos(inclination)])
        u, z = Q @ h, Q[:, :, 2]
        ahead = Rotation.from_rotvec(-(rate - bias) * dt[:, None]).as_matrix()
        apart = Rotation.from_matrix(Q[1:] @ (ahead @ Q[:-1]).transpose(0, 2, 1)).as_rotvec()
        width = GYRO_RAD_S * dt[:, None]
        left = np.concatenate(
            [
                ((u @ D.T + o - m) / sigma).ravel(),
                ((GRAVITY_M_S2 * z + e - accel_m_s2) / ACCEL_M_S2).ravel(),
                (apart / width).ravel(),
            ]
        )
        of_mag = (
            np.concatenate(
                [
                    np.einsum("ab,nj->nabj", np.eye(3), u).reshape(n, 3, 9),
                    np.tile(np.eye(3), (n, 1, 1)),
                    np.zeros((n, 3, 6)),
                    (Q @ dh @ D.T)[:, :, None],
                ],
                axis=2,
            )
            / sigma
        )
        of_accel = np.zeros((n, 3, 19))
        of_accel[:, :, 12:15] = np.eye(3) / ACCEL_M_S2
        of_gyro = np.zeros((n - 1, 3, 19))
        of_gyro[:, :, 15:18] = -np.eye(3) / GYRO_RAD_S
        shared = np.concatenate([one.reshape(-1, 19) for one in (of_mag, of_accel, of_gyro)])
        seen = [
            sparse.block_diag(list(one), format="csr")
            for one in (-D @ crosses(u) / sigma, -GRAVITY_M_S2 * crosses(z) / ACCEL_M_S2)
        ]
        near = sparse.block_diag(list(-ahead / width[:, :, None]), format="csr")
        far = sparse.diags(np.repeat(1.0 / width.ravel(), 3))
        none = sparse.csr_matrix((3 * (n - 1), 3))
        links = sparse.hstack([near, none]) + sparse.hstack([none, far])
        J = sparse.hstack([sparse.vstack([*seen, links]), sparse.csr_matrix(shared)], format="csc")
        step = spsolve((J.T @ J).tocsc(), -J.T @ left)
        Q = Rotation.from_rotvec(step[: 3 * n].reshape(n, 3)).as_matrix() @ Q
        p = step[3 * n :]
        D, o, e, bias, inclination = (
            D + p[:9].reshape(3, 3),
            o + p[9:12],
            e + p[12:15],
            bias + p[15:18],
            inclination + p[18],
        )
        if np.linalg.norm(step) < SMALL:
            break
    return strength_nT * o, np.linalg.inv(D)


if __name__ == "__main__":
    _, recording, result = sys.argv[1:]
    write(result, *joint_map(*read(recording), force(recording), STRENGTH_NT))
