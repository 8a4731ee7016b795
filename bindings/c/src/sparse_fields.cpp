#include "handles.hpp"
#include "index_base.hpp"
#include "values.hpp"

#include <cstring>
#include <memory>
#include <string>
#include <vector>

using namespace clsdf;
using c::Call;
using c::given;
using c::guarded;
using c::made;
using c::of;

namespace {

clsdf_sparse_counts as_c(const SparseCounts& counts) {
    return {static_cast<std::int64_t>(counts.bricks), static_cast<std::int64_t>(counts.runs)};
}

/// The caller's arrays.
SparseTargets targets_of(const clsdf_sparse_arrays* arrays) {
    const clsdf_sparse_arrays from = c::read_given(arrays, CLSDF_SPARSE_ARRAYS_INIT, "clsdf_sparse_arrays");
    const std::size_t bricks = c::count_of(from.brick_room, "clsdf_sparse_arrays.brick_room");
    const std::size_t runs = c::count_of(from.run_room, "clsdf_sparse_arrays.run_room");
    c::elements(from.bricks, from.brick_room, "clsdf_sparse_arrays.bricks");
    c::elements(from.inside, from.run_room, "clsdf_sparse_arrays.inside");
    if (from.brick_room > INT64_MAX / CLSDF_BRICK_SAMPLES)
        throw c::misuse("clsdf_sparse_arrays.brick_room is " + std::to_string(from.brick_room) +
                        "; no field has so many bricks");
    return {{reinterpret_cast<Index3*>(from.bricks), bricks},
            {reinterpret_cast<BrickRun*>(from.inside), runs},
            c::targets_of(from.values, bricks * CLSDF_BRICK_SAMPLES)};
}

/// Hands layers on with numbers that count from the mesh's index base, in one buffer for all layers.
SparseSink sink_of(clsdf_sparse_function sink, void* user, std::int32_t index_base) {
    return [=, shifted = c::ShiftedValues()](const SparseSlab& layers) mutable {
        SparseSlab handed = layers;
        handed.values = shifted(layers.values, index_base);
        const std::vector<clsdf_target> values = c::as_c(handed.values);
        const clsdf_sparse_slab slab = c::as_c(handed, values);
        clsdf_set_last_error(nullptr);
        c::check_callback(sink(user, &slab), "sink");
    };
}

/// A handle for a field whose numbers count from 0.
std::unique_ptr<clsdf_sparse_field> handle_of(SparseField field, std::int32_t index_base) {
    c::set_base(index_base, field.triangle());
    c::set_base(index_base, field.body());
    return std::make_unique<clsdf_sparse_field>(std::move(field), index_base);
}

}  // namespace

clsdf_status clsdf_compute_sparse(const clsdf_transform* transform, const clsdf_grid* grid, const clsdf_band* band,
                                  const clsdf_sparse_arrays* arrays, const clsdf_call_options* call,
                                  clsdf_statistics* statistics, clsdf_sparse_counts* counts) {
    if (counts != nullptr) *counts = {};
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        given(counts, "counts");
        const Call caller(call);
        const SparseTargets targets = targets_of(arrays);
        c::check_base(self.index_base, targets.values);
        SparseCounts found;
        try {
            c::set(self.transform.compute_sparse(c::grid_of(grid), c::band_of(band), targets, found, caller),
                   statistics);
        } catch (const Error&) {
            *counts = as_c(found);
            throw;
        }
        c::set_base(self.index_base, targets.values, found.bricks * brick_samples);
        *counts = as_c(found);
    });
}

clsdf_status clsdf_count_sparse(const clsdf_transform* transform, const clsdf_grid* grid, const clsdf_band* band,
                                const clsdf_call_options* call, clsdf_statistics* statistics,
                                clsdf_sparse_counts* counts) {
    if (counts != nullptr) *counts = {};
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        given(counts, "counts");
        const Call caller(call);
        TransformStatistics measured;
        *counts = as_c(self.transform.count_sparse(c::grid_of(grid), c::band_of(band), caller, &measured));
        c::set(measured, statistics);
    });
}

clsdf_status clsdf_compute_sparse_slabs(const clsdf_transform* transform, const clsdf_grid* grid,
                                        const clsdf_band* band, std::uint32_t outputs, clsdf_sparse_function sink,
                                        void* user, const clsdf_call_options* call, clsdf_statistics* statistics) {
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        if (sink == nullptr) throw c::misuse("sink is null; give a function");
        c::set(self.transform.compute_sparse(c::grid_of(grid), c::band_of(band), c::outputs_of(outputs),
                                             sink_of(sink, user, self.index_base), caller),
               statistics);
    });
}

