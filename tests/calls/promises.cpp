#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"
#include "support/throws.hpp"

#include <clsdf/papers.hpp>
#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <new>
#include <set>
#include <string>
#include <thread>
#include <vector>

// Promises of distance_transform.hpp that belong to no one part of it.

using namespace clsdf;
using namespace clsdf::test;

namespace {

const Mesh& noisy_sphere() {
    static const Mesh mesh = [] {
        Random random(8);
        return random_sphere(random, "sphere4", 0.1);
    }();
    return mesh;
}

const Grid& grid() {
    static const Grid around = grid_around(noisy_sphere(), 40, 3);
    return around;
}

Band band() {
    return Band::symmetric(3 * grid().voxel());
}

struct Stop {};

/// The name of what an action throws.
std::string thrown_by(const std::function<void()>& action) {
    try {
        action();
        return "nothing";
    } catch (const Stop&) {
        return "Stop";
    } catch (const Error& error) {
        return error.code() == ErrorCode::out_of_memory ? "out_of_memory" : error.what();
    } catch (const std::exception& error) {
        return error.what();
    }
}

using Call = std::function<void(const DistanceTransform& transform, const CallOptions& call)>;

const std::vector<std::pair<std::string, Call>>& all_calls() {
    static const std::vector<std::pair<std::string, Call>> calls{
        {"compute", [](const DistanceTransform& transform,
                       const CallOptions& call) { transform.compute(grid(), band(), Output::distance, call); }},
        {"requests",
         [](const DistanceTransform& transform, const CallOptions& call) {
             std::vector<float> one(grid().sample_count()), other(one.size());
             const std::array<Request, 2> requests{Request{grid(), band(), one}, Request{grid(), Band::full(), other}};
             transform.compute(requests, call);
         }},
        {"slabs",
         [](const DistanceTransform& transform, const CallOptions& call) {
             transform.compute(
                 grid(), band(), Output::distance, [](const Grid&, const FieldSlab&) {}, {}, call);
         }},
        {"query",
         [](const DistanceTransform& transform, const CallOptions& call) {
             const std::vector<Vec3> points(5000, Vec3{0.1, 0.2, 0.3});
             std::vector<float> distance(points.size());
             transform.query(points, 1, distance, call);
         }},
        {"plan", [](const DistanceTransform& transform, const CallOptions& call) {
             static_cast<void>(transform.plan(grid(), band(), {}, call));
         }}};
    return calls;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_callers_function_runs_on_its_thread_and_what_it_throws_is_passed_on_and_changes_no_later_field) {
    const Field expected = compute(noisy_sphere(), grid(), band());
    std::set<std::string> called;
    for (const std::string thrown_type : {"Stop", "bad_alloc", "Error"})
        for (const std::string function : {"progress", "should_stop", "compiling"})
            for (const auto& [name, call] : all_calls())
                for (const int throwing : {1, 2}) {
                    // On a new device a call builds and tests those that it needs.
                    const Device device = function == "compiling" ? Device::strongest() : test_device();
                    const DistanceTransform transform(device, noisy_sphere());
                    int calls = 0;
                    const auto run = [&, caller = std::this_thread::get_id()] {
                        BOOST_TEST((std::this_thread::get_id() == caller));
                        if (++calls != throwing) return;
                        if (thrown_type == "bad_alloc") throw std::bad_alloc();
                        if (thrown_type == "Error") throw Error(ErrorCode::out_of_memory, "the caller's");
                        throw Stop();
                    };
                    CallOptions options;
                    if (function == "progress") options.progress = when_computing([&](double) { run(); });
                    if (function == "compiling")
                        options.progress = [&](const Progress& progress) {
                            if (progress.stage == Progress::Stage::compiling) run();
                        };
                    if (function == "should_stop")
                        options.should_stop = [&] {
                            run();
                            return false;
                        };
                    const std::string thrown = thrown_by([&] { call(transform, options); });
                    BOOST_TEST_CONTEXT(function << " of " << name << " throws when it is called for time "
                                                << throwing) {
                        if (calls >= throwing) called.insert(function + " of " + name);
                        const std::string other = thrown_type == "Stop" ? "Stop" : "out_of_memory";
                        BOOST_TEST(thrown == (calls >= throwing ? other : "nothing"));
                        BOOST_TEST(calls <= throwing);
                        BOOST_TEST(same_bytes(transform.compute(grid(), band(), all_outputs()), expected));
                    }
                }
    // A plan has nothing to report.
    for (const std::string function : {"progress", "should_stop", "compiling"})
        for (const auto& [name, call] : all_calls())
            if (function != "progress" || name != "plan")
                BOOST_TEST(called.contains(function + " of " + name), function << " of " << name << " was not called");
}

// It would wait for itself.
BOOST_AUTO_TEST_CASE(a_callers_function_that_uses_the_same_transform_is_refused) {
    const Box box{{0, 0, 0}, {1, 1, 1}};
    const std::vector<Vec3> points(1, Vec3{});
    std::vector<float> distance(1);
    std::vector<BoxPlace> places(1);
    for (const auto& [name, call] : all_calls()) {
        DistanceTransform transform(test_device(), noisy_sphere());
        const std::vector<std::pair<std::string, std::function<void()>>> uses{
            {"a field", [&] { transform.compute(grid(), band()); }},
            {"a query", [&] { transform.query(points, 1, distance); }},
            {"classify",
             [&] {
                 transform.classify({&box, 1}, 0.1, places);
             }},
            {"a plan", [&] { static_cast<void>(transform.plan(grid(), band())); }},
            {"set_positions", [&] { transform.set_positions(noisy_sphere().vertices()); }},
            {"restrict_to",
             [&] {
                 static_cast<void>(transform.restrict_to({box, 0.1, 0.1}));
             }},
            {"memory", [&] { static_cast<void>(transform.memory()); }}};
        for (const auto& [use_name, use] : uses) BOOST_TEST_CONTEXT(use_name << " in should_stop of " << name) {
                CallOptions options;
                options.should_stop = [&use = use] {
                    use();
                    return false;
                };
                check_throws(ErrorCode::invalid_argument, {"used the transform that makes the call"},
                             [&, &call = call] { call(transform, options); });
            }
        check_exact(noisy_sphere(), transform.compute(grid(), band()));
    }
}

BOOST_AUTO_TEST_CASE(work_is_counted_wherever_the_field_goes) {
    const DistanceTransform transform(test_device(), noisy_sphere());
    const DeviceMemory memory(test_device().context(), grid().sample_count());
    TransformStatistics on_host, on_device;
    transform.compute(grid(), band(), Output::distance, {.count_work = true}, &on_host);
    on_device = transform.compute(grid(), band(), {{Output::distance, memory.handle()}}, {.count_work = true});
    BOOST_TEST(on_host.work->band_samples > 0U);
    for (const auto counter : {&WorkCounts::brick_pairs, &WorkCounts::lanes_evaluated, &WorkCounts::samples_covered,
                               &WorkCounts::band_samples})
        BOOST_TEST(((*on_device.work).*counter) == ((*on_host.work).*counter));
}

BOOST_AUTO_TEST_CASE(a_component_stride_alone_stores_all_x_before_all_y) {
    const DistanceTransform transform(test_device(), noisy_sphere());
    const Field field = transform.compute(grid(), band(), Output::gradient);
    const std::size_t samples = grid().sample_count();
    std::vector<float> distance(samples), gradient(3 * samples);
    OutputArray planes = gradient;
    planes.component_stride = static_cast<std::ptrdiff_t>(samples * sizeof(float));
    transform.compute(grid(), band(), {{Output::distance, distance}, {Output::gradient, planes}});
    std::vector<float> expected(3 * samples);
    for (std::size_t sample = 0; sample < samples; ++sample)
        for (std::size_t axis = 0; axis < 3; ++axis)
            expected[axis * samples + sample] = field.gradient()[3 * sample + axis];
    BOOST_TEST((bits_of(gradient) == bits_of(expected)));
}

BOOST_AUTO_TEST_CASE(what_the_log_throws_is_passed_on) {
    const Mesh open = without_triangle(cube(1), 3);
    const auto transform_with = [&](const std::function<void()>& fail) {
        bool is_called = false;
        const auto log = [&, caller = std::this_thread::get_id()](const std::string&) {
            BOOST_TEST((std::this_thread::get_id() == caller));
            is_called = true;
            fail();
        };
        const std::string thrown = thrown_by([&] { DistanceTransform(test_device(), open, {}, {.log = log}); });
        BOOST_TEST(is_called);
        return thrown;
    };
    BOOST_TEST(transform_with([] { throw Stop(); }) == "Stop");
    BOOST_TEST(transform_with([] { throw std::bad_alloc(); }) == "out_of_memory");
    BOOST_TEST(transform_with([] {}) == "nothing");
}

BOOST_AUTO_TEST_CASE(a_plan_of_boxes_moves_to_another_lattice) {
    for (const KernelBody body : {KernelBody::by_vector, KernelBody::by_group}) {
        const DistanceTransform transform(test_device(), noisy_sphere(), {.body = body});
        std::vector<Grid> grids{grid(), grid().part({5, 6, 7}, {20, 16, 12})};
        std::vector<DeviceMemory> memory;
        std::vector<Request> requests;
        for (const Grid& one : grids) {
            memory.emplace_back(test_device().context(), one.sample_count());
            requests.push_back({one, band(), {{Output::distance, memory.back().handle()}}});
        }
        Plan plan = transform.plan(requests);
        const auto check = [&] {
            enqueue(plan, nullptr).wait();
            for (std::size_t n = 0; n < grids.size(); ++n) {
                const cl::CommandQueue& queue = device::context_of(test_device()).queue();
                BOOST_TEST((memory[n].read(queue) == bits_of(transform.compute(grids[n], band()).distance())));
            }
        };
        check();
        for (const double factor : {1.5, 0.8}) {
            for (Grid& one : grids)
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    one.spacing[axis] *= factor;
                    one.origin[axis] += 0.3 * one.spacing[axis] * static_cast<double>(axis + 1);
                }
            plan.update(transform, grids);
            check();
        }
    }
}

