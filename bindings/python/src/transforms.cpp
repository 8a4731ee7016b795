#include "body.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace clsdf::python {

thread_local const AtWork* AtWork::current = nullptr;

namespace {

Body make(const PyDevice& device, nb::handle vertices, nb::handle faces, const std::string& sign,
          std::optional<std::size_t> kept_bytes, std::optional<double> floor, bool is_outer, bool is_silent) {
    Arrays arrays(&device);
    InputArray positions = arrays.triples(vertices, "vertices"), triangles = arrays.triples(faces, "faces");
    arrays.place({&positions, &triangles}, {});
    const MeshView mesh(positions, triangles);
    Call call;
    if (is_silent) call.mute();
    TransformOptions options;
    options.sign = sign_named(sign);
    options.kept_bytes = kept_bytes;
    options.floor = floor;
    options.surface = is_outer ? Surface::outer : Surface::given;
    const Device& own = device.get();
    arrays.begin();
    auto made = [&] {
        const nb::gil_scoped_release no_gil;
        return Body(device, DistanceTransform(own, mesh, options, call.options()));
    }();
    arrays.end();
    return made;
}

void compute(const Body& body, const Grid& grid, const Band& band, const ArraysByName& outputs, nb::object progress,
             nb::handle wait_for) {
    Arrays arrays(&body.device());
    OutputTargets targets = arrays.outputs(outputs, shape_of(grid.size));
    arrays.place({}, {&targets, 1});
    const Call call(std::move(progress), wait_for);
    arrays.begin();
    body.read([&](const DistanceTransform& transform) { transform.compute(grid, band, targets, call.options()); });
    arrays.end();
}

void compute_many(const Body& body, const RequestList& requests, nb::object progress, nb::handle wait_for) {
    Arrays arrays(&body.device());
    const std::vector<Request> boxes = requests_of(requests, arrays);
    const Call call(std::move(progress), wait_for);
    arrays.begin();
    body.read([&](const DistanceTransform& transform) { transform.compute(boxes, call.options()); });
    arrays.end();
}

std::size_t plan_bytes(const Body& body, const RequestList& requests, nb::object progress) {
    Arrays arrays(&body.device());
    const std::vector<Request> boxes = requests_of(requests, arrays);
    const Call call(std::move(progress));
    return body.read([&](const DistanceTransform& transform) { return transform.plan_bytes(boxes, call.options()); });
}

void compute_blocks(const Body& body, const Grid& lattice, const Band& band, const Index3& size,
                    const std::vector<Index3>& first, const ArraysByName& outputs, nb::object progress,
                    nb::handle wait_for) {
    Arrays arrays(&body.device());
    BlockSet blocks = blocks_of(lattice, band, size, first, outputs, arrays);
    arrays.place({}, {&blocks.targets, 1});
    const Call call(std::move(progress), wait_for);
    arrays.begin();
    body.read([&](const DistanceTransform& transform) { transform.compute(blocks, call.options()); });
    arrays.end();
}

void query(const Body& body, nb::handle points, double within, const ArraysByName& outputs, nb::object progress,
           nb::handle wait_for, bool refuse_unusable_points) {
    Arrays arrays(&body.device());
    InputArray asked = arrays.triples(points, "points");
    OutputTargets targets = arrays.outputs(outputs, {static_cast<std::int64_t>(asked.count)});
    arrays.place({&asked}, {&targets, 1});
    Call call(std::move(progress), wait_for);
    call.refuse_unusable_points(refuse_unusable_points);
    arrays.begin();
    body.read([&](const DistanceTransform& transform) { transform.query(asked, within, targets, call.options()); });
    arrays.end();
}

void winding(const Body& body, nb::handle points, nb::handle results, nb::handle wait_for) {
    Arrays arrays(&body.device());
    InputArray asked = arrays.triples(points, "points");
    OutputTargets written = arrays.output(results, info_of(Output::distance), {static_cast<std::int64_t>(asked.count)});
    arrays.place({&asked}, {&written, 1});
    const Call call(nb::none(), wait_for);
    arrays.begin();
    body.read([&](const DistanceTransform& transform) {
        transform.winding(asked, written[Output::distance], call.options());
    });
    arrays.end();
}

/// An array of the host for results, packed, or None. What it has to be like, the library says.
OutputArray result_of(Arrays& arrays, nb::handle array, const char* name) {
    OutputArray result;
    if (array.is_none()) return result;
    const ArrayView seen = arrays.view(array, name, true);
    result.host = seen.writable;
    result.device = seen.device;
    result.type = seen.type;
    result.offset = seen.offset;
    return result;
}

Hits hits_named(const std::string& name) {
    if (name == "walls") return Hits::walls;
    if (name == "faces") return Hits::faces;
    throw Error(ErrorCode::invalid_argument, "hits: '" + name + "' is neither 'walls' nor 'faces'");
}

void rays(const Body& body, nb::handle origins, nb::handle directions, const std::string& hits, double limit,
          std::size_t most, nb::handle t, nb::handle triangle, nb::handle counts, nb::handle any, nb::object progress,
          bool refuse_unusable_points) {
    Arrays arrays(&body.device());
    const InputArray from = arrays.triples(origins, "origins"), along = arrays.triples(directions, "directions");
    const RayTargets targets{most, result_of(arrays, t, "t"), result_of(arrays, triangle, "triangle"),
                             result_of(arrays, counts, "counts"), result_of(arrays, any, "any")};
    const RayOptions options{hits_named(hits), limit};
    Call call(std::move(progress));
    call.refuse_unusable_points(refuse_unusable_points);
    body.read(
        [&](const DistanceTransform& transform) { transform.rays(from, along, options, targets, call.options()); });
}

void visible(const Body& body, nb::handle from, nb::handle to, const std::string& hits, nb::handle results,
             nb::object progress, bool refuse_unusable_points) {
    Arrays arrays(&body.device());
    const InputArray first = arrays.triples(from, "from_points"), second = arrays.triples(to, "to_points");
    const OutputArray result = result_of(arrays, results, "visible");
    const Hits what = hits_named(hits);
    Call call(std::move(progress));
    call.refuse_unusable_points(refuse_unusable_points);
    body.read(
        [&](const DistanceTransform& transform) { transform.visible(first, second, result, what, call.options()); });
}

Body restrict_to(const Body& body, const std::vector<std::tuple<Vec3, Vec3, double, double>>& regions, double margin) {
    std::vector<Region> all;
    all.reserve(regions.size());
    for (const auto& [lower, upper, half_width, spacing] : regions)
        all.push_back({Box{lower, upper}, half_width, spacing});
    return Body(body.device(),
                body.read([&](const DistanceTransform& whole) { return whole.restrict_to(all, margin); }));
}

auto part_vertices(const Body& body) {
    std::vector<std::uint32_t> numbers =
        body.read([](const DistanceTransform& transform) { return transform.part_vertices(); });
    const std::size_t count = numbers.size();
    return array_in<nb::ndarray<nb::numpy, std::uint32_t, nb::ndim<1>>>(std::move(numbers), {count});
}

nb::bytes part_bytes(const Body& body) {
    const std::vector<std::byte> bytes =
        body.read([](const DistanceTransform& transform) { return transform.part_bytes(); });
    return nb::bytes(bytes.data(), bytes.size());
}

Body of_part(const PyDevice& device, const nb::bytes& part, std::optional<std::size_t> kept_bytes) {
    check_process();
    const std::span bytes(static_cast<const std::byte*>(part.data()), part.size());
    const nb::gil_scoped_release no_gil;
    return Body(device, DistanceTransform::from_part(device.get(), bytes, kept_bytes));
}

std::size_t prepared_bytes(const Body& body) {
    return body.read([](const DistanceTransform& transform) { return transform.prepared_bytes(); });
}

using SharedBytes = nb::ndarray<std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using ReadBytes = nb::ndarray<const std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

void share(const Body& body, const SharedBytes& memory) {
    const std::span bytes(reinterpret_cast<std::byte*>(memory.data()), memory.shape(0));
    body.read([&](const DistanceTransform& transform) { transform.share(bytes); });
}

// The memory must outlive the body and its plans.
Body of_shared(const PyDevice& device, const ReadBytes& memory, std::optional<std::size_t> kept_bytes) {
    check_process();
    const std::span bytes(reinterpret_cast<const std::byte*>(memory.data()), memory.shape(0));
    const nb::gil_scoped_release no_gil;
    return Body(device, DistanceTransform::from_shared(device.get(), bytes, kept_bytes));
}

void set_positions(Body& body, nb::handle positions, nb::handle wait_for) {
    Arrays arrays(&body.device());
    InputArray vertices = arrays.triples(positions, "positions");
    arrays.place({&vertices}, {});
    const Call call(nb::none(), wait_for);
    arrays.begin();
    body.change([&](DistanceTransform& transform) { transform.set_positions(vertices, call.options()); });
    arrays.end();
}

void set_motion(Body& body, const std::array<Vec3, 3>& rotation, const Vec3& translation) {
    body.change([&](DistanceTransform& transform) { transform.set_motion(rotation, translation); });
}

using Matrix = std::array<Vec3, 3>;

Matrix rotation_near(const Matrix& matrix) {
    std::array<double, 16> pose{};
    for (std::size_t row = 0; row < 3; ++row) std::ranges::copy(matrix[row], pose.begin() + 4 * row);
    pose.back() = 1;
    return pose_of(pose).rotation;
}

// The positions R x + t, with the roundings of DistanceTransform::set_motion().
auto moved(nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu> first, const Matrix& r,
           const Vec3& t) {
    std::vector<Vec3> positions(first.shape(0));
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const double* const x = first.data() + 3 * i;
        for (std::size_t a = 0; a < 3; ++a)
            positions[i][a] = std::fma(r[a][0], x[0], std::fma(r[a][1], x[1], std::fma(r[a][2], x[2], t[a])));
    }
    const std::size_t rows = positions.size();
    return array_in<nb::ndarray<nb::numpy, double, nb::shape<-1, 3>>>(std::move(positions), {rows, 3});
}

