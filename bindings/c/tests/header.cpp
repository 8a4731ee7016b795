// The headers are C++, also of 1998, and their _INIT macros initialise.
#include <clsdf_io.h>

int main() {
    clsdf_output_info output = CLSDF_OUTPUT_INFO_INIT;
    clsdf_grid_options grid = CLSDF_GRID_OPTIONS_INIT;
    clsdf_grid_division division = CLSDF_GRID_DIVISION_INIT;
    clsdf_read_options read = CLSDF_READ_OPTIONS_INIT;
    clsdf_device_info device = CLSDF_DEVICE_INFO_INIT;
    clsdf_device_limits limits = CLSDF_DEVICE_LIMITS_INIT;
    clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_topology topology = CLSDF_TOPOLOGY_INIT;
    clsdf_defects defects = CLSDF_DEFECTS_INIT;
    clsdf_weld_report weld = CLSDF_WELD_REPORT_INIT;
    clsdf_outer_report outer = CLSDF_OUTER_REPORT_INIT;
    clsdf_call_options call = CLSDF_CALL_OPTIONS_INIT;
    clsdf_statistics statistics = CLSDF_STATISTICS_INIT;
    clsdf_transform_options transform = CLSDF_TRANSFORM_OPTIONS_INIT;
    clsdf_kept_memory memory = CLSDF_KEPT_MEMORY_INIT;
    clsdf_block_set blocks = CLSDF_BLOCK_SET_INIT;
    clsdf_slab_options slabs = CLSDF_SLAB_OPTIONS_INIT;
    clsdf_field_description field = CLSDF_FIELD_DESCRIPTION_INIT;
    clsdf_fraction_options fractions = CLSDF_FRACTION_OPTIONS_INIT;
    const size_t sizes = output.struct_size + grid.struct_size + device.struct_size + limits.struct_size +
                         arrays.struct_size + topology.struct_size + defects.struct_size + call.struct_size +
                         statistics.struct_size + transform.struct_size + memory.struct_size + blocks.struct_size +
                         slabs.struct_size + field.struct_size + division.struct_size + read.struct_size +
                         weld.struct_size + outer.struct_size + fractions.struct_size;
    const bool is_default = grid.resolution == 256 && transform.kept_bytes == -1 && clsdf_band_full().inside > 1e300 &&
                            clsdf_band_signs_only().signs_only == 1;
    return sizes > 500 && is_default && clsdf_version() == CLSDF_VERSION ? 0 : 1;
}
