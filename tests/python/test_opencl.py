"""backend="opencl": rays alone in a medium have the native backend's bits; devices and choices of them."""
import numpy as np
import pytest

import cpm


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory, monkeypatch):
    """Programs built by these tests stay out of the user's cache."""
    monkeypatch.setenv("CPM_CACHE_DIR", str(tmp_path_factory.getbasetemp() / "cpm-programs"))


def media():
    heights = np.linspace(-2.0, 4.0, 33)
    x = np.linspace(-1.0, 1.0, 9)
    bump = 1.3 + 0.05 * np.exp(-(x[:, None, None] ** 2 + x[None, :, None] ** 2 + x[None, None, :] ** 2))
    shells = cpm.media.Layered(heights, 1.3 - 0.02 * heights, radius=3.0)
    formula = cpm.media.Expression("1.2 + 0.1*exp(-x*x - y*y) + 0.02*sin(z)*500/wavelength")
    return {
        "shells": shells,
        "expression": formula,
        "sum": shells + formula + cpm.media.Linear(1.1, gradient=(0.01, 0, 0), dispersion="BK7"),
        "homogeneous": cpm.media.Homogeneous(1.5),
        "linear-squared": cpm.media.LinearSquared(1.69, gradient=(0.0, -0.1, 0.0)),
        "linear": cpm.media.Linear(1.3, gradient=(0.01, -0.04, 0.0)),
        "layered": cpm.media.Layered(heights, 1.3 - 0.02 * heights, interpolation="cubic"),
        "grid": cpm.media.Grid(bump, origin=(-1, -1, -1), spacing=(0.25, 0.25, 0.25), interpolation="cubic"),
    }


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("name", media())
def test_rays_have_the_native_bits(name, precision):
    medium = media()[name]
    rng = np.random.default_rng(3)
    origins, directions = rng.uniform(-0.5, 0.5, (999, 3)), rng.normal(size=(999, 3))
    settings = {"wavelength": 550.0, "length": rng.uniform(0.0, 1.0, 999), "precision": precision, "path": 3}
    native = cpm.trace(medium, origins, directions, **settings)
    device = cpm.trace(medium, origins, directions, backend="opencl", **settings)
    for column in ("position", "direction", "optical_path", "evaluations", "steps", "status", "drift", "paths"):
        np.testing.assert_array_equal(getattr(native, column), getattr(device, column), err_msg=column)
    assert native.method.tolist() == device.method.tolist()


def test_a_plane_ends_rays_on_a_device_too():
    medium = media()["linear"]
    until = ((0.0, 0.0, 2.0), (0.0, 0.0, 1.0))
    rays = [cpm.trace(medium, [[0, 0, 0]], [[0.1, 0.2, 1.0]], wavelength=550.0, until=until, backend=backend)
            for backend in ("native", "opencl")]
    assert rays[0].position[0, 2] == pytest.approx(2.0, abs=1e-12)
    np.testing.assert_array_equal(rays[0].position, rays[1].position)


def test_devices_can_be_chosen_by_number_and_by_name():
    found = [device for device in cpm.devices() if device.backend == "opencl"]
    assert found, "no OpenCL device: install PoCL (packages-debian.txt)"
    assert all(device.memory > 0 and device.units > 0 and device.usable for device in found)
    medium = media()["linear"]
    for backend in ("opencl:0", f"opencl:{found[0].name[3:9].upper()}"):
        assert cpm.trace(medium, [[0, 0, 0]], [[0, 0, 1]], wavelength=550.0, length=1.0, backend=backend).status[0] == 0


@pytest.mark.parametrize("backend", ["opencl:99", "opencl:no such device", "cuda", "", None, 3])
def test_a_backend_that_is_not_there_is_refused(backend):
    with pytest.raises(ValueError, match="backend is"):
        cpm.trace(media()["linear"], [[0, 0, 0]], [[0, 0, 1]], wavelength=550.0, length=1.0, backend=backend)


def test_rays_of_scenes_are_refused_by_name():
    with pytest.raises(cpm.Error, match="native backend"):
        cpm.trace(cpm.Scene(), [[0, 0, 0]], [[0, 0, 1]], wavelength=550.0, backend="opencl")
    with pytest.raises(ValueError, match="backend is"):
        cpm.trace_photons(cpm.Scene(), 10, backend="cuda")
