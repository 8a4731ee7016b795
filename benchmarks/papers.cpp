#include "benchmarks/papers.hpp"

#include "benchmarks/meshes.hpp"

#include <clsdf/tuning.hpp>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace clsdf::bench {

namespace {

class SoftwareMauch final : public PapersMethod {
public:
    explicit SoftwareMauch(std::size_t threads) : threads_(threads) {}

    std::string name() const override {
        return threads_ == 1 ? "mauch, software, 1 thread" : "mauch, software, all threads";
    }
    std::string note() const override { return "from the mesh's arrays anew"; }

    Cost compute(const Workload& workload, std::span<float> distance, std::size_t) override {
        software_scan(workload.mesh, workload.grid, workload.band.outside, threads_, distance);
        return {};
    }

    Work work(const Workload& workload) override {
        FieldArray<float> distance(workload.grid.sample_count());
        const SoftwareScanCounts counts =
            software_scan(workload.mesh, workload.grid, workload.band.outside, threads_, distance);
        return {counts.polyhedra, counts.distances};
    }

private:
    std::size_t threads_;
};

class Scanned final : public PapersMethod {
public:
    Scanned(Device device, std::string name, Polyhedra polyhedra, Scan scan)
        : device_(std::move(device)), name_(std::move(name)), method_{.polyhedra = polyhedra, .scan = scan} {}

    std::string name() const override { return name_; }
    std::string note() const override { return "the transform is kept between calls, its polyhedra are not"; }

    void prepare(const Workload& workload) override {
        transform_ = std::make_unique<DistanceTransform>(make_transform(device_, workload.mesh, method_));
        // A small grid of the same kind compiles the kernels.
        Grid small = workload.grid;
        for (std::int64_t& size : small.size) size = std::min<std::int64_t>(size, 16);
        transform_->compute(small, workload.band);
    }

    Cost compute(const Workload& workload, std::span<float> distance, std::size_t) override {
        transform_->compute(workload.grid, workload.band, distance);
        return {};
    }

    Work work(const Workload& workload) override {
        TransformStatistics counted;
        make_transform(device_, workload.mesh, method_)
            .compute(workload.grid, workload.band, {}, {.count_work = true}, &counted);
        return {counted.work->polyhedra, counted.work->samples_covered};
    }

private:
    Device device_;
    std::string name_;
    PapersOptions method_;
    std::unique_ptr<DistanceTransform> transform_;
};

/// DistanceTransform::query() at all samples of the grid.
class TreeOfPoints final : public Method {
public:
    TreeOfPoints(Device device, std::string name, bool is_kept)
        : device_(std::move(device)), name_(std::move(name)), is_kept_(is_kept) {}

    std::string name() const override { return name_; }
    std::string note() const override {
        return is_kept_ ? "the transform and the samples' positions are kept" : "the samples' positions are kept";
    }

    void prepare(const Workload& workload) override {
        const Grid& grid = workload.grid;
        positions_.resize(grid.sample_count());
        tbb::parallel_for(std::int64_t{0}, grid.size[2], [&](std::int64_t k) {
            for (std::int64_t j = 0; j < grid.size[1]; ++j)
                for (std::int64_t i = 0; i < grid.size[0]; ++i)
                    positions_[grid.offset(i, j, k)] = grid.position(i, j, k);
        });
        if (is_kept_) kept_ = std::make_unique<DistanceTransform>(device_, workload.mesh);
    }

    Cost compute(const Workload& workload, std::span<float> distance, std::size_t) override {
        if (is_kept_)
            kept_->query(positions_, workload.band.outside, distance);
        else
            DistanceTransform(device_, workload.mesh).query(positions_, workload.band.outside, distance);
        return {};
    }

private:
    Device device_;
    std::string name_;
    bool is_kept_;
    std::vector<Vec3> positions_;
    std::unique_ptr<DistanceTransform> kept_;
};

}  // namespace

std::unique_ptr<PapersMethod> make_software_mauch(std::size_t threads) {
    return std::make_unique<SoftwareMauch>(threads);
}

std::unique_ptr<PapersMethod> make_scanned(const Device& device, const std::string& name, Polyhedra polyhedra,
                                           Scan scan) {
    return std::make_unique<Scanned>(device, name, polyhedra, scan);
}

std::vector<std::unique_ptr<PapersMethod>> papers_methods(const Device& device, const Workload& workload) {
    std::vector<std::unique_ptr<PapersMethod>> methods;
    methods.push_back(make_software_mauch(1));
    methods.push_back(make_software_mauch(0));
    methods.push_back(make_scanned(device, "mauch, slices", Polyhedra::mauch, Scan::slices));
    methods.push_back(make_scanned(device, "peikert-sigg, slices", Polyhedra::peikert_sigg, Scan::slices));
    methods.push_back(make_scanned(device, "leaned, slices", Polyhedra::leaned, Scan::slices));
    methods.push_back(make_scanned(device, "leaned, bricks", Polyhedra::leaned, Scan::bricks));
    constexpr std::size_t most_distances = 1'000'000'000;  // about half a second
    if (workload.grid.sample_count() <= most_distances / workload.mesh.triangles().size())
        methods.push_back(make_scanned(device, "brute force", Polyhedra::leaned, Scan::brute_force));
    return methods;
}

