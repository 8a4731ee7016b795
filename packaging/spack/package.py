"""Written, not tried: a package of Spack, for a repository of packages of your own. Nothing is published, so that it is
built from a clone: spack dev-build clsdf@main, in its folder."""
from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Clsdf(CMakePackage):
    """Exact signed distance fields of triangle meshes, computed by OpenCL on GPUs and processors."""

    license("MIT")
    version("main")

    variant("io", default=True, description="Files of fields")
    variant("openvdb", default=False, when="+io", description="Files of OpenVDB")
    variant("c", default=True, description="The interface of C")
    variant("shared", default=False, description="Shared libraries")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("cgal@5.5:")
    depends_on("eigen@3.4:")
    depends_on("fmt")
    depends_on("intel-oneapi-tbb")
    depends_on("nlohmann-json")
    depends_on("opencl-c-headers")
    depends_on("opencl-clhpp")
    depends_on("opencl-icd-loader")
    depends_on("expat", when="+io")
    depends_on("hdf5", when="+io")
    depends_on("zlib-api", when="+io")
    depends_on("openvdb", when="+openvdb")

    def cmake_args(self):
        left_out = ("APPS", "EXAMPLES", "FORTRAN", "INTEGRATIONS", "PAPERS", "PICTURE", "REFERENCE", "TESTS")
        return [
            *(self.define(f"CLSDF_BUILD_{name}", False) for name in left_out),
            self.define_from_variant("CLSDF_BUILD_IO", "io"),
            self.define_from_variant("CLSDF_WITH_OPENVDB", "openvdb"),
            self.define_from_variant("CLSDF_BUILD_C", "c"),
            self.define_from_variant("BUILD_SHARED_LIBS", "shared"),
        ]
