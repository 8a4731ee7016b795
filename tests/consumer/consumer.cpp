#include <clsdf/clsdf.hpp>

#include <array>
#include <cstdint>
#include <iostream>

static_assert(CLSDF_VERSION >= CLSDF_MAKE_VERSION(0, 1, 0) &&
              CLSDF_VERSION < CLSDF_MAKE_VERSION(CLSDF_VERSION_MAJOR + 1, 0, 0));

// The distance to a tetrahedron, from arrays in memory to a field in memory.
#ifdef CONSUMER_OF_C
extern "C" [[gnu::visibility("default")]] int consumer() try {
#else
int main() try {
#endif
    const std::array<float, 12> vertices{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::array<std::uint32_t, 12> triangles{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const clsdf::Mesh mesh{clsdf::MeshView{vertices, triangles}};

    const clsdf::Band band = clsdf::Band::full();
    clsdf::DistanceTransform transform(clsdf::Device::automatic(), mesh);
    const clsdf::Field field = transform.compute(clsdf::Grid::around(mesh, 12, band), band);

    std::size_t inside = 0;
    for (const float distance : field.distance()) inside += distance < 0 ? 1 : 0;
    std::cout << "clsdf " << clsdf::version() << ": " << inside << " of " << field.distance().size()
              << " samples lie inside\n";
    return inside > 0 && inside < field.distance().size() ? 0 : 1;
} catch (const clsdf::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