Layout PapersCase::layout() const {
    return {fmt::format("{}, {}%", resolution, percent), resolution, Length::of_extent(0.01 * percent)};
}

std::vector<PapersCase> papers_cases() {
    constexpr const char* about_five = "the paper: about 5 times software scan conversion";
    std::vector<PapersCase> cases;
    const auto add = [&](const char* mesh, std::int64_t resolution, int percent, const char* remark) {
        cases.push_back({mesh, resolution, percent, remark});
    };
    add("sphere6", 256, 10, about_five);
    add("knot", 256, 10, about_five);
    add("bunny00", 256, 10, about_five);
    add("knot", 64, 10, "and every triangle at every sample");
    add("sphere7", 256, 10, "131,072 triangles, each of about a voxel's area; the paper: 3.30 times");
    for (const std::int64_t resolution : {64, 128}) add("bunny00", resolution, 10, "");
    for (const int percent : {1, 3}) add("bunny00", 256, percent, "");
    return cases;
}

std::vector<Entry> far_field_methods(const Device& device) {
    std::vector<Entry> methods;
    methods.emplace_back("clsdf", "", "", make_transform_anew(device));
    for (const double share : {0.02, 0.05, 0.1}) {
        Entry sweep = openvdb_sweep_entry(device, share);
        sweep.name = fmt::format("band of {:g}%, OpenVDB's fast sweeping", 100 * share);
        methods.push_back(std::move(sweep));
    }
    return methods;
}

const std::vector<std::string>& far_field_meshes() {
    static const std::vector<std::string> meshes{"knot", "bunny00"};
    return meshes;
}

Layout UnderSampledCase::layout(const Length& half_width) const {
    const double voxel = std::sqrt(triangles_per_voxel * mean_triangle_area(mesh));
    const double side = mesh.box().longest_side() * (1 + 2 * margin_of(half_width).resolve(0, 1));
    constexpr std::int64_t fewest = 8;
    return {fmt::format("{:g} triangles per voxel", triangles_per_voxel),
            std::max(fewest, static_cast<std::int64_t>(std::lround(side / voxel)) + 1), half_width};
}

std::vector<UnderSampledCase> under_sampled_cases(const std::string& series, const Mesh& mesh, bool is_quick) {
    std::vector<UnderSampledCase> cases;
    if (series == "sphere6") {
        const auto add = [&](int level, double triangles_per_voxel) {
            const std::string name = fmt::format("sphere{}", is_quick ? level - 3 : level);
            cases.push_back({series, make_shape(name), triangles_per_voxel});
        };
        add(5, 0.1);
        add(7, 1);
        add(8, 10);
        add(8, 30);
        add(9, 100);
        add(9, 300);
        add(9, 1000);
        return cases;
    }
    const Mesh once = is_quick ? mesh : split_triangles(mesh);
    const Mesh twice = is_quick ? mesh : split_triangles(once);
    cases.push_back({series, mesh, 1});
    for (const double triangles_per_voxel : {10, 30}) cases.push_back({series, once, triangles_per_voxel});
    for (const double triangles_per_voxel : {100, 300, 1000}) cases.push_back({series, twice, triangles_per_voxel});
    return cases;
}

std::vector<Entry> under_sampled_methods(const Device& device) {
    std::vector<Entry> methods;
    methods.emplace_back("bricks", "", "", make_transform_anew(device, "bricks"));
    methods.emplace_back("tree", "", "", std::make_unique<TreeOfPoints>(device, "tree of points", false));
    methods.emplace_back("bricks_again", "", "", make_kept_transform(device, "bricks, again"));
    methods.emplace_back("tree_again", "", "", std::make_unique<TreeOfPoints>(device, "tree of points, again", true));
    methods.push_back(embree_entry());
    return methods;
}

std::vector<double> crossovers(std::span<const TimesOfTwo> times) {
    std::vector<double> found;
    for (std::size_t i = 0; i + 1 < times.size(); ++i) {
        const TimesOfTwo &a = times[i], &b = times[i + 1];
        const double before = std::log(a.first / a.second), after = std::log(b.first / b.second);
        if ((before > 0) == (after > 0)) continue;
        found.push_back(a.value * std::pow(b.value / a.value, before / (before - after)));
    }
    return found;
}

}  // namespace clsdf::bench
