#include "random_scenes.hpp"

#include "support/throws.hpp"

#include <clsdf/reference.hpp>

#include <boost/test/unit_test.hpp>

#include <array>
#include <cmath>
#include <cstring>
#include <thread>

using namespace clsdf;
using namespace clsdf::test;

namespace {

OutputSet every_output() {
    OutputSet all;
    for (const OutputInfo& info : output_table()) all.insert(info.output);
    return all;
}

Pose at(const Vec3& translation) {
    return {.translation = translation};
}

/// A grid around a scene of which some samples lie outside all bodies.
Grid grid_around(const Scene& scene, std::int64_t resolution) {
    return Grid::around(scene.box(), {.resolution = resolution, .margin = Length::of_extent(0.1)});
}

/// The fields of transforms, the least of them sample by sample: with the values of the body that has it.
Field least_of(const std::vector<DistanceTransform>& transforms, const Grid& grid, const Band& band) {
    std::vector<Field> fields;
    for (const DistanceTransform& transform : transforms)
        fields.push_back(transform.compute(grid, band, every_output()));
    Field least = fields[0];
    for (std::size_t i = 0; i < grid.sample_count(); ++i) {
        float value = INFINITY;
        for (const Field& field : fields) {
            const float found = field.distance()[i];
            if (found < value || (found == value && std::signbit(found))) value = found;
        }
        std::size_t body = fields.size();
        bool is_deep = false;  // beyond the band of a body that has the sample inside
        for (std::size_t b = fields.size(); b-- > 0;) {
            const float found = fields[b].distance()[i];
            if (found != value || std::signbit(found) != std::signbit(value)) continue;
            if (fields[b].triangle()[i] != no_triangle)
                body = b;
            else
                is_deep = is_deep || std::signbit(found);
        }
        if (is_deep) body = fields.size();
        for (const OutputInfo& info : output_table()) {
            const std::size_t bytes = info.sample_bytes();
            std::byte* const to = &least.bytes(info.output)[bytes * i];
            if (info.output == Output::distance)
                std::memcpy(to, &value, bytes);
            else if (body < fields.size())
                std::memcpy(to, &fields[body].bytes(info.output)[bytes * i], bytes);
            else
                std::memset(to, 0xFF, bytes);
        }
        if (body < fields.size()) least.body()[i] = static_cast<std::uint32_t>(body);
    }
    return least;
}

std::size_t differences_of(const Field& one, const Field& other, const char* where) {
    std::size_t count = 0;
    for (const OutputInfo& info : output_table()) {
        const Differences found = differences(one, 0, other, 0, one.grid.sample_count(), info);
        if (found.count > 0 && count == 0)
            BOOST_TEST_MESSAGE(where << ": " << found.count << " samples differ in " << info.name << ", the first "
                                     << found.first);
        count += found.count;
    }
    return count;
}

/// Where set_motion() puts the vertices.
reference::PlacedBody placed(const Mesh& mesh, const Pose& pose, SignRule sign) {
    std::vector<Vec3> positions(mesh.vertices().begin(), mesh.vertices().end());
    const auto& [r, t] = pose;
    for (Vec3& p : positions) {
        const Vec3 x = p;
        for (std::size_t a = 0; a < 3; ++a)
            p[a] = std::fma(r[a][0], x[0], std::fma(r[a][1], x[1], std::fma(r[a][2], x[2], t[a])));
    }
    return {Mesh(positions, {mesh.triangles().begin(), mesh.triangles().end()}, mesh.name()), sign};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_field_has_the_bytes_of_the_body_with_the_least_distance) {
    std::size_t different = 0, inside = 0, deep = 0, in_band = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        const RandomScene random(seed);
        if (random.bodies.size() > 10) continue;
        const Grid grid = grid_around(random.scene, 20);
        const double voxel = grid.voxel();
        const Band band = seed % 4 == 0   ? Band::full()
                          : seed % 4 == 1 ? Band{0, 2 * voxel}
                                          : Band::symmetric(static_cast<double>(seed % 5 + 1) * voxel / 2);
        const Field expected = least_of(random.transforms, grid, band);
        const Field found = random.scene.compute(grid, band, every_output());
        different += differences_of(found, expected, "the field") > 0 ? 1U : 0U;
        BOOST_TEST((found.sign != SignRule::none) == random.scene.has_sign());
        for (std::size_t i = 0; i < grid.sample_count(); ++i) {
            inside += std::signbit(found.distance()[i]) ? 1U : 0U;
            in_band += found.body()[i] != no_body ? 1U : 0U;
            deep += std::signbit(found.distance()[i]) && found.body()[i] == no_body ? 1U : 0U;
        }
        // A part has the bytes of the whole.
        const Grid part = grid.part({3, 1, 2}, {grid.size[0] - 5, grid.size[1] - 1, grid.size[2] - 2});
        const Field of_part = random.scene.compute(part, band, every_output());
        bool is_same = true;
        for (std::int64_t z = 0; z < part.size[2]; ++z)
            for (std::int64_t y = 0; y < part.size[1]; ++y)
                for (const OutputInfo& info : output_table())
                    is_same = is_same && differences(of_part, part.offset(0, y, z), found, grid.offset(3, y + 1, z + 2),
                                                     static_cast<std::size_t>(part.size[0]), info)
                                                 .count == 0;
        different += is_same ? 0U : 1U;
    }
    BOOST_TEST(different == 0U, "seeds 1 to 40");
    BOOST_TEST(inside > 1000U);
    BOOST_TEST(deep > 100U);
    BOOST_TEST(in_band > 10000U);
}

