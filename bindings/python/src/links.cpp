#include "body.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace clsdf::python {

namespace {

using Directions = nb::ndarray<const std::int32_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

template <typename Value, typename Items>
nb::object rows_of(Items& items, const nb::capsule& owner) {
    return nb::cast(
        nb::ndarray<nb::numpy, Value, nb::ndim<1>>(static_cast<void*>(items.data()), {items.size()}, owner));
}

/// The array of a list of whole numbers, which has an axis more.
nb::object triples_of(std::vector<std::array<std::int32_t, 3>>& items, const nb::capsule& owner) {
    return nb::cast(nb::ndarray<nb::numpy, std::int32_t, nb::ndim<2>>(static_cast<void*>(items.data()),
                                                                      {items.size(), std::size_t{3}}, owner));
}

/// An axis of one sample has no edges, and an array without items.
template <typename Value>
nb::object box_of(std::vector<Value>& items, const Index3& size, const nb::capsule& owner) {
    static Value no_item{};
    return nb::cast(nb::ndarray<nb::numpy, Value, nb::ndim<3>>(
        static_cast<void*>(items.empty() ? &no_item : items.data()),
        {static_cast<std::size_t>(size[2]), static_cast<std::size_t>(size[1]), static_cast<std::size_t>(size[0])},
        owner));
}

/// q, as floats if these are asked for.
nb::object parts_of(std::vector<double>& q, bool in_floats, const nb::capsule& owner) {
    if (!in_floats) return rows_of<double>(q, owner);
    std::vector<float> floats(q.size());
    std::ranges::transform(q, floats.begin(), as_float_part);
    return nb::cast(array_in<nb::ndarray<nb::numpy, float, nb::ndim<1>>>(std::move(floats), {q.size()}));
}

nb::tuple links(const Body& body, const Grid& grid, const Directions& directions, bool of_faces, bool with_between,
                bool in_floats, nb::object progress) {
    const Call call(std::move(progress));
    const std::span all(reinterpret_cast<const LinkDirection*>(directions.data()), directions.shape(0));
    const LinkOptions options{.hits = of_faces ? Hits::faces : Hits::walls, .with_between = with_between};
    auto own = std::make_unique<Links>(body.read(
        [&](const DistanceTransform& transform) { return transform.links(grid, all, options, call.options()); }));
    Links& links = *own;
    const nb::capsule owner = owner_of(std::move(own));
    auto* const flags = reinterpret_cast<std::uint8_t*>(links.flags.data());
    return nb::make_tuple(triples_of(links.samples, owner), rows_of<std::uint8_t>(links.directions, owner),
                          parts_of(links.q, in_floats, owner), rows_of<std::uint32_t>(links.triangles, owner),
                          rows_of<std::uint32_t>(links.counts, owner),
                          nb::cast(nb::ndarray<nb::numpy, std::uint8_t, nb::ndim<1>>(static_cast<void*>(flags),
                                                                                     {links.flags.size()}, owner)),
                          rows_of<std::uint8_t>(links.inside.bits, owner));
}

std::size_t count_links(const Body& body, const Grid& grid, const Directions& directions, bool of_faces,
                        bool with_between, nb::object progress) {
    const Call call(std::move(progress));
    const std::span all(reinterpret_cast<const LinkDirection*>(directions.data()), directions.shape(0));
    const LinkOptions options{.hits = of_faces ? Hits::faces : Hits::walls, .with_between = with_between};
    return body.read(
        [&](const DistanceTransform& transform) { return transform.count_links(grid, all, options, call.options()); });
}

nb::tuple crossings(const Body& body, const Grid& grid, bool with_counts, nb::object progress) {
    const Call call(std::move(progress));
    auto own = std::make_unique<Crossings>(body.read([&](const DistanceTransform& transform) {
        return transform.crossings(grid, {.with_counts = with_counts}, call.options());
    }));
    Crossings& crossings = *own;
    const nb::capsule owner = owner_of(std::move(own));
    nb::list axes;
    for (EdgeCrossings& edges : crossings.axes)
        axes.append(nb::make_tuple(box_of(edges.coordinates, edges.size, owner),
                                   box_of(edges.triangles, edges.size, owner),
                                   with_counts ? box_of(edges.counts, edges.size, owner) : nb::none()));
    return nb::make_tuple(axes, rows_of<std::uint8_t>(crossings.inside.bits, owner));
}

nb::object stencil_of(const std::string& name, const std::string& code) {
    auto own = std::make_unique<std::vector<LinkDirection>>(stencil(name, code));
    std::vector<LinkDirection>& directions = *own;
    return triples_of(directions, owner_of(std::move(own)));
}

}  // namespace

void add_links(nb::module_& module) {
    module.def(
        "links", &links, nb::arg("body"), nb::arg("grid"), nb::arg("directions"), nb::arg("of_faces"),
        nb::arg("with_between"), nb::arg("in_floats"), nb::arg("progress").none(),
        nb::sig("def links(body: Body, grid: Grid, directions: numpy.typing.NDArray[numpy.int32], of_faces: bool, "
                "with_between: bool, in_floats: bool, progress: object | None) -> tuple[typing.Any, ...]"));
    module.def("count_links", &count_links, nb::arg("body"), nb::arg("grid"), nb::arg("directions"),
               nb::arg("of_faces"), nb::arg("with_between"), nb::arg("progress").none());
    module.def("crossings", &crossings, nb::arg("body"), nb::arg("grid"), nb::arg("with_counts"),
               nb::arg("progress").none(),
               nb::sig("def crossings(body: Body, grid: Grid, with_counts: bool, progress: object | None) -> "
                       "tuple[typing.Any, ...]"));
    module.def("stencil", &stencil_of, nb::arg("name"), nb::arg("code"),
               nb::sig("def stencil(name: str, code: str) -> numpy.typing.NDArray[numpy.int32]"));
}

}  // namespace clsdf::python
