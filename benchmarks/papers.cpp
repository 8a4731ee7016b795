#include "benchmarks/papers.hpp"

#include <clsdf/tuning.hpp>

#include <fmt/format.h>

#include <algorithm>

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

}  // namespace clsdf::bench