// Small bodies are computed together. Faces that do not fill up vectors, point sites, several rules and outputs, bodies
// that overlap and such that do not.
BOOST_AUTO_TEST_CASE(many_bodies_have_the_bytes_of_single_ones) {
    Random random(3);
    std::vector<Mesh> meshes = meshes_of_bodies(random);
    meshes.push_back(make_shape("torus"));
    std::vector<DistanceTransform> transforms;
    std::vector<Pose> poses;
    Scene scene(test_device());
    std::vector<std::uint32_t> first(meshes.size());
    const auto place = [&] {
        poses.clear();
        for (std::size_t i = 0; i < 60; ++i) {
            Pose pose = at(random.point(0, 3));
            pose.translation[0] *= 8;
            if (i % 4 != 0) pose.rotation = random_rotation(random);
            poses.push_back(pose);
        }
        scene.set_poses(poses);
        for (std::uint32_t i = 0; i < transforms.size(); ++i)
            transforms[i].set_motion(scene.pose(i).rotation, scene.pose(i).translation);
    };
    for (std::size_t i = 0; i < 60; ++i) {
        const std::size_t number = i % meshes.size();
        if (i < meshes.size())
            first[number] = scene.add(meshes[number]);
        else
            scene.add_instance(first[number]);
        transforms.emplace_back(test_device(), meshes[number]);
    }
    const Grid grid = Grid{{-1, -1, -1}, {0.08, 0.08, 0.08}, {330, 60, 60}, {}}.part({3, 2, 1}, {320, 57, 58});
    std::size_t different = 0, in_band = 0;
    for (const Band& band : {Band::symmetric(0.2), Band{0.5, 0.1}}) {
        place();
        const Field found = scene.compute(grid, band, every_output());
        for (std::int64_t x = 0; x + 40 <= grid.size[0]; x += 56) {
            const Index3 begin{x, x % 3 * 8, 5}, size{40, 30, 25};
            const Grid block = grid.part(begin, size);
            const Field expected = least_of(transforms, block, band);
            for (std::int64_t z = 0; z < size[2]; ++z)
                for (std::int64_t y = 0; y < size[1]; ++y)
                    for (const OutputInfo& info : output_table())
                        different += differences(expected, block.offset(0, y, z), found,
                                                 grid.offset(begin[0], begin[1] + y, begin[2] + z), 40, info)
                                         .count;
            for (const std::uint32_t body : expected.body()) in_band += body != no_body ? 1U : 0U;
        }
    }
    BOOST_TEST(different == 0U);
    BOOST_TEST(in_band > 10000U);
}

// Bodies that overlap between two samples: the surface of one is nearer to a sample in the other one's depth than its
// own.
BOOST_AUTO_TEST_CASE(bodies_that_overlap_between_samples_keep_their_depth) {
    Scene scene(test_device());
    scene.add(cube(1.025));
    for (int i = 1; i < 20; ++i) scene.add_instance(0, at({i == 1 ? 2.0 : 0.0, 0, i == 1 ? 0.0 : 4.0 * i}));
    const Grid grid{{-0.525, 0, 0}, {1, 1, 1}, {4, 1, 80}, {}};
    const Field field = scene.compute(grid, {0.9, 0});
    const std::array<double, 4> depths{0.5, 0.55, 0.5, 0.55};
    for (std::size_t i = 0; i < 4; ++i)
        BOOST_TEST(std::abs(static_cast<double>(field.distance()[i]) + depths[i]) < 1e-6, "sample " << i);
}

