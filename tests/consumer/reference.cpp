#include <clsdf/reference.hpp>

// The distance to a triangle from a point above it.
int main() {
    const clsdf::reference::Nearest nearest =
        clsdf::reference::nearest_on_triangle({0.25, 0.25, 2}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    return nearest.distance == 2 ? 0 : 1;
}
