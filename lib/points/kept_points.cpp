#include "points/kept_points.hpp"

#include <utility>

namespace clsdf::points {

std::shared_ptr<const engine::PointMesh> KeptPoints::tree() {
    return kept_mesh_.prepare([&] {
        return tree_.get_or([&] {
            engine::PointMesh made = engine::make_point_mesh(kept_mesh_.tools(), kept_mesh_.mesh(),
                                                             kept_mesh_.sign_surface(), kept_mesh_.shared_topology());
            const engine::Restriction* restriction = kept_mesh_.restriction();
            if (auto boundary = kept_mesh_.boundary())
                made.film = std::make_shared<const FilmTree>(std::move(boundary), made.lattice.unit);
            made.is_part = restriction != nullptr;
            made.has_several_regions = made.is_part && restriction->regions.size() > 1;
            return made;
        });
    });
}

std::shared_ptr<const engine::FittedTree> KeptPoints::fitted_tree() {
    return kept_mesh_.prepare([&] {
        return fitted_tree_.get_or([&] {
            engine::FittedTree made = engine::fitted_tree(kept_mesh_.tools(), *tree(), divided_faces_.get());
            divided_faces_.set(made.divided);
            return made;
        });
    });
}

std::shared_ptr<const ScannedMesh> KeptPoints::scanned_mesh() {
    return kept_mesh_.prepare([&] {
        return scanned_mesh_.get_or([&] {
            const engine::PreparedMesh polyhedra = kept_mesh_.all_records(tree()->lattice);
            return make_scanned_mesh(kept_mesh_.tools(), *tree_, kept_mesh_.frusta(), polyhedra);
        });
    });
}

std::shared_ptr<const FaceSides> KeptPoints::face_sides(SignRule sign, bool is_found) {
    // In front of a part's faces there may be others that are missing, and in front of any face the film.
    if (!is_found || kept_mesh_.restriction() != nullptr || kept_mesh_.boundary() != nullptr) return face_sides_.get();
    return kept_mesh_.prepare(
        [&] { return face_sides_.get_or([&] { return find_face_sides(kept_mesh_.tools(), *tree(), sign); }); });
}

std::shared_ptr<const DeviceSignFaces> KeptPoints::sign_faces(SignRule sign) {
    return kept_mesh_.prepare([&] {
        return sign_faces_.get_or(
            [&] { return make_sign_faces(kept_mesh_.tools(), *tree(), sign, kept_mesh_.boundary().get()); });
    });
}

std::optional<PointInputs> KeptPoints::inputs_of_few(OutputSet outputs) const {
    const std::scoped_lock lock(mutex_);
    if (remembered_.moves != kept_mesh_.moves()) return std::nullopt;
    PointInputs inputs;
    inputs.mesh = remembered_.mesh.lock();
    engine::DeviceSites sites{remembered_.names.lock(), remembered_.normals.lock(), remembered_.renumbered,
                              remembered_.turned};
    if (!inputs.mesh || (engine::names_sites(outputs) && !sites.names) ||
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
    remembered_.mesh = inputs.mesh;
    if (engine::names_sites(outputs)) {
        remembered_.names = inputs.sites->names;
        remembered_.renumbered = inputs.sites->renumbered;
    }
    remembered_.sign = inputs.sign;
    if (!engine::takes_normals(outputs)) return;
    remembered_.normals = inputs.sites->normals;
    remembered_.turned = inputs.sites->turned;
    remembered_.is_inside_out = inputs.is_inside_out;
}

}  // namespace clsdf::points
