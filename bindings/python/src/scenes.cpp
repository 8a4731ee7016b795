#include "body.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace clsdf::python {

namespace {

/// Rows of R and t.
using Poses = nb::ndarray<const double, nb::shape<-1, 3, 4>, nb::c_contig, nb::device::cpu>;
using Pairs = nb::ndarray<const std::uint32_t, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu>;
using Numbers = nb::ndarray<const std::uint32_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

std::vector<Pose> poses_of(const Poses& rows) {
    std::vector<Pose> poses(rows.shape(0));
    const double* at = rows.data();
    for (Pose& pose : poses)
        for (std::size_t row = 0; row < 3; ++row, at += 4) {
            std::copy_n(at, 3, pose.rotation[row].begin());
            pose.translation[row] = at[3];
        }
    return poses;
}

Pose pose_or_none(const std::optional<Poses>& rows) {
    return rows ? poses_of(*rows).front() : Pose{};
}

/// An array that is written to, of the host and packed; empty for None.
template <typename Item>
std::span<Item> items_of(Arrays& arrays, nb::handle array, const char* name, ElementType type, std::size_t count) {
    if (array.is_none()) return {};
    const std::string what = std::string("out: the array of '") + name + "'";
    const ArrayView seen = arrays.view(array, what, true);
    if (seen.host == nullptr || seen.type != type || !seen.is_packed())
        refuse(what + " is not a packed array of " + name_of(type) + " in memory of the host");
    if (seen.shape != std::vector{static_cast<std::int64_t>(count)})
        refuse(what + " has another number of items than the " + std::to_string(count) + " points");
    return {static_cast<Item*>(seen.writable), count};
}

std::uint32_t add(Bodies& bodies, nb::handle vertices, nb::handle faces, const std::optional<Poses>& pose,
                  const std::string& sign) {
    Arrays arrays(&bodies.device());
    InputArray positions = arrays.triples(vertices, "vertices"), triangles = arrays.triples(faces, "faces");
    arrays.place({&positions, &triangles}, {});
    const SignRule rule = sign_named(sign);
    const Pose at = pose_or_none(pose);
    const Call call;
    arrays.begin();
    const std::uint32_t number = bodies.change(
        [&](Scene& scene) { return scene.add(MeshView(positions, triangles), at, rule, call.options()); });
    arrays.end();
    return number;
}

std::uint32_t add_instance(Bodies& bodies, std::uint32_t of, const std::optional<Poses>& pose) {
    const Pose at = pose_or_none(pose);
    return bodies.change([&](Scene& scene) { return scene.add_instance(of, at); });
}

void set_poses(Bodies& bodies, const Poses& rows, const std::optional<Numbers>& numbers) {
    const std::vector<Pose> poses = poses_of(rows);
    bodies.change([&](Scene& scene) {
        if (numbers)
            scene.set_poses(std::span(numbers->data(), numbers->size()), poses);
        else
            scene.set_poses(poses);
    });
}

void set_positions(Bodies& bodies, std::uint32_t body, nb::handle positions) {
    Arrays arrays(&bodies.device());
    InputArray vertices = arrays.triples(positions, "positions");
    arrays.place({&vertices}, {});
    const Call call;
    arrays.begin();
    bodies.change([&](Scene& scene) { scene.set_positions(body, vertices, call.options()); });
    arrays.end();
}

void compute(const Bodies& bodies, const Grid& grid, const Band& band, const ArraysByName& outputs, nb::object progress,
             nb::handle wait_for) {
    Arrays arrays(&bodies.device());
    OutputTargets targets = arrays.outputs(outputs, shape_of(grid.size));
    arrays.place({}, {&targets, 1});
    const Call call(std::move(progress), wait_for);
    arrays.begin();
    bodies.read([&](const Scene& scene) { scene.compute(grid, band, targets, call.options()); });
    arrays.end();
}

void query(const Bodies& bodies, nb::handle points, double within, const ArraysByName& outputs, nb::handle is_own,
           nb::object progress, nb::handle wait_for, bool refuse_unusable_points) {
    Arrays arrays(&bodies.device());
    InputArray asked = arrays.triples(points, "points");
    SceneTargets targets{arrays.outputs(outputs, {static_cast<std::int64_t>(asked.count)})};
    targets.is_own = items_of<std::uint8_t>(arrays, is_own, "is_own", ElementType::uint8, asked.count);
    arrays.place({&asked}, {&targets.outputs, 1});
    Call call(std::move(progress), wait_for);
    call.refuse_unusable_points(refuse_unusable_points);
    arrays.begin();
    bodies.read([&](const Scene& scene) { scene.query(asked, within, targets, call.options()); });
    arrays.end();
}

/// poses: of all bodies for each configuration, one after the other.
void query_poses(const Bodies& bodies, nb::handle points, const Poses& poses, double within,
                 const ArraysByName& outputs, nb::handle is_own, nb::object progress, bool refuse_unusable_points) {
    const std::vector<Pose> all = poses_of(poses);
    const std::size_t count = bodies.read([](const Scene& scene) { return scene.size(); });
    Arrays arrays(&bodies.device());
    InputArray asked = arrays.triples(points, "points");
    const std::size_t results = count == 0 ? 0 : all.size() / count * asked.count;
    SceneTargets targets{arrays.outputs(outputs, {static_cast<std::int64_t>(results)})};
    targets.is_own = items_of<std::uint8_t>(arrays, is_own, "is_own", ElementType::uint8, results);
    arrays.place({&asked}, {&targets.outputs, 1});
    Call call(std::move(progress));
    call.refuse_unusable_points(refuse_unusable_points);
    arrays.begin();
    bodies.read([&](const Scene& scene) { scene.query_poses(asked, all, within, targets, call.options()); });
    arrays.end();
}

void query_pairs(const Bodies& bodies, nb::handle points, const Pairs& pairs, double within,
                 const ArraysByName& outputs, nb::object progress, bool refuse_unusable_points) {
    Arrays arrays(&bodies.device());
    InputArray asked = arrays.triples(points, "points");
    OutputTargets targets = arrays.outputs(outputs, {static_cast<std::int64_t>(pairs.shape(0))});
    arrays.place({&asked}, {&targets, 1});
    Call call(std::move(progress));
    call.refuse_unusable_points(refuse_unusable_points);
    static_assert(sizeof(PointOfBody) == 2 * sizeof(std::uint32_t) &&
                  offsetof(PointOfBody, body) == sizeof(std::uint32_t));
    const std::span all(reinterpret_cast<const PointOfBody*>(pairs.data()), pairs.shape(0));
    arrays.begin();
    bodies.read([&](const Scene& scene) { scene.query_pairs(asked, all, within, targets, call.options()); });
    arrays.end();
}

void contains(const Bodies& bodies, nb::handle points, nb::handle results) {
    Arrays arrays(&bodies.device());
    InputArray asked = arrays.triples(points, "points");
    const auto is_inside = items_of<std::uint8_t>(arrays, results, "contains", ElementType::uint8, asked.count);
    arrays.place({&asked}, {});
    const Call call;
    arrays.begin();
    bodies.read([&](const Scene& scene) { scene.contains(asked, is_inside, call.options()); });
    arrays.end();
}

void winding(const Bodies& bodies, nb::handle points, nb::handle results) {
    Arrays arrays(&bodies.device());
    InputArray asked = arrays.triples(points, "points");
    const auto sums = items_of<double>(arrays, results, "winding", ElementType::float64, asked.count);
    arrays.place({&asked}, {});
    const Call call;
    arrays.begin();
    bodies.read([&](const Scene& scene) { scene.winding(asked, sums, call.options()); });
    arrays.end();
}

auto outer_of(const Bodies& bodies) {
    const Call call;
    SceneSurface found = bodies.read([&](const Scene& scene) { return scene.outer(call.options()); });
    const std::size_t count = found.bodies.size();
    auto numbers = array_in<nb::ndarray<nb::numpy, std::uint32_t, nb::shape<-1>>>(std::move(found.bodies), {count});
    return nb::make_tuple(tuple_of(std::move(found.surface)), numbers);
}

/// A property of the scene, or of a body by its number.
template <auto member, typename... Number>
auto read(const Bodies& bodies, Number... body) {
    return bodies.read([&](const Scene& scene) { return (scene.*member)(body...); });
}

}  // namespace

