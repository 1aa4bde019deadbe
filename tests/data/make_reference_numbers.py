"""Numbers from outside for tests/reference_numbers.rs.

    python3 -m venv venv && venv/bin/pip install numpy scipy scikit-learn POT
    venv/bin/python make_reference_numbers.py > reference_numbers.json

Made with numpy 2.4.6, scipy 1.17.1, scikit-learn 1.9.1, POT 0.9.7.post1.
"""

import json

import numpy as np
import ot
from scipy.linalg import eigh, sqrtm
from sklearn.mixture import GaussianMixture

rng = np.random.default_rng(20)
SIX = ([0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2])


def random_covariances(k, scale=1.0):
    roots = rng.normal(size=(k, 3, 3)) * scale
    return np.round(roots @ roots.transpose(0, 2, 1) + 0.01 * np.eye(3), 6)


def record(weights, means, covs):
    return {
        "weights": np.asarray(weights).tolist(),
        "means": np.asarray(means).tolist(),
        "covs": np.asarray(covs)[:, SIX[0], SIX[1]].tolist(),
    }


def em():
    k = 4
    centres = rng.uniform(-3, 3, (k, 3))
    points = np.round(np.concatenate([rng.normal(c, [1.0, 0.5, 0.2], (60, 3)) for c in centres]), 3)
    start_means = np.round(centres + rng.normal(0, 0.5, (k, 3)), 3)
    cases = []
    for iterations in (1, 5, 50):
        model = GaussianMixture(
            k, tol=0.0, max_iter=iterations, reg_covar=1e-6, weights_init=np.full(k, 1 / k),
            means_init=start_means, precisions_init=np.tile(np.eye(3), (k, 1, 1)),
        ).fit(points)
        cases.append({
            "iterations": iterations,
            "mean_log_likelihood": model.score(points),
            "mixture": record(model.weights_, model.means_, model.covariances_),
        })
    start = record(np.full(k, 1 / k), start_means, np.tile(np.eye(3), (k, 1, 1)))
    return {"points": points.tolist(), "start": start, "cases": cases}


def w2(m, a, n, b):
    root = np.real(sqrtm(a))
    cross = np.real(sqrtm(root @ b @ root))
    return float(np.sqrt(np.sum((m - n) ** 2) + np.trace(a + b - 2 * cross)))


def fm(m, a, n, b):
    return float(np.sqrt(np.sum(np.log(eigh(a, b, eigvals_only=True)) ** 2)) + np.linalg.norm(m - n))


def emd():
    cases = []
    for p, q in ((3, 3), (6, 9), (20, 15), (60, 45)):
        sides = []
        for k in (p, q):
            weights = rng.dirichlet(np.ones(k))
            sides.append((weights, np.round(rng.uniform(-4, 4, (k, 3)), 3), random_covariances(k, 0.6)))
        (wa, ma, ca), (wb, mb, cb) = sides
        case = {"a": record(*sides[0]), "b": record(*sides[1])}
        for name, ground in (("w2", w2), ("fm", fm), ("euclid", lambda m, _, n, __: float(np.linalg.norm(m - n)))):
            costs = np.array([[ground(ma[i], ca[i], mb[j], cb[j]) for j in range(q)] for i in range(p)])
            case[name] = {"emd": float(ot.emd2(wa, wb / wb.sum() * wa.sum(), costs)), "first_row": costs[0].tolist()}
        cases.append(case)
    return cases


def partial():
    """Unequal masses: POT's partial transport of min{W, U}, over min{W, U} (paper Eq. 5)."""
    cases = []
    for p, q, total_a, total_b in ((3, 4, 1.0, 2.5), (9, 6, 3.0, 1.2), (20, 25, 0.8, 0.79), (40, 30, 2.0, 2.0)):
        sides = []
        for k, total in ((p, total_a), (q, total_b)):
            weights = rng.dirichlet(np.ones(k)) * total
            sides.append((weights, np.round(rng.uniform(-4, 4, (k, 3)), 3), random_covariances(k, 0.6)))
        (wa, ma, ca), (wb, mb, cb) = sides
        moved = min(wa.sum(), wb.sum())
        costs = np.array([[w2(ma[i], ca[i], mb[j], cb[j]) for j in range(q)] for i in range(p)])
        work = float(np.sum(ot.partial.partial_wasserstein(wa, wb, costs, m=moved) * costs))
        cases.append({"a": record(*sides[0]), "b": record(*sides[1]), "w2": work / moved})
    return cases


print(json.dumps({"em": em(), "emd": emd(), "partial": partial()}))
