"""The example that learns: its derivatives and its solver hold, a few epochs help, the bench scores both methods."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim.dataset_writer import generate
from sim.scenario import load
from tests.conftest import ROOT

torch = pytest.importorskip("torch", reason="torch is not installed: pip install 'magbench[learn]'")
SCENARIO = ROOT / "examples" / "learn" / "circles.toml"
TINY = ("phases.0.duration_s=60", "phases.0.turn_rate_deg_s=12", "phases.0.radius_m=5", "sampling.rate_hz=5")


@pytest.fixture(autouse=True)
def double_precision():  # type: ignore[no-untyped-def]
    before = torch.get_default_dtype()
    torch.set_default_dtype(torch.float64)
    yield
    torch.set_default_dtype(before)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("learn") / "circles"
    generate(load(SCENARIO, TINY), out, runs=10, split="60/20/20")
    return out


def recordings():  # type: ignore[no-untyped-def]
    """Two recordings without noise over the whole sphere: measured, gravity, S, b, and the field along gravity."""
    rng = np.random.default_rng(4)
    turns = Rotation.random(400, rng=5).as_matrix()
    field, up = turns.transpose(0, 2, 1) @ [0.0, 0.4, -np.sqrt(0.84)], turns.transpose(0, 2, 1) @ [0.0, 0.0, 1.0]
    S, b = np.eye(3) + 0.03 * rng.standard_normal((2, 3, 3)), 0.03 * rng.standard_normal((2, 3))
    measured = field @ S.transpose(0, 2, 1) + b[:, None]
    return (*map(torch.tensor, (measured, np.stack([up, up]), S, b)), -np.sqrt(0.84))


def test_the_gradient_is_that_of_the_corrected_field() -> None:
    from examples.learn.network import gradient, parted

    measured, accel, *_ = recordings()
    found = 0.02 * torch.randn(2, 12, generator=torch.Generator().manual_seed(1))

    def product(parameters):  # type: ignore[no-untyped-def]
        offset, matrix = parted(parameters)
        return (((measured - offset[:, None]) @ matrix.mT) * accel).sum(-1)

    whole = torch.autograd.functional.jacobian(product, found)
    own = torch.stack([whole[run, :, run] for run in range(2)])
    offset, matrix = parted(found)
    torch.testing.assert_close(gradient(accel, measured - offset[:, None], matrix), own)


def test_without_noise_and_with_a_weak_prior_it_finds_the_calibration_to_a_rotation_about_the_vertical() -> None:
    from examples.learn.network import Refiner

    measured, accel, S, b, dip = recordings()
    network = Refiner(dip)
    with torch.no_grad():
        network.log_std.fill_(3.0)
        offset, matrix = network(measured, accel)
    torch.testing.assert_close(offset, b, atol=1e-5, rtol=0)
    whole = matrix @ S
    torch.testing.assert_close(whole @ whole.mT, torch.eye(3).expand(2, 3, 3), atol=1e-4, rtol=0)


def test_irons_dealt_anew_keep_motion_and_noise_and_fit_the_field(dataset: Path) -> None:
    from examples.learn.data import read_part

    runs = read_part(dataset, "train")
    measured = runs.field @ runs.S.mT + runs.b[:, None] + runs.noise
    torch.testing.assert_close(measured, runs.measured, atol=1e-9, rtol=0)
    dealt = runs.with_irons_dealt_anew(torch.Generator().manual_seed(2))
    assert sorted(dealt.b[:, 0].tolist()) == sorted(runs.b[:, 0].tolist())
    assert not torch.equal(dealt.b, runs.b)


def test_a_few_epochs_help_and_both_methods_are_scored_on_the_test_runs(dataset: Path) -> None:
    from examples.learn.data import read_part
    from examples.learn.judge import compared, told
    from examples.learn.network import Refiner
    from examples.learn.train import trained, validated

    network = trained(dataset, epochs=5)
    validation = read_part(dataset, "validation")
    assert validated(network, validation) < validated(Refiner(0.0), validation)
    scores = compared(dataset, network)
    assert sorted(scores["run"].unique()) == read_part(dataset, "test").number.tolist()
    assert set(scores["method"]) == {"learned", "ellipsoid"}
    assert np.isfinite(scores[scores["method"] == "learned"].iloc[:, 3:].to_numpy(float)).all()
    assert "the network is better in" in told(scores)
