// The code of docs/amrex.md for builds with CUDA, with stand-ins for AMReX and for CUDA's driver.
#include "documents/amrex_classes.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/cuda.hpp>

#include <cuda.h>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace {

CUstream stream = nullptr;

}  // namespace

// NOLINTBEGIN(readability-identifier-naming): AMReX's own names
namespace amrex::Gpu {
inline CUstream gpuStream() {
    return stream;
}
}  // namespace amrex::Gpu
// NOLINTEND(readability-identifier-naming)

namespace {

clsdf::Grid block_of(const amrex::Geometry& geom, const amrex::Box& nodes) {
    clsdf::Grid lattice;
    lattice.origin = {geom.ProbLo(0), geom.ProbLo(1), geom.ProbLo(2)};
    lattice.spacing = {geom.CellSize(0), geom.CellSize(1), geom.CellSize(2)};
    const auto first = nodes.smallEnd(), size = nodes.length();
    return lattice.block({first[0], first[1], first[2]}, {size[0], size[1], size[2]});
}

void fill_on_gpu(const clsdf::DistanceTransform& transform, const clsdf::cuda::SharedDevice& gpu,
                 const std::vector<amrex::Geometry>& geom, std::vector<amrex::MultiFab>& phi) {
    std::vector<clsdf::cuda::Array> memory;
    std::vector<clsdf::Request> requests;
    for (std::size_t level = 0; level < phi.size(); ++level)
        for (amrex::MFIter it(phi[level]); it.isValid(); ++it) {
            amrex::FArrayBox& fab = phi[level][it];
            const std::size_t bytes = fab.box().numPts() * sizeof(amrex::Real);
            memory.push_back({reinterpret_cast<std::uint64_t>(fab.dataPtr(1)), bytes, clsdf::cuda::Access::write,
                              amrex::Gpu::gpuStream(), "phi"});
            const auto band = clsdf::Band::symmetric(4 * geom[level].CellSize(0));
            requests.push_back({block_of(geom[level], fab.box()), band, {}});
        }
    clsdf::cuda::Arrays arrays(gpu, memory);
    const auto real = sizeof(amrex::Real) == 8 ? clsdf::ElementType::float64 : clsdf::ElementType::float32;
    for (std::size_t n = 0; n < requests.size(); ++n) requests[n].targets = arrays.output(n, real);
    arrays.begin();
    transform.compute(requests);
    arrays.end();
}

void require(CUresult code) {
    if (code != CUDA_SUCCESS) std::abort();
}

}  // namespace

int main() {
    const clsdf::Mesh mesh = clsdf::make_shape("torus");
    const clsdf::Device device = clsdf::Device::automatic();
    const clsdf::DistanceTransform transform(device, mesh);
    const clsdf::cuda::SharedDevice gpu(device);
    CUcontext context = nullptr;
    require(cuDevicePrimaryCtxRetain(&context, gpu.ordinal()));
    require(cuCtxPushCurrent(context));
    require(cuStreamCreate(&stream, CU_STREAM_NON_BLOCKING));

    const clsdf::Box box = mesh.box();
    std::vector<amrex::Geometry> geom;
    std::vector<amrex::MultiFab> phi;
    std::vector<std::vector<double>> expected;
    for (int level = 0; level < 2; ++level) {
        geom.push_back({box.lower, box.longest_side() / (16 << level)});
        amrex::MultiFab& fabs = phi.emplace_back();
        for (int x = 0; x < 2; ++x) {
            const amrex::Box bounds{{8 * x - 2, -2, -2}, {8 * x + 10, 12, 8}};
            const std::vector<double> before(2 * bounds.numPts(), -7.0);
            CUdeviceptr memory = 0;
            require(cuMemAlloc(&memory, before.size() * sizeof(double)));
            require(cuMemcpyHtoDAsync(memory, before.data(), before.size() * sizeof(double), stream));
            fabs.push_back({bounds, reinterpret_cast<double*>(memory)});
            std::vector<double>& values = expected.emplace_back(before);
            transform.compute(std::vector<clsdf::Request>{{block_of(geom.back(), bounds),
                                                           clsdf::Band::symmetric(4 * geom.back().CellSize(0)),
                                                           values.data() + bounds.numPts()}});
        }
    }

    fill_on_gpu(transform, gpu, geom, phi);

    std::size_t wrong = 0, at = 0;
    for (amrex::MultiFab& fabs : phi)
        for (amrex::FArrayBox& fab : fabs) {
            std::vector<double> found(expected[at].size());
            require(cuMemcpyDtoHAsync(found.data(), reinterpret_cast<CUdeviceptr>(fab.dataPtr(0)),
                                      found.size() * sizeof(double), stream));
            wrong += std::memcmp(found.data(), expected[at++].data(), found.size() * sizeof(double)) != 0;
            require(cuMemFree(reinterpret_cast<CUdeviceptr>(fab.dataPtr(0))));
        }
    require(cuStreamDestroy(stream));
    require(cuCtxPopCurrent(nullptr));
    std::printf("%zu boxes, %zu of them wrong\n", at, wrong);
    return wrong == 0 && at == 4 ? 0 : 1;
}