void add_scenes(nb::module_& module) {
    nb::class_<Bodies>(module, "Bodies", "A Scene of the library; clsdf.Scene is its Python face.")
        .def("add", &add, nb::arg("vertices"), nb::arg("faces"), nb::arg("pose").none(), nb::arg("sign"))
        .def("add_instance", &add_instance, nb::arg("of"), nb::arg("pose").none())
        .def("set_poses", &set_poses, nb::arg("poses"), nb::arg("bodies").none())
        .def("set_positions", &set_positions, nb::arg("body"), nb::arg("positions"))
        .def(
            "set_active",
            [](Bodies& bodies, std::uint32_t body, bool is_active) {
                bodies.change([&](Scene& scene) { scene.set_active(body, is_active); });
            },
            nb::arg("body"), nb::arg("is_active"))
        .def("compute", &compute, nb::arg("grid"), nb::arg("band"), nb::arg("outputs"), nb::arg("progress").none(),
             nb::arg("wait_for").none())
        .def("query", &query, nb::arg("points"), nb::arg("within"), nb::arg("outputs"), nb::arg("is_own").none(),
             nb::arg("progress").none(), nb::arg("wait_for").none(), nb::arg("refuse_unusable_points"))
        .def("query_poses", &query_poses, nb::arg("points"), nb::arg("poses"), nb::arg("within"), nb::arg("outputs"),
             nb::arg("is_own").none(), nb::arg("progress").none(), nb::arg("refuse_unusable_points"))
        .def("query_pairs", &query_pairs, nb::arg("points"), nb::arg("pairs"), nb::arg("within"), nb::arg("outputs"),
             nb::arg("progress").none(), nb::arg("refuse_unusable_points"))
        .def("contains", &contains, nb::arg("points"), nb::arg("results"))
        .def("winding", &winding, nb::arg("points"), nb::arg("results"))
        .def("classify", &classify<Scene>, nb::arg("boxes"), nb::arg("half_width"))
        .def("outer", &outer_of,
             nb::sig("def outer(self) -> tuple[tuple[typing.Any, ...], numpy.typing.NDArray[numpy.uint32]]"))
        .def("size", &read<&Scene::size>)
        .def("is_active", &read<&Scene::is_active, std::uint32_t>, nb::arg("body"))
        .def(
            "pose",
            [](const Bodies& bodies, std::uint32_t body) {
                const Pose pose = read<&Scene::pose>(bodies, body);
                return std::pair(pose.rotation, pose.translation);
            },
            nb::arg("body"))
        .def(
            "sign",
            [](const Bodies& bodies, std::uint32_t body) {
                return std::string(name_of(bodies.read([&](const Scene& scene) { return scene.sign(body); })));
            },
            nb::arg("body"))
        .def_prop_ro("has_sign", [](const Bodies& bodies) { return read<&Scene::has_sign>(bodies); })
        .def_prop_ro("field_sign",
                     [](const Bodies& bodies) {
                         return std::string(name_of(bodies.read([](const Scene& scene) { return scene.sign(); })));
                     })
        .def_prop_ro("box",
                     [](const Bodies& bodies) {
                         const Box box = read<&Scene::box>(bodies);
                         return std::pair(box.lower, box.upper);
                     })
        .def_prop_ro("memory",
                     [](const Bodies& bodies) {
                         const KeptMemory kept = read<&Scene::memory>(bodies);
                         return std::pair(kept.host_bytes, kept.device_bytes);
                     })
        .def_prop_ro("device", [](const Bodies& bodies) { return bodies.device(); });
    module.def(
        "make_bodies",
        [](const PyDevice& device, std::optional<std::size_t> kept_bytes, bool is_outer) {
            return Bodies(device, Scene(device.get(), {kept_bytes, is_outer ? Surface::outer : Surface::given}));
        },
        nb::arg("device"), nb::arg("kept_bytes").none(), nb::arg("is_outer"));
}

}  // namespace clsdf::python
