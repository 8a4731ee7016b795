#pragma once

#include "field/outputs.hpp"

// Its registries and their types are those of its library, which must find them, whatever this one hides.
#pragma GCC visibility push(default)
#include <openvdb/openvdb.h>
#pragma GCC visibility pop

// Included by the few files that include OpenVDB, whose headers take long to compile.

namespace clsdf::vdb {

/// The metadata that holds a field's description.
inline constexpr const char* description_key = "clsdf";

inline void initialise() {
    static const bool once = (openvdb::initialize(), true);
    static_cast<void>(once);
}

inline openvdb::Coord coordinates(const Index3& index) {
    return {static_cast<int>(index[0]), static_cast<int>(index[1]), static_cast<int>(index[2])};
}

/// Of which outputs there are grids: Int32Grid,
inline bool is_index(const OutputKind& kind) {
    return kind.type == ValueType::uint32 && kind.components == 1;
}

/// and Vec3SGrid.
inline bool is_vector(const OutputKind& kind) {
    return kind.type == ValueType::float32 && kind.components == 3;
}

}  // namespace clsdf::vdb