bool compile(const Body& body, const Grid& grid, const Band& band, const std::vector<std::string>& outputs,
             nb::object progress) {
    OutputSet wanted;
    for (const std::string& name : outputs) wanted.insert(output_named(name).output);
    const Call call(std::move(progress));
    return body.read([&](const DistanceTransform& transform) {
        return transform.compile(grid, band, wanted, call.options()).first_use;
    });
}

}  // namespace

SignRule sign_named(const std::string& name) {
    return value_named("sign", name,
                       {SignRule::automatic, SignRule::nonzero, SignRule::parity, SignRule::solid_angle,
                        SignRule::below, SignRule::none});
}

std::vector<Request> requests_of(const RequestList& requests, Arrays& arrays) {
    std::vector<Request> boxes;
    for (const nb::handle item : requests) {
        const std::string name = "request " + std::to_string(boxes.size());
        nb::tuple parts;
        const Grid* grid = nullptr;
        const Band* band = nullptr;
        ArraysByName outputs;
        if (!nb::try_cast(item, parts) || parts.size() != 3 || !nb::try_cast(parts[0], grid) ||
            !nb::try_cast(parts[1], band) || !nb::try_cast(parts[2], outputs) || grid == nullptr || band == nullptr)
            refuse(name + " is " + nb::cast<std::string>(nb::repr(item)).substr(0, 200) +
                   "; expected (clsdf.Grid, clsdf.Band, {output: array})");
        try {
            boxes.push_back({*grid, *band, arrays.outputs(outputs, shape_of(grid->size))});
        } catch (const Error& error) {
            throw Error(error.code(), name + ": " + error.what());
        }
    }
    arrays.place(boxes);
    return boxes;
}

