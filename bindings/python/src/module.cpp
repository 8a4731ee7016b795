#include "binding.hpp"

NB_MODULE(_core, module) {
    // Objects that a thread or a global variable still has at the end of the process are no fault.
    nb::set_leak_warnings(false);
    module.doc() = "The C++ library clsdf for the package clsdf: converts, calls one function, converts.";
    clsdf::python::add_errors(module);
    clsdf::python::add_arrays(module);
    clsdf::python::add_grids(module);
    clsdf::python::add_devices(module);
    clsdf::python::add_meshes(module);
    clsdf::python::add_transforms(module);
    clsdf::python::add_scenes(module);
    clsdf::python::add_links(module);
    clsdf::python::add_plans(module);
    clsdf::python::add_shared_arrays(module);
    clsdf::python::add_files(module);
    clsdf::python::add_sparse_fields(module);
}
