#include "arrays.hpp"
#include "binding.hpp"
#include "calls.hpp"

#include <clsdf/topology_table.h>
#include <clsdf/fractions.hpp>
#include <clsdf/mesh_files.hpp>
#include <clsdf/outer.hpp>
#include <clsdf/topology.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace clsdf::python {

namespace {

// A NumPy array (n, 3) that owns a copy.
template <typename Value, typename Triples>
auto array_of(const Triples& triples) {
    return array_in<nb::ndarray<nb::numpy, Value, nb::shape<-1, 3>>>(triples, {triples.size(), 3});
}

auto arrays_of(const Mesh& mesh) {
    return std::pair(array_of<double>(mesh.vertices()), array_of<std::uint32_t>(mesh.triangles()));
}

// Names, in which bytes that are not UTF-8 are replaced, and numbers (n,), int32.
nb::tuple groups_of(const Mesh& mesh) {
    nb::list names;
    for (const std::string& name : mesh.groups().names)
        names.append(nb::steal(PyUnicode_DecodeUTF8(name.data(), static_cast<Py_ssize_t>(name.size()), "replace")));
    const std::vector<std::uint32_t>& from = mesh.groups().numbers;
    return nb::make_tuple(names, array_in<nb::ndarray<nb::numpy, std::int32_t, nb::shape<-1>>>(
                                     std::vector<std::int32_t>(from.begin(), from.end()), {from.size()}));
}

Mesh read(const std::vector<std::string>& paths, const ReadOptions& options) {
    const nb::gil_scoped_release no_gil;
    return read_meshes(paths, options);
}

// Calls the function with a mesh of the arrays, without the GIL.
template <typename Function>
auto with_mesh(nb::handle vertices, nb::handle faces, Function function) {
    Arrays arrays;
    const MeshView view(arrays.triples(vertices, "vertices"), arrays.triples(faces, "faces"));
    const nb::gil_scoped_release no_gil;
    return function(Mesh(view));
}

std::uint64_t hash_of_mesh(nb::handle vertices, nb::handle faces) {
    return with_mesh(vertices, faces, [](const Mesh& mesh) { return mesh.hash(); });
}

auto welded(nb::handle vertices, nb::handle faces, double tolerance) {
    return arrays_of(with_mesh(vertices, faces, [tolerance](const Mesh& mesh) {
        Mesh result = weld(mesh, tolerance);
        if (tolerance > 0)
            if (const std::string warning = describe_weld(mesh, result).warning; !warning.empty())
                warn(fmt::format("weld: vertices are joined within {}: {}", tolerance, warning));
        return result;
    }));
}

auto closed_down(nb::handle vertices, nb::handle faces, double floor) {
    return arrays_of(with_mesh(vertices, faces, [floor](const Mesh& mesh) { return close_down(mesh, floor); }));
}

auto outer_of(nb::handle vertices, nb::handle faces, const std::string& sign, bool is_silent) {
    const SignRule rule = value_named("sign", sign, {SignRule::automatic, SignRule::nonzero, SignRule::parity});
    Call call;
    if (is_silent) call.mute();
    auto surface = with_mesh(vertices, faces, [&](const Mesh& mesh) { return outer(mesh, rule, call.options()); });
    return tuple_of(std::move(surface));
}

// A NumPy array that owns its values: of each cell so many, which values(cell, n) tells.
template <typename Value, typename Values>
nb::object column(const std::vector<CellFraction>& cells, const std::vector<std::size_t>& each, const Values& values) {
    std::size_t per_cell = 1;
    std::vector<std::size_t> shape{cells.size()};
    for (const std::size_t count : each) {
        per_cell *= count;
        shape.push_back(count);
    }
    auto memory = std::make_unique<std::vector<Value>>();
    memory->reserve(cells.size() * per_cell);
    for (const CellFraction& cell : cells)
        for (std::size_t n = 0; n < per_cell; ++n) memory->push_back(static_cast<Value>(values(cell, n)));
    auto* const data = memory->data();
    return nb::cast(nb::ndarray<nb::numpy, Value>(data, shape.size(), shape.data(), owner_of(std::move(memory))));
}

nb::tuple tuple_of(Fractions& found) {
    const std::vector<CellFraction>& cells = found.cells;
    const std::size_t bytes = found.full.size();
    using Cell = CellFraction;
    return nb::make_tuple(
        column<std::int32_t>(cells, {3}, [](const Cell& cell, std::size_t n) { return cell.cell[n]; }),
        column<std::uint32_t>(cells, {}, [](const Cell& cell, std::size_t) { return cell.pieces; }),
        column<double>(cells, {}, [](const Cell& cell, std::size_t) { return cell.volume; }),
        column<double>(cells, {3}, [](const Cell& cell, std::size_t n) { return cell.centroid[n]; }),
        column<double>(cells, {}, [](const Cell& cell, std::size_t) { return cell.area; }),
        column<double>(cells, {3}, [](const Cell& cell, std::size_t n) { return cell.vector_area[n]; }),
        column<double>(cells, {3}, [](const Cell& cell, std::size_t n) { return cell.surface_centroid[n]; }),
        column<double>(cells, {6}, [](const Cell& cell, std::size_t n) { return cell.face_fractions[n]; }),
        column<double>(cells, {6, 2},
                       [](const Cell& cell, std::size_t n) { return cell.face_centroids[n / 2][n % 2]; }),
        array_in<nb::ndarray<nb::numpy, std::uint8_t, nb::shape<-1>>>(std::move(found.full), {bytes}));
}

/// "" stands for the convention's.
FractionOptions fraction_options_of(const std::string& convention, const std::string& part, const std::string& walls,
                                    double snap) {
    const auto number_of = [](const char* what, const std::string& text, const std::vector<std::string>& names) {
        const auto at = std::ranges::find(names, text);
        if (at == names.end())
            refuse(fmt::format("{} '{}' is not known; the choices are {}", what, text, fmt::join(names, ", ")));
        return static_cast<std::int32_t>(at - names.begin());
    };
    FractionOptions options =
        part.empty()
            ? FractionOptions::of(convention)
            : FractionOptions::of(convention, static_cast<CellPart>(number_of("part", part, {"solid", "fluid"})));
    if (!walls.empty()) options.walls = static_cast<WallCell>(number_of("walls", walls, {"above", "solid", "fluid"}));
    options.snap = snap;
    return options;
}

nb::list fractions_of(nb::handle vertices, nb::handle faces, const std::vector<Grid>& grids, const std::string& sign,
                      bool is_outer, const std::string& convention, const std::string& part, const std::string& walls,
                      double snap) {
    const SignRule rule = value_named("sign", sign, {SignRule::automatic, SignRule::nonzero, SignRule::parity});
    const FractionOptions options = fraction_options_of(convention, part, walls, snap);
    const Call call;
    std::vector<Fractions> all;
    with_mesh(vertices, faces, [&](const Mesh& mesh) {
        fractions(
            is_outer ? OuterSurface{mesh, {}} : outer(mesh, rule, call.options()), grids,
            [&](std::size_t, Fractions& found) { all.push_back(std::move(found)); }, options, call.options());
    });
    nb::list list;
    for (Fractions& found : all) {
        list.append(tuple_of(found));
        found = {};
    }
    return list;
}

Defects defects_of(nb::handle vertices, nb::handle faces) {
    return with_mesh(vertices, faces, [](const Mesh& mesh) { return find_defects(mesh); });
}

nb::list list_of(const std::vector<Topology::Edge>& edges) {
    nb::list list;
    for (const Topology::Edge& edge : edges) list.append(std::pair(edge.from, edge.to));
    return list;
}

struct TopologyCount {
    std::size_t Topology::*member;
    const char *name, *meaning;
};

constexpr TopologyCount topology_counts[] = {
#define CLSDF_ROW(member, meaning) {&Topology::member, #member, meaning},
    CLSDF_TOPOLOGY_COUNTS(CLSDF_ROW)
#undef CLSDF_ROW
};

using Edges = std::vector<std::pair<Vec3, Vec3>>;
using TopologyState = std::tuple<std::tuple<bool, bool, bool>, std::vector<std::size_t>, Edges, Edges>;

Edges pairs_of(const std::vector<Topology::Edge>& edges) {
    Edges pairs;
    for (const Topology::Edge& edge : edges) pairs.emplace_back(edge.from, edge.to);
    return pairs;
}

TopologyState state_of(const Topology& topology) {
    std::vector<std::size_t> counts;
    for (const TopologyCount& count : topology_counts) counts.push_back(topology.*count.member);
    return {{topology.closed, topology.balanced, topology.inside_out},
            counts,
            pairs_of(topology.first_open_edges),
            pairs_of(topology.first_unbalanced_edges)};
}

Topology topology_of(const TopologyState& state) {
    const auto& [kinds, counts, open, unbalanced] = state;
    Topology topology;
    std::tie(topology.closed, topology.balanced, topology.inside_out) = kinds;
    for (std::size_t i = 0; i < std::min(counts.size(), std::size(topology_counts)); ++i)
        topology.*topology_counts[i].member = counts[i];
    for (const auto& [from, to] : open) topology.first_open_edges.push_back({from, to});
    for (const auto& [from, to] : unbalanced) topology.first_unbalanced_edges.push_back({from, to});
    return topology;
}

}  // namespace