BOOST_AUTO_TEST_CASE(many_meshes_are_added_at_once) {
    Random random(8);
    const std::vector<Mesh> meshes = meshes_of_bodies(random);
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < meshes.size(); ++i) poses.push_back({random_rotation(random), random.point(0, 3)});
    Scene scene(test_device()), one_by_one(test_device());
    one_by_one.add(cube(1));
    scene.add(cube(1));
    BOOST_TEST(scene.add(meshes, poses, SignRule::none) == 1U);
    for (std::size_t i = 0; i < meshes.size(); ++i) one_by_one.add(meshes[i], poses[i], SignRule::none);
    BOOST_TEST(scene.size() == one_by_one.size());
    const Grid grid = grid_around(scene, 24);
    const Band band = Band::symmetric(2 * grid.voxel());
    BOOST_TEST(differences_of(scene.compute(grid, band, every_output()), one_by_one.compute(grid, band, every_output()),
                              "at once") == 0U);
    check_throws(ErrorCode::invalid_argument, {"1 poses", "8 meshes"},
                 [&] { scene.add(meshes, std::span(poses).first(1)); });
    const Mesh one = cube(1);
    check_throws(ErrorCode::unsupported, {"below"}, [&] { scene.add(std::span(&one, 1), {}, SignRule::below); });
    BOOST_TEST(scene.size() == one_by_one.size());
}

BOOST_AUTO_TEST_CASE(the_reference_finds_no_fault_and_finds_faults_that_are_made) {
    for (const std::uint64_t seed : {3U, 10U, 21U, 34U}) {
        const RandomScene random(seed);
        std::vector<reference::PlacedBody> bodies;
        for (std::uint32_t i = 0; i < random.bodies.size(); ++i)
            bodies.push_back(placed(*random.bodies[i].mesh, random.bodies[i].pose, random.scene.sign(i)));
        const Grid grid = grid_around(random.scene, 16);
        Field field = random.scene.compute(grid, Band::symmetric(2.5 * grid.voxel()), every_output());
        const reference::CheckReport report = reference::check(bodies, field, {.samples = 0});
        BOOST_TEST(report.passed(),
                   "seed " << seed << ": " << (report.findings.empty() ? "" : report.findings[0].what));
        BOOST_TEST(report.band_samples > 0U);
        std::size_t in_band = 0;
        while (field.body()[in_band] == no_body) ++in_band;
        field.body()[in_band] = static_cast<std::uint32_t>(bodies.size());
        BOOST_TEST(reference::check(bodies, field, {.samples = 0}).wrong(Output::body) == 1U);
    }
}

// cube(a) is [-a, a]^3.
BOOST_AUTO_TEST_CASE(a_small_body_in_the_depth_of_a_large_one_does_not_count) {
    Scene scene(test_device());
    scene.add(cube(10));
    scene.add(cube(0.5), at({3, 0, 0}));
    const Grid grid{{3, 0, 0}, {0.25, 0.25, 0.25}, {40, 1, 1}, {}};  // from the small one's centre outwards
    const Field near = scene.compute(grid, Band::symmetric(1), Output::triangle | Output::body);
    for (std::size_t i = 0; i < 40; ++i) {
        const double depth = 7 - 0.25 * static_cast<double>(i);
        BOOST_TEST(near.distance()[i] == static_cast<float>(-std::clamp(depth, -1.0, 1.0)));
        BOOST_TEST(near.body()[i] == (std::abs(depth) <= 1 ? 0U : no_body));
        BOOST_TEST((near.triangle()[i] == no_triangle) == (near.body()[i] == no_body));
    }
    const Field full = scene.compute(grid, Band::full(), Output::body);
    for (std::size_t i = 0; i < 40; ++i) BOOST_TEST(full.body()[i] == 0U);
}

