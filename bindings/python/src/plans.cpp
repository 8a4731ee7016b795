#include "body.hpp"

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace clsdf::python {

namespace {

/// The requests of a plan, which keep the arrays that they write to.
struct PlanRequests {
    RequestList list;
    Owner<cuda::Arrays> cuda;  ///< the arrays in memory of CUDA; null if there are none
};

std::unique_ptr<PlanRequests> new_requests(RequestList list, std::unique_ptr<cuda::Arrays> cuda = nullptr) {
    return std::unique_ptr<PlanRequests>(new PlanRequests{std::move(list), Owner<cuda::Arrays>(cuda.release())});
}

/// A plan of the library for Python's threads, which take turns. Its end waits for the runs.
template <typename LibraryPlan>
class TakingTurns {
public:
    explicit TakingTurns(LibraryPlan plan) : plan_(new LibraryPlan(std::move(plan))) {}

    /// Calls the function with the plan, without the GIL.
    template <typename Function>
    auto use(Function function) const {
        const AtWork work(plan_.get(), "plan");
        const nb::gil_scoped_release no_gil;
        const std::lock_guard lock(*mutex_);
        return function(*plan_);
    }

private:
    Owner<LibraryPlan> plan_;
    std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
};

class PyPlan {
public:
    PyPlan(PyDevice device, Plan plan, std::unique_ptr<PlanRequests> requests)
        : device_(std::move(device)), requests_(std::move(requests)), plan_(std::move(plan)) {}

    template <typename Function>
    auto use(Function function) const {
        return plan_.use(std::move(function));
    }

    /// In a function of use() alone: another thread may change them.
    const PlanRequests& requests() const { return *requests_; }
    /// In a function of use(). The caller destroys the former requests after it, with the GIL.
    void swap_requests(std::unique_ptr<PlanRequests>& requests) { requests_.swap(requests); }

    const PyDevice& device() const { return device_; }

private:
    PyDevice device_;
    std::unique_ptr<PlanRequests> requests_;
    TakingTurns<Plan> plan_;  // its runs write to the arrays
};

/// A plan without arrays of its own.
template <class Made>
class PyPlanOf {
public:
    PyPlanOf(PyDevice device, Made plan) : device_(std::move(device)), plan_(std::move(plan)) {}

    template <typename Function>
    auto use(Function function) const {
        return plan_.use(std::move(function));
    }
    const PyDevice& device() const { return device_; }

private:
    PyDevice device_;
    TakingTurns<Made> plan_;
};

using PyPointPlan = PyPlanOf<PointPlan>;
using PySparsePlan = PyPlanOf<SparsePlan>;
using PyLinkPlan = PyPlanOf<LinkPlan>;

PyPlan plan_of_grid(const Body& body, const Grid& grid, const Band& band, const std::vector<std::string>& outputs,
                    nb::object progress) {
    OutputSet wanted;
    for (const std::string& name : outputs) wanted.insert(output_named(name).output);
    const Call call(std::move(progress));
    return PyPlan(body.device(), body.read([&](const DistanceTransform& transform) {
        return transform.plan(grid, band, wanted, call.options());
    }),
                  new_requests(RequestList()));
}

PyPlan plan_of_requests(const Body& body, const RequestList& requests, nb::object progress) {
    Arrays arrays(&body.device());
    const std::vector<Request> boxes = requests_of(requests, arrays);
    const Call call(std::move(progress));
    Plan plan = body.read([&](const DistanceTransform& transform) { return transform.plan(boxes, call.options()); });
    return PyPlan(body.device(), std::move(plan), new_requests(requests, arrays.take_cuda()));
}

/// The streams on which the packages of the requests' arrays work now. With the GIL.
std::vector<void*> streams_of(const RequestList& requests) {
    const nb::object stream_of = nb::module_::import_("clsdf._cuda").attr("stream_of");
    std::vector<void*> streams;
    for (const nb::handle request : requests)
        for (const nb::handle array : nb::cast<nb::dict>(request[2]).values())
            if (is_in_cuda(array)) streams.push_back(std::bit_cast<void*>(nb::cast<std::uintptr_t>(stream_of(array))));
    return streams;
}

/// An event of OpenCL, or none.
class ClEvent {
public:
    ClEvent() = default;
    ClEvent(const ClEvent&) = delete;
    ClEvent& operator=(const ClEvent&) = delete;
    ~ClEvent() {
        if (event_ != nullptr) clReleaseEvent(event_);
    }

    cl_event* put() { return &event_; }
    cl_event get() const { return event_; }
    cl_event release() { return std::exchange(event_, nullptr); }

private:
    cl_event event_ = nullptr;
};

cl_command_queue handle_of(nb::handle queue) {
    return queue.is_none() ? nullptr : std::bit_cast<cl_command_queue>(nb::cast<std::uintptr_t>(queue.attr("int_ptr")));
}

/// run(events, event of the end), after the streams of arrays in memory of CUDA, which wait for it. `shared`: of these
/// arrays; null: there are none. Returns whether there are some.
template <typename Run>
bool run_after_streams(cuda::Arrays* shared, cl_command_queue queue, const std::vector<cl_event>& events, ClEvent& done,
                       const Run& run) {
    if (shared == nullptr) {
        run(events);
        return false;
    }
    try {
        run(shared->begin(queue, events));
        shared->end(done.get());
    } catch (...) {
        shared->abandon();
        throw;
    }
    return true;
}

// The event of the end as a number, which the caller owns; 0 if arrays are in memory of CUDA, whose streams wait for
// it.
std::uintptr_t enqueue(const PyPlan& plan, nb::handle queue, const std::optional<RequestList>& outputs,
                       nb::handle wait_for) {
    const auto own = handle_of(queue);
    const std::vector<cl_event> events = events_of(wait_for);
    Arrays arrays(&plan.device());
    std::vector<OutputTargets> targets;
    if (outputs.has_value()) {
        const std::vector<Index3> sizes = plan.use([](const Plan& of) {
            std::vector<Index3> all;
            for (const Request& request : of.requests()) all.push_back(request.grid.size);
            return all;
        });
        if (sizes.size() != outputs->size())
            refuse("out has the arrays of " + std::to_string(outputs->size()) + " requests; the plan has " +
                   std::to_string(sizes.size()));
        for (std::size_t i = 0; i < sizes.size(); ++i)
            targets.push_back(arrays.outputs(nb::cast<ArraysByName>((*outputs)[i]), shape_of(sizes[i])));
        arrays.place({}, targets);
    }
    const Owner<cuda::Arrays> of_call(arrays.take_cuda().release());
    ClEvent done;
    const bool is_of_cuda = plan.use([&](Plan& of) {
        cuda::Arrays* const shared = outputs.has_value() ? of_call.get() : plan.requests().cuda.get();
        if (shared != nullptr && !outputs.has_value()) {
            const nb::gil_scoped_acquire gil;
            shared->follow(streams_of(plan.requests().list));
        }
        return run_after_streams(shared, own, events, done, [&](std::span<const cl_event> before) {
            if (outputs.has_value())
                of.enqueue(own, targets, before, done.put());
            else
                of.enqueue(own, before, done.put());
        });
    });
    return is_of_cuda ? 0 : std::bit_cast<std::uintptr_t>(done.release());
}

void update(PyPlan& plan, const Body& body, const std::optional<std::vector<Grid>>& grids, nb::object progress) {
    const Call call(std::move(progress));
    body.read([&](const DistanceTransform& transform) {
        const nb::gil_scoped_acquire gil;  // use() releases it again
        plan.use([&](Plan& of) {
            if (grids.has_value())
                of.update(transform, *grids, call.options());
            else
                of.update(transform, call.options());
        });
    });
}

void update_requests(PyPlan& plan, const Body& body, const RequestList& requests, nb::object progress) {
    Arrays arrays(&plan.device());
    const std::vector<Request> boxes = requests_of(requests, arrays);
    std::unique_ptr<PlanRequests> own = new_requests(requests, arrays.take_cuda());
    const Call call(std::move(progress));
    body.read([&](const DistanceTransform& transform) {
        const nb::gil_scoped_acquire gil;
        plan.use([&](Plan& of) {
            of.update(transform, boxes, call.options());
            plan.swap_requests(own);
        });
    });
}

using Room = std::pair<std::size_t, std::size_t>;  // bricks and runs

SparseRequest sparse_request_of(const Grid& grid, const Band& band, const std::vector<std::string>& outputs) {
    SparseRequest request{grid, band, {}};
    for (const std::string& name : outputs) request.outputs.insert(output_named(name).output);
    return request;
}

PySparsePlan sparse_plan(const Body& body, const Grid& grid, const Band& band, const std::vector<std::string>& outputs,
                         const Room& room, nb::object progress) {
    const SparseRequest request = sparse_request_of(grid, band, outputs);
    const Call call(std::move(progress));
    return PySparsePlan(body.device(), body.read([&](const DistanceTransform& transform) {
        return transform.plan_sparse(request, {room.first, room.second}, call.options());
    }));
}

/// An array of the device that a run writes, packed and of one of the types; a buffer of pyopencl has no type and no
/// shape. The result has its place and its type.
InputArray packed(Arrays& arrays, nb::handle array, const std::string& name, const std::vector<std::int64_t>& shape,
                  std::initializer_list<ElementType> types) {
    InputArray place;
    if (nb::hasattr(array, "int_ptr")) {
        place.device = std::bit_cast<cl_mem>(nb::cast<std::uintptr_t>(array.attr("int_ptr")));
        return place;
    }
    const std::string what = "out: the array of '" + name + "'";
    const ArrayView seen = arrays.view(array, what, true);
    if (std::ranges::find(types, seen.type) == types.end())
        refuse(what + " has " + name_of(seen.type) + "; give it " + name_of(*types.begin()));
    if (seen.shape != shape) {
        std::string expected;
        for (const std::int64_t side : shape) expected += (expected.empty() ? "" : ", ") + std::to_string(side);
        refuse(what + " has another shape than the plan has room for; expected (" + expected + ")");
    }
    if (!seen.is_packed()) refuse(what + " is not packed; pass a copy");
    if (seen.device == nullptr && std::ranges::find(shape, 0) == shape.end())
        refuse(what + " is in memory of the host, and a plan writes to the device's; pass an array there");
    place.device = seen.device;
    place.offset = seen.offset;
    place.type = seen.type;
    return place;
}

// The event of the end as a number, which the caller owns; 0 if arrays are in memory of CUDA. out: by the names of
// outputs, and "counts", "bricks" and "inside".
std::uintptr_t enqueue_sparse(const PySparsePlan& plan, nb::handle queue, const ArraysByName& out,
                              nb::handle wait_for) {
    const auto own = handle_of(queue);
    const std::vector<cl_event> events = events_of(wait_for);
    Arrays arrays(&plan.device());
    const SparseCounts room = plan.use([](const SparsePlan& of) { return of.room(); });
    const auto bricks = static_cast<std::int64_t>(room.bricks), runs = static_cast<std::int64_t>(room.runs);
    nb::dict values;
    InputArray of_counts, of_bricks, of_inside;
    const auto integers = {ElementType::int64, ElementType::uint64};
    for (const auto& [key, array] : out) {
        const auto name = nb::cast<std::string>(key);
        if (name == "counts")
            of_counts = packed(arrays, array, name, {3}, integers);
        else if (name == "bricks")
            of_bricks = packed(arrays, array, name, {bricks, 3}, integers);
        else if (name == "inside")
            of_inside = packed(arrays, array, name, {runs, 4}, integers);
        else
            values[key] = array;
    }
    std::vector<OutputTargets> targets{arrays.outputs(nb::cast<ArraysByName>(values), {bricks, 8, 8, 8})};
    for (const OutputTarget& target : targets.front().all())
        if (target.array.strides != ArrayLayout().strides || target.array.block_stride != 0)
            refuse(std::string("out: the array of '") + info_of(target.output).name + "' is not packed; pass a copy");
    arrays.place({&of_counts, &of_bricks, &of_inside}, targets);
    const SparseDeviceTargets to{{of_counts.device, of_counts.offset},
                                 {of_bricks.device, of_bricks.offset},
                                 {of_inside.device, of_inside.offset},
                                 targets.front()};
    const Owner<cuda::Arrays> of_call(arrays.take_cuda().release());
    ClEvent done;
    const bool is_of_cuda = plan.use([&](SparsePlan& of) {
        return run_after_streams(of_call.get(), own, events, done,
                                 [&](std::span<const cl_event> before) { of.enqueue(own, to, before, done.put()); });
    });
    return is_of_cuda ? 0 : std::bit_cast<std::uintptr_t>(done.release());
}

void update_sparse(PySparsePlan& plan, const Body& body, nb::object progress) {
    const Call call(std::move(progress));
    body.read([&](const DistanceTransform& transform) {
        const nb::gil_scoped_acquire gil;  // use() releases it again
        plan.use([&](SparsePlan& of) { of.update(transform, call.options()); });
    });
}

void update_sparse_field(PySparsePlan& plan, const Body& body, const Grid& grid, const Band& band,
                         const std::vector<std::string>& outputs, const Room& room, nb::object progress) {
    const SparseRequest request = sparse_request_of(grid, band, outputs);
    const Call call(std::move(progress));
    body.read([&](const DistanceTransform& transform) {
        const nb::gil_scoped_acquire gil;
        plan.use([&](SparsePlan& of) { of.update(transform, request, {room.first, room.second}, call.options()); });
    });
}

PyPointPlan plan_of_points(const Body& body, std::size_t count, double within, const std::vector<std::string>& outputs,
                           nb::object progress) {
    OutputSet wanted;
    for (const std::string& name : outputs) wanted.insert(output_named(name).output);
    const Call call(std::move(progress));
    return PyPointPlan(body.device(), body.read([&](const DistanceTransform& transform) {
        return transform.plan_points(count, within, wanted, call.options());
    }));
}

/// As enqueue(). status: None, or an array of bytes.
std::uintptr_t enqueue_points(const PyPointPlan& plan, nb::handle queue, nb::handle points, const ArraysByName& outputs,
                              nb::handle status, nb::handle wait_for) {
    const auto own = handle_of(queue);
    const std::vector<cl_event> events = events_of(wait_for);
    Arrays arrays(&plan.device());
    InputArray asked = arrays.triples(points, "points");
    const std::vector<std::int64_t> shape{static_cast<std::int64_t>(asked.count)};
    std::array<OutputTargets, 2> targets{arrays.outputs(outputs, shape)};
    // A byte of each point, as a site is.
    if (!status.is_none()) targets[1] = arrays.output(status, info_of(Output::site), shape);
    arrays.place({&asked}, targets);
    const Owner<cuda::Arrays> of_call(arrays.take_cuda().release());
    ClEvent done;
    const bool is_of_cuda = plan.use([&](PointPlan& of) {
        return run_after_streams(of_call.get(), own, events, done, [&](std::span<const cl_event> before) {
            of.enqueue(own, asked, targets[0], before, done.put(), targets[1][Output::distance]);
        });
    });
    return is_of_cuda ? 0 : std::bit_cast<std::uintptr_t>(done.release());
}

void update_points(PyPointPlan& plan, const Body& body, nb::object progress) {
    const Call call(std::move(progress));
    body.read([&](const DistanceTransform& transform) {
        const nb::gil_scoped_acquire gil;
        plan.use([&](PointPlan& of) { of.update(transform, call.options()); });
    });
}

using Directions = nb::ndarray<const std::int32_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

PyLinkPlan plan_of_links(const Body& body, const Grid& grid, const Directions& directions, std::size_t room,
                         bool of_faces, bool with_between, nb::object progress) {
    const Call call(std::move(progress));
    const std::span all(reinterpret_cast<const LinkDirection*>(directions.data()), directions.shape(0));
    const LinkOptions options{.hits = of_faces ? Hits::faces : Hits::walls, .with_between = with_between};
    return PyLinkPlan(body.device(), body.read([&](const DistanceTransform& transform) {
        return transform.plan_links(grid, all, room, options, call.options());
    }));
}

/// As enqueue_sparse(). out: by the names of LinkTargets, and "count".
std::uintptr_t enqueue_links(const PyLinkPlan& plan, nb::handle queue, const ArraysByName& out, nb::handle wait_for) {
    using enum ElementType;
    const auto own = handle_of(queue);
    const std::vector<cl_event> events = events_of(wait_for);
    Arrays arrays(&plan.device());
    const auto [room, size, fields] = plan.use([](const LinkPlan& of) {
        return std::tuple(of.room(), of.grid().size, static_cast<std::int64_t>(of.directions().size()));
    });
    const auto rows = static_cast<std::int64_t>(room);
    LinkTargets targets{.room = room};
    struct Row {
        const char* name;
        OutputArray& target;
        std::initializer_list<ElementType> types;
        std::vector<std::int64_t> shape;
        InputArray place{};
    };
    const auto in_q = {float64, float32}, in_numbers = {uint32, int32}, in_bytes = {uint8}, in_samples = {int32},
               in_count = {int64, uint64};
    OutputArray of_count;
    std::array<Row, 9> all{{{"samples", targets.samples, in_samples, {rows, 3}},
                            {"directions", targets.directions, in_bytes, {rows}},
                            {"q", targets.q, in_q, {rows}},
                            {"triangles", targets.triangles, in_numbers, {rows}},
                            {"counts", targets.counts, in_numbers, {rows}},
                            {"flags", targets.flags, in_bytes, {rows}},
                            {"inside", targets.inside, in_bytes, {size[2], size[1], size[0]}},
                            {"dense", targets.dense, in_q, {fields, size[2], size[1], size[0]}},
                            {"count", of_count, in_count, {2}}}};
    for (const auto& [key, array] : out) {
        const auto name = nb::cast<std::string>(key);
        const auto row = std::ranges::find(all, name, &Row::name);
        if (row == all.end())
            refuse("out has the array '" + name +
                   "', and a plan of links writes count, samples, directions, q, "
                   "triangles, counts, flags, inside and dense; leave it out");
        row->place = packed(arrays, array, name, row->shape, row->types);
    }
    arrays.place({&all[0].place, &all[1].place, &all[2].place, &all[3].place, &all[4].place, &all[5].place,
                  &all[6].place, &all[7].place, &all[8].place},
                 {});
    for (Row& row : all) {
        row.target = OutputArray(row.place.device, row.place.type);
        row.target.offset = row.place.offset;
    }
    const DeviceRange count{of_count.device, of_count.offset};
    const Owner<cuda::Arrays> of_call(arrays.take_cuda().release());
    ClEvent done;
    const bool is_of_cuda = plan.use([&](LinkPlan& of) {
        return run_after_streams(of_call.get(), own, events, done, [&](std::span<const cl_event> before) {
            of.enqueue(own, targets, count, before, done.put());
        });
    });
    return is_of_cuda ? 0 : std::bit_cast<std::uintptr_t>(done.release());
}

void update_links(PyLinkPlan& plan, const Body& body, const Grid& grid, std::size_t room, nb::object progress) {
    const Call call(std::move(progress));
    body.read([&](const DistanceTransform& transform) {
        const nb::gil_scoped_acquire gil;
        plan.use([&](LinkPlan& of) { of.update(transform, grid, room, call.options()); });
    });
}

}  // namespace

void add_plans(nb::module_& module) {
    nb::class_<PyPlan>(module, "PlanOfBoxes", "A Plan of the library; clsdf.Plan is its Python face.")
        .def("enqueue", &enqueue, nb::arg("queue").none(), nb::arg("outputs").none(), nb::arg("wait_for").none())
        .def("update", &update, nb::arg("body"), nb::arg("grids").none(), nb::arg("progress").none())
        .def("update_requests", &update_requests, nb::arg("body"), nb::arg("requests"), nb::arg("progress").none())
        .def_prop_ro(
            "sign",
            [](const PyPlan& plan) { return std::string(name_of(plan.use([](const Plan& of) { return of.sign(); }))); })
        .def_prop_ro(
            "device_bytes",
            [](const PyPlan& plan) { return plan.use([](const Plan& of) { return of.statistics().device_bytes; }); })
        .def_prop_ro("device", [](const PyPlan& plan) { return plan.device(); });
    nb::class_<PySparsePlan>(module, "PlanOfBricks",
                             "A SparsePlan of the library; clsdf.SparsePlan is its Python face.")
        .def("enqueue", &enqueue_sparse, nb::arg("queue").none(), nb::arg("out"), nb::arg("wait_for").none())
        .def("update", &update_sparse, nb::arg("body"), nb::arg("progress").none())
        .def("update_field", &update_sparse_field, nb::arg("body"), nb::arg("grid"), nb::arg("band"),
             nb::arg("outputs"), nb::arg("room"), nb::arg("progress").none())
        .def_prop_ro("room",
                     [](const PySparsePlan& plan) {
                         const SparseCounts room = plan.use([](const SparsePlan& of) { return of.room(); });
                         return Room(room.bricks, room.runs);
                     })
        .def_prop_ro(
            "grid",
            [](const PySparsePlan& plan) { return plan.use([](const SparsePlan& of) { return of.request().grid; }); })
        .def_prop_ro(
            "band",
            [](const PySparsePlan& plan) { return plan.use([](const SparsePlan& of) { return of.request().band; }); })
        .def_prop_ro("outputs",
                     [](const PySparsePlan& plan) {
                         const OutputSet outputs =
                             plan.use([](const SparsePlan& of) { return of.request().outputs | Output::distance; });
                         std::vector<std::string> names;
                         for (const OutputInfo& info : output_table())
                             if (outputs.contains(info.output)) names.emplace_back(info.name);
                         return names;
                     })
        .def_prop_ro("sign",
                     [](const PySparsePlan& plan) {
                         return std::string(name_of(plan.use([](const SparsePlan& of) { return of.sign(); })));
                     })
        .def_prop_ro("device_bytes", [](const PySparsePlan& plan) {
            return plan.use([](const SparsePlan& of) { return of.statistics().device_bytes; });
        });
    module.def("sparse_plan", &sparse_plan, nb::arg("body"), nb::arg("grid"), nb::arg("band"), nb::arg("outputs"),
               nb::arg("room"), nb::arg("progress").none());
    nb::class_<PyLinkPlan>(module, "PlanOfLinks", "A LinkPlan of the library; clsdf.LinkPlan is its Python face.")
        .def("enqueue", &enqueue_links, nb::arg("queue").none(), nb::arg("out"), nb::arg("wait_for").none())
        .def("update", &update_links, nb::arg("body"), nb::arg("grid"), nb::arg("room"), nb::arg("progress").none())
        .def_prop_ro("room",
                     [](const PyLinkPlan& plan) { return plan.use([](const LinkPlan& of) { return of.room(); }); })
        .def_prop_ro(
            "grid", [](const PyLinkPlan& plan) { return plan.use([](const LinkPlan& of) { return Grid(of.grid()); }); })
        .def_prop_ro("sign",
                     [](const PyLinkPlan& plan) {
                         return std::string(name_of(plan.use([](const LinkPlan& of) { return of.sign(); })));
                     })
        .def_prop_ro("device_bytes", [](const PyLinkPlan& plan) {
            return plan.use([](const LinkPlan& of) { return of.statistics().device_bytes; });
        });
    module.def("plan_of_links", &plan_of_links, nb::arg("body"), nb::arg("grid"), nb::arg("directions"),
               nb::arg("room"), nb::arg("of_faces"), nb::arg("with_between"), nb::arg("progress").none(),
               nb::sig("def plan_of_links(body: Body, grid: Grid, directions: numpy.typing.NDArray[numpy.int32], "
                       "room: int, of_faces: bool, with_between: bool, progress: object | None) -> PlanOfLinks"));
    nb::class_<PyPointPlan>(module, "PlanOfPoints", "A PointPlan of the library; clsdf.PointPlan is its Python face.")
        .def("enqueue", &enqueue_points, nb::arg("queue").none(), nb::arg("points"), nb::arg("outputs"),
             nb::arg("status").none(), nb::arg("wait_for").none())
        .def("update", &update_points, nb::arg("body"), nb::arg("progress").none())
        .def_prop_ro("sign",
                     [](const PyPointPlan& plan) {
                         return std::string(name_of(plan.use([](const PointPlan& of) { return of.sign(); })));
                     })
        .def_prop_ro("count",
                     [](const PyPointPlan& plan) { return plan.use([](const PointPlan& of) { return of.count(); }); })
        .def_prop_ro("device_bytes",
                     [](const PyPointPlan& plan) {
                         return plan.use([](const PointPlan& of) { return of.statistics().device_bytes; });
                     })
        .def_prop_ro("device", [](const PyPointPlan& plan) { return plan.device(); });
    module.def("plan_of_points", &plan_of_points, nb::arg("body"), nb::arg("count"), nb::arg("within"),
               nb::arg("outputs"), nb::arg("progress").none());
    module.def("plan_of_grid", &plan_of_grid, nb::arg("body"), nb::arg("grid"), nb::arg("band"), nb::arg("outputs"),
               nb::arg("progress").none());
    module.def("plan_of_requests", &plan_of_requests, nb::arg("body"), nb::arg("requests"), nb::arg("progress").none());
}

}  // namespace clsdf::python