BOOST_AUTO_TEST_CASE(a_query_does_not_depend_on_the_method) {
    Random random(9);
    std::vector<Vec3> points(5000);
    for (Vec3& p : points) p = random.point(-1.3, 1.3);
    const DistanceTransform plain(test_device(), noisy_sphere());
    const DistanceTransform mauch = make_transform(test_device(), noisy_sphere(), {.polyhedra = Polyhedra::mauch});
    for (const double half_width : {0.1, std::numeric_limits<double>::infinity()})
        BOOST_TEST(same_bytes(query(plain, points, half_width), query(mauch, points, half_width)));
}

BOOST_AUTO_TEST_CASE(what_cannot_be_restricted_is_refused) {
    const Box box{{0, 0, 0}, {1, 1, 1}};
    const DistanceTransform mauch = make_transform(test_device(), cube(1), {.polyhedra = Polyhedra::mauch});
    check_throws(ErrorCode::unsupported, {"clsdf::papers", "cannot be restricted"}, [&] {
        mauch.restrict_to({box, 0.1, 0.1});
    });
    const DistanceTransform whole(test_device(), cube(1));
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
            Box low = box, high = box;
            low.lower[axis] = -wrong;
            high.upper[axis] = wrong;
            check_throws(ErrorCode::invalid_argument, {"box"}, [&] { whole.restrict_to({low, 0.1, 0.1}); });
            check_throws(ErrorCode::invalid_argument, {"box"}, [&] { whole.restrict_to({high, 0.1, 0.1}); });
        }
}