BOOST_AUTO_TEST_CASE(instances_and_bodies_that_are_off) {
    Scene scene(test_device());
    const std::uint32_t first = scene.add(cube(1));
    for (int i = 1; i < 5; ++i) scene.add_instance(first, at({3.0 * i, 0, 0}));
    scene.add(cube(1), at({3, 0, 0}));  // where body 1 is
    scene.set_active(2, false);
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {13, 1, 1}, {}};
    std::vector<std::uint32_t> body(13);
    std::vector<double> distance(13);
    scene.compute(grid, Band::symmetric(1), {{Output::distance, distance}, {Output::body, body}});
    const std::vector<std::uint32_t> bodies{0, 0, 1, 1, 1, no_body, no_body, no_body, 3, 3, 3, 4, 4};
    const std::vector<double> values{-1, 0, 0, -1, 0, 1, 1, 1, 0, -1, 0, 0, -1};
    for (std::size_t i = 0; i < 13; ++i) {
        if (i != 5 && i != 7) BOOST_TEST(body[i] == bodies[i], "sample " << i);  // at the limit of the band
        BOOST_TEST(std::abs(distance[i] - values[i]) < 1e-12, "sample " << i);
    }
    // What has moved, has: also the mesh.
    std::vector<Pose> poses;
    for (int i = 0; i < 6; ++i) poses.push_back(at({0, 0, i == 3 ? 0.0 : 100.0}));
    scene.set_poses(poses);
    const Mesh large = cube(2);
    const std::vector<Vec3> larger(large.vertices().begin(), large.vertices().end());
    scene.set_positions(first, larger);
    scene.compute(grid, Band::symmetric(1), {{Output::distance, distance}, {Output::body, body}});
    BOOST_TEST(distance[0] == -1);
    BOOST_TEST(body[0] == no_body);
    BOOST_TEST(distance[2] == 0);
    BOOST_TEST(body[2] == 3U);
    BOOST_TEST(distance[12] == 1);
}

BOOST_AUTO_TEST_CASE(signs_alone_and_exact_signs_are_those_of_the_union) {
    Scene scene(test_device());
    scene.add(cube(1));
    scene.add(cube(1), at({1.5, 0, 0}));
    scene.add(make_shape("sphere2"), at({0, 0, 4}), SignRule::none);
    const Grid grid = grid_around(scene, 24);
    const Field signs = scene.compute(grid, Band::signs_only()),
                exact = scene.compute(grid, Band::symmetric(grid.voxel()).with_exact_signs(), Output::body);
    std::size_t inside = 0, wrong = 0;
    for (std::int64_t z = 0; z < grid.size[2]; ++z)
        for (std::int64_t y = 0; y < grid.size[1]; ++y)
            for (std::int64_t x = 0; x < grid.size[0]; ++x) {
                const std::size_t i = grid.offset(x, y, z);
                const Vec3 p = grid.position(x, y, z);
                const bool is_inside = std::abs(p[1]) < 1 && std::abs(p[2]) < 1 && p[0] > -1 && p[0] < 2.5;
                inside += is_inside ? 1U : 0U;
                wrong += std::signbit(signs.distance()[i]) != is_inside || signs.distance()[i] != 0 ? 1U : 0U;
                wrong += (exact.distance()[i] < 0) != is_inside ? 1U : 0U;
            }
    BOOST_TEST(inside > 100U);
    BOOST_TEST(wrong == 0U);
    for (std::uint32_t body : {0U, 1U}) scene.set_active(body, false);
    BOOST_TEST((scene.sign() == SignRule::none));
    check_throws(ErrorCode::invalid_argument, {"no body of the scene has a sign"},
                 [&] { scene.compute(grid, Band::signs_only()); });
    check_throws(ErrorCode::invalid_argument, {"no body of the scene has a sign"},
                 [&] { scene.compute(grid, Band::symmetric(1).with_exact_signs()); });
}

