#include <clsdf.h>

#include <clsdf/clsdf.hpp>

#include <iostream>

// A program that links both interfaces: each has its own copy of the library, if that is static.
int main() try {
    clsdf_mesh* mesh = nullptr;
    clsdf_box box;
    if (clsdf_mesh_shape("cube", &mesh) != CLSDF_OK || clsdf_mesh_box(mesh, &box) != CLSDF_OK) return 2;
    clsdf_mesh_release(mesh);
    const clsdf::Box same = clsdf::make_shape("cube").box();
    return box.upper[0] == same.upper[0] && clsdf_version() == CLSDF_VERSION ? 0 : 3;
} catch (const clsdf::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
