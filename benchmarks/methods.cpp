#include "benchmarks/method.hpp"

namespace clsdf::bench {

namespace {

class KeptTransform final : public Method {
public:
    KeptTransform(Device device, std::string name) : device_(std::move(device)), name_(std::move(name)) {}

    std::string name() const override { return name_; }
    std::string note() const override { return "the transform is kept, and with it what the call before has prepared"; }
    bool gets_every_call() const override { return true; }

    void prepare(const Workload& workload) override {
        transform_ = std::make_unique<DistanceTransform>(device_, workload.mesh);
        // A small grid of the same kind compiles the kernels.
        Grid small = workload.grid;
        for (std::int64_t& size : small.size) size = std::min<std::int64_t>(size, 16);
        transform_->compute(small, workload.band);
    }

    Cost compute(const Workload& workload, std::span<float> distance, std::size_t) override {
        transform_->compute(workload.grid, workload.band, distance);
        return {};
    }

private:
    Device device_;
    std::string name_;
    std::unique_ptr<DistanceTransform> transform_;
};

class TransformAnew final : public Method {
public:
    TransformAnew(Device device, std::string name) : device_(std::move(device)), name_(std::move(name)) {}

    std::string name() const override { return name_; }
    std::string note() const override {
        return "from the mesh's arrays anew; only the device and its programs are kept";
    }
    bool gets_every_call() const override { return true; }

    Cost compute(const Workload& workload, std::span<float> distance, std::size_t) override {
        DistanceTransform(device_, workload.mesh).compute(workload.grid, workload.band, distance);
        return {};
    }

private:
    Device device_;
    std::string name_;
};

#if !CLSDF_PEER_EMBREE || !CLSDF_PEER_OPENVDB
/// `missing` is empty if the package was not looked for.
[[maybe_unused]] Entry absent(const char* name, const std::string& missing) {
    return {name, "",
            missing.empty() ? "not in this build: configure with -DCLSDF_BUILD_BENCHMARKS=ON"
                            : "not installed: apt-get install " + missing,
            nullptr};
}
#endif

}  // namespace

std::unique_ptr<Method> make_kept_transform(const Device& device, const std::string& name) {
    return std::make_unique<KeptTransform>(device, name);
}

std::unique_ptr<Method> make_transform_anew(const Device& device, const std::string& name) {
    return std::make_unique<TransformAnew>(device, name);
}

#if !CLSDF_PEER_EMBREE
Entry embree_entry() {
    return absent("embree", CLSDF_MISSING_EMBREE);
}
PointPeer embree_points(const Mesh&) {
    return {};
}
RayPeer embree_rays(const Mesh&) {
    return {};
}
#endif
#if !CLSDF_PEER_OPENVDB
Entry openvdb_entry() {
    return absent("openvdb", CLSDF_MISSING_OPENVDB);
}
Entry openvdb_sweep_entry(const Device&, double) {
    return absent("openvdb_sweep", CLSDF_MISSING_OPENVDB);
}
#endif

#if !CLSDF_PEER_CGAL
Entry cgal_entry() {
    return {"cgal", "", "not in this build, which has no GPL code: configure with -DCLSDF_BUILD_REFERENCE=ON", nullptr};
}
#endif

std::vector<Entry> all_methods(const Device& device) {
    std::vector<Entry> entries;
    entries.emplace_back("clsdf", "", "", make_transform_anew(device));
    entries.emplace_back("again", "", "", make_kept_transform(device));
    entries.push_back(embree_entry());
    entries.push_back(openvdb_entry());
    entries.push_back(cgal_entry());
    return entries;
}

}  // namespace clsdf::bench
