#include "benchmarks/memory.hpp"

#include <malloc.h>
#include <algorithm>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

namespace clsdf::bench {

namespace {

/// A line of /proc/self/status, "VmRSS:  1234 kB", in bytes.
std::optional<std::size_t> status_bytes(const std::string& key) {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;) {
        std::size_t kilobytes = 0;
        if (word == key && status >> kilobytes) return kilobytes * 1024;
    }
    return std::nullopt;
}

}  // namespace

PeakMemory::PeakMemory() {
    malloc_trim(0);  // freed memory that malloc keeps would hide a method's memory
    std::ofstream clear("/proc/self/clear_refs");
    clear << "5" << std::flush;
    if (clear) before_ = status_bytes("VmRSS:");
}

std::optional<std::size_t> PeakMemory::growth() const {
    const auto peak = status_bytes("VmHWM:");
    if (!before_ || !peak) return std::nullopt;
    return *peak > *before_ ? *peak - *before_ : 0;
}

namespace {

constexpr double band_voxels = 3;

std::size_t resident_bytes() {
    malloc_trim(0);
    const auto bytes = status_bytes("VmRSS:");
    if (!bytes) throw Error(ErrorCode::unsupported, "this system does not state the resident memory of a process");
    return *bytes;
}

Grid domain_of(const Mesh& mesh, std::int64_t resolution) {
    return Grid::around(mesh.box(), {.resolution = resolution, .margin = Length::in_voxels(band_voxels)});
}

/// The half with the larger indices along each axis.
Grid eighth_of(const Grid& domain) {
    Index3 first{}, size{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        first[axis] = domain.size[axis] / 2;
        size[axis] = domain.size[axis] - first[axis];
    }
    return domain.part(first, size);
}

struct Kept {
    DistanceTransform transform;
    Field field;
};

/// Only one whole transform is there at a time, as in a process of its own.
Kept make_whole(const Mesh& mesh, const Device& device, std::int64_t resolution) {
    const Grid domain = domain_of(mesh, resolution);
    DistanceTransform whole(device, mesh);
    Field field = whole.compute(domain, Band::symmetric(band_voxels * domain.voxel()));
    return {std::move(whole), std::move(field)};
}

Kept make_restricted(const Mesh& mesh, const Device& device, std::int64_t resolution) {
    const Grid eighth = eighth_of(domain_of(mesh, resolution));
    const Band band = Band::symmetric(band_voxels * eighth.voxel());
    DistanceTransform part = DistanceTransform(device, mesh).restrict_to({eighth.box(), band.widest(), eighth.voxel()});
    Field field = part.compute(eighth, band);
    return {std::move(part), std::move(field)};
}

std::size_t kept_bytes(const DistanceTransform& transform) {
    const KeptMemory memory = transform.memory();
    return memory.host_bytes + memory.device_bytes;
}

std::size_t differences(const Field& part, const Field& whole) {
    std::size_t count = 0;
    const Index3& size = part.grid.size;
    Index3 shift{};
    for (std::size_t axis = 0; axis < 3; ++axis) shift[axis] = part.grid.first[axis] - whole.grid.first[axis];
    for (std::int64_t k = 0; k < size[2]; ++k)
        for (std::int64_t j = 0; j < size[1]; ++j)
            for (std::int64_t i = 0; i < size[0]; ++i) {
                const float& here = part.distance()[part.grid.offset(i, j, k)];
                const float& there = whole.distance()[whole.grid.offset(i + shift[0], j + shift[1], k + shift[2])];
                if (std::memcmp(&here, &there, sizeof here) != 0) ++count;
            }
    return count;
}

}  // namespace

RestrictedMemory measure_restricted_memory(const std::function<Mesh()>& load, const Device& device,
                                           std::int64_t resolution) {
    RestrictedMemory result;
    const Mesh small = make_shape("sphere3");
    make_restricted(small, device, 32);
    make_whole(small, device, 32);
    result.without_mesh = resident_bytes();

    Field of_part, of_whole;
    {
        Kept kept = make_restricted(load(), device, resolution);
        of_part = std::move(kept.field);
        const std::size_t bytes_of_field = of_part.distance().size() * sizeof(float);
        result.restricted = resident_bytes() - bytes_of_field;
        result.restricted_kept = kept_bytes(kept.transform);
    }
    {
        Kept kept = [&] {
            const Mesh mesh = load();
            result.triangles = mesh.triangles().size();
            return make_whole(mesh, device, resolution);
        }();
        of_whole = std::move(kept.field);
        const std::size_t bytes_of_fields = (of_part.distance().size() + of_whole.distance().size()) * sizeof(float);
        result.whole = resident_bytes() - bytes_of_fields;
        result.whole_kept = kept_bytes(kept.transform);
    }
    result.samples = of_part.distance().size();
    result.different = differences(of_part, of_whole);
    return result;
}

}  // namespace clsdf::bench
