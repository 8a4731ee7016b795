#include "arrays.hpp"
#include "binding.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace clsdf::python {

namespace {

std::string text_of(const Grid& grid) {
    return fmt::format("clsdf.Grid(origin=({}, {}, {}), spacing=({}, {}, {}), size=({}, {}, {}), first=({}, {}, {}))",
                       grid.origin[0], grid.origin[1], grid.origin[2], grid.spacing[0], grid.spacing[1],
                       grid.spacing[2], grid.size[0], grid.size[1], grid.size[2], grid.first[0], grid.first[1],
                       grid.first[2]);
}

// Three numbers of any sequence; `of_all` takes one for all axes.
Vec3 numbers_of(nb::handle values, const char* what, bool of_all = false) {
    Vec3 each{};
    if (nb::try_cast(values, each)) return each;
    double all = 0;
    if (of_all && !nb::isinstance<nb::str>(values) && nb::try_cast(values, all)) return {all, all, all};
    refuse(fmt::format("{}: expected {}three numbers (x, y, z), not {}", what, of_all ? "a number or " : "",
                       shown(values)));
}

Index3 wholes_of(nb::handle values, const char* what, bool of_all = false) {
    Index3 each{};
    if (nb::try_cast(values, each)) return each;
    std::int64_t all = 0;
    if (of_all && !nb::isinstance<nb::bool_>(values) && nb::try_cast(values, all)) return {all, all, all};
    refuse(fmt::format("{}: expected {}three whole numbers, along x, y and z, not {}", what,
                       of_all ? "a whole number or " : "", shown(values)));
}

// A half width of a Band, which knows neither a mesh nor a grid.
double width_of(nb::handle value, const char* what) {
    double width = 0;
    if (!nb::isinstance<nb::str>(value) && !nb::isinstance<nb::bool_>(value) && nb::try_cast(value, width))
        return width;
    refuse(
        fmt::format("Band: {} is {}; write a number, in the mesh's units (three voxels are 3 * grid.voxel, no end is "
                    "math.inf); band= of field() takes texts, too",
                    what, value.is_none() ? "missing" : shown(value)));
}

// The arguments of a call by the names of its parameters, null for those that are not given. Any arguments but these
// are a TypeError that has the right ones: `call`.
template <std::size_t Count>
std::array<nb::object, Count> arguments_of(const char* call, const std::array<const char*, Count>& names,
                                           std::size_t required, const nb::args& args, const nb::kwargs& kwargs) {
    const auto wrong = [&](const std::string& why) { throw nb::type_error(fmt::format("{}: {}", call, why).c_str()); };
    std::array<nb::object, Count> found;
    if (args.size() > Count) wrong(fmt::format("{} arguments are given", args.size()));
    for (std::size_t at = 0; at < args.size(); ++at) found[at] = args[at];
    for (const auto& [key, value] : kwargs) {
        const auto name = nb::cast<std::string>(key);
        const auto at = static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
        if (at == Count) wrong(fmt::format("there is no argument '{}'", name));
        if (found[at].is_valid()) wrong(fmt::format("'{}' is given twice", name));
        found[at] = nb::borrow(value);
    }
    for (std::size_t at = 0; at < required; ++at)
        if (!found[at].is_valid()) wrong(fmt::format("'{}' is missing", names[at]));
    return found;
}

// The positions of all samples, (nz, ny, nx, 3).
auto positions_of(const Grid& grid) {
    const auto samples = static_cast<std::size_t>(grid.size[0] * grid.size[1] * grid.size[2]);
    std::vector<Vec3> positions(samples);
    std::size_t at = 0;
    for (std::int64_t k = 0; k < grid.size[2]; ++k)
        for (std::int64_t j = 0; j < grid.size[1]; ++j)
            for (std::int64_t i = 0; i < grid.size[0]; ++i) positions[at++] = grid.position(i, j, k);
    const auto side = [&](std::size_t axis) { return static_cast<std::size_t>(grid.size[axis]); };
    return array_in<nb::ndarray<nb::numpy, double, nb::shape<-1, -1, -1, 3>>>(std::move(positions),
                                                                              {side(2), side(1), side(0), 3});
}

Grid checked(const Vec3& origin, const Vec3& spacing, const Index3& size, const Index3& first) {
    Grid grid{origin, spacing, size, first};
    grid.validate();
    return grid;
}

// A whole number, or three.
AxisCounts counts_of(nb::handle counts, const char* what) {
    if (counts.is_none()) return {};
    Index3 each{};
    if (nb::try_cast(counts, each)) return each;
    std::int64_t all = 0;
    if (nb::try_cast(counts, all)) return all;
    refuse(fmt::format("{}: expected a whole number or three, not {}", what, nb::cast<std::string>(nb::repr(counts))));
}

Grid between(nb::handle lower, nb::handle upper, nb::handle samples, nb::handle cells, bool cell_centred) {
    const Vec3 low = numbers_of(lower, "lower"), high = numbers_of(upper, "upper");
    return Grid::between(low, high, {counts_of(samples, "samples"), counts_of(cells, "cells"), cell_centred});
}

std::pair<Vec3, Vec3> pair_of(const Box& box) {
    return {box.lower, box.upper};
}

auto state_of_band(const Band& band) {
    return std::tuple(band.inside, band.outside, band.has_exact_signs);
}

Band band_of(double inside, double outside, bool exact_signs) {
    return {inside, outside, inside == 0 && outside == 0, exact_signs};
}

auto state_of_grid(const Grid& grid) {
    return std::tuple(grid.origin, grid.spacing, grid.size, grid.first);
}

// Equal grids, and equal bands, have equal hashes.
template <typename State>
Py_hash_t hash_of(const State& state) {
    return nb::hash(nb::cast(state));
}

void add_lengths(nb::module_& module) {
    nb::class_<Length>(module, "Length", "A length in the mesh's units, in voxels, or as a fraction of the mesh's box.")
        .def_static("in_mesh_units", &Length::in_mesh_units, nb::arg("value"), "A length in the mesh's units.")
        .def_static("in_voxels", &Length::in_voxels, nb::arg("value"), "In voxels: the grid's smallest spacing.")
        .def_static("of_extent", &Length::of_extent, nb::arg("fraction"),
                    "A fraction of the longest side of the mesh's box: 0.1 is 10%.")
        .def_static("infinite", &Length::infinite, "No end.")
        .def_static(
            "parse", [](const std::string& text, const std::string& name) { return Length::parse(text, name); },
            nb::arg("text"), nb::arg("name"), "\"10%\", \"3v\", \"0.05\" or \"full\"; the name is that of the option.")
        .def("is_infinite", &Length::is_infinite, "True for a length without end.")
        .def("resolve", &Length::resolve, nb::arg("voxel"), nb::arg("extent"), "The length in the mesh's units.");
}

void add_bands(nb::module_& module) {
    nb::class_<Band>(
        module, "Band",
        "The half widths of a band around the surface, in the mesh's units. A sample with\n"
        "-inside <= distance <= outside has its exact distance; every other one has +outside or -inside.\n"
        "Both are 0 for the signs alone: -0.0 inside, +0.0 outside. outside: as wide as inside if it is not\n"
        "given. exact_signs: the field is below 0 at exactly those samples that are inside, on the surface,\n"
        "too, as links and crossings see them. Raises clsdf.Error for a negative or NaN width.")
        .def(
            "__init__",
            [](Band* band, nb::handle inside_width, nb::handle outside_width, bool exact_signs) {
                const double inside = width_of(inside_width, "inside");
                const double outside = outside_width.is_none() ? inside : width_of(outside_width, "outside");
                const Band made = band_of(inside, outside, exact_signs);
                made.validate();
                new (band) Band(made);
            },
            nb::arg("inside") = nb::none(), nb::arg("outside") = nb::none(), nb::kw_only(),
            nb::arg("exact_signs") = false,
            nb::sig("def __init__(self, inside: float, outside: float | None = None, *, exact_signs: bool = False) "
                    "-> None"))
        .def_ro("inside", &Band::inside, "Half width inside, in the mesh's units.")
        .def_ro("outside", &Band::outside, "Half width outside, in the mesh's units.")
        .def_ro("exact_signs", &Band::has_exact_signs, "Whether the field is below 0 at exactly the samples inside.")
        .def(
            "__eq__", [](const Band& a, const Band& b) { return a == b; }, nb::arg("other"), nb::is_operator(),
            nb::sig("def __eq__(self, other: object, /) -> bool"))
        .def("__hash__", [](const Band& band) { return hash_of(state_of_band(band)); })
        .def("__getstate__", &state_of_band)
        .def("__setstate__",
             [](Band& band, const std::tuple<double, double, bool>& state) {
                 new (&band) Band(std::apply(band_of, state));
             })
        .def("__repr__", [](const Band& band) {
            return fmt::format("clsdf.Band({}, {}{})", band.inside, band.outside,
                               band.has_exact_signs ? ", exact_signs=True" : "");
        });
}

}  // namespace