BOOST_AUTO_TEST_CASE(strides_doubles_and_overlaps) {
    Random random(5);
    Scene scene(test_device());
    const std::uint32_t first = scene.add(make_shape("torus"));
    for (int i = 0; i < 4; ++i) scene.add_instance(first, {random_rotation(random), random.point(-2, 2)});
    const Grid grid = grid_around(scene, 20);
    const Band band = Band::symmetric(2 * grid.voxel());
    const Field expected = scene.compute(grid, band, Output::body | Output::gradient);
    struct Sample {
        float distance;
        std::uint32_t body;
        std::array<double, 3> gradient;
    };
    std::vector<Sample> samples(grid.sample_count());
    const auto step = static_cast<std::ptrdiff_t>(sizeof(Sample));
    const auto member = [&](void* data, ElementType type) {
        OutputArray array;
        array.host = data;
        array.type = type;
        array.strides = {step, step * grid.size[0], step * grid.size[0] * grid.size[1]};
        array.component_stride = type == ElementType::float64 ? 8 : 0;
        return array;
    };
    scene.compute(grid, band,
                  {{Output::distance, member(&samples[0].distance, ElementType::float32)},
                   {Output::body, member(&samples[0].body, ElementType::uint32)},
                   {Output::gradient, member(&samples[0].gradient, ElementType::float64)}});
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        wrong += samples[i].distance != expected.distance()[i] || samples[i].body != expected.body()[i] ? 1U : 0U;
        for (std::size_t a = 0; a < 3; ++a) {
            const auto as_float = static_cast<float>(samples[i].gradient[a]);
            wrong += as_float != expected.gradient()[3 * i + a] && !std::isnan(as_float) ? 1U : 0U;
        }
    }
    BOOST_TEST(wrong == 0U);
    std::vector<std::uint32_t> body(grid.sample_count());
    OutputArray overlapping(body);
    overlapping.type = ElementType::float32;
    check_throws(ErrorCode::invalid_argument, {"distance", "body"}, [&] {
        scene.compute(grid, band, {{Output::distance, overlapping}, {Output::body, body}});
    });
    check_throws(ErrorCode::invalid_argument, {"distance has no target"}, [&] {
        scene.compute(grid, band, OutputTargets{{Output::body, body}});
    });
}

BOOST_AUTO_TEST_CASE(many_threads_compute_and_a_call_can_be_stopped) {
    Random random(17);
    Scene scene(test_device());
    const std::uint32_t first = scene.add(make_shape("sphere2"));
    for (int i = 0; i < 20; ++i) scene.add_instance(first, {random_rotation(random), random.point(-5, 5)});
    const Grid grid = grid_around(scene, 32);
    const Band band = Band::symmetric(2 * grid.voxel());
    const Field expected = scene.compute(grid, band, every_output());
    std::vector<std::size_t> different(3);
    {
        std::vector<std::jthread> threads;
        for (std::size_t thread = 0; thread < different.size(); ++thread)
            threads.emplace_back([&, thread] {
                different[thread] = differences_of(scene.compute(grid, band, every_output()), expected, "a thread");
            });
    }
    for (const std::size_t count : different) BOOST_TEST(count == 0U);
    std::vector<double> fractions;
    CallOptions call;
    call.progress = [&](const Progress& step) {
        if (step.stage == Progress::Stage::computing) fractions.push_back(step.fraction);
    };
    scene.compute(grid, band, Output::distance, call);
    BOOST_TEST(std::ranges::is_sorted(fractions));
    BOOST_TEST((!fractions.empty() && fractions.back() == 1));
    call.should_stop = [] { return true; };
    check_throws(ErrorCode::cancelled, {}, [&] { scene.compute(grid, band, Output::distance, call); });
}

BOOST_AUTO_TEST_CASE(bad_fields_are_named) {
    Scene scene(test_device());
    const Grid grid{{0, 0, 0}, {1, 1, 1}, {4, 4, 4}, {}};
    check_throws(ErrorCode::invalid_argument, {"has no bodies"}, [&] { scene.compute(grid, Band::symmetric(1)); });
    check_throws(ErrorCode::invalid_argument, {"has no bodies"}, [&] { scene.box(); });
    scene.add(cube(1));
    check_throws(ErrorCode::invalid_argument, {}, [&] { scene.compute(grid, Band{}); });
    check_throws(ErrorCode::invalid_argument, {}, [&] { scene.compute({{}, {1, 1, 1}, {}, {}}, Band::full()); });
    scene.set_active(0, false);
    check_throws(ErrorCode::invalid_argument, {"all 1 bodies"}, [&] { scene.compute(grid, Band::symmetric(1)); });
    scene.set_active(0, true);
    // A body that does not reach the grid.
    scene.set_poses(std::array{at({50, 0, 0})});
    const Field far = scene.compute(grid, {1, 2}, Output::body);
    for (std::size_t i = 0; i < grid.sample_count(); ++i) {
        BOOST_TEST(far.distance()[i] == 2);
        BOOST_TEST(far.body()[i] == no_body);
    }
}
