#pragma once

#include "structs.hpp"

#include <clsdf/calls.hpp>
#include <clsdf/distance_transform.hpp>
#include <clsdf/grid.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/mesh_files.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/segments.hpp>
#include <clsdf/sparse.hpp>
#include <clsdf/topology.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

/// From the structs of C to those of C++, and back.
namespace clsdf::c {

/// Three numbers side by side from the first byte on, so that an array of C's numbers is one of these.
template <typename Triple, typename Number>
inline constexpr bool is_triple =
    std::is_standard_layout_v<Triple> && sizeof(Triple) == 3 * sizeof(Number) &&
    alignof(Triple) == alignof(Number) && std::is_same_v<typename Triple::value_type, Number>;

OutputArray output_of(const clsdf_array* array, const char* name, std::size_t points);
Box box_of(const clsdf_box* box);
clsdf_box as_c(const Box& box);
/// In the same memory.
std::span<const Box> boxes_of(const clsdf_box* boxes, std::int64_t count);
std::span<BoxPlace> places_of(std::uint8_t* places, std::int64_t count);
Band band_of(const clsdf_band* band);
clsdf_band as_c(const Band& band);
Grid grid_of(const clsdf_grid* grid);
clsdf_grid as_c(const Grid& grid);
Length length_of(const clsdf_length* length, const char* name);

InputArray input_of(const clsdf_array* array, const char* name);
/// The targets of a grid or of points. Throws Error(invalid_argument) if one has another count of items, unless it is
/// 0.
OutputTargets targets_of(const clsdf_targets& targets, const Grid& grid);
OutputTargets targets_of(const clsdf_targets& targets, std::size_t points);
/// An array that may be missing, of so many items. what: of which there are so many; name: of the array's count.
OutputArray items_of(const clsdf_array& array, std::size_t items, const char* what, const char* name);
Hits hits_of(std::int32_t hits, const char* name);
/// Throws Error(invalid_argument) if an array has another count of items than there are rays, unless it is 0.
RayTargets ray_targets_of(const clsdf_ray_request& request, std::size_t rays);
/// directions: triples.
std::span<const LinkDirection> directions_of(const std::int32_t* directions, std::int64_t count);
LinkOptions link_options_of(const clsdf_link_options* options);
/// samples: of the grid.
LinkTargets link_targets_of(const clsdf_link_buffers& buffers, std::size_t samples);
clsdf_target as_c(const OutputTarget& target);
/// 0: the distance. Throws Error(invalid_argument) for a bit that is no output's.
OutputSet outputs_of(std::uint32_t bits);
/// The arrays of a slab: packed, on the host, of the types of output_table().
std::vector<clsdf_target> as_c(const FieldSlab& slab);
/// The other way. Throws Error(invalid_argument) for arrays that are not packed.
FieldSlab slab_of(const clsdf_target* values, std::int64_t count, std::int64_t samples);

/// Layers of a sparse field, in the same memory.
clsdf_sparse_slab as_c(const SparseSlab& slab, const std::vector<clsdf_target>& values);
/// The other way. If arrays have more items than the slab's bricks, the first ones are taken.
SparseSlab sparse_slab_of(const clsdf_sparse_slab* slab);

SignRule sign_rule_of(std::int32_t rule, const char* name);
Surface surface_of(std::int32_t surface, const char* name);
clsdf_topology as_c(const Topology& topology);
clsdf_statistics as_c(const TransformStatistics& statistics);
/// to: may be null.
void set(const TransformStatistics& from, clsdf_statistics* to);
clsdf_kept_memory as_c(const KeptMemory& memory);
/// With the name's address.
clsdf_field_description as_c(const FieldDescription& field);
FieldDescription description_of(const clsdf_field_description* description);

/// A caller's options of a call.
class Call {
public:
    explicit Call(const clsdf_call_options* options);
    operator const CallOptions&() const { return options_; }  // NOLINT(google-explicit-constructor): it is them

private:
    CallOptions options_;
    std::vector<cl_event> wait_list_;
};

/// Null: the defaults.
ReadOptions read_options_of(const clsdf_read_options* options);

std::vector<cl_event> events_of(void* const* wait_list, std::int64_t count);

/// Throws CallbackEnded if a callback returned a status.
void check_callback(std::int32_t status, const char* name);

std::int32_t checked_index_base(std::int32_t base);

/// What `of_request` returns for request i. Its number stands in the message of an Error, as in the library's.
template <typename Function>
auto for_request(std::size_t i, std::size_t count, const Function& of_request) {
    try {
        return of_request();
    } catch (const Error& error) {
        if (count == 1) throw;
        throw Error(error.code(), "request " + std::to_string(i) + " of " + std::to_string(count) + ": " + error.what(),
                    error.opencl_code());
    }
}

/// Requests with the targets of each.
std::vector<Request> requests_of(const clsdf_request* requests, std::int64_t count);
BlockSet block_set_of(const clsdf_block_set* blocks);

}  // namespace clsdf::c
