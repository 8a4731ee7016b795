#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>

#include <iostream>

// A mesh is the same when it has been written to a file and read, without a library of fields.
int main() try {
    const clsdf::Mesh cube = clsdf::make_shape("cube");
    clsdf::write_mesh(cube, "cube.ply");
    const clsdf::Mesh read = clsdf::read_mesh("cube.ply");
    return read.vertices() == cube.vertices() && read.triangles() == cube.triangles() ? 0 : 2;
} catch (const clsdf::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
