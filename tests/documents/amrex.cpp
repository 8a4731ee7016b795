// The code of docs/amrex.md, with a stand-in for the classes of AMReX that it uses. That for CUDA is in amrex_cuda.cpp.
#include "documents/amrex_classes.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/fractions.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <utility>
#include <vector>

namespace {

clsdf::Grid block_of(const amrex::Geometry& geom, const amrex::Box& nodes) {
    clsdf::Grid lattice;
    lattice.origin = {geom.ProbLo(0), geom.ProbLo(1), geom.ProbLo(2)};
    lattice.spacing = {geom.CellSize(0), geom.CellSize(1), geom.CellSize(2)};
    const auto first = nodes.smallEnd(), size = nodes.length();
    return lattice.block({first[0], first[1], first[2]}, {size[0], size[1], size[2]});
}

/// AMReX's data of cut cells in a box of cells.
struct Moments {
    amrex::FArrayBox volfrac, centroid, bndryarea, bndrycent, bndrynorm;
    std::array<amrex::FArrayBox, 3> areafrac, facecent;
};

clsdf::OutputArray array_of(amrex::FArrayBox& fab) {
    clsdf::OutputArray array(fab.dataPtr(0));
    array.component_stride = static_cast<std::ptrdiff_t>(fab.box().numPts() * sizeof(amrex::Real));
    return array;
}

clsdf::FractionRequest request_of(const amrex::Geometry& geom, const amrex::Box& cells, Moments& to) {
    clsdf::FractionRequest request{block_of(geom, amrex::surroundingNodes(cells)), {}};
    request.targets.volume = array_of(to.volfrac);
    request.targets.centroid = array_of(to.centroid);
    request.targets.area = array_of(to.bndryarea);
    request.targets.surface_centroid = array_of(to.bndrycent);
    request.targets.normal = array_of(to.bndrynorm);
    for (std::size_t d = 0; d < 3; ++d) {
        request.targets.face_fractions[d] = array_of(to.areafrac[d]);
        request.targets.face_centroids[d] = array_of(to.facecent[d]);
    }
    return request;
}

// NOLINTBEGIN(readability-identifier-naming): AMReX's own names
/// The geometry of a mesh for amrex::EB2::Build: the fluid is outside.
class MeshShop {
public:
    static constexpr int allregular = -1, mixedcells = 0, allcovered = 1;
    static constexpr bool isGPUable() { return false; }

    explicit MeshShop(const clsdf::DistanceTransform& transform) : transform_(&transform) {}

    int getBoxType(const amrex::Box& nodes, const amrex::Geometry& geom, amrex::RunOn) const {
        const std::array<clsdf::Box, 1> box{block_of(geom, nodes).box()};
        std::array<clsdf::BoxPlace, 1> place{};
        transform_->classify(box, 0, place);
        if (place[0] == clsdf::BoxPlace::within) return mixedcells;
        return place[0] == clsdf::BoxPlace::inside ? allcovered : allregular;
    }

    void fillFab(amrex::BaseFab<amrex::Real>& levelset, const amrex::Geometry& geom, amrex::RunOn,
                 const amrex::Box&) const {
        const clsdf::Grid grid = block_of(geom, levelset.box());
        const auto band = clsdf::Band::symmetric(4 * geom.CellSize(0)).with_exact_signs();
        transform_->compute(std::vector<clsdf::Request>{{grid, band, levelset.dataPtr()}});
        amrex::Real* const level = levelset.dataPtr();
        for (std::size_t n = 0; n < grid.sample_count(); ++n)
            level[n] = level[n] < 0 ? -level[n] : -std::max(level[n], std::numeric_limits<amrex::Real>::min());
    }