void add_grids(nb::module_& module) {
    add_lengths(module);
    add_bands(module);
    nb::class_<Grid>(
        module, "Grid",
        "A regular grid: sample (i, j, k) lies at origin + (i, j, k) * spacing, with i along x. It is the block of\n"
        "`size` samples from sample `first` on of an unbounded lattice; blocks of one lattice have the bytes of the\n"
        "whole. All triples are in the order x, y, z; arrays have the shape (nz, ny, nx). Lengths are in the mesh's\n"
        "units. Raises clsdf.Error for a size or a spacing that is not positive, or a number that is not finite.")
        .def(
            "__init__",
            [](Grid* grid, const nb::args& args, const nb::kwargs& kwargs) {
                const auto [origin, spacing, size, first] =
                    arguments_of<4>("clsdf.Grid(origin, spacing, size, first=(0, 0, 0))",
                                    {"origin", "spacing", "size", "first"}, 3, args, kwargs);
                new (grid) Grid(checked(numbers_of(origin, "origin"), numbers_of(spacing, "spacing", true),
                                        wholes_of(size, "size", true),
                                        first.is_valid() ? wholes_of(first, "first") : Index3{}));
            },
            nb::sig("def __init__(self, origin: numpy.typing.ArrayLike, spacing: float | numpy.typing.ArrayLike, "
                    "size: int | numpy.typing.ArrayLike, first: numpy.typing.ArrayLike = (0, 0, 0)) -> None"))
        .def_static(
            "between", &between, nb::arg("lower"), nb::arg("upper"), nb::kw_only(), nb::arg("samples") = nb::none(),
            nb::arg("cells") = nb::none(), nb::arg("cell_centred") = false,
            nb::sig("def between(lower: numpy.typing.ArrayLike, upper: numpy.typing.ArrayLike, *, "
                    "samples: int | typing.Sequence[int] | None = None, "
                    "cells: int | typing.Sequence[int] | None = None, cell_centred: bool = False) -> Grid"),
            "The grid from one corner of a box to the other: so many samples, both ends included, or so many\n"
            "cells, with samples at their corners or, if cell_centred, at their centres. A number is for all\n"
            "axes or (nx, ny, nz). The first sample is `lower` exactly; the spacing is rounded once. A slice: an\n"
            "axis on which both corners are equal has one sample, and the least of the other spacings.")
        .def_ro("origin", &Grid::origin, "Position (x, y, z) of the lattice's sample (0, 0, 0).")
        .def_ro("spacing", &Grid::spacing, "Distance of the samples along x, y and z.")
        .def_ro("size", &Grid::size, "Number of samples along x, y and z.")
        .def_ro("first", &Grid::first, "The first sample (i, j, k) of this block, on the lattice.")
        .def_prop_ro(
            "shape", [](const Grid& grid) { return nb::make_tuple(grid.size[2], grid.size[1], grid.size[0]); },
            nb::sig("def shape(self) -> tuple[int, int, int]"), "(nz, ny, nx): the shape of an array of samples.")
        .def_prop_ro("voxel", &Grid::voxel, "The smallest spacing.")
        .def_prop_ro(
            "box", [](const Grid& grid) { return pair_of(grid.box()); },
            "Two corners, lower and upper: the first and the last sample.")
        .def(
            "position",
            [](const Grid& grid, nb::handle i, nb::handle j, nb::handle k) {
                return grid.position(whole_of(i, "i"), whole_of(j, "j"), whole_of(k, "k"));
            },
            nb::arg("i"), nb::arg("j"), nb::arg("k"),
            nb::sig("def position(self, i: int, j: int, k: int) -> tuple[float, float, float]"),
            "Position (x, y, z) of sample (i, j, k) of this block.")
        .def("positions", &positions_of,
             "The positions of all samples: an array (nz, ny, nx, 3), float64, as position() has them.")
        .def(
            "part",
            [](const Grid& grid, nb::handle offset, nb::handle size) {
                return grid.part(wholes_of(offset, "offset"), wholes_of(size, "size", true));
            },
            nb::arg("offset"), nb::arg("size"),
            nb::sig("def part(self, offset: numpy.typing.ArrayLike, size: int | numpy.typing.ArrayLike) -> Grid"),
            "The block of `size` samples that starts `offset` samples from this one's first. Raises clsdf.Error if it\n"
            "is not inside.")
        .def(
            "block",
            [](const Grid& grid, nb::handle first, nb::handle size) {
                return grid.block(wholes_of(first, "first"), wholes_of(size, "size", true));
            },
            nb::arg("first"), nb::arg("size"),
            nb::sig("def block(self, first: numpy.typing.ArrayLike, size: int | numpy.typing.ArrayLike) -> Grid"),
            "Any block of the lattice, within this grid or beyond it.")
        .def(
            "grown",
            [](const Grid& grid, nb::handle samples) { return grid.grown(whole_of(samples, "grown(): samples")); },
            nb::arg("samples"), nb::sig("def grown(self, samples: int) -> Grid"),
            "So many samples more on every side; fewer if negative.")
        .def(
            "refined",
            [](const Grid& grid, nb::handle ratio) { return grid.refined(whole_of(ratio, "refined(): ratio")); },
            nb::arg("ratio"), nb::sig("def refined(self, ratio: int) -> Grid"),
            "A lattice `ratio` times as fine that has all samples of this one, for samples at nodes.")
        .def(
            "refined_cells",
            [](const Grid& grid, nb::handle ratio) {
                return grid.refined_cells(whole_of(ratio, "refined_cells(): ratio"));
            },
            nb::arg("ratio"), nb::sig("def refined_cells(self, ratio: int) -> Grid"),
            "The same for samples at the centres of cells.")
        .def("in_whole_bricks", &in_whole_bricks,
             "The bricks of sparse fields that overlap the grid: it is rounded out to multiples of 8 on the lattice.")
        .def("cell_centred", &Grid::cell_centred, "The same block shifted by half a voxel on every axis.")
        .def(
            "__eq__", [](const Grid& a, const Grid& b) { return a == b; }, nb::arg("other"), nb::is_operator(),
            nb::sig("def __eq__(self, other: object, /) -> bool"))
        .def("__repr__", &text_of)
        .def("__hash__", [](const Grid& grid) { return hash_of(state_of_grid(grid)); })
        .def("__getstate__", &state_of_grid)
        .def("__setstate__", [](Grid& grid, const std::tuple<Vec3, Vec3, Index3, Index3>& state) {
            new (&grid) Grid{std::get<0>(state), std::get<1>(state), std::get<2>(state), std::get<3>(state)};
        });
    module.def(
        "grid_around",
        [](const Vec3& lower, const Vec3& upper, std::int64_t resolution, std::optional<Vec3> spacing,
           const Length& margin, bool cubic, bool cell_centred) {
            GridOptions options;
            options.resolution = resolution;
            options.spacing = spacing;
            options.margin = margin;
            options.cubic = cubic;
            options.cell_centred = cell_centred;
            return Grid::around(Box{lower, upper}, options);
        },
        nb::arg("lower"), nb::arg("upper"), nb::arg("resolution"), nb::arg("spacing").none(), nb::arg("margin"),
        nb::arg("cubic"), nb::arg("cell_centred"), "A grid around a box; docs/grids-and-bands.md has the rules.");
}

}  // namespace clsdf::python
