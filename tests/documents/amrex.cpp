// The code of docs/amrex.md, with a stand-in for the classes of AMReX that it uses.
#include <clsdf/clsdf.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

// NOLINTBEGIN(readability-identifier-naming,google-explicit-constructor): AMReX's own names
namespace amrex {

using Real = double;
using IntVect = std::array<int, 3>;

struct Geometry {
    std::array<Real, 3> lower{};
    Real size = 0;
    Real ProbLo(int axis) const { return lower.at(static_cast<std::size_t>(axis)); }
    Real CellSize(int) const { return size; }
};

struct Box {
    IntVect lower{}, upper{};  // included
    IntVect smallEnd() const { return lower; }
    IntVect length() const { return {upper[0] - lower[0] + 1, upper[1] - lower[1] + 1, upper[2] - lower[2] + 1}; }
    std::size_t numPts() const {
        const IntVect n = length();
        return static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]);
    }
};

struct FArrayBox {
    Box bounds;
    std::vector<Real> values;
    Box box() const { return bounds; }
    Real* dataPtr(int component) { return values.data() + static_cast<std::size_t>(component) * bounds.numPts(); }
};

using MultiFab = std::vector<FArrayBox>;

struct MFIter {
    explicit MFIter(const MultiFab& fabs) : count(fabs.size()) {}
    bool isValid() const { return at < count; }
    MFIter& operator++() {
        ++at;
        return *this;
    }
    operator std::size_t() const { return at; }
    std::size_t at = 0, count;
};

}  // namespace amrex
// NOLINTEND(readability-identifier-naming,google-explicit-constructor)

namespace {

clsdf::Grid block_of(const amrex::Geometry& geom, const amrex::Box& nodes) {
    clsdf::Grid lattice;
    lattice.origin = {geom.ProbLo(0), geom.ProbLo(1), geom.ProbLo(2)};
    lattice.spacing = {geom.CellSize(0), geom.CellSize(1), geom.CellSize(2)};
    const auto first = nodes.smallEnd(), size = nodes.length();
    return lattice.block({first[0], first[1], first[2]}, {size[0], size[1], size[2]});
}

void set_boundary(const clsdf::DistanceTransform& transform, const amrex::Geometry& geom, amrex::FArrayBox& fab,
                  clsdf::Crossings& intercepts) {
    const clsdf::Grid nodes = block_of(geom, fab.box());
    const auto band = clsdf::Band::symmetric(4 * geom.CellSize(0)).with_exact_signs();
    transform.compute(nodes, band, fab.dataPtr(1));
    intercepts = transform.crossings(nodes);
}

/// The edges along an axis on which level set and intercept disagree.
std::size_t count_contradictions(amrex::FArrayBox& fab, const clsdf::Crossings& intercepts, std::size_t axis) {
    const clsdf::EdgeCrossings& edges = intercepts.axes.at(axis);
    const amrex::IntVect nodes = fab.box().length();
    const auto side = [&](std::size_t a) { return static_cast<std::size_t>(nodes.at(a)); };
    const std::size_t step = axis == 0 ? 1 : axis == 1 ? side(0) : side(0) * side(1);
    std::size_t wrong = 0, edge = 0;
    for (std::int64_t k = 0; k < edges.size[2]; ++k)
        for (std::int64_t j = 0; j < edges.size[1]; ++j)
            for (std::int64_t i = 0; i < edges.size[0]; ++i) {
                const double* const phi =
                    fab.dataPtr(1) + static_cast<std::size_t>(i) +
                    side(0) * (static_cast<std::size_t>(j) + side(1) * static_cast<std::size_t>(k));
                wrong += ((phi[0] < 0) != (phi[step] < 0)) == std::isnan(edges.coordinates[edge++]);
            }
    return wrong;
}

}  // namespace

int main() {
    const clsdf::Mesh mesh = clsdf::make_shape("torus");
    const clsdf::DistanceTransform transform(clsdf::Device::automatic(), mesh);
    const clsdf::Box box = mesh.box();
    std::vector<amrex::Geometry> geom;
    std::vector<amrex::MultiFab> phi;
    for (int level = 0; level < 2; ++level) {
        geom.push_back({box.lower, box.longest_side() / (16 << level)});
        amrex::MultiFab& fabs = phi.emplace_back();
        for (int x = 0; x < 2; ++x) {
            const amrex::Box bounds{{8 * x - 2, -2, -2}, {8 * x + 10, 12, 8}};
            fabs.push_back({bounds, std::vector<double>(2 * bounds.numPts(), -7.0)});
        }
    }

    std::vector<clsdf::Request> requests;
    for (std::size_t level = 0; level < phi.size(); ++level)
        for (amrex::MFIter it(phi[level]); it.isValid(); ++it) {
            amrex::FArrayBox& fab = phi[level][it];
            const auto band = clsdf::Band::symmetric(4 * geom[level].CellSize(0));
            requests.push_back({block_of(geom[level], fab.box()), band, fab.dataPtr(1)});
        }
    transform.compute(requests);

    // Node by node, against queries at the positions of AMReX's nodes.
    std::size_t wrong = 0, within = 0;
    for (std::size_t level = 0; level < phi.size(); ++level)
        for (amrex::FArrayBox& fab : phi[level]) {
            const amrex::Box nodes = fab.box();
            const double h = geom[level].CellSize(0);
            std::vector<clsdf::Vec3> positions;
            for (int k = nodes.lower[2]; k <= nodes.upper[2]; ++k)
                for (int j = nodes.lower[1]; j <= nodes.upper[1]; ++j)
                    for (int i = nodes.lower[0]; i <= nodes.upper[0]; ++i)
                        positions.push_back({box.lower[0] + i * h, box.lower[1] + j * h, box.lower[2] + k * h});
            std::vector<double> expected(positions.size());
            transform.query(positions, 4 * h, expected);
            for (std::size_t n = 0; n < expected.size(); ++n) {
                const double found = fab.dataPtr(1)[n];
                wrong += found - expected[n] > 1e-5 * h || expected[n] - found > 1e-5 * h || fab.dataPtr(0)[n] != -7.0;
                within += found > -4 * h && found < 4 * h;
            }
        }
    // Two cubes that share a face, on planes of nodes: no distance decides for the nodes there.
    const clsdf::Mesh cube = clsdf::make_shape("cube");
    const clsdf::Box extent = cube.box();
    std::vector<clsdf::Vec3> vertices = cube.vertices();
    std::vector<clsdf::Triangle> triangles = cube.triangles();
    for (auto [x, y, z] : cube.vertices()) vertices.push_back({x + extent.longest_side(), y, z});
    const auto first = static_cast<std::uint32_t>(cube.vertices().size());
    for (const auto& [a, b, c] : cube.triangles()) triangles.push_back({a + first, b + first, c + first});
    const clsdf::DistanceTransform aligned(clsdf::Device::automatic(), clsdf::Mesh(vertices, triangles, "cubes"));
    const amrex::Geometry of_cube{extent.lower, extent.longest_side() / 8};
    const amrex::Box bounds{{-2, -2, -2}, {18, 10, 10}};
    amrex::FArrayBox fab{bounds, std::vector<double>(2 * bounds.numPts())};
    clsdf::Crossings intercepts;
    set_boundary(aligned, of_cube, fab, intercepts);
    std::size_t contradictions = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) contradictions += count_contradictions(fab, intercepts, axis);
    std::printf("%zu nodes in the band, %zu are wrong; %zu edges contradict the level set\n", within, wrong,
                contradictions);
    return wrong == 0 && within > 1000 && contradictions == 0 ? 0 : 1;
}