    void getIntercept(const amrex::Array<amrex::Array4<amrex::Real>, 3>& inter_arr,
                      const amrex::Array<amrex::Array4<const amrex::EB2::Type_t>, 3>& type_arr,
                      const amrex::Array4<const amrex::Real>&, const amrex::Geometry& geom, amrex::RunOn,
                      const amrex::Box&) const {
        // Edges along x are one less than the nodes along x, and as many along y and z.
        const amrex::Dim3 low = inter_arr[0].begin, high = inter_arr[0].end;
        const clsdf::Grid nodes = block_of(geom, {{low.x, low.y, low.z}, {high.x, high.y - 1, high.z - 1}});
        const clsdf::Crossings crossings = transform_->crossings(nodes);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const amrex::Array4<amrex::Real>& inter = inter_arr[axis];
            const clsdf::EdgeCrossings& edges = crossings.axes[axis];
            for (int k = inter.begin.z; k < inter.end.z; ++k)
                for (int j = inter.begin.y; j < inter.end.y; ++j)
                    for (int i = inter.begin.x; i < inter.end.x; ++i) {
                        const std::int64_t row = (k - low.z) * edges.size[1] + (j - low.y);
                        const bool is_cut = type_arr[axis](i, j, k) == amrex::EB2::Type::irregular;
                        inter(i, j, k) =
                            is_cut ? edges.coordinates[static_cast<std::size_t>(row * edges.size[0] + i - low.x)]
                                   : std::numeric_limits<amrex::Real>::quiet_NaN();
                    }
        }
    }

    /// AMReX has covered nodes of small cells: the wall lies at such a node.
    void updateIntercept(const amrex::Array<amrex::Array4<amrex::Real>, 3>& inter_arr,
                         const amrex::Array<amrex::Array4<const amrex::EB2::Type_t>, 3>& type_arr,
                         const amrex::Array4<const amrex::Real>& lst, const amrex::Geometry& geom) const {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const amrex::Array4<amrex::Real>& inter = inter_arr[axis];
            for (int k = inter.begin.z; k < inter.end.z; ++k)
                for (int j = inter.begin.y; j < inter.end.y; ++j)
                    for (int i = inter.begin.x; i < inter.end.x; ++i) {
                        if (type_arr[axis](i, j, k) != amrex::EB2::Type::irregular) {
                            inter(i, j, k) = std::numeric_limits<amrex::Real>::quiet_NaN();
                            continue;
                        }
                        const amrex::Array<int, 3> from{i, j, k};
                        amrex::Array<int, 3> to = from;
                        ++to[axis];
                        for (const amrex::Array<int, 3>& node : {to, from}) {
                            const amrex::Real level = lst(node[0], node[1], node[2]);
                            if (level == 0 || (level > 0 && std::isnan(inter(i, j, k))))
                                inter(i, j, k) = geom.ProbLo(static_cast<int>(axis)) +
                                                 node[axis] * geom.CellSize(static_cast<int>(axis));
                        }
                    }
        }
    }

private:
    const clsdf::DistanceTransform* transform_;
};
// NOLINTEND(readability-identifier-naming)