nb::tuple tuple_of(OuterSurface surface) {
    const std::size_t count = surface.faces.size();
    auto faces = array_in<nb::ndarray<nb::numpy, std::uint32_t, nb::shape<-1>>>(std::move(surface.faces), {count});
    const auto [own_vertices, own_faces] = arrays_of(surface.mesh);
    return nb::make_tuple(own_vertices, own_faces, faces, surface.whole_faces, surface.partial_faces,
                          surface.hidden_faces, surface.volume, surface.area);
}

void add_meshes(nb::module_& module) {
    nb::class_<Topology> of_topology(
        module, "Topology",
        "What the sign rule depends on. Vertices of equal coordinates count as one. If the mesh itself is not\n"
        "balanced, another surface decides the sign (docs/sign.md), and edges are those of that surface.");
    of_topology.def_ro("closed", &Topology::closed, "Every edge has an even number of faces.")
        .def_ro("balanced", &Topology::balanced, "Every edge is used equally often in both directions.")
        .def_ro("inside_out", &Topology::inside_out,
                "Balanced, and the enclosed volume is negative; or not balanced, and the winding number is.")
        .def_prop_ro(
            "first_open_edges", [](const Topology& topology) { return list_of(topology.first_open_edges); },
            nb::sig(
                "def first_open_edges(self) -> list[tuple[tuple[float, float, float], tuple[float, float, float]]]"),
            "Up to five: two positions each.")
        .def_prop_ro(
            "first_unbalanced_edges", [](const Topology& topology) { return list_of(topology.first_unbalanced_edges); },
            nb::sig("def first_unbalanced_edges(self) -> list[tuple[tuple[float, float, float], tuple[float, float, "
                    "float]]]"),
            "The same.")
        .def("__getstate__", &state_of)
        .def("__setstate__",
             [](Topology& topology, const TopologyState& state) { new (&topology) Topology(topology_of(state)); })
        .def("__repr__", [](const Topology& topology) {
            return std::string("<clsdf.Topology: ") + (topology.closed ? "closed" : "open") +
                   (topology.balanced ? ", balanced" : ", not balanced") +
                   (topology.inside_out ? ", inside out>" : ">");
        });
    for (const TopologyCount& count : topology_counts) of_topology.def_ro(count.name, count.member, count.meaning);
    nb::class_<Defects>(module, "Defects",
                        "Defects of a mesh other than those of its edges. Vertices of equal coordinates count as one. "
                        "The distance is\n"
                        "exact in spite of them.")
        .def_ro("zero_area_faces", &Defects::zero_area_faces, "Three different vertices on one line, exactly.")
        .def_ro("duplicate_faces", &Defects::duplicate_faces,
                "Faces with the three different vertices of an earlier face, in any order.")
        .def_ro("components", &Defects::components, "Parts of the mesh that share no vertex.")
        .def("__getstate__",
             [](const Defects& defects) {
                 return std::tuple(defects.zero_area_faces, defects.duplicate_faces, defects.components);
             })
        .def("__setstate__",
             [](Defects& defects, const std::tuple<std::size_t, std::size_t, std::size_t>& state) {
                 const auto [zero_area, duplicate, components] = state;
                 new (&defects) Defects{zero_area, duplicate, components};
             })
        .def("__repr__", [](const Defects& defects) {
            return fmt::format("<clsdf.Defects: {} faces without area, {} duplicate faces, {} components>",
                               defects.zero_area_faces, defects.duplicate_faces, defects.components);
        });
    module.def(
        "read_mesh",
        [](const std::vector<std::string>& paths, double scale, const Vec3& translate, const std::string& up,
           const Vec3& rotate, const std::string& group_by, bool skip_bad_facets) {
            ReadOptions options{.log = warn, .scale = scale, .translate = translate, .up = up, .rotate = rotate};
            options.group_by = group_by;
            options.skip_bad_facets = skip_bad_facets;
            const Mesh mesh = read(paths, options);
            const auto arrays = arrays_of(mesh);
            return nb::make_tuple(arrays.first, arrays.second, groups_of(mesh));
        },
        nb::arg("paths"), nb::arg("scale") = 1.0, nb::arg("translate") = Vec3{}, nb::arg("up") = "z",
        nb::arg("rotate") = Vec3{}, nb::arg("group_by") = "", nb::arg("skip_bad_facets") = false,
        nb::sig(
            "def read_mesh(paths: typing.Sequence[str], scale: float = 1.0, translate: tuple[float, float, float] = "
            "(0.0, 0.0, 0.0), up: str = 'z', rotate: tuple[float, float, float] = (0.0, 0.0, 0.0), group_by: str = "
            "'', skip_bad_facets: bool = False) -> tuple[typing.Any, typing.Any, tuple[list[str], typing.Any]]"),
        "Vertices (n, 3), float64, faces (m, 3), uint32, and the names and numbers of groups of files .off, .obj,\n"
        ".stl or .ply, one after the other.\n"
        "Raises clsdf.Error (unreadable_input, invalid_mesh, unsupported) that names the line or the element.");
    module.def("mesh_hash", &hash_of_mesh, nb::arg("vertices"), nb::arg("faces"));
    module.def("weld", &welded, nb::arg("vertices"), nb::arg("faces"), nb::arg("tolerance") = 0.0);
    module.def("close_down", &closed_down, nb::arg("vertices"), nb::arg("faces"), nb::arg("floor"));
    module.def(
        "outer", &outer_of, nb::arg("vertices"), nb::arg("faces"), nb::arg("sign") = "auto",
        nb::arg("is_silent") = false,
        nb::sig("def outer(vertices: typing.Any, faces: typing.Any, sign: str = 'auto', is_silent: bool = False) -> "
                "tuple[typing.Any, ...]"));
    module.def("fractions", &fractions_of, nb::arg("vertices"), nb::arg("faces"), nb::arg("grids"), nb::arg("sign"),
               nb::arg("is_outer"), nb::arg("convention"), nb::arg("part"), nb::arg("walls"), nb::arg("snap"),
               nb::sig("def fractions(vertices: typing.Any, faces: typing.Any, grids: typing.Sequence[Grid], sign: "
                       "str, is_outer: bool, convention: str, part: str, walls: str, snap: float) -> "
                       "list[tuple[typing.Any, ...]]"));
    module.def("find_defects", &defects_of, nb::arg("vertices"), nb::arg("faces"));
    module.def(
        "make_shape", [](const std::string& name) { return arrays_of(make_shape(name)); }, nb::arg("name"),
        "Vertices and faces of a shape made by code: 'sphere0' to 'sphere9', 'torus', 'knot' and others, which\n"
        "shape_names() lists.");
    module.def(
        "shape_names",
        [] {
            nb::dict names;
            for (const ShapeName& shape : shape_names()) names[shape.name.c_str()] = shape.description;
            return names;
        },
        nb::sig("def shape_names() -> dict[str, str]"), "The names of make_shape(), each with a description.");
}

}  // namespace clsdf::python