// A method that gives the distance and the triangle alone refuses a gradient before anything is done.
BOOST_AUTO_TEST_CASE(what_a_method_cannot_give_is_refused_before_anything_changes) {
    const Mesh mesh = make_shape("sphere2");
    const DistanceTransform slices = make_transform(test_device(), mesh, {.scan = Scan::slices});
    const Grid grid = grid_around(mesh, 16, 2);
    const Band band = Band::symmetric(2 * grid.voxel());
    const std::size_t samples = grid.sample_count();

    std::vector<float> first(samples, 77), second(samples, 77), gradient(3 * samples, 77);
    const std::vector<Request> on_host{{grid, band, first},
                                       {grid, band, {{Output::distance, second}, {Output::gradient, gradient}}}};
    check_throws(ErrorCode::unsupported, {"request 1 of 2", "gradient"}, [&] { slices.compute(on_host); });
    for (const std::vector<float>* array : {&first, &second, &gradient})
        BOOST_TEST(std::ranges::all_of(*array, [](float value) { return value == 77; }));

    const device::Context& context = device::context_of(test_device());
    const cl::Buffer memory(context.context(), CL_MEM_READ_WRITE, samples * sizeof(float)),
        gradients(context.context(), CL_MEM_READ_WRITE, 3 * samples * sizeof(float));
    Plan plan = slices.plan(Request{grid, band, {{Output::distance, memory()}}});
    const Request refused{grid, band, {{Output::distance, memory()}, {Output::gradient, gradients()}}};
    check_throws(ErrorCode::unsupported, {"gradient"}, [&] { plan.update(slices, {&refused, 1}); });
    enqueue(plan, nullptr).wait();
    std::vector<float> values(samples);
    context.callers_queue().enqueueReadBuffer(memory, CL_TRUE, 0, samples * sizeof(float), values.data());
    BOOST_TEST((bits_of(values) == bits_of(slices.compute(grid, band).distance())));
}

BOOST_AUTO_TEST_CASE(slabs_are_handed_out_as_they_are_foretold) {
    const DistanceTransform transform(test_device(), make_shape("sphere2"));
    Grid large = grid_around(make_shape("sphere2"), 720, 4);
    large.size[2] = 70;
    const std::vector<Grid> foretold = DistanceTransform::slabs_of(large);
    BOOST_TEST(foretold.size() > 2U);
    std::vector<Grid> parts;
    transform.compute(large, Band::symmetric(large.voxel()), Output::distance,
                      [&](const Grid& part, const FieldSlab&) { parts.push_back(part); });
    BOOST_TEST((parts == foretold));
}