/// AMReX's arrays of a box of cells, its types of edges, and what the shop makes of them. How many edges are wrong.
std::size_t wrong_edges(const clsdf::DistanceTransform& transform, const amrex::Geometry& geom, const amrex::Box& cells,
                        std::size_t& cut) {
    const MeshShop shop(transform);
    amrex::Box nodes = cells;
    for (int& n : nodes.upper) ++n;
    amrex::BaseFab<double> level(nodes);
    shop.fillFab(level, geom, amrex::RunOn::Cpu, nodes);
    const amrex::Array4<double> s = level.array();
    std::vector<amrex::BaseFab<double>> intercepts;
    std::vector<amrex::BaseFab<int>> types;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        amrex::Box edges = nodes;
        --edges.upper[axis];
        intercepts.emplace_back(edges);
        amrex::BaseFab<int>& type = types.emplace_back(edges);
        const amrex::Array4<int> t = type.array();
        for (int k = edges.lower[2]; k <= edges.upper[2]; ++k)
            for (int j = edges.lower[1]; j <= edges.upper[1]; ++j)
                for (int i = edges.lower[0]; i <= edges.upper[0]; ++i) {
                    const double from = s(i, j, k), to = s(i + (axis == 0), j + (axis == 1), k + (axis == 2));
                    t(i, j, k) = from < 0 && to < 0     ? amrex::EB2::Type::regular
                                 : from >= 0 && to >= 0 ? amrex::EB2::Type::covered
                                                        : amrex::EB2::Type::irregular;
                }
    }
    const amrex::Array<amrex::Array4<double>, 3> inter{intercepts[0].array(), intercepts[1].array(),
                                                       intercepts[2].array()};
    const amrex::Array<amrex::Array4<const int>, 3> type{types[0].array(), types[1].array(), types[2].array()};
    shop.getIntercept(inter, type, s, geom, amrex::RunOn::Cpu, nodes);
    shop.updateIntercept(inter, type, s, geom);

    std::size_t wrong = 0;
    std::vector<clsdf::Vec3> origins, directions;
    std::vector<double> expected;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (int k = inter[axis].begin.z; k < inter[axis].end.z; ++k)
            for (int j = inter[axis].begin.y; j < inter[axis].end.y; ++j)
                for (int i = inter[axis].begin.x; i < inter[axis].end.x; ++i) {
                    const double found = inter[axis](i, j, k);
                    if (type[axis](i, j, k) != amrex::EB2::Type::irregular) {
                        wrong += !std::isnan(found);
                        continue;
                    }
                    // By a ray from the end outside to the other one.
                    std::array<int, 3> node{i, j, k};
                    const bool is_from = s(i, j, k) < 0;
                    if (!is_from) ++node[axis];
                    clsdf::Vec3 origin{}, direction{};
                    for (int n = 0; n < 3; ++n)
                        origin[static_cast<std::size_t>(n)] =
                            geom.ProbLo(n) + node[static_cast<std::size_t>(n)] * geom.CellSize(n);
                    direction[axis] = is_from ? geom.CellSize(0) : -geom.CellSize(0);
                    origins.push_back(origin);
                    directions.push_back(direction);
                    expected.push_back((found - origin[axis]) / direction[axis]);
                }
    std::vector<double> t(origins.size());
    transform.rays(origins, directions, {}, {.t = t});
    for (std::size_t n = 0; n < t.size(); ++n) wrong += !(std::abs(t[n] - expected[n]) < 1e-12) || t[n] > 1;
    cut += t.size();
    return wrong;
}

/// The parts of the shop for the torus, and for a cube whose faces lie on nodes.
bool is_shop_right(const clsdf::DistanceTransform& transform, const clsdf::Box& box) {
    const amrex::Geometry geom{box.lower, box.longest_side() / 24};
    const clsdf::Mesh cube({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {4, 4, 0}, {0, 0, 4}, {4, 0, 4}, {0, 4, 4}, {4, 4, 4}},
                           {{0, 3, 1},
                            {0, 2, 3},
                            {4, 5, 7},
                            {4, 7, 6},
                            {0, 1, 5},
                            {0, 5, 4},
                            {2, 7, 3},
                            {2, 6, 7},
                            {0, 6, 2},
                            {0, 4, 6},
                            {1, 3, 7},
                            {1, 7, 5}},
                           "cube");
    const clsdf::DistanceTransform of_cube(clsdf::Device::automatic(), cube);
    // Two of them share a face: no distance decides for the nodes there.
    std::vector<clsdf::Vec3> vertices = cube.vertices();
    std::vector<clsdf::Triangle> triangles = cube.triangles();
    for (const auto& [x, y, z] : cube.vertices()) vertices.push_back({x + 4, y, z});
    for (const auto& [a, b, c] : cube.triangles()) triangles.push_back({a + 8, b + 8, c + 8});
    const clsdf::DistanceTransform of_two(clsdf::Device::automatic(), clsdf::Mesh(vertices, triangles, "cubes"));
    const amrex::Geometry unit{{0, 0, 0}, 1};
    std::size_t cut = 0, cut_of_cube = 0, cut_of_two = 0;
    const std::size_t wrong = wrong_edges(transform, geom, {{-3, -2, -4}, {26, 25, 11}}, cut) +
                              wrong_edges(of_cube, unit, {{-2, -3, -1}, {6, 5, 7}}, cut_of_cube) +
                              wrong_edges(of_two, unit, {{-2, -3, -1}, {10, 5, 7}}, cut_of_two);
    const MeshShop shop(of_cube);
    const auto type = [&](const amrex::Box& nodes) { return shop.getBoxType(nodes, unit, amrex::RunOn::Cpu); };
    const bool are_types_right = type({{1, 1, 1}, {3, 3, 3}}) == MeshShop::allcovered &&
                                 type({{5, 0, 0}, {7, 4, 4}}) == MeshShop::allregular &&
                                 type({{3, 3, 3}, {5, 5, 5}}) == MeshShop::mixedcells;
    std::printf("%zu edges are cut, %zu of the cube, %zu of two; %zu are wrong\n", cut, cut_of_cube, cut_of_two, wrong);
    // 3 x 3 nodes of the cube are inside, on each of six sides; 7 x 3 of two, on four sides.
    return wrong == 0 && cut > 500 && cut_of_cube == 54 && cut_of_two == 4 * 21 + 2 * 9 && are_types_right;
}

