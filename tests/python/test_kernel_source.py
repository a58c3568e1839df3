"""cpm.kernels: the sources that users run straight from pyopencl."""
import pytest

import cpm


def test_source_is_self_contained():
    text = cpm.kernels.source()
    assert '#include "' not in text
    for name in cpm.kernels.names():
        assert f"kernels/{name}.cl" in text


def test_files_without_a_guard_are_there_as_often_as_they_are_included():
    # elementary_body.h serves doubles and lanes: included twice, by design.
    assert cpm.kernels.source().count("/* shared/elementary_body.h */") == 2
    assert cpm.kernels.source().count("/* dialect.h */") == 1


def test_unknown_kernel_lists_the_known():
    with pytest.raises(ValueError, match=cpm.kernels.names()[0]):
        cpm.kernels.source("no-such-kernel")


@pytest.mark.parametrize("options", [[], ["-DCPM_WIDTH=1"], ["-DCPM_WIDTH=8"]])
def test_source_builds(options):
    import pyopencl as cl

    platforms = cl.get_platforms()
    assert platforms, "no OpenCL platform: install PoCL (packages-debian.txt)"
    context = cl.Context([platforms[0].get_devices()[0]])
    program = cl.Program(context, cpm.kernels.source()).build(options=["-cl-std=CL1.2", *options])
    assert "cpm_trace" in program.kernel_names
