#include "bench.hpp"

using clsdf::bench::Layout;
using clsdf::bench::split_triangles;
using clsdf::bench::Workload;

std::vector<NamedMesh> load_standard_meshes(const BenchOptions& options) {
    return options.load_meshes(options.quick ? std::vector<std::string>{"sphere4"} : clsdf::bench::standard_meshes());
}

void for_each_workload(const BenchOptions& options, const std::vector<NamedMesh>& meshes, const clsdf::Device& device,
                       const std::function<void(const Workload&)>& measure) {
    for (const NamedMesh& mesh : meshes)
        for (Layout layout : clsdf::bench::standard_layouts()) {
            // Triangles far smaller than voxels: the mesh split twice, of the first mesh only unless it is asked for.
            const bool split = layout.name == "W4";
            if (options.workloads.empty() ? split && &mesh != &meshes.front()
                                          : !contains(options.workloads, layout.name))
                continue;
            layout.resolution = options.scaled(layout.resolution);
            measure(make_workload(layout, mesh.name, split ? split_triangles(split_triangles(mesh.mesh)) : mesh.mesh,
                                  device));
        }
}
