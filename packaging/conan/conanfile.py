"""Conan's recipe of the libraries, for Conan 2: `conan create packaging/conan` in a clone or in an unpacked archive.

It compiles the sources beside it. The libraries that they need are those of the system: on Debian and Ubuntu by apt
(`-c tools.system.package_manager:mode=install` lets Conan install them; otherwise it names those that are missing).
A project finds the package as it would an installed one: find_package(clsdf COMPONENTS ...). The package has nothing
under the GPL: neither the command nor clsdf::reference.
"""
import os
import re

from conan import ConanFile
from conan.errors import ConanInvalidConfiguration
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load, rmdir
from conan.tools.system.package_manager import Apt

FOLDERS = ("lib", "kernels", "cmake", "bindings/c", "bindings/fortran", "integrations", "docs", "examples", "benchmarks", "conformance")
FILES = ("CMakeLists.txt", "LICENSE", "README.md", "CHANGELOG.md", "CONTRIBUTING.md")


class ClsdfRecipe(ConanFile):
    name = "clsdf"
    package_type = "library"
    license = "MIT"
    description = "Exact signed distance fields of triangle meshes, computed by OpenCL on GPUs and processors"
    topics = ("signed-distance-field", "level-set", "mesh", "geometry", "opencl", "gpu", "simulation")
    settings = "os", "arch", "compiler", "build_type"
    options = {
        "shared": [True, False],
        "fPIC": [True, False],
        "meshes": [True, False],  # clsdf::meshes: files of meshes and points
        "io": [True, False],  # clsdf::io: files of fields, with HDF5, expat, zlib
        "openvdb": [True, False],  # its .vdb files
        "papers": [True, False],  # clsdf::papers
        "c": [True, False],  # clsdf::c and, with io, clsdf::c_io
    }
    default_options = {"shared": False, "fPIC": True, "meshes": True, "io": True, "openvdb": False, "papers": False, "c": True}
    implements = ["auto_shared_fpic"]

    def set_version(self):
        text = load(self, os.path.join(self.root, "lib", "include", "clsdf", "version.hpp"))
        self.version = ".".join(re.search(rf"CLSDF_VERSION_{part} (\d+)", text)[1] for part in ("MAJOR", "MINOR", "PATCH"))

    @property
    def root(self):
        return os.path.normpath(os.path.join(self.recipe_folder, "..", ".."))

    def export_sources(self):
        for folder in FOLDERS:
            copy(self, f"{folder}/*", self.root, self.export_sources_folder)
        for file in FILES:
            copy(self, file, self.root, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def validate(self):
        if self.settings.os != "Linux":
            raise ConanInvalidConfiguration("clsdf has been built on Linux alone")
        check_min_cppstd(self, 20)
        if (self.options.io or self.options.c) and not self.options.meshes:
            raise ConanInvalidConfiguration("io and c need meshes")
        if self.options.openvdb and not self.options.io:
            raise ConanInvalidConfiguration("openvdb is a part of io: set io, too")

    def system_requirements(self):
        packages = ["libcgal-dev", "libeigen3-dev", "libtbb-dev", "libfmt-dev", "nlohmann-json3-dev", "ocl-icd-opencl-dev",
                    "opencl-clhpp-headers"]
        if self.options.io:
            packages += ["libhdf5-dev", "libexpat1-dev", "zlib1g-dev"]
        if self.options.openvdb:
            packages.append("libopenvdb-dev")
        Apt(self).install(packages, update=True, check=True)

    def generate(self):
        toolchain = CMakeToolchain(self)
        for name in ("meshes", "io", "papers", "c"):
            toolchain.cache_variables[f"CLSDF_BUILD_{name.upper()}"] = bool(self.options.get_safe(name))
        toolchain.cache_variables["CLSDF_WITH_OPENVDB"] = bool(self.options.openvdb)
        for name in ("REFERENCE", "PICTURE", "APPS", "TESTS", "EXAMPLES", "FORTRAN", "INTEGRATIONS"):
            toolchain.cache_variables[f"CLSDF_BUILD_{name}"] = False
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        CMake(self).install()
        rmdir(self, os.path.join(self.package_folder, "share", "doc"))

    def package_info(self):
        # The package's own description for CMake says what it is; Conan's would be a second one.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("lib", "cmake", "clsdf")]