/// A box of cells with room for its moments.
Moments room_for(const amrex::Box& cells) {
    Moments moments{amrex::FArrayBox(cells, 1),
                    amrex::FArrayBox(cells, 3),
                    amrex::FArrayBox(cells, 1),
                    amrex::FArrayBox(cells, 3),
                    amrex::FArrayBox(cells, 3),
                    {},
                    {}};
    for (int d = 0; d < 3; ++d) {
        const amrex::Box faces = amrex::surroundingNodes(cells, d);
        moments.areafrac.at(static_cast<std::size_t>(d)) = amrex::FArrayBox(faces, 1);
        moments.facecent.at(static_cast<std::size_t>(d)) = amrex::FArrayBox(faces, 2);
    }
    return moments;
}

amrex::Real value_at(amrex::FArrayBox& fab, const std::array<int, 3>& at, int component = 0) {
    const amrex::Box box = fab.box();
    std::size_t item = 0;
    for (std::size_t d = 3; d-- > 0;)
        item = item * static_cast<std::size_t>(box.length()[d]) + static_cast<std::size_t>(at[d] - box.lower[d]);
    return fab.dataPtr(component)[item];
}

/// The moments of boxes of two levels, against AMReX's relations between them and against what EB2 makes of the shop.
bool are_moments_right() {
    // A tilted block: the cells around its first corner are a part of one plane but for a few.
    std::vector<clsdf::Vec3> vertices;
    for (int n = 0; n < 8; ++n) {
        const double x = n & 1 ? 20 : 0, y = n & 2 ? 10 : -10, z = n & 4 ? 10 : -10;
        vertices.push_back({0.8 * x - 0.36 * y - 0.48 * z, 0.6 * x + 0.48 * y + 0.64 * z, 0.8 * y - 0.6 * z});
    }
    const clsdf::Mesh mesh(vertices,
                           {{0, 1, 3},
                            {0, 3, 2},
                            {4, 7, 5},
                            {4, 6, 7},
                            {0, 5, 1},
                            {0, 4, 5},
                            {2, 3, 7},
                            {2, 7, 6},
                            {0, 6, 4},
                            {0, 2, 6},
                            {1, 5, 7},
                            {1, 7, 3}},
                           "block");
    const clsdf::OuterSurface surface = clsdf::outer(mesh);
    const std::vector<amrex::Geometry> geom{{{-3, -3, -3}, 1}, {{-3, -3, -3}, 0.5}};
    const std::vector<amrex::Box> boxes{{{-1, -1, -1}, {5, 6, 7}}, {{3, 2, 1}, {10, 9, 8}}};
    std::vector<Moments> moments;
    for (const amrex::Box& box : boxes) moments.push_back(room_for(box));

    std::vector<clsdf::FractionRequest> requests;
    for (std::size_t level = 0; level < geom.size(); ++level)
        requests.push_back(request_of(geom[level], boxes[level], moments[level]));
    clsdf::fractions(surface, requests, clsdf::FractionOptions::of("amrex"));

    const clsdf::DistanceTransform transform(clsdf::Device::automatic(), mesh);
    const MeshShop shop(transform);
    std::size_t wrong = 0, cut = 0, faces = 0;
    for (std::size_t level = 0; level < geom.size(); ++level) {
        Moments& own = moments[level];
        const amrex::Box &cells = boxes[level], nodes = amrex::surroundingNodes(cells);
        for (int k = cells.lower[2]; k <= cells.upper[2]; ++k)
            for (int j = cells.lower[1]; j <= cells.upper[1]; ++j)
                for (int i = cells.lower[0]; i <= cells.upper[0]; ++i) {
                    const std::array<int, 3> at{i, j, k};
                    const double volume = value_at(own.volfrac, at), area = value_at(own.bndryarea, at);
                    wrong += !(volume >= 0 && volume <= 1);
                    if (area == 0) {
                        wrong += value_at(own.bndrycent, at) != -1 || (volume != 0 && volume != 1);
                        continue;
                    }
                    ++cut;
                    for (int d = 0; d < 3; ++d) {
                        const auto axis = static_cast<std::size_t>(d);
                        std::array<int, 3> next = at;
                        ++next[axis];
                        const double low = value_at(own.areafrac[axis], at), high = value_at(own.areafrac[axis], next);
                        // What comes in and does not go out meets the wall; the normal points to the wall.
                        wrong += std::abs(low - high - area * value_at(own.bndrynorm, at, d)) > 1e-12;
                        wrong += std::abs(value_at(own.centroid, at, d)) > 0.5;
                    }
                }
        // EB2's fraction of a face between two cut edges opposite to each other is the mean of their open lengths.
        amrex::BaseFab<double> level_set(nodes);
        shop.fillFab(level_set, geom[level], amrex::RunOn::Cpu, nodes);
        const amrex::Array4<double> s = level_set.array();
        const clsdf::Crossings crossings = transform.crossings(block_of(geom[level], nodes));
        const auto open_length = [&](int i, int j, int k) {  // of the edge along x
            const clsdf::EdgeCrossings& edges = crossings.axes[0];
            const auto row = static_cast<std::size_t>((k - nodes.lower[2]) * edges.size[1] + (j - nodes.lower[1]));
            const double wall = (edges.coordinates[row * static_cast<std::size_t>(edges.size[0]) +
                                                   static_cast<std::size_t>(i - nodes.lower[0])] -
                                 geom[level].ProbLo(0)) /
                                    geom[level].CellSize(0) -
                                i;
            return s(i, j, k) < 0 ? wall : 1 - wall;
        };
        for (int k = cells.lower[2]; k <= nodes.upper[2]; ++k)
            for (int j = cells.lower[1]; j <= cells.upper[1]; ++j)
                for (int i = cells.lower[0]; i <= cells.upper[0]; ++i) {
                    const bool is_open = s(i, j, k) < 0;
                    if ((s(i, j + 1, k) < 0) != is_open || (s(i + 1, j, k) < 0) == is_open ||
                        (s(i + 1, j + 1, k) < 0) == is_open)
                        continue;
                    const double expected = (open_length(i, j, k) + open_length(i, j + 1, k)) / 2;
                    ++faces;
                    wrong += std::abs(value_at(own.areafrac[2], {i, j, k}) - expected) > 1e-12;
                }
    }
    std::printf("%zu cut cells, %zu faces compared; %zu values are wrong\n", cut, faces, wrong);
    return wrong == 0 && cut > 100 && faces > 30;
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
    std::printf("%zu nodes in the band, %zu are wrong\n", within, wrong);
    return wrong == 0 && within > 1000 && is_shop_right(transform, box) && are_moments_right() ? 0 : 1;
}
