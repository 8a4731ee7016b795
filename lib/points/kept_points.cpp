#include "points/kept_points.hpp"

#include <memory>
#include <utility>

namespace clsdf::points {

void KeptPoints::set_borrowed(engine::PointMesh mesh, engine::WideLeaves leaves, FaceSides sides) {
    wide_tree_.set(leaves.tree);
    if (mesh.polyhedra) {
        complete(mesh);
        mesh_.set(std::make_shared<const engine::PointMesh>(std::move(mesh)));
    }
    wide_leaves_.set(std::make_shared<const engine::WideLeaves>(std::move(leaves)));
    if ((*sides.sides)() != nullptr) face_sides_.set(std::make_shared<const FaceSides>(std::move(sides)));
}

std::shared_ptr<const engine::PointFaces> KeptPoints::faces() {
    return kept_mesh_.prepare([&]() -> std::shared_ptr<const engine::PointFaces> {
        if (mesh_) return mesh_.get();
        if (faces_) return faces_.get();
        const auto topology = kept_mesh_.topology_on_device();
        if (topology && !topology->has_irregular) {
            auto made = engine::make_faces_and_tree(kept_mesh_.tools(), kept_mesh_.box(), kept_mesh_.name(),
                                                    {topology, kept_mesh_.positions_on_device()}, divided_faces_.get());
            divided_faces_.set(made.tree.divided);
            if (made.faces.found.special == 0) {
                faces_.set(std::make_shared<const engine::PointFaces>(std::move(made.faces)));
                fitted_tree_.set(std::make_shared<const engine::FittedTree>(std::move(made.tree)));
                return faces_.get();
            }
        }
        return mesh();
    });
}

std::shared_ptr<const engine::PointMesh> KeptPoints::mesh() {
    return kept_mesh_.prepare([&] {
        const auto& mesh = mesh_.get_or([&] {
            engine::PointMesh made =
                engine::make_point_mesh(kept_mesh_.tools(), kept_mesh_.mesh(), kept_mesh_.sign_surface(),
                                        kept_mesh_.shared_topology(), faces_.get().get());
            complete(made);
            return made;
        });
        faces_.forget();
        return mesh;
    });
}

std::shared_ptr<const engine::PointMesh> KeptPoints::host_mesh() {
    if (mesh_) return mesh();
    return kept_mesh_.prepare([&] {
        return host_mesh_.get_or([&] {
            engine::PointMesh made = engine::make_host_point_mesh(kept_mesh_.mesh(), kept_mesh_.sign_surface(),
                                                                  kept_mesh_.shared_topology());
            complete(made);
            return made;
        });
    });
}

void KeptPoints::complete(engine::PointMesh& made) {
    const engine::Restriction* restriction = kept_mesh_.restriction();
    if (auto boundary = kept_mesh_.boundary(); boundary && boundary->floor)
        made.walls = std::make_shared<const Walls>(std::move(boundary));
    else if (boundary)
        made.film = std::make_shared<const FilmTree>(std::move(boundary), made.lattice.unit);
    made.is_part = restriction != nullptr;
    made.has_several_regions = made.is_part && restriction->regions.size() > 1;
}

std::shared_ptr<const engine::PointMesh> KeptPoints::sign_mesh() {
    auto mesh = host_mesh();
    if (!mesh->walls) return mesh;
    return kept_mesh_.prepare([&] {
        const auto& closed = closed_mesh_.get_or([&] { return engine::closed_down(*mesh, *kept_mesh_.boundary()); });
        return std::shared_ptr<const engine::PointMesh>(closed, &closed->mesh);
    });
}

std::shared_ptr<const engine::ClosedFaces> KeptPoints::closed_faces() {
    return kept_mesh_.prepare([&] {
        return closed_faces_.get_or([&] {
            const auto mesh = sign_mesh();
            return engine::ClosedFaces{engine::make_wide_tree(*mesh), engine::crossed_extent(*mesh)};
        });
    });
}

std::shared_ptr<const engine::WideTree> KeptPoints::wide_tree() {
    return kept_mesh_.prepare([&] { return wide_tree_.get_or([&] { return engine::make_wide_tree(*mesh()); }); });
}

std::shared_ptr<const engine::CrossedExtent> KeptPoints::crossed_extent() {
    return kept_mesh_.prepare([&] { return crossed_extent_.get_or([&] { return engine::crossed_extent(*mesh()); }); });
}

std::shared_ptr<const engine::WideLeaves> KeptPoints::wide_leaves() {
    return kept_mesh_.prepare([&] {
        return wide_leaves_.get_or([&] { return engine::make_wide_leaves(kept_mesh_.tools(), *mesh(), wide_tree()); });
    });
}

std::shared_ptr<const device::BufferPool::Lease> KeptPoints::triangles() {
    return kept_mesh_.prepare([&]() -> std::shared_ptr<const device::BufferPool::Lease> {
        if (const auto& faces = kept_mesh_.made_names(); !triangles_ && faces) return {faces, &faces->triangles};
        return triangles_.get_or([&] {
            const engine::DeviceTools tools = kept_mesh_.tools();
            return device::uploaded(tools.context, tools.pool, kept_mesh_.topology().faces.triangles, "triangles");
        });
    });
}

std::shared_ptr<const engine::FittedTree> KeptPoints::fitted_tree() {
    return kept_mesh_.prepare([&] {
        const auto faces = this->faces();  // kernels that make them make the tree, too
        return fitted_tree_.get_or([&] {
            const engine::DeviceTools tools = kept_mesh_.tools();
            const auto positions = faces->geometry
                                       ? faces->geometry->positions
                                       : std::make_shared<const device::BufferPool::Lease>(device::uploaded(
                                             tools.context, tools.pool, mesh()->positions, "positions of vertices"));
            engine::FittedTree made =
                engine::fitted_tree(tools, *faces, **positions, **triangles(), divided_faces_.get());
            divided_faces_.set(made.divided);
            return made;
        });
    });
}

std::shared_ptr<const ScannedMesh> KeptPoints::scanned_mesh() {
    return kept_mesh_.prepare([&] {
        return scanned_mesh_.get_or([&] {
            const engine::PreparedMesh polyhedra = kept_mesh_.all_records(mesh()->lattice);
            return make_scanned_mesh(kept_mesh_.tools(), *mesh_, kept_mesh_.frusta(), polyhedra);
        });
    });
}

std::shared_ptr<const FaceSides> KeptPoints::face_sides(SignRule sign, bool is_found) {
    // In front of a part's faces there may be others that are missing, and in front of any face the film or
    // a wall.
    if (!is_found || kept_mesh_.restriction() != nullptr || kept_mesh_.boundary() != nullptr) return face_sides_.get();
    return kept_mesh_.prepare([&] {
        return face_sides_.get_or([&] {
            const engine::DeviceTools tools = kept_mesh_.tools();
            if (const auto faces = this->faces(); faces->geometry)
                if (const auto surface = sign_faces(sign); surface->are_exact)
                    return find_face_sides(tools, *faces, *fitted_tree(), *surface);
            // For the body by_group kernels do the rest: then the tree is not kept.
            const bool is_kept = wide_tree_ || tools.programs.body == KernelBody::by_vector;
            const auto tree =
                is_kept ? wide_tree() : std::make_shared<const engine::WideTree>(engine::make_wide_tree(*mesh()));
            return find_face_sides(tools, {*mesh(), *tree}, sign);
        });
    });
}

std::shared_ptr<const DeviceSignFaces> KeptPoints::sign_faces(SignRule sign) {
    return kept_mesh_.prepare([&] {
        return sign_faces_.get_or([&] {
            const auto faces = this->faces();
            if (faces->geometry) return make_sign_faces(kept_mesh_.tools(), *faces, sign);
            return make_sign_faces(kept_mesh_.tools(), *mesh(), sign, kept_mesh_.boundary().get());
        });
    });
}

std::shared_ptr<const engine::DeviceSites> KeptPoints::sites(OutputSet outputs, bool are_normals_needed,
                                                             const FaceSides* sides) {
    const bool have_own = sides != nullptr && sides->normals && !are_normals_needed;
    auto sites = kept_mesh_.sites(engine::names_sites(outputs), are_normals_needed || (sides != nullptr && !have_own));
    if (!have_own) return sites;
    return std::make_shared<const engine::DeviceSites>(
        engine::DeviceSites{sites->names, sides->normals, sites->renumbered, sites->pieces, 0});
}

std::optional<PointInputs> KeptPoints::inputs_of_few(OutputSet outputs) const {
    const std::scoped_lock lock(mutex_);
    if (remembered_.moves != kept_mesh_.moves()) return std::nullopt;
    PointInputs inputs;
    inputs.mesh = inputs.on_host = remembered_.mesh.lock();
    inputs.leaves = remembered_.leaves.lock();
    engine::DeviceSites sites{remembered_.names.lock(), remembered_.normals.lock(), remembered_.renumbered,
                              remembered_.pieces, remembered_.turned};
    if (!inputs.mesh || !inputs.leaves || (engine::names_sites(outputs) && !sites.names) ||
        (engine::takes_normals(outputs) && !sites.normals))
        return std::nullopt;
    inputs.sites = std::make_shared<const engine::DeviceSites>(std::move(sites));
    inputs.sign = remembered_.sign;
    inputs.is_inside_out = remembered_.is_inside_out;
    return inputs;
}

void KeptPoints::remember(const PointInputs& inputs, OutputSet outputs) {
    const std::scoped_lock lock(mutex_);
    if (remembered_.moves != kept_mesh_.moves()) remembered_ = {};
    remembered_.moves = kept_mesh_.moves();
    remembered_.mesh = inputs.on_host;
    remembered_.leaves = inputs.leaves;
    if (engine::names_sites(outputs)) {
        remembered_.names = inputs.sites->names;
        remembered_.renumbered = inputs.sites->renumbered;
        remembered_.pieces = inputs.sites->pieces;
    }
    remembered_.sign = inputs.sign;
    if (!engine::takes_normals(outputs)) return;
    remembered_.normals = inputs.sites->normals;
    remembered_.turned = inputs.sites->turned;
    remembered_.is_inside_out = inputs.is_inside_out;
}

}  // namespace clsdf::points