BlockSet blocks_of(const Grid& lattice, const Band& band, const Index3& size, const std::vector<Index3>& first,
                   const ArraysByName& outputs, Arrays& arrays) {
    std::vector<std::int64_t> shape = shape_of(size);
    shape.insert(shape.begin(), static_cast<std::int64_t>(first.size()));
    return {lattice, band, size, first, arrays.outputs(outputs, shape)};
}

void add_transforms(nb::module_& module) {
    nb::class_<Body>(module, "Body", "A DistanceTransform of the library; clsdf.Transform is its Python face.")
        .def("compute", &compute, nb::arg("grid"), nb::arg("band"), nb::arg("outputs"), nb::arg("progress").none(),
             nb::arg("wait_for").none())
        .def("compute_many", &compute_many, nb::arg("requests"), nb::arg("progress").none(), nb::arg("wait_for").none())
        .def("plan_bytes", &plan_bytes, nb::arg("requests"), nb::arg("progress").none())
        .def("compute_blocks", &compute_blocks, nb::arg("lattice"), nb::arg("band"), nb::arg("size"), nb::arg("first"),
             nb::arg("outputs"), nb::arg("progress").none(), nb::arg("wait_for").none())
        .def("query", &query, nb::arg("points"), nb::arg("within"), nb::arg("outputs"), nb::arg("progress").none(),
             nb::arg("wait_for").none(), nb::arg("refuse_unusable_points"))
        .def("winding", &winding, nb::arg("points"), nb::arg("results"), nb::arg("wait_for").none())
        .def("rays", &rays, nb::arg("origins"), nb::arg("directions"), nb::arg("hits"), nb::arg("limit"),
             nb::arg("most"), nb::arg("t").none(), nb::arg("triangle").none(), nb::arg("counts").none(),
             nb::arg("any").none(), nb::arg("progress").none(), nb::arg("refuse_unusable_points"))
        .def("visible", &visible, nb::arg("first"), nb::arg("second"), nb::arg("hits"), nb::arg("results"),
             nb::arg("progress").none(), nb::arg("refuse_unusable_points"))
        .def("classify", &classify<DistanceTransform>, nb::arg("boxes"), nb::arg("half_width"))
        .def("restrict_to", &restrict_to, nb::arg("regions"), nb::arg("margin"))
        .def("part_vertices", &part_vertices)
        .def("part_bytes", &part_bytes)
        .def("prepared_bytes", &prepared_bytes)
        .def("share", &share, nb::arg("memory"))
        .def("set_positions", &set_positions, nb::arg("positions"), nb::arg("wait_for").none())
        .def("set_motion", &set_motion, nb::arg("rotation"), nb::arg("translation"))
        .def("compile", &compile, nb::arg("grid"), nb::arg("band"), nb::arg("outputs"), nb::arg("progress").none())
        .def_prop_ro("box",
                     [](const Body& body) {
                         const Box box = body.read([](const DistanceTransform& transform) { return transform.box(); });
                         return std::pair(box.lower, box.upper);
                     })
        .def_prop_ro("topology",
                     [](const Body& body) {
                         return body.read([](const DistanceTransform& transform) { return transform.topology(); });
                     })
        .def_prop_ro("sign",
                     [](const Body& body) {
                         return std::string(
                             name_of(body.read([](const DistanceTransform& transform) { return transform.sign(); })));
                     })
        .def_prop_ro(
            "floor",
            [](const Body& body) { return body.read([](const DistanceTransform& whole) { return whole.floor(); }); })
        .def_prop_ro("mesh_name",
                     [](const Body& body) {
                         return body.read([](const DistanceTransform& whole) { return whole.mesh_name(); });
                     })
        .def_prop_ro("memory",
                     [](const Body& body) {
                         const KeptMemory kept =
                             body.read([](const DistanceTransform& transform) { return transform.memory(); });
                         return std::pair(kept.host_bytes, kept.device_bytes);
                     })
        .def_prop_ro("shared_memory",
                     [](const Body& body) {
                         const KeptMemory kept =
                             body.read([](const DistanceTransform& transform) { return transform.memory(); });
                         return std::pair(kept.shared_host_bytes, kept.shared_device_bytes);
                     })
        .def_prop_ro("device", [](const Body& body) { return body.device(); });
    module.def("make_body", &make, nb::arg("device"), nb::arg("vertices"), nb::arg("faces"), nb::arg("sign"),
               nb::arg("kept_bytes").none(), nb::arg("floor").none() = nb::none(), nb::arg("is_outer") = false,
               nb::arg("is_silent") = false);
    module.def("of_part", &of_part, nb::arg("device"), nb::arg("part"), nb::arg("kept_bytes").none());
    module.def("of_shared", &of_shared, nb::arg("device"), nb::arg("memory"), nb::arg("kept_bytes").none());
    module.def("rotation_near", &rotation_near, nb::arg("matrix"), "The rotation that was rounded to floats.");
    module.def("moved", &moved, nb::arg("first"), nb::arg("rotation"), nb::arg("translation"),
               "The positions rotation @ x + translation, as a transform has them.");
    module.def(
        "slabs_of", [](const Grid& grid) { return DistanceTransform::slabs_of(grid); }, nb::arg("grid"),
        "The parts in which a large field is computed: whole slices, in the order of z.");
}

}  // namespace clsdf::python
