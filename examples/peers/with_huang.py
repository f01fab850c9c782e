"""The joint calibration of magnetometer and IMU by Huang, Hendeby and Skog (arXiv 2505.16662), written anew.

magbench compare standard-auv --exec 'huang=python3 examples/peers/with_huang.py joint_map {recording.csv} {result}'

The authors' program is for MATLAB; this one minimises what theirs does. Maximum a posteriori of every orientation
Q, of D and o of the magnetometer, the biases of gyro and accelerometer, and the field's inclination I, by Gauss-Newton
without damping on

m = D Q h + o,  a = g Q z + e,  log(Q_next (exp(-[(w - b) dt]x) Q)^T) = 0,  h = (cos I, 0, sin I)

The noises are stated, white, the accelerometer's that of the sensor alone. As in the paper the start is an ellipsoid
turned to the gyro's axes; here it is the gyro's linear relation to the ellipsoid's directions that turns it.
The noises are those of magbench's standard case, and of its default instruments.
"""

import sys
from dataclasses import dataclass

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


@dataclass
class Log:
    """Field m (n, 3) and its noise, in strengths, force a (n, 3), and between samples rate (n - 1, 3) and dt."""

    m: np.ndarray
    sigma: float
    a: np.ndarray
    rate: np.ndarray
    dt: np.ndarray


@dataclass
class Unknowns:
    """What is estimated: Q (n, 3, 3), D, o, e, b, I."""

    Q: np.ndarray
    D: np.ndarray
    o: np.ndarray
    e: np.ndarray
    b: np.ndarray
    inclination: float

    def moved(self, step):
        """After a step (3 n + 19,): turns of Q, then D, o, e, b, I."""
        turns, p = step[:-19].reshape(-1, 3), step[-19:]
        Q = Rotation.from_rotvec(turns).as_matrix() @ self.Q
        D = self.D + p[:9].reshape(3, 3)
        return Unknowns(Q, D, self.o + p[9:12], self.e + p[12:15], self.b + p[15:18], self.inclination + p[18])

    def ahead(self, log):
        """The gyro's turn from each sample to the next (n - 1, 3, 3)."""
        return Rotation.from_rotvec(-(log.rate - self.b) * log.dt[:, None]).as_matrix()


def start(log):
    """The ellipsoid, turned to the gyro's axes, and the attitudes that its directions and the force give."""
    o, D = ellipsoid(log.m)
    u = (log.m - o) @ np.linalg.inv(D).T
    u /= np.linalg.norm(u, axis=1)[:, None]
    R = turned(u, log.rate, log.dt)
    u, up = u @ R, log.a / np.linalg.norm(log.a, axis=1)[:, None]
    inclination = np.arcsin(np.mean(np.sum(u * up, axis=1)))
    return Unknowns(attitudes(u, up, inclination), D @ R, o, np.zeros(3), np.zeros(3), inclination)


def left(x, log):
    """Residuals (9 n - 3,) over their noise: field, force, turn."""
    h = np.array([np.cos(x.inclination), 0.0, np.sin(x.inclination)])
    apart = Rotation.from_matrix(x.Q[1:] @ (x.ahead(log) @ x.Q[:-1]).transpose(0, 2, 1)).as_rotvec()
    field = (x.Q @ h @ x.D.T + x.o - log.m) / log.sigma
    pull = (GRAVITY_M_S2 * x.Q[:, :, 2] + x.e - log.a) / ACCEL_M_S2
    return np.concatenate([one.ravel() for one in (field, pull, apart / (GYRO_RAD_S * log.dt[:, None]))])


def of_shared(x, log):
    """Slopes (9 n - 3, 19) of the residuals with D, o, e, b, I."""
    n, c, s = len(log.m), np.cos(x.inclination), np.sin(x.inclination)
    of_mag = np.zeros((n, 3, 19))
    of_mag[:, :, :9] = np.einsum("ab,nj->nabj", np.eye(3), x.Q @ np.array([c, 0.0, s])).reshape(n, 3, 9)
    of_mag[:, :, 9:12] = np.eye(3)
    of_mag[:, :, 18] = x.Q @ np.array([-s, 0.0, c]) @ x.D.T
    of_accel, of_gyro = np.zeros((n, 3, 19)), np.zeros((n - 1, 3, 19))
    of_accel[:, :, 12:15] = np.eye(3) / ACCEL_M_S2
    of_gyro[:, :, 15:18] = -np.eye(3) / GYRO_RAD_S
    return np.concatenate([one.reshape(-1, 19) for one in (of_mag / log.sigma, of_accel, of_gyro)])


def of_turns(x, log):
    """Slopes (9 n - 3, 3 n) of the residuals with the turns of Q."""
    u = x.Q @ np.array([np.cos(x.inclination), 0.0, np.sin(x.inclination)])
    width = GYRO_RAD_S * log.dt[:, None]
    of_field, of_force = -x.D @ crosses(u) / log.sigma, -GRAVITY_M_S2 * crosses(x.Q[:, :, 2]) / ACCEL_M_S2
    seen = [sparse.block_diag(list(one), format="csr") for one in (of_field, of_force)]
    near = sparse.block_diag(list(-x.ahead(log) / width[:, :, None]), format="csr")
    far = sparse.diags(np.repeat(1.0 / width.ravel(), 3))
    none = sparse.csr_matrix((3 * len(log.dt), 3))
    return sparse.vstack([*seen, sparse.hstack([near, none]) + sparse.hstack([none, far])])


def joint_map(mag_nT, rate_rad_s, time_s, accel_m_s2, strength_nT):
    """Offset, nT, and matrix of the field in units of the strength."""
    rate = (rate_rad_s[1:] + rate_rad_s[:-1]) / 2
    log = Log(mag_nT / strength_nT, MAG_NT / strength_nT, accel_m_s2, rate, np.diff(time_s))
    x = start(log)
    for _ in range(MOST_STEPS):
        J = sparse.hstack([of_turns(x, log), sparse.csr_matrix(of_shared(x, log))], format="csc")
        step = spsolve((J.T @ J).tocsc(), -J.T @ left(x, log))
        x = x.moved(step)
        if np.linalg.norm(step) < SMALL:
            break
    return strength_nT * x.o, np.linalg.inv(x.D)


if __name__ == "__main__":
    _, recording, result = sys.argv[1:]
    write(result, *joint_map(*read(recording), force(recording), STRENGTH_NT))