clsdf_status clsdf_compute_sparse_field(const clsdf_transform* transform, const clsdf_grid* grid,
                                        const clsdf_band* band, std::uint32_t outputs, const clsdf_call_options* call,
                                        clsdf_statistics* statistics, clsdf_sparse_field** field) {
    return made(field, "field", [&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        const Call caller(call);
        TransformStatistics measured;
        auto result = handle_of(self.transform.compute_sparse(c::grid_of(grid), c::band_of(band),
                                                              c::outputs_of(outputs), caller, &measured),
                                self.index_base);
        c::set(measured, statistics);
        return result.release();
    });
}

clsdf_status clsdf_compute_sparse_requests(const clsdf_transform* transform, const clsdf_sparse_request* requests,
                                           std::int64_t count, const clsdf_call_options* call,
                                           clsdf_statistics* statistics, clsdf_sparse_field** fields) {
    if (fields != nullptr)
        for (std::int64_t n = 0; n < count; ++n) fields[n] = nullptr;
    return guarded([&] {
        const clsdf_transform& self = of(transform);
        c::check_result(statistics, "clsdf_statistics");
        c::elements(requests, count, "requests");
        c::elements(fields, count, "fields");
        const Call caller(call);
        const auto size = static_cast<std::size_t>(count);
        std::vector<SparseRequest> all;
        for (std::size_t n = 0; n < size; ++n)
            all.push_back(c::for_request(n, size, [&]() -> SparseRequest {
                const clsdf_sparse_request& from = requests[n];
                c::check_reserved(from.reserved, "clsdf_sparse_request");
                return {c::grid_of(&from.grid), c::band_of(&from.band), c::outputs_of(from.outputs)};
            }));
        TransformStatistics measured;
        std::vector<std::unique_ptr<clsdf_sparse_field>> handles;
        for (SparseField& field : self.transform.compute_sparse(all, caller, &measured))
            handles.push_back(handle_of(std::move(field), self.index_base));
        c::set(measured, statistics);
        for (std::size_t n = 0; n < handles.size(); ++n) fields[n] = handles[n].release();
    });
}

clsdf_status clsdf_sparse_field_describe(const clsdf_sparse_field* field, clsdf_field_description* description) {
    return guarded([&] { c::write_given(c::as_c(of(field).field), description, "clsdf_field_description"); });
}

clsdf_status clsdf_sparse_field_slab(const clsdf_sparse_field* field, clsdf_sparse_slab* slab) {
    return guarded([&] {
        const clsdf_sparse_field& self = of(field);
        c::write_given(c::as_c(self.field.slab(), self.values), slab, "clsdf_sparse_slab");
    });
}

clsdf_status clsdf_sparse_field_set_index_base(clsdf_sparse_field* field, std::int32_t index_base) {
    return guarded([&] {
        clsdf_sparse_field& self = of(field);
        const std::int32_t base = c::checked_index_base(index_base);
        for (const std::span<std::uint32_t> numbers : {self.field.triangle(), self.field.body()})
            for (std::uint32_t& number : numbers)
                number += static_cast<std::uint32_t>(base) - static_cast<std::uint32_t>(self.index_base);
        self.index_base = base;
    });
}

clsdf_status clsdf_sparse_find(const clsdf_sparse_slab* slab, const std::int64_t* sample, std::int64_t* number) {
    return guarded([&] {
        const SparseSlab layers = c::sparse_slab_of(slab);
        const std::int64_t* at = &given(sample, "sample");
        const auto found = layers.find({at[0], at[1], at[2]});
        given(number, "number") = found ? static_cast<std::int64_t>(*found) : -1;
    });
}

clsdf_status clsdf_sparse_distances(const clsdf_sparse_slab* slab, const clsdf_band* band, const std::int64_t* samples,
                                    std::int64_t count, float* distances) {
    return guarded([&] {
        const SparseSlab layers = c::sparse_slab_of(slab);
        const Band of_field = c::band_of(band);
        c::elements(samples, count, "samples");
        c::elements(distances, count, "distances");
        if (layers.values.distance().size() != layers.bricks.size() * brick_samples)
            throw c::misuse("clsdf_sparse_slab.values has no distances; give it those of its bricks");
        for (std::int64_t n = 0; n < count; ++n) {
            const std::int64_t* at = samples + 3 * n;
            distances[n] = layers.distance_at({at[0], at[1], at[2]}, of_field);
        }
    });
}
